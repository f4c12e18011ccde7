// The checked reader of PointCloud2, in four stages, each of which relies only on what the former have checked: a view of the
// message, checks of the view, copies of the points, a check of every point.
#include "deformable_surface/ros/convert/cloud_decoder.h"

#include "deformable_surface/base/value.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <vector>

namespace deformable_surface::node {
namespace {

// No scanner or camera sends as many fields; keeps the pairwise check for overlaps cheap.
constexpr std::uint32_t kMaxFields = 256;
// Far above any real frame or field name; keeps them fit for logs and memory.
constexpr std::size_t kMaxNameLength = 256;
// Enough of a list of names to recognise the message in a sentence.
constexpr std::size_t kShownLength = 80;

constexpr std::array<const char*, 3> kCoordinates{"x", "y", "z"};
constexpr std::array<const char*, 3> kNormals{"normal_x", "normal_y", "normal_z"};

struct FieldView {
  std::string_view name;
  std::uint64_t offset;
  std::uint8_t datatype;
  std::uint64_t count;

  cloud::ScalarType type() const { return static_cast<cloud::ScalarType>(datatype); }
  std::uint64_t end() const { return offset + cloud::sizeOf(type()) * count; }
  bool isFloat() const { return type() == cloud::ScalarType::kFloat32 || type() == cloud::ScalarType::kFloat64; }
};

/// The statements of a message about itself, unchecked; names and data point into the message.
struct CloudView {
  std::uint32_t seq = 0, sec = 0, nsec = 0;
  std::string_view frame_id;
  std::uint64_t height = 0, width = 0;
  std::vector<FieldView> fields;
  bool is_bigendian = false;
  std::uint64_t point_step = 0, row_step = 0;
  const std::uint8_t* data = nullptr;
  std::uint64_t data_size = 0;
};

struct Problem {
  std::string sentence;
};

std::string countOf(std::uint64_t n, const char* unit) { return std::to_string(n) + " " + unit + (n == 1 ? "" : "s"); }

bool isPrintable(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7f; });
}

/// A name from outside, safe to show: it need not even be text.
std::string show(std::string_view name) {
  std::string shown(name.substr(0, kMaxNameLength));
  for (char& c : shown)
    if (!isPrintable({&c, 1})) c = '?';
  return quote(shown);
}

/// Takes numbers and strings from the front of a byte span. Wire numbers are little-endian, as is every host of ROS 1.
class WireReader {
 public:
  WireReader(const std::uint8_t* bytes, std::size_t size) : at_(bytes), left_(size), size_(size) {}

  const std::uint8_t* take(std::uint64_t length, const char* what) {
    if (length > left_)
      throw Problem{"the message ends too early: " + std::string(what) + " takes " + countOf(length, "byte") + ", of " +
                    std::to_string(size_) + " only " + std::to_string(left_) + " are left"};
    const std::uint8_t* taken = at_;
    at_ += length;
    left_ -= length;
    return taken;
  }
  std::uint8_t takeByte(const char* what) { return *take(1, what); }
  std::uint32_t takeNumber(const char* what) {
    std::uint32_t number;
    std::memcpy(&number, take(sizeof number, what), sizeof number);
    return number;
  }
  std::string_view takeString(const char* what) {
    const std::uint32_t length = takeNumber(what);
    return {reinterpret_cast<const char*>(take(length, what)), length};
  }
  std::uint64_t left() const { return left_; }

 private:
  const std::uint8_t* at_;
  std::uint64_t left_, size_;
};

void checkFieldCount(std::uint64_t count) {
  if (count > kMaxFields)
    throw Problem{"the cloud has " + std::to_string(count) + " fields; accepted are at most " + std::to_string(kMaxFields)};
}

/// A count of zero means one: old drivers do not set it.
FieldView makeField(std::string_view name, std::uint32_t offset, std::uint8_t datatype, std::uint32_t count) {
  return {name, offset, datatype, count == 0 ? 1u : count};
}

