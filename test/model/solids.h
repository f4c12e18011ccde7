// Small bodies that the tests of elastic solids share.
#pragma once

#include "../support/surfaces.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/elastic_solid/elastic_solid.h"

#include <random>

namespace deformable_surface::test {

/// A box of points from the origin on; jitter, in shares of the spacing, keeps those on faces and edges on them. One layer (0 0
/// 1): planar.
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
        for (int c = 0; c < 3; ++c)
          p[c] = spacing * (at[c] + (at[c] == 0 || at[c] == counts[c] - 1 ? 0.0 : jitter * shift[c]));
        points.push_back(p);
      }
  return points;
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
