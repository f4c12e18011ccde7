// Clouds that break naive readers of PointCloud2, and unusual clouds that are legal, each with the expected verdict. Tests of the
// decoder and of the node share this file. Every cloud is small: the wrong values are in the numbers that describe it.
#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace deformable_surface::node::test {

enum class Verdict {
  kAccept,  // must be taken
  kEither,  // may be taken, without its unusable points, or refused with a reason
  kRefuse,  // must be refused with a reason
};

struct BadCloud {
  std::string id;
  std::string what;
  Verdict verdict;
  sensor_msgs::PointCloud2 message;
};

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;
using Point3f = std::array<float, 3>;
using Points3f = std::vector<Point3f>;

inline PointField makeField(const std::string& name, std::uint32_t offset, std::uint8_t datatype = PointField::FLOAT32,
                            std::uint32_t count = 1) {
  PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = datatype;
  field.count = count;
  return field;
}

/// Writes a scalar into the data at a byte offset.
template <class Scalar>
void write(PointCloud2& cloud, std::size_t offset, Scalar scalar) {
  std::memcpy(cloud.data.data() + offset, &scalar, sizeof scalar);
}

/// A width x height cloud with float32 x, y, z at the start of each point, the rest of the point zero.
inline PointCloud2 makeCloud(std::uint32_t width, std::uint32_t height, std::uint32_t point_step,
                             const std::function<Point3f(std::uint32_t column, std::uint32_t row)>& position) {
  PointCloud2 cloud;
  cloud.header.frame_id = "map";
  cloud.header.stamp.sec = 100;
  cloud.width = width;
  cloud.height = height;
  cloud.point_step = point_step;
  cloud.row_step = width * point_step;
  cloud.fields = {makeField("x", 0), makeField("y", 4), makeField("z", 8)};
  cloud.is_dense = true;
  cloud.data.assign(std::size_t(cloud.row_step) * height, 0);
  for (std::uint32_t row = 0; row < height; ++row)
    for (std::uint32_t column = 0; column < width; ++column) {
      const Point3f point = position(column, row);
      for (int axis = 0; axis < 3; ++axis)
        write(cloud, std::size_t(row) * cloud.row_step + std::size_t(column) * point_step + 4 * axis, point[axis]);
    }
  return cloud;
}

/// A slightly curved sheet with a centimetre between points.
inline PointCloud2 makeSheet(std::uint32_t width = 10, std::uint32_t height = 10, std::uint32_t point_step = 16) {
  return makeCloud(width, height, point_step, [](std::uint32_t column, std::uint32_t row) {
    const float x = 0.01f * column, y = 0.01f * row;
    return Point3f{x, y, x * y};
  });
}

inline PointCloud2 makeUnorganised(const Points3f& points) {
  return makeCloud(points.size(), 1, 16, [&](std::uint32_t column, std::uint32_t) { return points[column]; });
}

inline Points3f makeGrid(int n, float spacing, Point3f corner = {0, 0, 0}) {
  Points3f points;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) points.push_back({corner[0] + spacing * i, corner[1] + spacing * j, corner[2]});
  return points;
}

class BadClouds {
 public:
  static std::vector<BadCloud> makeAll() {
    BadClouds corpus;
    corpus.addLayouts();
    corpus.addEmptyClouds();
    corpus.addFalseSizes();
    corpus.addFalseSteps();
    corpus.addFalseDimensions();
    corpus.addFalseFields();
    corpus.addHeaders();
    corpus.addShapes();
    return corpus.clouds_;
  }

 private:
  static constexpr auto kAccept = Verdict::kAccept, kEither = Verdict::kEither, kRefuse = Verdict::kRefuse;
  static constexpr std::uint32_t kMax = 0xffffffffu;
  static constexpr std::uint32_t kTwoTo16 = 1u << 16, kTwoTo26 = 1u << 26, kTwoTo28 = 1u << 28, kTwoTo31 = 1u << 31;

  using Change = std::function<void(PointCloud2&)>;

