// Writing point files, .ply and .pcd, without a library: a header and rows of little-endian numbers.
#include "deformable_surface/io/point_files.h"

#include "point_files_common.h"

#include "deformable_surface/base/value.h"
#include "deformable_surface/io/pending_file.h"

#include <cerrno>
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

/// A column of floats: component c of the rows.
ExtraField makeColumn(const std::string& name, const Points& rows, int c) {
  ExtraField column{name, ScalarType::kFloat32, 1, std::vector<std::uint8_t>(rows.size() * sizeof(float))};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const float value = static_cast<float>(rows[i][c]);
    std::memcpy(&column.bytes[i * sizeof(value)], &value, sizeof(value));
  }
  return column;
}

/// Scalar columns of a field: byte `stride * i + offset` of its rows and the bytes after it.
ExtraField sliceField(const ExtraField& field, const std::string& name, ScalarType type, std::size_t n, std::size_t offset) {
  const std::size_t stride = field.count * cloud::sizeOf(field.type), size = cloud::sizeOf(type);
  ExtraField slice{name, type, 1, std::vector<std::uint8_t>(n * size)};
  for (std::size_t i = 0; i < n; ++i) std::memcpy(&slice.bytes[i * size], &field.bytes[i * stride + offset], size);
  return slice;
}

/// All columns of a file in their order. PLY knows single numbers only, so fields are split, and packed colours become bytes.
std::vector<ExtraField> makeColumns(const PointCloud& cloud, const std::vector<float>& displacement, bool is_ply) {
  const std::size_t n = cloud.positions.size();
  std::vector<ExtraField> columns;
  const char* const kNormals[2][3] = {{"normal_x", "normal_y", "normal_z"}, {"nx", "ny", "nz"}};
  const char* const kPosition[3] = {"x", "y", "z"};
  for (int c = 0; c < 3; ++c) columns.push_back(makeColumn(kPosition[c], cloud.positions, c));
  for (int c = 0; c < 3 && !cloud.normals.empty(); ++c) columns.push_back(makeColumn(kNormals[is_ply][c], cloud.normals, c));
  if (!displacement.empty()) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(displacement.data());
    columns.push_back({"displacement", ScalarType::kFloat32, 1, {bytes, bytes + n * sizeof(float)}});
  }
  for (const ExtraField& field : cloud.extra_fields) {
    const std::size_t size = cloud::sizeOf(field.type);
    if (field.name == "displacement" && !displacement.empty()) continue;
    if (!is_ply) {
      columns.push_back(field);
    } else if ((field.name == "rgb" || field.name == "rgba") && field.count == 1 && size == 4) {
      // Blue is the lowest byte.
      columns.push_back(sliceField(field, "red", ScalarType::kUint8, n, 2));
      columns.push_back(sliceField(field, "green", ScalarType::kUint8, n, 1));
      columns.push_back(sliceField(field, "blue", ScalarType::kUint8, n, 0));
      if (field.name == "rgba") columns.push_back(sliceField(field, "alpha", ScalarType::kUint8, n, 3));
    } else {
      for (std::uint32_t k = 0; k < field.count; ++k) {
        const std::string name = field.count == 1 ? field.name : field.name + "_" + std::to_string(k);
        columns.push_back(sliceField(field, name, field.type, n, k * size));
      }
    }
  }
  // Names come from anywhere: one word each, and no two the same.
  std::set<std::string> used;
  for (ExtraField& column : columns) {
    for (char& c : column.name) c = std::isalnum(static_cast<unsigned char>(c)) || c == '_' ? c : '_';
    if (column.name.empty() || column.name == "_") column.name = "field";
    while (!used.insert(column.name).second) column.name += "_";
  }
  return columns;
}

