// Particle sets with known topology and spacing, and readers of real ones, for the tests of triangulation and growth.
#pragma once

#include "cloud/test_surfaces.h"
#include "support/shared_data.h"

#include <fstream>
#include <sstream>
#include <string>

namespace deformable_surface::model {

using cloud::TestSurface;

/// Hexagonal sheet in z = 0, facing +z, about the origin: all particles within radius.
inline TestSurface makeHexagons(double spacing, double radius) {
  TestSurface sheet;
  const int count = static_cast<int>(2.0 * radius / spacing) + 1;
  for (int i = -count; i <= count; ++i) {
    for (int j = -count; j <= count; ++j) {
      const Vec3 p = spacing * Vec3(i + 0.5 * j, std::sqrt(0.75) * j, 0.0);
      if (p.norm() <= radius) sheet.add(p, Vec3::UnitZ());
    }
  }
  return sheet;
}

/// Particles that face +z.
inline TestSurface makePositionsOf(const Points& positions) {
  TestSurface surface;
  for (const Vec3& p : positions) surface.add(p, Vec3::UnitZ());
  return surface;
}

inline double distanceBetween(const TestSurface& surface, Index i, Index j) {
  return (surface.positions[i] - surface.positions[j]).norm();
}

/// The mean distance to the nearest other particle; O(n^2).
inline double measureSpacing(const TestSurface& surface) {
  double sum = 0.0;
  for (Index i = 0; i < surface.size(); ++i) {
    double nearest = HUGE_VAL;
    for (Index j = 0; j < surface.size(); ++j) {
      if (j != i) nearest = std::min(nearest, distanceBetween(surface, i, j));
    }
    sum += nearest;
  }
  return sum / surface.size();
}

/// Lines of x y z nx ny nz of a text file (.xyz, or .pcd after its header) in the folder of real data; empty if the file is
/// missing.
inline TestSurface readRealData(const std::string& name) {
  std::ifstream file(test::sharedFolder() + "/" + name);
  TestSurface surface;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    Vec3 p, n;
    if (words >> p.x() >> p.y() >> p.z() >> n.x() >> n.y() >> n.z()) surface.add(p, n);
  }
  return surface;
}

}  // namespace deformable_surface::model