  void add(const char* id, Verdict verdict, const char* what, PointCloud2 cloud) {
    clouds_.push_back({id, what, verdict, std::move(cloud)});
  }
  void addChanged(const char* id, Verdict verdict, const char* what, PointCloud2 cloud, const Change& change) {
    change(cloud);
    cloud.data.shrink_to_fit();  // so that a sanitizer sees a read behind the end
    add(id, verdict, what, std::move(cloud));
  }
  /// The sheet of ten by ten points of sixteen bytes, with one defect.
  void addSheet(const char* id, Verdict verdict, const char* what, const Change& change) {
    addChanged(id, verdict, what, makeSheet(), change);
  }
  void addPoints(const char* id, Verdict verdict, const char* what, const Points3f& points, bool is_dense = true) {
    addChanged(id, verdict, what, makeUnorganised(points), [&](PointCloud2& c) { c.is_dense = is_dense; });
  }

  void addLayouts() {
    addSheet("L00", kAccept, "an organised cloud with padded points", [](PointCloud2&) {});
    add("L01", kAccept, "one row of packed points", makeSheet(100, 1, 12));
    addChanged("L02", kAccept, "an extra field after a gap", makeSheet(100, 1, 32),
               [](PointCloud2& c) { c.fields.push_back(makeField("intensity", 16)); });
    addChanged("L03", kAccept, "coordinates as float64", makeSheet(50, 1, 24), [](PointCloud2& c) {
      c.fields = {makeField("x", 0, PointField::FLOAT64), makeField("y", 8, PointField::FLOAT64),
                  makeField("z", 16, PointField::FLOAT64)};
      for (int i = 0; i < 50; ++i)
        for (int axis = 0; axis < 3; ++axis) write(c, 24 * i + 8 * axis, 0.01 * i + axis);
    });
    addSheet("L04", kEither, "big-endian numbers, and it says so", [](PointCloud2& c) {
      c.is_bigendian = true;
      for (std::size_t i = 0; i < c.data.size(); i += 4) std::reverse(c.data.begin() + i, c.data.begin() + i + 4);
    });
    addSheet("L05", kAccept, "rows followed by padding", [](PointCloud2& c) {
      const auto packed = c.data;
      c.row_step = 200;
      c.data.assign(10 * 200, 0xab);
      for (int row = 0; row < 10; ++row) std::copy_n(packed.begin() + row * 160, 160, c.data.begin() + row * 200);
    });
    add("L06", kAccept, "an odd number of bytes per point", makeSheet(100, 1, 13));
    addSheet("L07", kAccept, "fields listed from z to x", [](PointCloud2& c) { std::reverse(c.fields.begin(), c.fields.end()); });
    addSheet("L08", kAccept, "coordinates stored as y z x", [](PointCloud2& c) {
      c.fields = {makeField("x", 8), makeField("y", 0), makeField("z", 4)};
    });
    addChanged("L09", kEither, "coordinates as int16", makeSheet(50, 1, 12), [](PointCloud2& c) {
      c.point_step = 6;
      c.row_step = 300;
      c.fields = {makeField("x", 0, PointField::INT16), makeField("y", 2, PointField::INT16),
                  makeField("z", 4, PointField::INT16)};
      c.data.assign(300, 1);
    });
    add("L10", kAccept, "a kilobyte per point", makeSheet(100, 1, 1024));
    addSheet("L11", kAccept, "said to have holes and has none", [](PointCloud2& c) { c.is_dense = false; });
  }

  void addEmptyClouds() {
    add("E00", kEither, "no columns and no rows", makeSheet(0, 0));
    add("E01", kEither, "a row of no points", makeSheet(0, 1));
    add("E02", kEither, "a column of no points", makeSheet(1, 0));
    add("E03", kEither, "an empty message", PointCloud2());
    addSheet("E04", kRefuse, "data without fields", [](PointCloud2& c) { c.fields.clear(); });
    addChanged("E05", kEither, "a row of no points of no bytes", makeSheet(0, 1),
               [](PointCloud2& c) { c.point_step = c.row_step = 0; });
    addChanged("E06", kRefuse, "data without points", makeSheet(0, 0), [](PointCloud2& c) { c.data.assign(160, 7); });
  }

