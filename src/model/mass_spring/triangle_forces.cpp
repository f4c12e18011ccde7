// The forces of the triangles, of four patches at a time.
#include "deformable_surface/model/mass_spring/triangle_membrane.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <cmath>

#include "triangle_polar.h"

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 64;  // groups of four patches per task: some microseconds of work

// Four triangles side by side, from different patches: the products of their two edges, L^2, then K.
struct Products {
  Double4 square1, square2, dot, L;
};

using Flags4 = decltype(Double4{} < Double4{});

DEFORMABLE_SURFACE_INLINE void multiplyEdges(const Double4* a, const Double4* b, Products& products) {
  products.square1 = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
  products.square2 = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
  products.dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const Double4 cx = a[1] * b[2] - a[2] * b[1], cy = a[2] * b[0] - a[0] * b[2], cz = a[0] * b[1] - a[1] * b[0];
  products.L = cx * cx + cy * cy + cz * cz;
}

// edges: x, y and z of the three from the first point. Those of the triangles are the same, but of the last of four they are the
// differences from the first.
template <int kTriangles>
DEFORMABLE_SURFACE_INLINE void loadEdges(const Index* points, const double* positions, Double4* edges, Products* products) {
  Double4 a[4], b[4], d[4];
  for (int lane = 0; lane < 4; ++lane) {
    Double4 origin;
    load(positions + 4 * points[lane], origin);
    load(positions + 4 * points[4 + lane], a[lane]);
    load(positions + 4 * points[8 + lane], b[lane]);
    load(positions + 4 * points[12 + lane], d[lane]);
    a[lane] -= origin;
    b[lane] -= origin;
    d[lane] -= origin;
  }
  transpose(a[0], a[1], a[2], a[3]);
  transpose(b[0], b[1], b[2], b[3]);
  transpose(d[0], d[1], d[2], d[3]);
  multiplyEdges(a, b, products[0]);
  multiplyEdges(b, d, products[1]);
  for (int c = 0; c < 3; ++c) {
    edges[c] = a[c];
    edges[3 + c] = b[c];
    edges[6 + c] = d[c];
  }
  if constexpr (kTriangles == 4) {
    multiplyEdges(a, d, products[2]);
    for (int c = 0; c < 3; ++c) {
      b[c] -= a[c];
      d[c] -= a[c];
    }
    multiplyEdges(b, d, products[3]);
  }
}

// Of n vectors of four triangles. K11, K12, K22 take the places of square1, dot, square2. is_collapsed: flags of the lanes, which
// are only ever set. Two loops, each with one root, so that the processor finds more roots at a time.
template <Index kMost>
DEFORMABLE_SURFACE_INLINE void findK(Index n, const double* constants, double lambda, double mu, Products* products,
                                     Flags4& is_collapsed) {
  Double4 squared_traces[kMost];  // T^2
  for (Index t = 0; t < n; ++t) {
    Products& p = products[t];
    Double4 G11, G12, G22, det;
    load(constants + 24 * t, G11);
    load(constants + 24 * t + 4, G12);
    load(constants + 24 * t + 8, G22);
    load(constants + 24 * t + 12, det);
    takeRoots(p.L);
    is_collapsed |= p.L == 0.0;
    squared_traces[t] = G11 * p.square1 + G22 * p.square2 + 2.0 * (G12 * p.dot + det * p.L);
  }
  for (Index t = 0; t < n; ++t) {
    Products& p = products[t];
    Double4 G11, G12, G22, area, half_weight, T = squared_traces[t];  // half_weight = w A det D
    load(constants + 24 * t, G11);
    load(constants + 24 * t + 4, G12);
    load(constants + 24 * t + 8, G22);
    load(constants + 24 * t + 16, area);
    load(constants + 24 * t + 20, half_weight);
    takeRoots(T);
    const Double4 s = lambda - 2.0 * (lambda + mu) / T;
    const Double4 plain = area * (2.0 * mu + s), crossed = half_weight * s / p.L, square1 = p.square1;
    p.square1 = plain * G11 + crossed * p.square2;
    p.dot = plain * G12 - crossed * p.dot;
    p.square2 = plain * G22 + crossed * square1;
  }
}

