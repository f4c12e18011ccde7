// Reading PCD files.
#include "point_files_read.h"

#include "deformable_surface/base/value.h"

#include <pcl/io/lzf.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
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
        char* end = nullptr;
        const double value = *next == '\n' ? 0.0 : std::strtod(next, &end);
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

}  // namespace

/// PCL's own reader follows broken headers out of its memory, so only the decompression is PCL's.
Table readPcd(const std::string& file, Index max_points) {
  const Head head = readHead(file, "DATA");
  Table table;
  std::vector<std::string> names, sizes, types, counts, viewpoint;
  std::uint64_t width = 0, height = 1;
  bool has_points = false;
  std::string encoding;
  for (const std::vector<std::string>& words : head.lines) {
    if (words.size() < 2) continue;
    const std::vector<std::string> rest(words.begin() + 1, words.end());
    if (words[0] == "FIELDS" || words[0] == "COLUMNS") names = rest;
    if (words[0] == "SIZE") sizes = rest;
    if (words[0] == "TYPE") types = rest;
    if (words[0] == "COUNT") counts = rest;
    if (words[0] == "WIDTH") width = toCount(file, rest[0]);
    if (words[0] == "HEIGHT") height = toCount(file, rest[0]);
    if (words[0] == "VIEWPOINT") viewpoint = rest;
    if (words[0] == "DATA") encoding = rest[0];
    if (words[0] == "POINTS") {
      table.points = toCount(file, rest[0]);
      has_points = true;
    }
  }
  if (counts.empty()) counts.assign(names.size(), "1");
  if (names.empty() || sizes.size() != names.size() || types.size() != names.size() || counts.size() != names.size()) {
    refuse(file, "found FIELDS, SIZE, TYPE and COUNT of different lengths in the header; accepted: one entry for each field");
  }

  // Bytes and scalars of one point.
  std::uint64_t step = 0, scalars = 0;
  for (std::size_t f = 0; f < names.size(); ++f) {
    // In the order of ScalarType, which begins at 1.
    static const std::vector<std::string> kTypes{"I1", "U1", "I2", "U2", "I4", "U4", "F4", "F8"};
    const auto type = std::find(kTypes.begin(), kTypes.end(), types[f] + sizes[f]);
    if (type == kTypes.end()) {
      refuse(file, "found the type " + quote(types[f] + sizes[f]) + " for the field " + quote(names[f]) +
                       "; accepted: F4, F8, I1, I2, I4, U1, U2, U4");
    }
    pcl::PCLPointField field;
    field.name = names[f];
    field.datatype = static_cast<std::uint8_t>(type - kTypes.begin() + 1);
    field.offset = static_cast<std::uint32_t>(step);
    const std::uint64_t count = toCount(file, counts[f]);
    scalars += count;
    if (count == 0 || scalars > kMaxScalars) {
      refuse(file, "found " + quote(counts[f]) + " as the COUNT of the field " + quote(names[f]) +
                       "; accepted: from 1, and at most " + std::to_string(kMaxScalars) + " in all");
    }
    field.count = static_cast<std::uint32_t>(count);
    step += count * cloud::sizeOf(static_cast<ScalarType>(field.datatype));
    table.data.fields.push_back(field);
  }
  if (!has_points) table.points = width * height;
  if (table.points != width * height) {
    refuse(file, "found " + std::to_string(table.points) + " points in " + std::to_string(width) + " x " +
                     std::to_string(height) + "; accepted: POINTS = WIDTH * HEIGHT");
  }

  // Too many points are refused before anything is multiplied by them, and a short file before memory is taken.
  const std::uint64_t body_bytes = head.file_bytes - head.header_bytes;
  checkCounts(file, table.points, body_bytes, 0, max_points);
  if (encoding == "ascii") {
    // The last line may lack its end.
    checkCounts(file, table.points, body_bytes + 1, table.points * scalars * kMinTextBytes, max_points);
  } else if (encoding == "binary") {
    checkCounts(file, table.points, body_bytes, table.points * step, max_points);
  } else if (encoding == "binary_compressed") {
    checkCounts(file, table.points, kMaxCompression * body_bytes, table.points * step, max_points);
  } else {
    refuse(file, "found DATA " + quote(encoding) + "; accepted: ascii, binary, binary_compressed");
  }
  table.data.width = static_cast<std::uint32_t>(width);
  table.data.height = static_cast<std::uint32_t>(height);
  table.data.point_step = static_cast<std::uint32_t>(step);
  table.data.data.resize(table.points * step);
  const std::string body = readBody(file, head);
  if (encoding == "ascii") {
    parseRows(file, body, table);
  } else if (encoding == "binary") {
    std::memcpy(table.data.data.data(), body.data(), table.data.data.size());
  } else {
    decompressRows(file, body, table);
  }
  for (std::size_t c = 0; c < 3 && c < viewpoint.size(); ++c) {
    const Value number = parseNumber(viewpoint[c]);
    if (number.isNull()) refuse(file, "found " + quote(viewpoint[c]) + " in VIEWPOINT; accepted: numbers");
    table.viewpoint[static_cast<int>(c)] = number.asReal() ? *number.asReal() : static_cast<double>(*number.asInteger());
  }
  return table;
}

}  // namespace deformable_surface::io