  void addFalseSizes() {
    addSheet("D00", kRefuse, "a byte too few", [](PointCloud2& c) { c.data.pop_back(); });
    addSheet("D01", kRefuse, "half the data", [](PointCloud2& c) { c.data.resize(c.data.size() / 2); });
    addSheet("D02", kRefuse, "no data for a hundred points", [](PointCloud2& c) { c.data.clear(); });
    addSheet("D03", kRefuse, "one byte for a hundred points", [](PointCloud2& c) { c.data.resize(1); });
    addSheet("D04", kRefuse, "twice the data", [](PointCloud2& c) { c.data.resize(2 * c.data.size(), 0x41); });
    addChanged("D05", kRefuse, "two coordinates and far too much data", makeSheet(10, 1, 12), [](PointCloud2& c) {
      c.fields.pop_back();
      c.point_step = 8;
      c.row_step = 80;
      c.data.assign(8000, 0x41);
    });
    addChanged("D06", kRefuse, "two coordinates, padded rows, one row of four", makeSheet(10, 1, 12), [](PointCloud2& c) {
      c.fields.pop_back();
      c.height = 4;
      c.point_step = 8;
      c.row_step = 96;
      c.data.assign(96, 0x41);
    });
    addSheet("D07", kRefuse, "three bytes too many", [](PointCloud2& c) { c.data.resize(c.data.size() + 3, 0); });
  }

  void addFalseSteps() {
    addSheet("P00", kRefuse, "point_step 0", [](PointCloud2& c) { c.point_step = 0; });
    addSheet("P01", kRefuse, "point_step 0 and row_step 0", [](PointCloud2& c) { c.point_step = c.row_step = 0; });
    addSheet("P02", kRefuse, "point_step 1", [](PointCloud2& c) { c.point_step = 1; });
    addSheet("P03", kRefuse, "point_step of one coordinate", [](PointCloud2& c) { c.point_step = 4; });
    addSheet("P04", kRefuse, "point_step doubled", [](PointCloud2& c) { c.point_step *= 2; });
    addSheet("P05", kRefuse, "the largest point_step", [](PointCloud2& c) { c.point_step = kMax; });
    addSheet("P06", kRefuse, "point_step 2^31", [](PointCloud2& c) { c.point_step = kTwoTo31; });
    addSheet("P07", kRefuse, "row_step 0 with several rows", [](PointCloud2& c) { c.row_step = 0; });
    addChanged("P08", kEither, "row_step 0 with one row", makeSheet(100, 1), [](PointCloud2& c) { c.row_step = 0; });
    addSheet("P09", kRefuse, "the largest row_step", [](PointCloud2& c) { c.row_step = kMax; });
    addSheet("P10", kRefuse, "row_step 2^28", [](PointCloud2& c) { c.row_step = kTwoTo28; });
    addSheet("P11", kRefuse, "row_step of half a row", [](PointCloud2& c) { c.row_step /= 2; });
    addSheet("P12", kRefuse, "row_step doubled", [](PointCloud2& c) { c.row_step *= 2; });
  }

