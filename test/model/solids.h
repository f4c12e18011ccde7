// Small bodies that the tests of elastic solids share.
#pragma once

#include "../support/surfaces.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/elastic_solid/elastic_solid.h"

#include <random>

namespace deformable_surface::test {

/// A box of points with one corner at the origin. Jitter is in shares of the spacing. Points on faces and edges stay on them. One
/// layer (0 0 1): planar.
inline Points makeBox(Index nx, Index ny, Index nz, double spacing, double jitter = 0.0, unsigned seed = 1) {
  std::mt19937 generator(seed);
  Points points;
  const Index counts[3] = {nx, ny, nz};
  for (Index i = 0; i < nx; ++i)
    for (Index j = 0; j < ny; ++j)
      for (Index k = 0; k < nz; ++k) {
        const Index at[3] = {i, j, k};
        const Vec3 shift = randomVector(generator);
        Vec3 p;
        for (int c = 0; c < 3; ++c) p[c] = spacing * (at[c] + (at[c] == 0 || at[c] == counts[c] - 1 ? 0.0 : jitter * shift[c]));
        points.push_back(p);
      }
  return points;
}

/// A quarter of a ring of radii 1 and outer in the plane z = 0, between the axes, with so many points through its wall. Jitter is
/// in shares of the spacing. Points on circles and axes stay on them.
struct QuarterRing {
  Points points;
  std::vector<Index> inner;    // on the inner circle, from the x axis on
  std::vector<double> length;  // of each, its part of the circle, m
};

inline QuarterRing makeQuarterRing(double outer, Index through, double jitter = 0.0, unsigned seed = 1) {
  std::mt19937 generator(seed);
  const double spacing = (outer - 1.0) / (through - 1), quarter = 0.5 * M_PI;
  const Index rays = static_cast<Index>(std::lround(quarter * std::sqrt(outer) / spacing));
  QuarterRing ring;
  std::vector<double> angles;
  for (Index i = 0; i < through; ++i)
    for (Index j = 0; j <= rays; ++j) {
      const Vec3 shift = jitter * randomVector(generator);
      const double radius = 1.0 + spacing * (i + (i == 0 || i == through - 1 ? 0.0 : shift.x()));
      const double angle = quarter / rays * (j + (j == 0 || j == rays ? 0.0 : shift.y()));
      if (i == 0) {
        ring.inner.push_back(static_cast<Index>(ring.points.size()));
        angles.push_back(angle);
      }
      ring.points.emplace_back(j == rays ? 0.0 : radius * std::cos(angle), j == 0 ? 0.0 : radius * std::sin(angle), 0.0);
    }
  for (Index j = 0; j <= rays; ++j) ring.length.push_back(0.5 * (angles[std::min(j + 1, rays)] - angles[std::max(j - 1, 0)]));
  return ring;
}

struct SolidOptions {
  model::MaterialParams material;
  model::ElasticSolidParams params;

  SolidOptions() { material.poisson_ratio = 0.3; }
};

inline model::ElasticSolid makeSolid(const Points& rest, const SolidOptions& options = {}) {
  return {rest, cloud::nearestNeighbors(rest, 32), {}, Vec3::Zero(), options.material, options.params};
}

inline model::ElasticSolid makePlanarSolid(const Points& rest, const SolidOptions& options = {}) {
  return {rest, cloud::nearestNeighbors(rest, 16), {}, Vec3::UnitZ(), options.material, options.params};
}

}  // namespace deformable_surface::test