// The sum of K over the triangles, in terms of the three edges of the patch, gives the forces on its last three points.
template <int kTriangles>
DEFORMABLE_SURFACE_INLINE void storeForces(const Double4* edges, const Products* K, double* corner_force) {
  Double4 K00 = K[0].square1, K01 = K[0].dot, K02{}, K11 = K[0].square2 + K[1].square1, K12 = K[1].dot, K22 = K[1].square2;
  if constexpr (kTriangles == 4) {
    const Double4 first = K[3].square1 + K[3].dot, second = K[3].dot + K[3].square2;
    K00 += K[2].square1 + (first + second);
    K01 -= first;
    K02 = K[2].dot - second;
    K11 += K[3].square1;
    K12 += K[3].dot;
    K22 += K[2].square2 + K[3].square2;
  }
  Double4 force[4][4];
  for (int c = 0; c < 3; ++c) {
    const Double4 &a = edges[c], &b = edges[3 + c], &d = edges[6 + c];
    if constexpr (kTriangles == 4) {
      force[1][c] = -(K00 * a + K01 * b + K02 * d);
      force[3][c] = -(K02 * a + K12 * b + K22 * d);
    } else {
      force[1][c] = -(K00 * a + K01 * b);
      force[3][c] = -(K12 * b + K22 * d);
    }
    force[2][c] = -(K01 * a + K11 * b + K12 * d);
    force[0][c] = -(force[1][c] + force[2][c] + force[3][c]);
  }
  for (int k = 0; k < 4; ++k) {
    force[k][3] = Double4{};
    transpose(force[k][0], force[k][1], force[k][2], force[k][3]);
    for (int lane = 0; lane < 4; ++lane) store(force[k][lane], corner_force + 16 * k + 4 * lane);
  }
}

// The forces of the groups of four patches from begin to end, as in the header. Returns true if a triangle is collapsed; the
// forces of its patch are then not finite. Several loops over a few groups each, so that roots and divisions of one group do not
// wait for those of another.
template <int kTriangles>
DEFORMABLE_SURFACE_INLINE bool computePatchForces(Index begin, Index end, const Index* points, const double* constants,
                                                  const double* positions, double lambda, double mu, double* corner_force) {
  constexpr Index kBatch = 32 / kTriangles;  // groups that fit the nearest cache
  Double4 edges[9 * kBatch];
  Products products[kTriangles * kBatch];
  Flags4 is_collapsed{};
  for (Index batch = begin; batch < end; batch += kBatch) {
    const Index size = end - batch < kBatch ? end - batch : kBatch;
    for (Index k = 0; k < size; ++k)
      loadEdges<kTriangles>(points + 16 * (batch + k), positions, edges + 9 * k, products + kTriangles * k);
    findK<kTriangles * kBatch>(kTriangles * size, constants + 24 * kTriangles * batch, lambda, mu, products, is_collapsed);
    for (Index k = 0; k < size; ++k)
      storeForces<kTriangles>(edges + 9 * k, products + kTriangles * k, corner_force + 64 * (batch + k));
  }
  return is_collapsed[0] || is_collapsed[1] || is_collapsed[2] || is_collapsed[3];
}

DEFORMABLE_SURFACE_WIDE bool computeForcesOfFours(Index begin, Index end, const Index* points, const double* constants,
                                                  const double* positions, double lambda, double mu, double* corner_force) {
  return computePatchForces<4>(begin, end, points, constants, positions, lambda, mu, corner_force);
}

DEFORMABLE_SURFACE_WIDE bool computeForcesOfPairs(Index begin, Index end, const Index* points, const double* constants,
                                                  const double* positions, double lambda, double mu, double* corner_force) {
  return computePatchForces<2>(begin, end, points, constants, positions, lambda, mu, corner_force);
}