  void addFalseDimensions() {
    const auto set = [](std::uint32_t width, std::uint32_t height, std::uint32_t point_step, std::uint32_t row_step) {
      return [=](PointCloud2& c) {
        c.width = width;
        c.height = height;
        c.point_step = point_step;
        c.row_step = row_step;
      };
    };
    addSheet("W00", kRefuse, "a product that wraps to 0, no steps", set(kTwoTo16, kTwoTo16, 0, 0));
    addSheet("W01", kRefuse, "a product that wraps to 0", set(kTwoTo16, kTwoTo16, 16, 160));
    addSheet("W02", kRefuse, "a product that wraps to 2", set(kTwoTo31 + 1, 2, 16, 0));
    addSheet("W03", kRefuse, "the largest width", set(kMax, 1, 16, 160));
    addSheet("W04", kRefuse, "width 2^26", set(kTwoTo26, 1, 16, 160));
    addSheet("W05", kRefuse, "the largest height", set(1, kMax, 16, 160));
    addChanged("W06", kRefuse, "a hundred rows declared, one sent", makeSheet(100, 1), set(100, 100, 16, 1600));
    addChanged("W07", kRefuse, "half the points declared", makeSheet(100, 1), set(50, 1, 16, 800));
    addSheet("W08", kRefuse, "width 2^26, points of no bytes", set(kTwoTo26, 1, 0, 0));
    addSheet("W09", kRefuse, "a product that wraps to 4, no steps", set((1u << 30) + 1, 4, 0, 0));
    addSheet("W10", kRefuse, "a row whose bytes wrap to one point", set(kTwoTo28 + 1, 1, 16, 16));
    addChanged("W11", kRefuse, "rows whose bytes wrap to one row", makeSheet(2, 1), set(2, (1u << 27) + 1, 16, 32));
  }

  void addFalseFields() {
    const auto moveX = [](std::uint32_t offset) { return [=](PointCloud2& c) { c.fields[0].offset = offset; }; };
    addSheet("F00", kRefuse, "x right behind the point", moveX(16));
    addSheet("F01", kRefuse, "x at the largest offset", moveX(kMax));
    addSheet("F02", kRefuse, "x at offset 2^31 - 1", moveX(kTwoTo31 - 1));
    addSheet("F03", kRefuse, "x in front of the point, as a negative offset", moveX(0u - 16u));
    addSheet("F04", kRefuse, "z half outside the point", [](PointCloud2& c) { c.fields[2].offset = 14; });
    addSheet("F05", kEither, "all coordinates in one place", [](PointCloud2& c) {
      for (PointField& field : c.fields) field.offset = 0;
    });
    addSheet("F06", kRefuse, "a second x far away", [](PointCloud2& c) { c.fields.push_back(makeField("x", 4000)); });
    const auto putXFirst = [](std::uint32_t offset) {
      return [=](PointCloud2& c) { c.fields.insert(c.fields.begin(), makeField("x", offset)); };
    };
    addSheet("F07", kRefuse, "a first x far away", putXFirst(4000));
    addSheet("F08", kRefuse, "a second x in place of z", putXFirst(8));
    addSheet("F09", kRefuse, "datatype 0", [](PointCloud2& c) { c.fields[0].datatype = 0; });
    addSheet("F10", kRefuse, "datatype 255", [](PointCloud2& c) { c.fields[0].datatype = 255; });
    addSheet("F11", kEither, "count 0", [](PointCloud2& c) { c.fields[0].count = 0; });
    addSheet("F12", kRefuse, "the largest count", [](PointCloud2& c) { c.fields[0].count = kMax; });
    addSheet("F13", kEither, "y as float64 that reaches into z",
             [](PointCloud2& c) { c.fields[1].datatype = PointField::FLOAT64; });
    addSheet("F14", kRefuse, "names in capitals", [](PointCloud2& c) {
      for (PointField& field : c.fields) field.name[0] -= 'a' - 'A';
    });
    addSheet("F15", kRefuse, "no z", [](PointCloud2& c) { c.fields.pop_back(); });
    addSheet("F16", kRefuse, "a field name of a mebibyte", [](PointCloud2& c) { c.fields[0].name.assign(1 << 20, 'x'); });
    addSheet("F17", kEither, "ten thousand fields", [](PointCloud2& c) {
      for (int f = 0; f < 10000; ++f) c.fields.push_back(makeField("field" + std::to_string(f), 0));
    });
    addSheet("F18", kRefuse, "a zero byte in a field name", [](PointCloud2& c) { c.fields[0].name = std::string("x\0y", 3); });
    addSheet("F19", kRefuse, "three times x", [](PointCloud2& c) { c.fields[1].name = c.fields[2].name = "x"; });
    addSheet("F20", kRefuse, "an extra field far away", [](PointCloud2& c) { c.fields.push_back(makeField("intensity", 4000)); });
    addSheet("F21", kRefuse, "an extra field half outside", [](PointCloud2& c) { c.fields.push_back(makeField("rgb", 13)); });
    addChanged("F22", kRefuse, "a normal far away", makeSheet(100, 1, 32), [](PointCloud2& c) {
      c.fields.push_back(makeField("normal_x", 1u << 30));
      c.fields.push_back(makeField("normal_y", 20));
      c.fields.push_back(makeField("normal_z", 24));
    });
  }

