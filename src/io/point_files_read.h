// Shared by the readers of point files: headers are checked against the size of the file before memory is allocated.
#pragma once

#include "point_files_common.h"

#include "deformable_surface/cloud/point_cloud.h"

#include <pcl/PCLPointCloud2.h>

#include <cstdint>
#include <string>
#include <vector>

namespace deformable_surface::io {

// One scalar written as text takes a digit and a separator.
constexpr std::uint64_t kMinTextBytes = 2;

// Scalars per point; real files have some dozens.
constexpr std::uint64_t kMaxScalars = 10000;

/// The beginning of a file, up to the line that ends its header, and the size of the file.
struct Head {
  std::vector<std::vector<std::string>> lines;  // words of each line
  std::uint64_t header_bytes = 0, file_bytes = 0;
};

/// Reads up to the line that begins with the word.
Head readHead(const std::string& file, const std::string& last_word);

/// A count of a header.
std::uint64_t toCount(const std::string& file, const std::string& word);

/// Refuses a file without points, with more than max_points, and with fewer bytes than the points need.
void checkCounts(const std::string& file, std::uint64_t points, std::uint64_t body_bytes, std::uint64_t needed_bytes,
                 Index max_points);

/// One record of numbers per point, as a file holds them, and the place of the scanner.
struct Table {
  pcl::PCLPointCloud2 data;
  std::uint64_t points = 0;
  Vec3 viewpoint = Vec3::Zero();
};

// One for each kind of file.
Table readPcd(const std::string& file, Index max_points);
Table readPly(const std::string& file, Index max_points);
cloud::PointCloud readXyz(const std::string& file, Index max_points);
cloud::PointCloud readObj(const std::string& file, Index max_points);
cloud::PointCloud readOff(const std::string& file, Index max_points);

}  // namespace deformable_surface::io
