#include "deformable_surface/model/mass_spring/triangle_membrane.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"
#include "deformable_surface/model/mass_spring/incidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace deformable_surface::model {
namespace {

using Mat32 = Eigen::Matrix<double, 3, 2>;

constexpr Index kBlock = 64;

// Rotation and invariants of F.
struct Polar {
  Mat32 rotation;
  Vec3 normal;
  double trace;        // T = tr S, the sum of the two stretches
  double determinant;  // J
};

Polar decompose(const Mat32& F, Index element) {
  Polar p;
  const Vec3 cross = F.col(0).cross(F.col(1));
  p.determinant = cross.norm();
  p.trace = std::sqrt(F.squaredNorm() + 2.0 * p.determinant);
  if (p.determinant > 0.0) {
    p.normal = cross / p.determinant;
  } else {
    // Collapsed to a line or a point: a normal perpendicular to the line, always the same one.
    const Vec3 line = F.col(F.col(0).squaredNorm() >= F.col(1).squaredNorm() ? 0 : 1);
    const Vec3 aside = fixedDirection(element, element + 1);
    p.normal = line.squaredNorm() > 0.0 ? Vec3(line.cross(aside)) : aside;
    const double length = p.normal.norm();
    p.normal = length > 0.0 ? Vec3(p.normal / length) : line.unitOrthogonal();
  }
  if (p.trace > 0.0) {
    Mat32 cofactor;
    cofactor << F.col(1).cross(p.normal), p.normal.cross(F.col(0));
    p.rotation = (F + cofactor) / p.trace;
  } else {
    const Vec3 first = p.normal.unitOrthogonal();
    p.rotation << first, p.normal.cross(first);
  }
  return p;
}

// Of the three corners in the plane at rest, where inverse is that of the edges from the first.
std::array<Vec2, 3> findShapeGradients(const Mat2& inverse) {
  return {Vec2(-(inverse.row(0) + inverse.row(1))), Vec2(inverse.row(0)), Vec2(inverse.row(1))};
}

// Four triangles side by side, from different patches: the products of their two edges, L^2, then K.
struct Products {
  Double4 square1, square2, dot, L;
};

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

// K11, K12, K22 take the places of square1, dot, square2. Returns whether a triangle is collapsed.
DEFORMABLE_SURFACE_INLINE bool findK(const double* constants, double lambda, double mu, Products& products) {
  Double4 G11, G12, G22, det, area, half_weight;  // half_weight = w A det D
  load(constants, G11);
  load(constants + 4, G12);
  load(constants + 8, G22);
  load(constants + 12, det);
  load(constants + 16, area);
  load(constants + 20, half_weight);
  const Double4 square1 = products.square1, square2 = products.square2;
  takeRoots(products.L);
  const auto none = products.L == 0.0;
  Double4 T = G11 * square1 + G22 * square2 + 2.0 * (G12 * products.dot + det * products.L);
  takeRoots(T);
  const Double4 s = lambda - 2.0 * (lambda + mu) / T;
  const Double4 plain = area * (2.0 * mu + s), crossed = half_weight * s / products.L;
  products.square1 = plain * G11 + crossed * square2;
  products.dot = plain * G12 - crossed * products.dot;
  products.square2 = plain * G22 + crossed * square1;
  return none[0] || none[1] || none[2] || none[3];
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
// forces of its patch are then not finite. Three loops over a few groups each, so that roots and divisions of one group do not
// wait for those of another.
template <int kTriangles>
DEFORMABLE_SURFACE_INLINE bool computePatchForces(Index begin, Index end, const Index* points, const double* constants,
                                                  const double* positions, double lambda, double mu, double* corner_force) {
  constexpr Index kBatch = 32 / kTriangles;  // groups that fit the nearest cache
  Double4 edges[9 * kBatch];
  Products products[kTriangles * kBatch];
  bool collapsed = false;
  for (Index batch = begin; batch < end; batch += kBatch) {
    const Index size = end - batch < kBatch ? end - batch : kBatch;
    for (Index k = 0; k < size; ++k)
      loadEdges<kTriangles>(points + 16 * (batch + k), positions, edges + 9 * k, products + kTriangles * k);
    for (Index t = 0; t < kTriangles * size; ++t)
      collapsed |= findK(constants + 24 * (kTriangles * batch + t), lambda, mu, products[t]);
    for (Index k = 0; k < size; ++k)
      storeForces<kTriangles>(edges + 9 * k, products + kTriangles * k, corner_force + 64 * (batch + k));
  }
  return collapsed;
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

TriangleMembrane::TriangleMembrane(const std::vector<WeightedTriangle>& triangles, const Points& rest, double membrane_stiffness,
                                   double poisson_ratio)
    : mu_(membrane_stiffness / (2.0 * (1.0 + poisson_ratio))),
      lambda_(membrane_stiffness * poisson_ratio / (1.0 - poisson_ratio * poisson_ratio)) {
  for (const WeightedTriangle& t : triangles) {
    const Vec3 a = rest[t.corner[1]] - rest[t.corner[0]], b = rest[t.corner[2]] - rest[t.corner[0]];
    const double twice_area = a.cross(b).norm();
    if (!(twice_area > 0.0)) continue;
    // Edges in the triangle's own plane, first axis along a.
    const double length = a.norm();
    Mat2 edges;
    edges << length, a.dot(b) / length, 0.0, twice_area / length;
    Element e{{t.corner[0], t.corner[1], t.corner[2]}, edges.inverse(), 0.5 * t.weight * twice_area};
    if (e.inverse.allFinite()) elements_.push_back(e);
  }
  groupTriangles();
  prepareForceLoop(static_cast<Index>(rest.size()));
}

// Triangles with a side in common, by that side. Those of four cocircular points, on every three of them, are found first.
void TriangleMembrane::groupTriangles() {
  patches_.clear();
  const Index n = static_cast<Index>(elements_.size());
  using Side = std::array<Index, 3>;  // two points, ascending, and the triangle
  std::vector<Side> sides;
  sides.reserve(3 * n);
  const auto makeSide = [](Index i, Index j, Index t) { return Side{std::min(i, j), std::max(i, j), t}; };
  for (Index t = 0; t < n; ++t)
    for (int c = 0; c < 3; ++c) sides.push_back(makeSide(elements_[t].corner[c], elements_[t].corner[(c + 1) % 3], t));
  std::sort(sides.begin(), sides.end());
  std::vector<char> is_taken(n, 0);
  const auto oppositeOf = [&](const Side& side) {
    const auto& [i, j, k] = elements_[side[2]].corner;
    return i + j + k - side[0] - side[1];
  };
  // visit(point opposite the side, triangle): of each free triangle at a side, until it returns true.
  const auto findAt = [&](Index i, Index j, const auto& visit) {
    for (auto s = std::lower_bound(sides.begin(), sides.end(), makeSide(i, j, 0));
         s != sides.end() && (*s)[0] == std::min(i, j) && (*s)[1] == std::max(i, j); ++s)
      if (!is_taken[(*s)[2]] && visit(oppositeOf(*s), (*s)[2])) return;
  };
  const auto findOne = [&](Index i, Index j, Index opposite) {
    Index found = -1;
    findAt(i, j, [&](Index point, Index t) { return point == opposite && (found = t, true); });
    return found;
  };
  for (Index t = 0; t < n; ++t) {
    if (is_taken[t]) continue;
    const auto& [i, j, k] = elements_[t].corner;
    Patch four{{i, j, k, -1}, {t, -1, -1, -1}};
    findAt(i, k, [&, i = i, j = j, k = k](Index point, Index u) {
      if (point == j) return false;
      four = {{i, j, k, point}, {t, u, findOne(i, j, point), findOne(j, k, point)}};
      return four.elements[2] >= 0 && four.elements[3] >= 0;
    });
    if (four.points[3] < 0 || four.elements[2] < 0 || four.elements[3] < 0) continue;
    patches_.push_back(four);
    for (const Index u : four.elements) is_taken[u] = 1;
  }
  num_fours_ = static_cast<Index>(patches_.size());
  // The others by twos, first with the neighbour that has the fewest others.
  const auto countFree = [&](Index t) {
    Index count = 0;
    for (int c = 0; c < 3; ++c)
      findAt(elements_[t].corner[c], elements_[t].corner[(c + 1) % 3], [&](Index, Index u) {
        count += u != t;
        return false;
      });
    return count;
  };
  for (Index t = 0; t < n; ++t) {
    if (is_taken[t]) continue;
    const auto& corner = elements_[t].corner;
    // Without a partner the second triangle is the first one, without weight.
    Patch pair{{corner[0], corner[1], corner[2], corner[1]}, {t, -1, -1, -1}};
    Index fewest = std::numeric_limits<Index>::max();
    for (int c = 0; c < 3; ++c) {
      const Index i = corner[c], j = corner[(c + 1) % 3], k = corner[(c + 2) % 3];
      findAt(i, j, [&](Index point, Index u) {
        if (u == t || point == k) return false;
        const Index free = countFree(u);
        if (free < fewest) {
          fewest = free;
          pair = {{i, k, j, point}, {t, u, -1, -1}};
        }
        return false;
      });
    }
    patches_.push_back(pair);
    for (const Index u : pair.elements)
      if (u >= 0) is_taken[u] = 1;
  }
}

// The numbers of an element for the force loop, with its edges from p to q and to r.
std::array<double, 6> TriangleMembrane::constantsOf(const Element& e, Index p, Index q, Index r) {
  const Mat2 at_rest = e.inverse.inverse();
  const auto placeOf = [&](Index point) -> Vec2 {
    return point == e.corner[0] ? Vec2::Zero() : Vec2(at_rest.col(point == e.corner[1] ? 0 : 1));
  };
  Mat2 edges;
  edges << placeOf(q) - placeOf(p), placeOf(r) - placeOf(p);
  const Mat2 inverse = edges.inverse(), G = inverse * inverse.transpose();
  const double det = std::abs(inverse.determinant());
  return {G(0, 0), G(0, 1), G(1, 1), det, e.area, e.area * det};
}

void TriangleMembrane::prepareForceLoop(Index num_points) {
  const Index num_patches = static_cast<Index>(patches_.size());
  const Index groups_of_fours = (num_fours_ + 3) / 4, groups = groups_of_fours + (num_patches - num_fours_ + 3) / 4;
  std::vector<std::pair<Index, Index>> corners;
  corners.reserve(4 * num_patches);
  corner_force_.resize(64 * groups);
  group_points_.resize(16 * groups);
  group_constants_.resize(96 * groups_of_fours + 48 * (groups - groups_of_fours));
  for (Index place = 0; place < 4 * groups; ++place) {
    const Index group = place / 4, lane = place % 4;
    const bool is_four = group < groups_of_fours;
    const Index wanted = is_four ? place : num_fours_ + place - 4 * groups_of_fours, end = is_four ? num_fours_ : num_patches;
    // The last group is filled up with the last patch, whose forces there are not gathered.
    const Patch& patch = patches_[std::min(wanted, end - 1)];
    for (int c = 0; c < 4; ++c) {
      group_points_[16 * group + 4 * c + lane] = patch.points[c];
      if (wanted < end && (c < 3 || patch.elements[1] >= 0)) corners.emplace_back(patch.points[c], 16 * group + 4 * c + lane);
    }
    double* constants = &group_constants_[is_four ? 96 * group : 96 * groups_of_fours + 48 * (group - groups_of_fours)];
    const auto& [i, j, k, l] = patch.points;
    const Index ends[4][3] = {{i, j, k}, {i, k, l}, {i, j, l}, {j, k, l}};
    for (int t = 0; t < (is_four ? 4 : 2); ++t) {
      const bool is_there = patch.elements[t] >= 0;
      const Element& e = elements_[patch.elements[is_there ? t : 0]];
      std::array<double, 6> numbers = constantsOf(e, ends[t][0], ends[t][1], ends[t][2]);
      if (!is_there) numbers[4] = numbers[5] = 0.0;
      for (int c = 0; c < 6; ++c) constants[24 * t + 4 * c + lane] = numbers[c];
    }
  }
  incidence_ = groupByPoint(num_points, corners);
}

Index TriangleMembrane::patchOf(Index item) const {
  const Index group = item / 16, groups_of_fours = (num_fours_ + 3) / 4;
  return item % 4 + (group < groups_of_fours ? 4 * group : num_fours_ + 4 * (group - groups_of_fours));
}

Mat32 TriangleMembrane::gradient(const Element& e, const State& state) {
  const Vec3& origin = state.positions[e.corner[0]];
  Mat32 edges;
  edges << state.positions[e.corner[1]] - origin, state.positions[e.corner[2]] - origin;
  return edges * e.inverse;
}

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

void TriangleMembrane::addStiffness(const State& state, Hessian hessian, BlockSparse& stiffness) const {
  const double lowest = hessian == Hessian::kPositive ? 0.0 : -std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < elements_.size(); ++t) {
    const Element& e = elements_[t];
    const Mat32 F = gradient(e, state);
    const Polar p = decompose(F, static_cast<Index>(t));

    // Principal stretches and directions: S = R^T F is symmetric.
    const Mat2 S = p.rotation.transpose() * F;
    const double mean = 0.5 * (S(0, 0) + S(1, 1)), difference = 0.5 * (S(0, 0) - S(1, 1));
    const double offdiagonal = 0.5 * (S(0, 1) + S(1, 0));
    const double radius = std::hypot(difference, offdiagonal);
    const double angle = 0.5 * std::atan2(offdiagonal, difference);
    const Vec2 v[2] = {Vec2(std::cos(angle), std::sin(angle)), Vec2(-std::sin(angle), std::cos(angle))};
    const double stretch[2] = {mean + radius, mean - radius};

    // d2W/dF2 has these eigenvectors (unit, 3 x 2) beside a plain 2 mu on the two remaining strains: R / sqrt 2 (dilation), R
    // turned (spin in the plane), and n v_k^T (tilt out of the plane). c is the effect of the rotation's change.
    const double c = 2.0 * mu_ - lambda_ * (p.trace - 2.0);
    const double spin = std::max(lowest, 2.0 * mu_ - (p.trace > 0.0 ? 2.0 * c / p.trace : 0.0)) - 2.0 * mu_;
    Mat2 turn;
    turn << 0.0, -1.0, 1.0, 0.0;
    const Mat32 spin_mode = p.rotation * turn / std::sqrt(2.0), dilation_mode = p.rotation / std::sqrt(2.0);
    double tilt[2];
    for (int k = 0; k < 2; ++k) tilt[k] = std::max(lowest, 2.0 * mu_ - (stretch[k] > 1e-9 ? c / stretch[k] : 0.0)) - 2.0 * mu_;

    // Shape function gradients of the corners in the plane at rest.
    Vec2 g[3];
    g[1] = e.inverse.row(0);
    g[2] = e.inverse.row(1);
    g[0] = -g[1] - g[2];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b <= a; ++b) {
        Mat3 block = 2.0 * mu_ * g[a].dot(g[b]) * Mat3::Identity();
        block += 2.0 * lambda_ * (dilation_mode * g[a]) * (dilation_mode * g[b]).transpose();
        block += spin * (spin_mode * g[a]) * (spin_mode * g[b]).transpose();
        for (int k = 0; k < 2; ++k) block += tilt[k] * v[k].dot(g[a]) * v[k].dot(g[b]) * p.normal * p.normal.transpose();
        stiffness.add(e.corner[a], e.corner[b], e.area * block);
      }
  }
}

std::vector<std::pair<Index, Index>> TriangleMembrane::findEdges() const {
  std::vector<std::pair<Index, Index>> edges;
  edges.reserve(3 * elements_.size());
  for (const Element& e : elements_)
    for (int c = 0; c < 3; ++c) edges.push_back(std::minmax({e.corner[c], e.corner[(c + 1) % 3]}));
  return edges;
}

// A wave in the plane is resisted by 2 mu + lambda in stretching and by mu in shearing: their mean.
void TriangleMembrane::computeSpringsAlong(std::vector<double>& stiffness) const {
  stiffness.clear();
  stiffness.reserve(3 * elements_.size());
  for (const Element& e : elements_) {
    const auto g = findShapeGradients(e.inverse);
    for (int c = 0; c < 3; ++c) stiffness.push_back(-0.5 * (3.0 * mu_ + lambda_) * e.area * g[c].dot(g[(c + 1) % 3]));
  }
}

// The tilt modes of addStiffness() without their direction. Pressure, which would buckle, counts as zero.
void TriangleMembrane::computeSpringsAcross(const State& state, std::vector<double>& stiffness) const {
  stiffness.resize(3 * elements_.size());
  for (std::size_t t = 0; t < elements_.size(); ++t) {
    const Element& e = elements_[t];
    const Mat32 F = gradient(e, state);
    const double J = F.col(0).cross(F.col(1)).norm(), trace = std::sqrt(F.squaredNorm() + 2.0 * J);
    // The squares of the stretches are the eigenvalues of F^T F.
    const Mat2 C = F.transpose() * F;
    const double mean = 0.5 * (C(0, 0) + C(1, 1)), radius = std::hypot(0.5 * (C(0, 0) - C(1, 1)), C(0, 1));
    const double c = 2.0 * mu_ - lambda_ * (trace - 2.0);
    const auto findTension = [&](double squared) {
      return squared > 1e-18 ? std::max(0.0, 2.0 * mu_ - c / std::sqrt(squared)) : 0.0;
    };
    const double large = findTension(mean + radius), small = findTension(mean - radius);
    // The tensor with these eigenvalues in the directions of those of C.
    const double slope = radius > 0.0 ? 0.5 * (large - small) / radius : 0.0;
    const Mat2 H = slope * (C - mean * Mat2::Identity()) + 0.5 * (large + small) * Mat2::Identity();
    const auto g = findShapeGradients(e.inverse);
    for (int k = 0; k < 3; ++k) stiffness[3 * t + k] = -e.area * g[k].dot(H * g[(k + 1) % 3]);
  }
}

void TriangleMembrane::addRowBounds(std::vector<double>& stiffness) const {
  const double largest = 2.0 * mu_ + 2.0 * std::max(0.0, lambda_);
  for (const Element& e : elements_) {
    const Vec2 g1 = e.inverse.row(0), g2 = e.inverse.row(1);
    const double norm[3] = {(g1 + g2).norm(), g1.norm(), g2.norm()};
    const double sum = norm[0] + norm[1] + norm[2];
    for (int c = 0; c < 3; ++c) stiffness[e.corner[c]] += e.area * largest * norm[c] * sum;
  }
}

}  // namespace deformable_surface::model