  void addHeaders() {
    const auto setFrame = [](const std::string& frame) { return [=](PointCloud2& c) { c.header.frame_id = frame; }; };
    const auto setStamp = [](std::uint32_t sec, std::uint32_t nsec) {
      return [=](PointCloud2& c) {
        c.header.stamp.sec = sec;
        c.header.stamp.nsec = nsec;
      };
    };
    addSheet("H00", kEither, "no frame", setFrame(""));
    addSheet("H01", kRefuse, "a frame name of a mebibyte", setFrame(std::string(1 << 20, 'm')));
    addSheet("H02", kRefuse, "a frame name that clears the terminal", setFrame("map\n\x1b[2J[ INFO] all is well"));
    addSheet("H03", kEither, "a leading slash", setFrame("/map"));
    addSheet("H04", kAccept, "stamp zero", setStamp(0, 0));
    addSheet("H05", kEither, "the latest stamp", setStamp(kMax, 999999999));
    addSheet("H06", kRefuse, "nanoseconds of more than a second", setStamp(100, kMax));
    addSheet("H07", kRefuse, "a frame name that is no text", setFrame("\xff\xfe\x80"));
    addSheet("H08", kEither, "a frame name like a format", setFrame("%n%n%s%s%x"));
    addSheet("H09", kEither, "a frame name like a path", setFrame("../../etc/passwd"));
  }