// Columns of another length would be read past their end.
void requireRows(const std::string& file, const PointCloud& cloud, const std::vector<float>& displacement) {
  const std::size_t n = cloud.positions.size();
  const auto require = [&](std::size_t found, std::size_t accepted, const std::string& what) {
    if (found != accepted)
      refuse(file, "found " + std::to_string(found) + " " + what + " for " + std::to_string(n) +
                       " points; accepted: " + std::to_string(accepted));
  };
  if (!cloud.normals.empty()) require(cloud.normals.size(), n, "normals");
  if (!displacement.empty()) require(displacement.size(), n, "displacements");
  for (const ExtraField& field : cloud.extra_fields) {
    const std::size_t type = static_cast<std::size_t>(field.type);
    if (type < 1 || type > static_cast<std::size_t>(ScalarType::kFloat64))
      refuse(file, "found the type " + std::to_string(type) + " of the field " + quote(field.name) + "; accepted: 1 to 8");
    require(field.bytes.size(), n * field.count * cloud::sizeOf(field.type), "bytes of the field " + quote(field.name));
  }
}

std::string makeHeader(const PointCloud& cloud, const std::vector<ExtraField>& columns, bool is_ply) {
  static const char* const kPlyTypes[] = {"", "char", "uchar", "short", "ushort", "int", "uint", "float", "double"};
  static const char* const kPcdTypes[] = {"", "I", "U", "I", "U", "I", "U", "F", "F"};
  const std::size_t n = cloud.positions.size();
  std::ostringstream out;
  out.imbue(std::locale::classic());
  if (is_ply) {
    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << n << "\n";
    for (const ExtraField& column : columns) {
      out << "property " << kPlyTypes[static_cast<std::size_t>(column.type)] << " " << column.name << "\n";
    }
    out << "end_header\n";
    return out.str();
  }
  std::string names, sizes, types, counts;
  for (const ExtraField& column : columns) {
    names += " " + column.name;
    sizes += " " + std::to_string(cloud::sizeOf(column.type));
    types += std::string(" ") + kPcdTypes[static_cast<std::size_t>(column.type)];
    counts += " " + std::to_string(column.count);
  }
  // Inserted points break the rows of an organised cloud.
  const bool keeps_shape = std::uint64_t{cloud.width} * cloud.height == n;
  const Vec3 viewpoint = cloud.viewpoint.value_or(Vec3::Zero());
  out.precision(std::numeric_limits<double>::max_digits10);
  out << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS" << names << "\nSIZE" << sizes << "\nTYPE" << types
      << "\nCOUNT" << counts << "\nWIDTH " << (keeps_shape ? cloud.width : n) << "\nHEIGHT " << (keeps_shape ? cloud.height : 1)
      << "\nVIEWPOINT " << viewpoint.x() << " " << viewpoint.y() << " " << viewpoint.z() << " 1 0 0 0\nPOINTS " << n
      << "\nDATA binary\n";
  return out.str();
}

}  // namespace

void checkPointFileName(const std::string& file) {
  const std::string extension = toLowerExtension(file);
  if (extension != ".ply" && extension != ".pcd")
    refuse(file, "found the extension " + quote(extension) + "; accepted: .ply, .pcd");
}

void writePointFile(const std::string& file, const cloud::PointCloud& cloud, const std::vector<float>& displacement) {
  checkPointFileName(file);
  const bool is_ply = toLowerExtension(file) == ".ply";
  requireRows(file, cloud, displacement);
  const std::size_t n = cloud.positions.size();
  const std::vector<ExtraField> columns = makeColumns(cloud, displacement, is_ply);

  // Interleave the columns to rows.
  std::size_t step = 0;
  for (const ExtraField& column : columns) step += column.count * cloud::sizeOf(column.type);
  std::string rows(n * step, '\0');
  std::size_t offset = 0;
  for (const ExtraField& column : columns) {
    const std::size_t size = column.count * cloud::sizeOf(column.type);
    for (std::size_t i = 0; i < n; ++i) std::memcpy(&rows[i * step + offset], &column.bytes[i * size], size);
    offset += size;
  }

  PendingFile pending(file);
  errno = 0;
  std::ofstream stream(pending.temporary(), std::ios::binary | std::ios::trunc);
  stream << makeHeader(cloud, columns, is_ply);
  stream.write(rows.data(), static_cast<std::streamsize>(rows.size()));
  stream.close();
  if (!stream) refuse(file, std::string("cannot be written: ") + std::strerror(errno));
  pending.keep();
}

}  // namespace deformable_surface::io
