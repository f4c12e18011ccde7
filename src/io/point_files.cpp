// Reading point files, whatever their kind: where the file is, and from its table to a cloud.
#include "deformable_surface/io/point_files.h"

#include "point_files_read.h"

#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cstring>

namespace deformable_surface::io {

namespace {

using cloud::ExtraField;
using cloud::PointCloud;
using cloud::ScalarType;

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

  // Other fields are kept as extra fields; "_" is padding.
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

}  // namespace

std::string findPointFile(const std::string& file, const FindPackage& find_package) {
  const std::string scheme = "package://";
  if (file.compare(0, scheme.size(), scheme) != 0) return file;
  const std::size_t slash = file.find('/', scheme.size());
  const std::string package = file.substr(scheme.size(), slash - scheme.size());
  if (package.empty() || slash == std::string::npos) refuse(file, "accepted: package://PACKAGE/PATH");
  if (!find_package) refuse(file, "packages are not known here; accepted: a path");
  return find_package(package) + file.substr(slash);
}

cloud::PointCloud readPointFile(const std::string& file, double scale, Index max_points, const FindPackage& find_package) {
  const std::string path = findPointFile(file, find_package);
  const std::string extension = toLowerExtension(path);
  PointCloud cloud;
  if (extension == ".pcd") {
    cloud = toCloud(path, readPcd(path, max_points));
  } else if (extension == ".ply") {
    cloud = toCloud(path, readPly(path, max_points));
  } else if (extension == ".xyz") {
    cloud = readXyz(path, max_points);
  } else if (extension == ".obj") {
    cloud = readObj(path, max_points);
  } else if (extension == ".off") {
    cloud = readOff(path, max_points);
  } else {
    refuse(file, "found the extension " + quote(extension) + "; accepted: .pcd, .ply, .obj, .off, .xyz");
  }
  // Some writers use all-zero normals for no normals.
  const auto is_zero = [](const Vec3& normal) { return normal == Vec3::Zero(); };
  if (std::all_of(cloud.normals.begin(), cloud.normals.end(), is_zero)) cloud.normals.clear();
  for (Vec3& position : cloud.positions) position *= scale;
  if (cloud.viewpoint) *cloud.viewpoint *= scale;
  return cloud;
}

}  // namespace deformable_surface::io
