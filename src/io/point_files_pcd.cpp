// Reading PCD files.
#include "point_files_read.h"

#include "deformable_surface/base/read_number.h"
#include "deformable_surface/base/value.h"

#include <pcl/io/lzf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace deformable_surface::io {

namespace {

using cloud::ScalarType;

// The most by which LZF, the compression of PCD, can shrink: three bytes stand for at most 264.
constexpr std::uint64_t kMaxCompression = 88;

std::string readBody(const std::string& file, const Head& head) {
  std::string body(head.file_bytes - head.header_bytes, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(head.header_bytes));
  stream.read(&body[0], static_cast<std::streamsize>(body.size()));
  if (!stream) refuse(file, "cannot be read to its end; accepted: a readable file");
  return body;
}

template <class T>
bool storeAs(double value, std::uint8_t* place) {
  if (std::numeric_limits<T>::is_integer &&
      !(value >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
        value <= static_cast<double>(std::numeric_limits<T>::max()) && value == std::floor(value))) {
    return false;
  }
  const T stored = static_cast<T>(value);
  std::memcpy(place, &stored, sizeof(stored));
  return true;
}

/// False if the type cannot hold the value.
bool storeScalar(ScalarType type, double value, std::uint8_t* place) {
  switch (type) {
    case ScalarType::kInt8: return storeAs<std::int8_t>(value, place);
    case ScalarType::kUint8: return storeAs<std::uint8_t>(value, place);
    case ScalarType::kInt16: return storeAs<std::int16_t>(value, place);
    case ScalarType::kUint16: return storeAs<std::uint16_t>(value, place);
    case ScalarType::kInt32: return storeAs<std::int32_t>(value, place);
    case ScalarType::kUint32: return storeAs<std::uint32_t>(value, place);
    case ScalarType::kFloat32: return storeAs<float>(value, place);
    case ScalarType::kFloat64: return storeAs<double>(value, place);
  }
  return false;
}

/// Records from lines of text, one line each.
void parseRows(const std::string& file, const std::string& body, Table& table) {
  const char* next = body.c_str();
  for (std::uint64_t i = 0; i < table.points; ++i) {
    next += std::strspn(next, " \t\r\n");
    for (const pcl::PCLPointField& field : table.data.fields) {
      const auto type = static_cast<ScalarType>(field.datatype);
      for (std::uint32_t k = 0; k < field.count; ++k) {
        next += std::strspn(next, " \t\r");
        const char* end = nullptr;
        const double value = *next == '\n' ? 0.0 : readNumber(next, &end);
        std::uint8_t* place = &table.data.data[i * table.data.point_step + field.offset + k * cloud::sizeOf(type)];
        if (!end || end == next || !storeScalar(type, value, place)) {
          refuse(file, "row " + std::to_string(i) + " behind the header: found " +
                           quote(std::string(next, std::strcspn(next, "\n"))) +
                           "; accepted: as many rows as the header says, with a number for each field");
        }
        next = end;
      }
    }
    next += std::strspn(next, " \t\r");
    if (*next != '\n' && *next != '\0') {
      refuse(file, "row " + std::to_string(i) + " behind the header: found more than one number for each field; accepted: one");
    }
  }
  next += std::strspn(next, " \t\r\n");
  if (*next != '\0') {
    refuse(file, "row " + std::to_string(table.points) + " behind the header: found " +
                     quote(std::string(next, std::strcspn(next, "\n"))) + "; accepted: as many rows as the header says, " +
                     std::to_string(table.points));
  }
}

/// Records from compressed data, which holds all values of the first field, then all of the second, and so on.
void decompressRows(const std::string& file, const std::string& body, Table& table) {
  std::uint32_t sizes[2] = {0, 0};  // compressed, uncompressed
  if (body.size() >= sizeof(sizes)) std::memcpy(sizes, body.data(), sizeof(sizes));
  std::string columns(table.data.data.size(), '\0');
  if (body.size() < sizeof(sizes) || sizes[0] > body.size() - sizeof(sizes) || sizes[1] != columns.size() ||
      pcl::lzfDecompress(body.data() + sizeof(sizes), sizes[0], &columns[0], sizes[1]) != sizes[1]) {
    refuse(file, "found compressed data of another size than the header says; accepted: a complete file");
  }
  const char* column = columns.data();
  for (const pcl::PCLPointField& field : table.data.fields) {
    const std::size_t size = field.count * cloud::sizeOf(static_cast<ScalarType>(field.datatype));
    for (std::uint64_t i = 0; i < table.points; ++i, column += size) {
      std::memcpy(&table.data.data[i * table.data.point_step + field.offset], column, size);
    }
  }
}

/// The entries of a header, by field, and what follows from the counts.
struct Header {
  std::vector<std::string> names, sizes, types, counts, viewpoint;
  std::uint64_t width = 0, height = 1, points = 0;
  std::string encoding;
};

Header readHeader(const std::string& file, const Head& head) {
  Header h;
  bool has_points = false;
  for (const std::vector<std::string>& words : head.lines) {
    if (words.size() < 2) continue;
    const std::vector<std::string> rest(words.begin() + 1, words.end());
    if (words[0] == "FIELDS" || words[0] == "COLUMNS") h.names = rest;
    if (words[0] == "SIZE") h.sizes = rest;
    if (words[0] == "TYPE") h.types = rest;
    if (words[0] == "COUNT") h.counts = rest;
    if (words[0] == "WIDTH") h.width = toCount(file, rest[0]);
    if (words[0] == "HEIGHT") h.height = toCount(file, rest[0]);
    if (words[0] == "VIEWPOINT") h.viewpoint = rest;
    if (words[0] == "DATA") h.encoding = rest[0];
    if (words[0] == "POINTS") {
      h.points = toCount(file, rest[0]);
      has_points = true;
    }
  }
  if (h.counts.empty()) h.counts.assign(h.names.size(), "1");
  if (h.names.empty() || h.sizes.size() != h.names.size() || h.types.size() != h.names.size() ||
      h.counts.size() != h.names.size()) {
    refuse(file, "found FIELDS, SIZE, TYPE and COUNT of different lengths in the header; accepted: one entry for each field");
  }
  if (!has_points) h.points = h.width * h.height;
  return h;
}

/// Adds the fields to the table and returns the number of scalars in a point.
std::uint64_t addFields(const std::string& file, const Header& h, Table& table) {
  std::uint64_t step = 0, scalars = 0;
  for (std::size_t f = 0; f < h.names.size(); ++f) {
    // In the order of ScalarType, which begins at 1.
    static const std::vector<std::string> kTypes{"I1", "U1", "I2", "U2", "I4", "U4", "F4", "F8"};
    const auto type = std::find(kTypes.begin(), kTypes.end(), h.types[f] + h.sizes[f]);
    if (type == kTypes.end()) {
      refuse(file, "found the type " + quote(h.types[f] + h.sizes[f]) + " for the field " + quote(h.names[f]) +
                       "; accepted: F4, F8, I1, I2, I4, U1, U2, U4");
    }
    pcl::PCLPointField field;
    field.name = h.names[f];
    field.datatype = static_cast<std::uint8_t>(type - kTypes.begin() + 1);
    field.offset = static_cast<std::uint32_t>(step);
    const std::uint64_t count = toCount(file, h.counts[f]);
    scalars += count;
    if (count == 0 || scalars > kMaxScalars) {
      refuse(file, "found " + quote(h.counts[f]) + " as the COUNT of the field " + quote(h.names[f]) +
                       "; accepted: from 1, and at most " + std::to_string(kMaxScalars) + " in all");
    }
    field.count = static_cast<std::uint32_t>(count);
    step += count * cloud::sizeOf(static_cast<ScalarType>(field.datatype));
    table.data.fields.push_back(field);
  }
  table.data.point_step = static_cast<std::uint32_t>(step);
  return scalars;
}

/// Too many points are refused before anything is multiplied by them, and a short file before memory is allocated.
void checkBody(const std::string& file, const Header& h, std::uint64_t body_bytes, std::uint64_t step, std::uint64_t scalars,
               Index max_points) {
  if (h.points != h.width * h.height) {
    refuse(file, "found " + std::to_string(h.points) + " points in " + std::to_string(h.width) + " x " +
                     std::to_string(h.height) + "; accepted: POINTS = WIDTH * HEIGHT");
  }
  checkCounts(file, h.points, body_bytes, 0, max_points);
  if (h.encoding == "ascii") {
    // The last line may lack its end.
    checkCounts(file, h.points, body_bytes + 1, h.points * scalars * kMinTextBytes, max_points);
  } else if (h.encoding == "binary") {
    checkCounts(file, h.points, body_bytes, h.points * step, max_points);
  } else if (h.encoding == "binary_compressed") {
    checkCounts(file, h.points, kMaxCompression * body_bytes, h.points * step, max_points);
  } else {
    refuse(file, "found DATA " + quote(h.encoding) + "; accepted: ascii, binary, binary_compressed");
  }
}

}  // namespace

