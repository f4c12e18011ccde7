// Reading plain text, a point on each line.
#include "point_files_read.h"

#include "deformable_surface/base/value.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace deformable_surface::io {

using cloud::PointCloud;
using cloud::ScalarType;

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

}  // namespace deformable_surface::io
