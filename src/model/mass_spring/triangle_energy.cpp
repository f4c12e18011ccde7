// The energy of the triangles.
#include "deformable_surface/model/mass_spring/triangle_membrane.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 64;  // triangles per task; sums are added in this order

// Some triangles side by side, one quantity in one array, for their energies.
struct EnergyBatch {
  static constexpr Index kSize = 64;        // fits the nearest cache, and the loop's ends do not count
  double edge1[3][kSize], edge2[3][kSize];  // from the first corner, m
  double inverse[4][kSize];                 // i00, i01, i10, i11
  double area[kSize];                       // m^2
  double energy[kSize];                     // J
};

// With the stretches s1, s2: mu (|F - R|^2) = mu/2 ((T - 2)^2 + (s1 - s2)^2). s1 - s2 is the length of n x f1 - f2, in which
// no large terms cancel; a collapsed triangle has s1 - s2 = |F|.
DEFORMABLE_SURFACE_WIDE void computeEnergies(Index size, double mu, double lambda, EnergyBatch& batch) {
#pragma GCC ivdep
  for (Index l = 0; l < size; ++l) {
    const double a = batch.inverse[0][l], b = batch.inverse[1][l], c = batch.inverse[2][l], d = batch.inverse[3][l];
    const double f1x = batch.edge1[0][l] * a + batch.edge2[0][l] * c, f2x = batch.edge1[0][l] * b + batch.edge2[0][l] * d;
    const double f1y = batch.edge1[1][l] * a + batch.edge2[1][l] * c, f2y = batch.edge1[1][l] * b + batch.edge2[1][l] * d;
    const double f1z = batch.edge1[2][l] * a + batch.edge2[2][l] * c, f2z = batch.edge1[2][l] * b + batch.edge2[2][l] * d;
    const double cx = f1y * f2z - f1z * f2y, cy = f1z * f2x - f1x * f2z, cz = f1x * f2y - f1y * f2x;
    const double J = std::sqrt(cx * cx + cy * cy + cz * cz);
    const double squares = f1x * f1x + f1y * f1y + f1z * f1z + f2x * f2x + f2y * f2y + f2z * f2z;
    const double dilation = std::sqrt(squares + 2.0 * J) - 2.0;
    const double safe = J > 0.0 ? J : 1.0;
    const double nx = cx / safe, ny = cy / safe, nz = cz / safe;
    const double dx = ny * f1z - nz * f1y - f2x, dy = nz * f1x - nx * f1z - f2y, dz = nx * f1y - ny * f1x - f2z;
    const double difference = J > 0.0 ? dx * dx + dy * dy + dz * dz : squares;
    batch.energy[l] = 0.5 * batch.area[l] * (mu * (dilation * dilation + difference) + lambda * dilation * dilation);
  }
}

}  // namespace

double TriangleMembrane::energy(const State& state) const {
  return parallelSum(static_cast<Index>(elements_.size()), kBlock, [&](Index block_begin, Index block_end) {
    EnergyBatch batch;
    double sum = 0.0;
    for (Index begin = block_begin; begin < block_end; begin += EnergyBatch::kSize) {
      const Index size = std::min(EnergyBatch::kSize, block_end - begin);
      for (Index l = 0; l < size; ++l) {
        const Element& e = elements_[begin + l];
        const Vec3 edge1 = state.positions[e.corner[1]] - state.positions[e.corner[0]];
        const Vec3 edge2 = state.positions[e.corner[2]] - state.positions[e.corner[0]];
        for (int c = 0; c < 3; ++c) {
          batch.edge1[c][l] = edge1[c];
          batch.edge2[c][l] = edge2[c];
        }
        for (int k = 0; k < 4; ++k) batch.inverse[k][l] = e.inverse(k / 2, k % 2);
        batch.area[l] = e.area;
      }
      computeEnergies(size, mu_, lambda_, batch);
      for (Index l = 0; l < size; ++l) sum += batch.energy[l];
    }
    return sum;
  });
}

}  // namespace deformable_surface::model