/// PCL's own reader follows broken headers out of its memory, so only the decompression is PCL's.
Table readPcd(const std::string& file, Index max_points) {
  const Head head = readHead(file, "DATA");
  const Header h = readHeader(file, head);
  Table table;
  const std::uint64_t scalars = addFields(file, h, table), step = table.data.point_step;
  checkBody(file, h, head.file_bytes - head.header_bytes, step, scalars, max_points);
  table.points = h.points;
  table.data.width = static_cast<std::uint32_t>(h.width);
  table.data.height = static_cast<std::uint32_t>(h.height);
  table.data.data.resize(table.points * step);
  const std::string body = readBody(file, head);
  if (h.encoding == "ascii") {
    parseRows(file, body, table);
  } else if (h.encoding == "binary") {
    std::memcpy(table.data.data.data(), body.data(), table.data.data.size());
  } else {
    decompressRows(file, body, table);
  }
  for (std::size_t c = 0; c < 3 && c < h.viewpoint.size(); ++c) {
    const Value number = parseNumber(h.viewpoint[c]);
    if (number.isNull()) refuse(file, "found " + quote(h.viewpoint[c]) + " in VIEWPOINT; accepted: numbers");
    table.viewpoint[static_cast<int>(c)] = number.asReal() ? *number.asReal() : static_cast<double>(*number.asInteger());
  }
  return table;
}

}  // namespace deformable_surface::io
