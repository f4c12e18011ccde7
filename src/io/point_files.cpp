// Reading point files. Headers are checked here, against the size of the file, before memory is taken; PCL decompresses PCD and
// parses PLY.
#include "deformable_surface/io/point_files.h"

#include "point_files_common.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/lzf.h>
#include <pcl/io/ply_io.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <locale>
#include <set>
#include <sstream>

namespace deformable_surface::io {

namespace {

using cloud::ExtraField;
using cloud::PointCloud;
using cloud::ScalarType;

// Headers of real files end within a few kilobytes.
constexpr std::size_t kMaxHeader = std::size_t{1} << 16;

// The most by which LZF, the compression of PCD, can shrink: three bytes stand for at most 264.
constexpr std::uint64_t kMaxCompression = 88;

// One scalar written as text takes a digit and a separator.
constexpr std::uint64_t kMinTextBytes = 2;

// Scalars per point; real files have some dozens.
constexpr std::uint64_t kMaxScalars = 10000;

std::string resolve(const std::string& file, const FindPackage& find_package) {
  const std::string scheme = "package://";
  if (file.compare(0, scheme.size(), scheme) != 0) return file;
  const std::size_t slash = file.find('/', scheme.size());
  const std::string package = file.substr(scheme.size(), slash - scheme.size());
  if (package.empty() || slash == std::string::npos) refuse(file, "accepted: package://PACKAGE/PATH");
  if (!find_package) refuse(file, "packages are not known here; accepted: a path");
  return find_package(package) + file.substr(slash);
}

std::vector<std::string> splitWords(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// The head of a file, up to the line that ends its header, and its size.
struct Head {
  std::vector<std::vector<std::string>> lines;  // words of each line
  std::uint64_t header_bytes = 0, file_bytes = 0;
};

Head readHead(const std::string& file, const std::string& last_word) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) refuse(file, std::string("cannot be opened: ") + std::strerror(errno));
  std::string head(kMaxHeader, '\0');
  stream.read(&head[0], static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  if (head.empty()) refuse(file, "found no bytes to read; accepted: a point file");
  Head result;
  stream.clear();
  stream.seekg(0, std::ios::end);
  result.file_bytes = static_cast<std::uint64_t>(stream.tellg());

  for (std::size_t begin = 0; begin < head.size();) {
    const std::size_t end = head.find('\n', begin);
    if (end == std::string::npos) break;
    result.lines.push_back(splitWords(head.substr(begin, end - begin)));
    begin = end + 1;
    if (!result.lines.back().empty() && result.lines.back()[0] == last_word) {
      result.header_bytes = begin;
      return result;
    }
  }
  refuse(file, "found no line " + quote(last_word) + " in the first " + std::to_string(kMaxHeader) +
                   " bytes; accepted: a complete header");
}

std::uint64_t toCount(const std::string& file, const std::string& word) {
  const Value value = parseNumber(word);
  if (!value.asInteger() || *value.asInteger() < 0 || *value.asInteger() > std::numeric_limits<std::uint32_t>::max()) {
    refuse(file, "found " + quote(word) + " as a count in the header; accepted: an integer from 0 to 2^32 - 1");
  }
  return static_cast<std::uint64_t>(*value.asInteger());
}

void checkCounts(const std::string& file, std::uint64_t points, std::uint64_t body_bytes, std::uint64_t needed_bytes,
                 Index max_points) {
  if (points == 0) refuse(file, "found no points; accepted: at least one");
  if (points > static_cast<std::uint64_t>(max_points)) {
    refuse(file, "found " + std::to_string(points) + " points; accepted: at most " + std::to_string(max_points));
  }
  if (needed_bytes > body_bytes) {
    refuse(file, "found " + std::to_string(body_bytes) + " bytes behind the header, but " + std::to_string(points) +
                     " points need at least " + std::to_string(needed_bytes) + "; accepted: a complete file");
  }
}

/// One record of numbers per point, as a file holds them, and where the scanner stood.
struct Table {
  pcl::PCLPointCloud2 data;
  std::uint64_t points = 0;
  Vec3 viewpoint = Vec3::Zero();
};

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
    case ScalarType::kInt8:
      return storeAs<std::int8_t>(value, place);
    case ScalarType::kUint8:
      return storeAs<std::uint8_t>(value, place);
    case ScalarType::kInt16:
      return storeAs<std::int16_t>(value, place);
    case ScalarType::kUint16:
      return storeAs<std::uint16_t>(value, place);
    case ScalarType::kInt32:
      return storeAs<std::int32_t>(value, place);
    case ScalarType::kUint32:
      return storeAs<std::uint32_t>(value, place);
    case ScalarType::kFloat32:
      return storeAs<float>(value, place);
    case ScalarType::kFloat64:
      return storeAs<double>(value, place);
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

std::uint64_t sizeOfPlyType(const std::string& file, const std::string& type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "float" || type == "int32" || type == "uint32" || type == "float32") return 4;
  if (type == "double" || type == "float64") return 8;
  refuse(file, "found the property type " + quote(type) + "; accepted: char, uchar, short, ushort, int, uint, float, double");
}

/// Checks the header of a PLY file for all that PCL takes on trust. Returns the number of points.
std::uint64_t checkPly(const std::string& file, Index max_points) {
  const Head head = readHead(file, "end_header");
  if (head.lines[0] != std::vector<std::string>{"ply"}) refuse(file, "found another first line than 'ply'; accepted: a PLY file");
  std::string format;
  std::vector<std::string> properties;  // of the vertices
  std::uint64_t points = 0, step = 0;
  int elements = 0;
  for (const std::vector<std::string>& words : head.lines) {
    if (words.empty()) continue;
    if (words[0] == "format" && words.size() == 3) format = words[1];
    if (words[0] == "obj_info" && words.size() > 1 && (words[1] == "num_cols" || words[1] == "num_rows")) {
      refuse(file, "found a range grid; accepted: a plain list of vertices");
    }
    if (words[0] == "element" && words.size() == 3) {
      const std::uint64_t count = toCount(file, words[2]);
      if (count > head.file_bytes)
        refuse(file, "found more elements " + quote(words[1]) + " than bytes; accepted: a complete file");
      if ((++elements == 1) != (words[1] == "vertex")) refuse(file, "accepted: one element 'vertex', before all others");
      if (words[1] == "range_grid") refuse(file, "found a range grid; accepted: a plain list of vertices");
      if (elements == 1) points = count;
    }
    if (words[0] != "property" || elements != 1) continue;
    if (words.size() != 3) refuse(file, "found a list among the properties of the vertices; accepted: single numbers");
    const std::string &type = words[1], &name = words[2];
    step += sizeOfPlyType(file, type);
    if (std::count(properties.begin(), properties.end(), name))
      refuse(file, "found the property " + quote(name) + " twice; accepted: once");
    // Byte colours are packed by PCL as they come.
    const std::string before = properties.empty() ? "" : properties.back();
    if (type == "uchar" || type == "uint8") {
      for (const std::string prefix : {"", "diffuse_"}) {
        if ((name == prefix + "green" && before != prefix + "red") || (name == prefix + "blue" && before != prefix + "green") ||
            (name == "alpha" && before != "blue" && before != "diffuse_blue")) {
          refuse(file, "found the colour " + quote(name) + " out of its place; accepted: red, green, blue and then alpha");
        }
      }
    }
    if ((before == "red" && name != "green") || (before == "green" && name != "blue")) {
      refuse(file, "found an incomplete colour; accepted: red, green and blue together");
    }
    properties.push_back(name);
  }
  const std::uint64_t body = head.file_bytes - head.header_bytes;
  if (properties.size() > kMaxScalars)
    refuse(file, "found too many properties; accepted: at most " + std::to_string(kMaxScalars));
  if (format == "ascii") {
    checkCounts(file, points, body + 1, points * properties.size() * kMinTextBytes, max_points);
  } else if (format == "binary_little_endian" || format == "binary_big_endian") {
    checkCounts(file, points, body, points * step, max_points);
  } else {
    refuse(file, "found the format " + quote(format) + "; accepted: ascii, binary_little_endian, binary_big_endian");
  }
  return points;
}

/// Position of the scalar fields with these three names, or an empty list.
std::vector<const pcl::PCLPointField*> findTriple(const pcl::PCLPointCloud2& data, const char* const names[3]) {
  std::vector<const pcl::PCLPointField*> triple;
  for (int c = 0; c < 3; ++c) {
    for (const pcl::PCLPointField& field : data.fields) {
      const bool is_float = field.datatype == pcl::PCLPointField::FLOAT32 || field.datatype == pcl::PCLPointField::FLOAT64;
      if (field.name == names[c] && is_float && field.count <= 1) {
        triple.push_back(&field);
        break;
      }
    }
  }
  if (triple.size() != 3) triple.clear();
  return triple;
}

double readScalar(const std::uint8_t* bytes, const pcl::PCLPointField& field) {
  if (field.datatype == pcl::PCLPointField::FLOAT64) {
    double value;
    std::memcpy(&value, bytes + field.offset, sizeof(value));
    return value;
  }
  float value;
  std::memcpy(&value, bytes + field.offset, sizeof(value));
  return value;
}

Points readTriple(const pcl::PCLPointCloud2& data, const std::vector<const pcl::PCLPointField*>& triple, std::size_t n) {
  Points rows(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t* bytes = data.data.data() + i * data.point_step;
    for (int c = 0; c < 3; ++c) rows[i][c] = readScalar(bytes, *triple[c]);
  }
  return rows;
}

Table readPly(const std::string& file, Index max_points) {
  Table table;
  table.points = checkPly(file, max_points);
  // PCL writes its complaints to the console; ours are exceptions.
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  Eigen::Vector4f origin = Eigen::Vector4f::Zero();
  Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();
  int version = 0, failed = 0;
  try {
    failed = pcl::PLYReader().read(file, table.data, origin, orientation, version);
  } catch (const std::exception& error) {
    refuse(file, std::string("cannot be read: ") + error.what());
  }
  // A camera may have changed width and height, so the bytes tell what there is.
  if (failed < 0 || table.data.point_step == 0 || table.data.data.size() != table.points * table.data.point_step) {
    refuse(file, "found broken or missing rows; accepted: as many rows as the header says, each complete");
  }
  for (const pcl::PCLPointField& field : table.data.fields) {
    const auto type = static_cast<std::uint8_t>(field.datatype);
    if (type < static_cast<std::uint8_t>(ScalarType::kInt8) || type > static_cast<std::uint8_t>(ScalarType::kFloat64) ||
        field.offset + std::uint64_t{field.count} * cloud::sizeOf(static_cast<ScalarType>(type)) > table.data.point_step) {
      refuse(file, "found the field " + quote(field.name) + " of an unknown type; accepted: integers to 32 bits, floats");
    }
  }
  table.data.width = static_cast<std::uint32_t>(table.points);
  table.data.height = 1;
  table.viewpoint = origin.head<3>().cast<double>();
  return table;
}

PointCloud toCloud(const std::string& file, const Table& table) {
  const pcl::PCLPointCloud2& data = table.data;
  const std::uint64_t points = table.points;
  PointCloud cloud;
  const char* const kPosition[3] = {"x", "y", "z"};
  const char* const kNormals[2][3] = {{"normal_x", "normal_y", "normal_z"}, {"nx", "ny", "nz"}};
  std::vector<const pcl::PCLPointField*> taken = findTriple(data, kPosition);
  if (taken.empty()) refuse(file, "found no x, y, z of type float32 or float64; accepted: files that have them");
  cloud.positions = readTriple(data, taken, points);
  for (const auto& names : kNormals) {
    const std::vector<const pcl::PCLPointField*> normals = findTriple(data, names);
    if (normals.empty() || !cloud.normals.empty()) continue;
    cloud.normals = readTriple(data, normals, points);
    taken.insert(taken.end(), normals.begin(), normals.end());
  }

  // What is left travels along; "_" is padding.
  for (const pcl::PCLPointField& field : data.fields) {
    if (field.name == "_" || std::count(taken.begin(), taken.end(), &field)) continue;
    ExtraField extra{field.name, static_cast<ScalarType>(field.datatype), std::max(1u, static_cast<unsigned>(field.count)), {}};
    const std::size_t size = extra.count * cloud::sizeOf(extra.type);
    extra.bytes.resize(points * size);
    for (std::size_t i = 0; i < points; ++i) {
      std::memcpy(&extra.bytes[i * size], &data.data[i * data.point_step + field.offset], size);
    }
    cloud.extra_fields.push_back(std::move(extra));
  }
  cloud.width = data.width;
  cloud.height = data.height;
  if (table.viewpoint.allFinite() && table.viewpoint != Vec3::Zero()) cloud.viewpoint = table.viewpoint;
  return cloud;
}

PointCloud readXyz(const std::string& file, Index max_points) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) refuse(file, std::string("cannot be opened: ") + std::strerror(errno));
  PointCloud cloud;
  std::size_t columns = 0, number = 0;
  std::vector<double> row;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const auto refuseLine = [&](const std::string& sentence) {
      refuse(file, "line " + std::to_string(number) + ": " + sentence);
    };
    // The numbers of the line.
    row.clear();
    const char* next = line.c_str();
    while (*(next += std::strspn(next, " \t\r")) != '\0' && *next != '#') {
      char* end = nullptr;
      row.push_back(std::strtod(next, &end));
      if (end == next) refuseLine("found " + quote(next) + "; accepted: numbers with spaces between them");
      next = end;
    }
    if (row.empty()) continue;
    if (columns == 0) {
      columns = row.size();
      if (columns != 3 && (columns < 6 || columns > kMaxScalars)) {
        refuseLine("found " + std::to_string(columns) + " numbers; accepted: 3 (x y z), or 6 and more (with a normal)");
      }
      for (std::size_t c = 6; c < columns; ++c) {
        cloud.extra_fields.push_back({"column_" + std::to_string(c + 1), ScalarType::kFloat64, 1, {}});
      }
    }
    if (row.size() != columns) {
      refuseLine("found " + std::to_string(row.size()) + " numbers; accepted: " + std::to_string(columns) +
                 ", as in the first line");
    }
    if (cloud.size() == max_points) refuseLine("found more points; accepted: at most " + std::to_string(max_points));
    cloud.positions.emplace_back(row[0], row[1], row[2]);
    if (columns >= 6) cloud.normals.emplace_back(row[3], row[4], row[5]);
    for (std::size_t c = 6; c < columns; ++c) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&row[c]);
      std::vector<std::uint8_t>& out = cloud.extra_fields[c - 6].bytes;
      out.insert(out.end(), bytes, bytes + sizeof(double));
    }
  }
  if (!stream.eof()) refuse(file, "cannot be read to its end; accepted: a readable file");
  if (cloud.positions.empty()) refuse(file, "found no points; accepted: at least one");
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  return cloud;
}

}  // namespace

cloud::PointCloud readPointFile(const std::string& file, double scale, Index max_points, const FindPackage& find_package) {
  const std::string path = resolve(file, find_package);
  const std::string extension = toLowerExtension(path);
  PointCloud cloud;
  if (extension == ".pcd") {
    cloud = toCloud(path, readPcd(path, max_points));
  } else if (extension == ".ply") {
    cloud = toCloud(path, readPly(path, max_points));
  } else if (extension == ".xyz") {
    cloud = readXyz(path, max_points);
  } else {
    refuse(file, "found the extension " + quote(extension) + "; accepted: .pcd, .ply, .xyz");
  }
  // All-zero normals are how some writers say that there are none.
  const auto is_zero = [](const Vec3& normal) { return normal == Vec3::Zero(); };
  if (std::all_of(cloud.normals.begin(), cloud.normals.end(), is_zero)) cloud.normals.clear();
  for (Vec3& position : cloud.positions) position *= scale;
  if (cloud.viewpoint) *cloud.viewpoint *= scale;
  return cloud;
}

}  // namespace deformable_surface::io