// Adds the corner forces to each point. forces: (n x 3).
DEFORMABLE_SURFACE_WIDE void gatherForces(Index begin, Index end, const Index* offsets, const Index* items,
                                          const double* corner_force, double* forces) {
  for (Index i = begin; i < end; ++i) {
    Double4 sum{};
    for (Index k = offsets[i]; k < offsets[i + 1]; ++k) {
      Double4 force;
      load(corner_force + 4 * items[k], force);
      sum += force;
    }
    for (int c = 0; c < 3; ++c) forces[3 * i + c] += sum[c];
  }
}

}  // namespace

// The forces of four patches at a time; the few with collapsed triangles are repeated one by one.
void TriangleMembrane::addForces(const State& state, const PaddedPoints& positions, Points& forces) const {
  const Index groups_of_fours = (num_fours_ + 3) / 4;
  parallelFor(static_cast<Index>(group_points_.size() / 16), kBlock, [&](Index begin, Index end) {
    const Index middle = std::clamp(groups_of_fours, begin, end);
    const double* const of_pairs = group_constants_.data() + 96 * groups_of_fours;
    bool collapsed = computeForcesOfFours(begin, middle, group_points_.data(), group_constants_.data(), positions.data(), lambda_,
                                          mu_, corner_force_.data());
    collapsed |=
        computeForcesOfPairs(middle - groups_of_fours, end - groups_of_fours, group_points_.data() + 16 * groups_of_fours,
                             of_pairs, positions.data(), lambda_, mu_, corner_force_.data() + 64 * groups_of_fours);
    if (collapsed) repairCollapsed(begin, end, state);
  });
  // Gathered by the points.
  parallelFor(incidence_.size(), 4 * kBlock, [&](Index begin, Index end) {
    gatherForces(begin, end, incidence_.offsets.data(), incidence_.items.data(), corner_force_.data(), forces.data()->data());
  });
}

void TriangleMembrane::repairCollapsed(Index begin, Index end, const State& state) const {
  for (Index place = 16 * begin; place < 16 * end; place += place % 4 == 3 ? 13 : 1) {
    double* force[4];
    double sum = 0.0;
    for (int c = 0; c < 4; ++c) {
      force[c] = &corner_force_[4 * (place + 4 * c)];
      for (int k = 0; k < 3; ++k) sum += force[c][k];
    }
    const Index p = patchOf(place);
    if (std::isfinite(sum) || p >= (place / 16 < (num_fours_ + 3) / 4 ? num_fours_ : static_cast<Index>(patches_.size())))
      continue;
    const Patch& patch = patches_[p];
    for (double* f : force) std::fill_n(f, 3, 0.0);
    for (const Index t : patch.elements) {
      if (t < 0) continue;
      const Mat32 corner = cornerForces(t, state);
      // The first place of a point: the last one of a pair without a partner repeats another.
      const auto add = [&](Index point, const Vec3& f) {
        int c = 0;
        while (patch.points[c] != point) ++c;
        for (int k = 0; k < 3; ++k) force[c][k] += f[k];
      };
      add(elements_[t].corner[0], -(corner.col(0) + corner.col(1)));
      add(elements_[t].corner[1], corner.col(0));
      add(elements_[t].corner[2], corner.col(1));
    }
  }
}

// Minus the first Piola-Kirchhoff stress times the gradients of the shape functions: forces on the second and third corner.
Mat32 TriangleMembrane::cornerForces(Index t, const State& state) const {
  const Element& e = elements_[t];
  const Mat32 F = gradient(e, state);
  const Polar p = decompose(F, t);
  const Mat32 stress = 2.0 * mu_ * (F - p.rotation) + lambda_ * (p.trace - 2.0) * p.rotation;
  return -e.area * stress * e.inverse.transpose();
}

}  // namespace deformable_surface::model
