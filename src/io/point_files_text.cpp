// Reading text in which a line is a point: plain numbers, and the vertices of a Wavefront object or of an OFF file.
#include "point_files_read.h"

#include "deformable_surface/base/read_number.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

namespace deformable_surface::io {
namespace {

using cloud::PointCloud;
using cloud::ScalarType;

constexpr char kBlanks[] = " \t\r";
constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";  // of UTF-8

constexpr double kLeastLength = 0.9, kMostLength = 1.1;  // of a normal: files round to one digit or more
constexpr double kFewestUnit = 0.9;                      // of the rows that have one

/// The lines of a file one after the other, with sentences that name them.
class Lines {
 public:
  explicit Lines(const std::string& file) : file_(file), stream_(file, std::ios::binary) {
    if (!stream_) io::refuse(file, std::string("cannot be opened: ") + std::strerror(errno));
  }

  /// The next one that is not blank, without what stands before its first word; nullptr at the end of the file.
  const char* next() {
    while (std::getline(stream_, line_)) {
      if (++number_ == 1 && line_.compare(0, std::strlen(kByteOrderMark), kByteOrderMark) == 0)
        line_.erase(0, std::strlen(kByteOrderMark));
      const char* first = line_.c_str() + std::strspn(line_.c_str(), kBlanks);
      if (*first != '\0' && *first != '#') return first;
    }
    if (!stream_.eof()) io::refuse(file_, "cannot be read to its end; accepted: a readable file");
    return nullptr;
  }

  /// The numbers of the rest of the line, up to a remark.
  const std::vector<double>& readNumbers(const char* next) {
    row_.clear();
    while (*(next += std::strspn(next, kBlanks)) != '\0' && *next != '#') {
      const char* end = nullptr;
      row_.push_back(readNumber(next, &end));
      if (end == next) refuse("found " + quote(next) + "; accepted: numbers with spaces between them");
      next = end;
    }
    return row_;
  }

  [[noreturn]] void refuse(const std::string& sentence) const {
    io::refuse(file_, "line " + std::to_string(number_) + ": " + sentence);
  }

 private:
  const std::string& file_;
  std::ifstream stream_;
  std::string line_;
  std::vector<double> row_;
  std::size_t number_ = 0;
};

void addPosition(const std::vector<double>& row, const Lines& lines, Index max_points, PointCloud& cloud) {
  if (cloud.size() == max_points) lines.refuse("found more points; accepted: at most " + std::to_string(max_points));
  cloud.positions.emplace_back(row[0], row[1], row[2]);
}

void finish(const std::string& file, PointCloud& cloud) {
  if (cloud.positions.empty()) refuse(file, "found no points; accepted: at least one");
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
}

// Columns 4 to 6 may be anything. Normals have about unit length; zeros and values that are not finite stand for missing ones.
bool areNormals(const Points& columns) {
  Index num_unit = 0, num_given = 0;
  for (const Vec3& row : columns) {
    const double length = row.norm();
    if (length == 0.0 || !std::isfinite(length)) continue;
    ++num_given;
    num_unit += length >= kLeastLength && length <= kMostLength;
  }
  return static_cast<double>(num_unit) >= kFewestUnit * static_cast<double>(num_given);
}

void keepAsFields(PointCloud& cloud) {
  std::vector<cloud::ExtraField> fields;
  for (int c = 0; c < 3; ++c) {
    cloud::ExtraField field{"column_" + std::to_string(c + 4), ScalarType::kFloat64, 1, {}};
    field.bytes.resize(cloud.normals.size() * sizeof(double));
    for (std::size_t i = 0; i < cloud.normals.size(); ++i)
      std::memcpy(&field.bytes[i * sizeof(double)], &cloud.normals[i][c], sizeof(double));
    fields.push_back(std::move(field));
  }
  cloud.extra_fields.insert(cloud.extra_fields.begin(), std::make_move_iterator(fields.begin()),
                            std::make_move_iterator(fields.end()));
  cloud.normals.clear();
}

}  // namespace

PointCloud readXyz(const std::string& file, Index max_points) {
  Lines lines(file);
  PointCloud cloud;
  std::size_t columns = 0;
  while (const char* line = lines.next()) {
    const std::vector<double>& row = lines.readNumbers(line);
    if (columns == 0) {
      columns = row.size();
      if (columns != 3 && (columns < 6 || columns > kMaxScalars))
        lines.refuse("found " + std::to_string(columns) + " numbers; accepted: 3 (x y z), or 6 and more (with a normal)");
      for (std::size_t c = 6; c < columns; ++c)
        cloud.extra_fields.push_back({"column_" + std::to_string(c + 1), ScalarType::kFloat64, 1, {}});
    }
    if (row.size() != columns)
      lines.refuse("found " + std::to_string(row.size()) + " numbers; accepted: " + std::to_string(columns) +
                   ", as in the first line");
    addPosition(row, lines, max_points, cloud);
    if (columns >= 6) cloud.normals.emplace_back(row[3], row[4], row[5]);
    for (std::size_t c = 6; c < columns; ++c) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&row[c]);
      std::vector<std::uint8_t>& out = cloud.extra_fields[c - 6].bytes;
      out.insert(out.end(), bytes, bytes + sizeof(double));
    }
  }
  if (!areNormals(cloud.normals)) keepAsFields(cloud);
  finish(file, cloud);
  return cloud;
}

