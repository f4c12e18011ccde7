#include "deformable_surface/io/mesh_output.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/io/pending_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <locale>

namespace deformable_surface::io {

void checkMeshFileName(const std::string& file) {
  if (file.size() < 5 || file.compare(file.size() - 4, 4, ".obj") != 0)
    throw InputError(file + ": found another extension than .obj; accepted: .obj");
}

void writeMeshFile(const std::string& file, const Points& positions, const Points& normals,
                   const std::vector<std::array<Index, 3>>& triangles) {
  checkMeshFileName(file);
  PendingFile pending(file);
  errno = 0;
  std::ofstream stream(pending.temporary(), std::ios::trunc);
  stream.imbue(std::locale::classic());
  stream.precision(9);
  for (const Vec3& p : positions) stream << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  for (const Vec3& n : normals) stream << "vn " << n.x() << ' ' << n.y() << ' ' << n.z() << '\n';
  for (const std::array<Index, 3>& t : triangles) {
    stream << 'f';
    for (const Index corner : t) stream << ' ' << corner + 1 << "//" << corner + 1;
    stream << '\n';
  }
  stream.close();
  if (!stream) throw InputError(file + ": cannot be written: " + std::strerror(errno));
  pending.keep();
}

}  // namespace deformable_surface::io