  /// Correct messages whose points hardly form a surface.
  void addShapes() {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
    constexpr float kHuge = std::numeric_limits<float>::max(), kTiny = std::numeric_limits<float>::denorm_min();
    std::mt19937 engine(7);
    const auto draw = [&](float low, float high) { return low + (high - low) * float(engine()) / float(engine.max()); };
    const auto makeLine = [](int n, const std::function<Point3f(int)>& point) {
      Points3f points;
      for (int i = 0; i < n; ++i) points.push_back(point(i));
      return points;
    };
    const auto joined = [](Points3f a, const Points3f& b) {
      a.insert(a.end(), b.begin(), b.end());
      return a;
    };
    const auto changed = [](Points3f points, const std::function<void(Points3f&)>& change) {
      change(points);
      return points;
    };
    const auto scaled = [&](float factor) {
      return changed(makeGrid(20, 0.01f), [=](Points3f& points) {
        for (Point3f& p : points)
          for (float& c : p) c *= factor;
      });
    };
    const Points3f sheet = makeGrid(20, 0.01f);
    const auto hole_every_seventh = changed(sheet, [&](Points3f& p) {
      for (std::size_t i = 0; i < p.size(); i += 7) p[i][i % 3] = kNan;
    });
    const auto circle = makeLine(100, [](int i) { return Point3f{std::cos(0.0628f * i), std::sin(0.0628f * i), 0}; });
    const auto hair = makeLine(100, [](int i) { return Point3f{0, 0, 0.01f * i}; });

    addPoints("V00", kEither, "no points", {});
    addPoints("V01", kEither, "one point", {{0.3f, 0.2f, 0.1f}});
    addPoints("V02", kEither, "two points", {{0, 0, 0}, {0, 0.1f, 0}});
    addPoints("V03", kEither, "three points", {{0, 0, 0}, {0, 0.1f, 0}, {0.1f, 0, 0}});
    addPoints("V04", kEither, "one point a hundred times", Points3f(100, {3, 2, 1}));
    addPoints("V05", kEither, "every point twice", joined(sheet, sheet));
    addPoints("V06", kEither, "points on an axis", makeLine(100, [](int i) { return Point3f{0.01f * i, 0, 0}; }));
    addPoints("V07", kEither, "points on a skew line", makeLine(100, [&](int) {
                const float t = draw(0, 1);
                return Point3f{t, 2 * t, -3 * t};
              }));
    addPoints("V08", kAccept, "a plane grid", sheet);
    addPoints("V09", kAccept, "a circle", circle);
    addPoints("V10", kRefuse, "nothing but holes", Points3f(400, {kNan, kNan, kNan}), false);
    addPoints("V11", kEither, "a hole in every seventh point", hole_every_seventh, false);
    addPoints("V12", kEither, "holes, said to have none", hole_every_seventh, true);
    addPoints("V13", kEither, "infinite points", changed(sheet, [&](Points3f& p) {
                p[5] = {kInf, 0, 0};
                p[9] = {0, -kInf, 0};
              }));
    addPoints("V14", kEither, "points at the end of float32", changed(sheet, [&](Points3f& p) {
                p[5].fill(kHuge);
                p[9] = {-kHuge, 0, 0};
              }));
    addPoints("V15", kEither, "larger than the universe", scaled(1e20f));
    addPoints("V16", kEither, "smaller than an atom's nucleus", scaled(1e-25f));
    addPoints("V17", kAccept, "heights that are denormal", changed(sheet, [&](Points3f& p) {
                for (Point3f& q : p) q[2] = kTiny;
              }));
    addPoints("V18", kEither, "a millimetre grid a thousand kilometres away", makeGrid(30, 0.001f, {1e6f, 1e6f, 0}));
    addPoints("V19", kAccept, "a millimetre grid a kilometre away", makeGrid(30, 0.001f, {1e3f, 1e3f, 0}));
    addPoints("V20", kAccept, "a fine grid on a coarse one", joined(makeGrid(20, 0.1f), makeGrid(30, 0.0001f, {0.5f, 0.5f, 0})));
    addPoints("V21", kEither, "a few points far away",
              joined(sheet, makeLine(4, [&](int) {
                       return Point3f{draw(-1e4f, 1e4f), draw(-1e4f, 1e4f), draw(-1e4f, 1e4f)};
                     })));
    addPoints("V22", kAccept, "two sheets closer than their spacing", joined(sheet, makeGrid(20, 0.01f, {0, 0, 0.001f})));
    addPoints("V23", kEither, "a hair that stands on a sheet", joined(makeGrid(10, 0.01f), hair));
    addPoints("V24", kAccept, "two sheets far apart", joined(makeGrid(10, 0.01f), makeGrid(10, 0.01f, {5, 0, 0})));
    addPoints("V25", kEither, "a sheet and a lone point", joined(makeGrid(10, 0.01f), {{5, 5, 5}}));
    addPoints("V26", kAccept, "a sphere", makeLine(400, [&](int) {
                const float z = draw(-1, 1), angle = draw(0, 6.2831853f), r = std::sqrt(1 - z * z);
                return Point3f{r * std::cos(angle), r * std::sin(angle), z};
              }));
    addPoints("V27", kEither, "a filled cube", makeLine(400, [&](int) { return Point3f{draw(0, 1), draw(0, 1), draw(0, 1)}; }));
    addPoints("V28", kAccept, "negative zeros", changed(sheet, [](Points3f& p) {
                for (Point3f& q : p)
                  for (float& c : q)
                    if (c == 0) c = -0.0f;
              }));
    addPoints("V29", kEither, "a sliver", changed(sheet, [](Points3f& p) {
                for (Point3f& q : p) q[1] *= 1e-7f;
              }));
  }

  std::vector<BadCloud> clouds_;
};

}  // namespace deformable_surface::node::test