CloudView viewBytes(const std::uint8_t* bytes, std::size_t size) {
  WireReader reader(bytes, size);
  CloudView view;
  view.seq = reader.takeNumber("header.seq");
  view.sec = reader.takeNumber("header.stamp");
  view.nsec = reader.takeNumber("header.stamp");
  view.frame_id = reader.takeString("header.frame_id");
  view.height = reader.takeNumber("height");
  view.width = reader.takeNumber("width");
  const std::uint32_t num_fields = reader.takeNumber("fields");
  checkFieldCount(num_fields);
  for (std::uint32_t f = 0; f < num_fields; ++f) {
    const std::string_view name = reader.takeString("a field's name");
    const std::uint32_t offset = reader.takeNumber("a field's offset");
    const std::uint8_t datatype = reader.takeByte("a field's datatype");
    view.fields.push_back(makeField(name, offset, datatype, reader.takeNumber("a field's count")));
  }
  view.is_bigendian = reader.takeByte("is_bigendian") != 0;
  view.point_step = reader.takeNumber("point_step");
  view.row_step = reader.takeNumber("row_step");
  view.data_size = reader.takeNumber("data");
  view.data = reader.take(view.data_size, "data");
  reader.takeByte("is_dense");  // not believed: every point is tested
  if (reader.left() > 0) throw Problem{"the message goes on for " + countOf(reader.left(), "byte") + " after its end"};
  return view;
}

CloudView viewMessage(const sensor_msgs::PointCloud2& message) {
  CloudView view;
  view.seq = message.header.seq;
  view.sec = message.header.stamp.sec;
  view.nsec = message.header.stamp.nsec;
  view.frame_id = message.header.frame_id;
  view.height = message.height;
  view.width = message.width;
  checkFieldCount(message.fields.size());
  for (const sensor_msgs::PointField& field : message.fields)
    view.fields.push_back(makeField(field.name, field.offset, field.datatype, field.count));
  view.is_bigendian = message.is_bigendian;
  view.point_step = message.point_step;
  view.row_step = message.row_step;
  view.data = message.data.data();
  view.data_size = message.data.size();
  return view;
}

void checkName(const char* what, std::string_view name) {
  if (name.size() > kMaxNameLength)
    throw Problem{std::string(what) + " " + show(name) + " has " + countOf(name.size(), "character") + "; accepted are at most " +
                  std::to_string(kMaxNameLength)};
  if (!isPrintable(name)) throw Problem{std::string(what) + " " + show(name) + " must hold printable ASCII characters only"};
}

void checkHeader(const CloudView& view) {
  constexpr std::uint32_t kNanosecondsPerSecond = 1000000000;
  if (view.nsec >= kNanosecondsPerSecond)
    throw Problem{"the nanoseconds of the stamp are " + std::to_string(view.nsec) + "; accepted are 0 to 999999999"};
  checkName("frame_id", view.frame_id);
}

void checkFields(const CloudView& view) {
  for (const FieldView& field : view.fields) {
    checkName("the field name", field.name);
    if (field.datatype < 1 || field.datatype > 8)
      throw Problem{"field " + show(field.name) + " has datatype " + std::to_string(field.datatype) +
                    "; accepted are 1 to 8, the types of sensor_msgs/PointField"};
    if (field.end() > view.point_step)
      throw Problem{"field " + show(field.name) + " ends at byte " + std::to_string(field.end()) +
                    ", but a point has point_step = " + countOf(view.point_step, "byte")};
  }
  for (std::size_t a = 0; a < view.fields.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const FieldView &first = view.fields[b], &second = view.fields[a];
      if (first.name == second.name) throw Problem{"field " + show(first.name) + " occurs twice; names must be distinct"};
      if (first.offset < second.end() && second.offset < first.end())
        throw Problem{"fields " + show(first.name) + " and " + show(second.name) + " overlap; each needs bytes of its own"};
    }
}

/// The view with that name as float32 or float64, one per point, or null.
const FieldView* findFloat(const CloudView& view, std::string_view name) {
  for (const FieldView& field : view.fields)
    if (field.name == name && field.isFloat() && field.count == 1) return &field;
  return nullptr;
}

std::array<const FieldView*, 3> findFloats(const CloudView& view, const std::array<const char*, 3>& names) {
  return {findFloat(view, names[0]), findFloat(view, names[1]), findFloat(view, names[2])};
}

void checkCoordinates(const CloudView& view) {
  for (const char* name : kCoordinates) {
    if (findFloat(view, name)) continue;
    std::string found;
    for (const FieldView& field : view.fields) {
      if (field.name == name)
        throw Problem{"field " + show(name) + " has datatype " + std::to_string(field.datatype) + " and count " +
                      std::to_string(field.count) + "; accepted is one float32 (7) or float64 (8) per point"};
      if (found.size() < kShownLength)
        found += (found.empty() ? "" : ", ") + show(field.name);
      else if (found.back() != '.')
        found += ", ...";
    }
    throw Problem{"the cloud has no field " + show(name) + (found.empty() ? " and no other" : " but " + found) +
                  "; needed are x, y and z as float32 or float64"};
  }
}

