// Reading PLY files: the header is checked here for what PCL takes on trust, and PCL parses the rest.
#include "point_files_read.h"

#include "deformable_surface/base/read_number.h"
#include "deformable_surface/base/value.h"

#include <pcl/io/ply_io.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <fstream>
#include <numeric>

#include "quiet_pcl.h"

namespace deformable_surface::io {

namespace {

using cloud::ScalarType;

std::uint64_t sizeOfPlyType(const std::string& file, const std::string& type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "float" || type == "int32" || type == "uint32" || type == "float32") return 4;
  if (type == "double" || type == "float64") return 8;
  refuse(file, "found the property type " + quote(type) + "; accepted: char, uchar, short, ushort, int, uint, float, double");
}

/// Of a vertex.
struct Property {
  std::string name;
  bool is_whole;
  std::int64_t least, most;  // of whole numbers

  bool canHold(double x) const {
    return !is_whole || (x >= static_cast<double>(least) && x <= static_cast<double>(most) && x == std::floor(x));
  }
};

Property makeProperty(const std::string& file, const std::string& type, const std::string& name) {
  const std::int64_t range = std::int64_t{1} << (8 * std::min(std::uint64_t{4}, sizeOfPlyType(file, type)));
  const std::int64_t least = type[0] == 'u' ? 0 : -range / 2;
  return {name, type[0] != 'f' && type[0] != 'd', least, least + range - 1};
}

/// Checks the lines behind the header: PCL takes words for NaN, cuts off integers that are too large, and leaves out the lines
/// that are too many. counts: of the elements, a line each, the vertices first.
void checkLines(const std::string& file, const Head& head, const std::vector<std::uint64_t>& counts,
                const std::vector<Property>& properties) {
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(head.header_bytes));
  const std::uint64_t points = counts[0], wanted = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  const std::string one_each = "a number for each of the " + std::to_string(properties.size()) + " properties";
  std::string line;
  std::uint64_t row = 0;
  for (; std::getline(stream, line); ++row) {
    const char* next = line.c_str();
    const auto skipBlanks = [&] { next += std::strspn(next, " \t\r"); };
    const auto refuseLine = [&](const std::string& accepted) {
      refuse(file, "line " + std::to_string(head.lines.size() + row + 1) + ": found " + quote(line) + "; accepted: " + accepted);
    };
    skipBlanks();
    if (row >= wanted && *next != '\0') refuseLine("as many lines as the header says, " + std::to_string(wanted));
    if (row >= points) continue;
    for (const Property& property : properties) {
      const char* end = nullptr;
      const double value = readNumber(next, &end);
      if (end == next) refuseLine(one_each);
      if (!property.canHold(value))
        refuseLine("whole numbers from " + std::to_string(property.least) + " to " + std::to_string(property.most) + " for " +
                   quote(property.name));
      next = end;
      skipBlanks();
    }
    if (*next != '\0') refuseLine(one_each);
  }
  if (row < wanted)
    refuse(file,
           "found " + std::to_string(row) + " lines behind the header; accepted: as many as it says, " + std::to_string(wanted));
}

/// Checks the header of a PLY file for all that PCL takes on trust. Returns the number of points.
std::uint64_t checkPly(const std::string& file, Index max_points) {
  const Head head = readHead(file, "end_header");
  if (head.lines[0] != std::vector<std::string>{"ply"}) refuse(file, "found another first line than 'ply'; accepted: a PLY file");
  std::string format;
  std::vector<Property> properties;  // of the vertices
  std::uint64_t points = 0, step = 0;
  std::vector<std::uint64_t> counts;  // of the elements
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
      if (counts.empty() != (words[1] == "vertex")) refuse(file, "accepted: one element 'vertex', before all others");
      if (words[1] == "range_grid") refuse(file, "found a range grid; accepted: a plain list of vertices");
      if (counts.empty()) points = count;
      counts.push_back(count);
    }
    if (words[0] != "property" || counts.size() != 1) continue;
    if (words.size() != 3) refuse(file, "found a list among the properties of the vertices; accepted: single numbers");
    const std::string &type = words[1], &name = words[2];
    step += sizeOfPlyType(file, type);
    if (std::any_of(properties.begin(), properties.end(), [&](const Property& p) { return p.name == name; }))
      refuse(file, "found the property " + quote(name) + " twice; accepted: once");
    // Byte colours are packed by PCL as they come.
    const std::string before = properties.empty() ? "" : properties.back().name;
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
    properties.push_back(makeProperty(file, type, name));
  }
  const std::uint64_t body = head.file_bytes - head.header_bytes;
  if (properties.size() > kMaxScalars)
    refuse(file, "found too many properties; accepted: at most " + std::to_string(kMaxScalars));
  if (format == "ascii") {
    checkCounts(file, points, body + 1, points * properties.size() * kMinTextBytes, max_points);
    checkLines(file, head, counts, properties);
  } else if (format == "binary_little_endian" || format == "binary_big_endian") {
    checkCounts(file, points, body, points * step, max_points);
  } else {
    refuse(file, "found the format " + quote(format) + "; accepted: ascii, binary_little_endian, binary_big_endian");
  }
  return points;
}

}  // namespace

Table readPly(const std::string& file, Index max_points) {
  Table table;
  table.points = checkPly(file, max_points);
  const QuietPcl quiet;
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

}  // namespace deformable_surface::io
