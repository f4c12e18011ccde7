// Small surfaces that many tests share: sheets, strips and spheres as points with normals and rings.
#pragma once

#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/rings.h"
#include "deformable_surface/model/deformable_model.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::test {

/// A number in [-1, 1) that is the same on every platform.
inline double uniform(std::mt19937& generator) { return static_cast<double>(generator()) / 2147483648.0 - 1.0; }

inline Vec3 randomVector(std::mt19937& generator) {
  const double x = uniform(generator), y = uniform(generator), z = uniform(generator);
  return Vec3(x, y, z);
}

/// A rotation that is special to no axis.
inline Mat3 someRotation() { return Eigen::AngleAxisd(1.1, Vec3(0.3, -0.5, 0.8).normalized()).toRotationMatrix(); }

struct Surface {
  Points points, normals;
  cloud::Rings rings;
  double area = 0.0;

  bool isClosed() const { return std::count(rings.open.begin(), rings.open.end(), 1) == 0; }
};

inline Surface connect(Points points, Points normals, Index k = 16) {
  Surface s;
  s.points = std::move(points);
  s.normals = std::move(normals);
  s.rings = cloud::buildRings(s.points, s.normals, cloud::nearestNeighbors(s.points, k));
  for (double a : s.rings.area) s.area += a;
  return s;
}

/// nx x ny points on [0, length] x [-width / 2, width / 2] in z = 0; jitter in shares of the spacing moves interior points, and
/// boundary points along the boundary.
inline Surface makeSheet(Index nx, Index ny, double length, double width, double jitter = 0.0, unsigned seed = 1) {
  std::mt19937 generator(seed);
  Points points;
  const double dx = length / (nx - 1), dy = width / (ny - 1);
  for (Index i = 0; i < nx; ++i)
    for (Index j = 0; j < ny; ++j) {
      const double u = uniform(generator), v = uniform(generator);
      const bool corner = (i == 0 || i == nx - 1) && (j == 0 || j == ny - 1);
      const double x = i * dx + (i == 0 || i == nx - 1 || corner ? 0.0 : jitter * dx * u);
      const double y = j * dy - 0.5 * width + (j == 0 || j == ny - 1 || corner ? 0.0 : jitter * dy * v);
      points.emplace_back(x, y, 0.0);
    }
  return connect(points, Points(points.size(), Vec3::UnitZ()));
}

/// n points spread evenly over a sphere about the origin, with outward normals.
inline Surface makeSphere(Index n, double radius) {
  Points points, normals;
  const double golden = M_PI * (3.0 - std::sqrt(5.0));
  for (Index i = 0; i < n; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / n, r = std::sqrt(1.0 - z * z);
    normals.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
    points.push_back(radius * normals.back());
  }
  return connect(points, normals);
}

/// For clamps that end at the last points that they hold.
inline std::vector<model::ClampEdge> edgesAtPoints(const Surface& s, const std::vector<char>& held) {
  std::vector<model::ClampEdge> edges;
  for (Index i = 0; i < s.rings.ring.size(); ++i)
    if (held[i] && std::any_of(s.rings.ring.begin(i), s.rings.ring.end(i), [&](Index j) { return !held[j]; }))
      edges.push_back({i, s.points[i]});
  return edges;
}

}  // namespace deformable_surface::test