/// Checks that the data hold the declared points. No product overflows: each factor has at most 32 bits.
void checkExtent(CloudView& view, const DecodeLimits& limits) {
  const std::uint64_t num_points = view.width * view.height;
  if (num_points > static_cast<std::uint64_t>(limits.max_points))
    throw Problem{"the cloud declares " + std::to_string(view.width) + " x " + std::to_string(view.height) +
                  " points; accepted are at most " + std::to_string(limits.max_points) + " (input.max_points)"};
  if (num_points == 0) {
    if (view.data_size > 0)
      throw Problem{"the cloud declares no points but brings " + countOf(view.data_size, "byte") + " of data"};
    return;
  }
  // Some drivers do not set row_step; with a single row nothing depends on it.
  const std::uint64_t row_size = view.width * view.point_step;
  if (view.row_step == 0 && view.height == 1) view.row_step = row_size;
  if (view.row_step < row_size)
    throw Problem{"row_step is " + std::to_string(view.row_step) + ", but a row of " + countOf(view.width, "point") + " of " +
                  countOf(view.point_step, "byte") + " takes " + std::to_string(row_size)};
  const std::uint64_t least = (view.height - 1) * view.row_step + row_size, most = view.height * view.row_step;
  if (view.data_size < least || view.data_size > most)
    throw Problem{"the cloud brings " + countOf(view.data_size, "byte") + " of data, but " + std::to_string(view.width) + " x " +
                  std::to_string(view.height) + " points take " + std::to_string(least) +
                  (most > least ? " to " + std::to_string(most) : "")};
}

/// Copies a scalar of Size bytes, reversed if Swap.
template <std::size_t Size, bool Swap>
void copyScalar(const std::uint8_t* from, std::uint8_t* to) {
  if (Swap)
    std::reverse_copy(from, from + Size, to);
  else
    std::memcpy(to, from, Size);
}

template <class Scalar, bool Swap>
double readScalar(const std::uint8_t* from) {
  Scalar scalar;
  copyScalar<sizeof(Scalar), Swap>(from, reinterpret_cast<std::uint8_t*>(&scalar));
  return static_cast<double>(scalar);
}

using ReadScalar = double (*)(const std::uint8_t*);

ReadScalar chooseReader(const FieldView& field, bool swap) {
  const bool is_single = field.type() == cloud::ScalarType::kFloat32;
  if (swap) return is_single ? readScalar<float, true> : readScalar<double, true>;
  return is_single ? readScalar<float, false> : readScalar<double, false>;
}

/// Calls visit(i, bytes of point i) for every point in order.
template <class Visit>
void forEachPoint(const CloudView& view, const Visit& visit) {
  std::size_t i = 0;
  for (std::uint64_t row = 0; row < view.height; ++row) {
    const std::uint8_t* point = view.data + row * view.row_step;
    for (std::uint64_t column = 0; column < view.width; ++column, point += view.point_step) visit(i++, point);
  }
}

/// Three fields of every point as vectors; the usual case, three float32 in host order, without a call per scalar.
Points readVectors(const CloudView& view, const std::array<const FieldView*, 3>& fields) {
  Points vectors(view.width * view.height);
  const std::uint64_t x = fields[0]->offset, y = fields[1]->offset, z = fields[2]->offset;
  const bool is_usual = !view.is_bigendian && std::all_of(fields.begin(), fields.end(), [](const FieldView* field) {
    return field->type() == cloud::ScalarType::kFloat32;
  });
  if (is_usual) {
    forEachPoint(view, [&](std::size_t i, const std::uint8_t* point) {
      constexpr ReadScalar kRead = readScalar<float, false>;
      vectors[i] = {kRead(point + x), kRead(point + y), kRead(point + z)};
    });
    return vectors;
  }
  const ReadScalar read_x = chooseReader(*fields[0], view.is_bigendian), read_y = chooseReader(*fields[1], view.is_bigendian),
                   read_z = chooseReader(*fields[2], view.is_bigendian);
  forEachPoint(view, [&](std::size_t i, const std::uint8_t* point) {
    vectors[i] = {read_x(point + x), read_y(point + y), read_z(point + z)};
  });
  return vectors;
}

template <std::size_t Size, bool Swap>
void copyField(const CloudView& view, const FieldView& field, std::vector<std::uint8_t>& bytes) {
  std::uint8_t* to = bytes.data();
  forEachPoint(view, [&](std::size_t, const std::uint8_t* point) {
    for (std::uint64_t c = 0; c < field.count; ++c, to += Size) copyScalar<Size, Swap>(point + field.offset + c * Size, to);
  });
}