// Only the vertices; what follows their coordinates, colours for example, depends on the first word and on the program that wrote
// it.
PointCloud readOff(const std::string& file, Index max_points) {
  Lines lines(file);
  const char* line = lines.next();
  const std::string kind = line ? std::string(line, std::strcspn(line, " \t\r#")) : "";
  static const char* const kKinds[] = {"OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF"};
  if (std::find(std::begin(kKinds), std::end(kKinds), kind) == std::end(kKinds))
    refuse(file, "begins with " + quote(kind) + "; accepted: OFF, COFF, NOFF and their like, as text");
  line += kind.size();
  line += std::strspn(line, kBlanks);
  if (*line == '\0' || *line == '#') line = lines.next();
  const std::vector<double> counts = line ? lines.readNumbers(line) : std::vector<double>();
  const double count = counts.empty() ? 0.0 : counts[0];
  if (!(count >= 1.0) || count != std::floor(count))
    lines.refuse("found no number of vertices; accepted: a whole number above 0");
  PointCloud cloud;
  while (static_cast<double>(cloud.size()) < count && (line = lines.next())) {
    const std::vector<double>& row = lines.readNumbers(line);
    if (row.size() < 3)
      lines.refuse("found a vertex of " + std::to_string(row.size()) + " numbers; accepted: 3 (x y z) and more");
    addPosition(row, lines, max_points, cloud);
  }
  if (static_cast<double>(cloud.size()) < count)
    refuse(file,
           "found " + std::to_string(cloud.size()) + " vertices; accepted: as many as its header says, " + formatReal(count));
  finish(file, cloud);
  return cloud;
}

// Normals belong to corners of faces there, and a vertex can have several; they are estimated as for other clouds.
PointCloud readObj(const std::string& file, Index max_points) {
  Lines lines(file);
  PointCloud cloud;
  while (const char* line = lines.next()) {
    if (*line != 'v' || std::strchr(kBlanks, line[1]) == nullptr) continue;  // also where the line ends behind the v
    const std::vector<double>& row = lines.readNumbers(line + 1);
    if (row.size() < 3)
      lines.refuse("found a vertex of " + std::to_string(row.size()) + " numbers; accepted: 3 (x y z) and more");
    addPosition(row, lines, max_points, cloud);
  }
  finish(file, cloud);
  return cloud;
}

}  // namespace deformable_surface::io