cloud::ExtraField readExtraField(const CloudView& view, const FieldView& field) {
  const std::size_t size = cloud::sizeOf(field.type());
  cloud::ExtraField extra{std::string(field.name), field.type(), static_cast<std::uint32_t>(field.count), {}};
  extra.bytes.resize(view.width * view.height * field.count * size);
  const bool swap = view.is_bigendian;
  switch (size) {
    case 1: copyField<1, false>(view, field, extra.bytes); break;
    case 2: swap ? copyField<2, true>(view, field, extra.bytes) : copyField<2, false>(view, field, extra.bytes); break;
    case 4: swap ? copyField<4, true>(view, field, extra.bytes) : copyField<4, false>(view, field, extra.bytes); break;
    case 8: swap ? copyField<8, true>(view, field, extra.bytes) : copyField<8, false>(view, field, extra.bytes); break;
  }
  return extra;
}

/// Sets rows that are not finite or out of range to NaN; returns how many.
Index markHoles(Points& positions, double max_coordinate) {
  Index num_holes = 0;
  for (Vec3& p : positions)
    if (!(std::abs(p.x()) <= max_coordinate && std::abs(p.y()) <= max_coordinate && std::abs(p.z()) <= max_coordinate)) {
      p.setConstant(std::numeric_limits<double>::quiet_NaN());
      ++num_holes;
    }
  return num_holes;
}

bool isOneOf(const FieldView& field, const std::array<const FieldView*, 3>& fields) {
  return std::find(fields.begin(), fields.end(), &field) != fields.end();
}

void decodeView(CloudView view, const DecodeLimits& limits, DecodedCloud& decoded) {
  constexpr Index kMinPoints = 3;  // fewer do not span a surface
  checkHeader(view);
  decoded.header.seq = view.seq;
  decoded.header.stamp.sec = view.sec;
  decoded.header.stamp.nsec = view.nsec;
  // tf2 knows no leading slashes, but old bags have them.
  if (!view.frame_id.empty() && view.frame_id.front() == '/') view.frame_id.remove_prefix(1);
  decoded.header.frame_id = std::string(view.frame_id);

  checkExtent(view, limits);
  if (view.width * view.height < kMinPoints)
    throw Problem{"the cloud has " + countOf(view.width * view.height, "point") + "; a surface needs at least " +
                  std::to_string(kMinPoints)};
  checkFields(view);
  checkCoordinates(view);

  cloud::PointCloud& cloud = decoded.cloud;
  cloud.width = static_cast<std::uint32_t>(view.width);
  cloud.height = static_cast<std::uint32_t>(view.height);
  const auto coordinates = findFloats(view, kCoordinates), normals = findFloats(view, kNormals);
  cloud.positions = readVectors(view, coordinates);
  decoded.num_not_finite = markHoles(cloud.positions, limits.max_coordinate);
  const Index num_finite = cloud.size() - decoded.num_not_finite;
  if (num_finite < kMinPoints) {
    const Points sent = readVectors(view, coordinates);
    const bool has_far = std::any_of(sent.begin(), sent.end(), [&](const Vec3& p) {
      return p.allFinite() && p.cwiseAbs().maxCoeff() > limits.max_coordinate;
    });
    throw Problem{"of " + countOf(cloud.size(), "point") + " " + std::to_string(num_finite) + " have finite coordinates within " +
                  formatReal(limits.max_coordinate) + " m; a surface needs at least " + std::to_string(kMinPoints) +
                  (has_far ? "; others are farther, as in coordinates of maps: subtract an offset from them" : "")};
  }

  const bool has_normals = normals[0] && normals[1] && normals[2];
  if (has_normals) cloud.normals = readVectors(view, normals);
  for (const FieldView& field : view.fields)
    if (!isOneOf(field, coordinates) && !(has_normals && isOneOf(field, normals)))
      cloud.extra_fields.push_back(readExtraField(view, field));
}

template <class MakeView>
DecodedCloud decode(const MakeView& make_view, const DecodeLimits& limits) {
  DecodedCloud decoded;
  try {
    decodeView(make_view(), limits, decoded);
  } catch (const Problem& problem) {
    decoded.cloud = cloud::PointCloud();
    decoded.num_not_finite = 0;
    decoded.problem = problem.sentence;
  }
  return decoded;
}

}  // namespace

DecodedCloud decodeCloud(const std::uint8_t* bytes, std::size_t size, const DecodeLimits& limits) {
  return decode([&] { return viewBytes(bytes, size); }, limits);
}

DecodedCloud decodeCloud(const sensor_msgs::PointCloud2& message, const DecodeLimits& limits) {
  return decode([&] { return viewMessage(message); }, limits);
}

}  // namespace deformable_surface::node
