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

constexpr Index kBlock = 128;
constexpr Index kBatch = 16;  // groups of four triangles that fit the nearest cache

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

// Four triangles side by side: edges from the first corner, their products, L^2, then K.
struct Group {
  Double4 e1[4], e2[4], square1, square2, dot, L, K11, K12, K22;
};

DEFORMABLE_SURFACE_INLINE void loadEdges(const Index* corners, const double* positions, Group& group) {
  Double4 a[4], b[4];
  for (int lane = 0; lane < 4; ++lane) {
    Double4 origin;
    load(positions + 4 * corners[lane], origin);
    load(positions + 4 * corners[4 + lane], a[lane]);
    load(positions + 4 * corners[8 + lane], b[lane]);
    a[lane] -= origin;
    b[lane] -= origin;
  }
  transpose(a[0], a[1], a[2], a[3]);
  transpose(b[0], b[1], b[2], b[3]);
  group.square1 = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
  group.square2 = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
  group.dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const Double4 cx = a[1] * b[2] - a[2] * b[1], cy = a[2] * b[0] - a[0] * b[2], cz = a[0] * b[1] - a[1] * b[0];
  group.L = cx * cx + cy * cy + cz * cz;
  for (int c = 0; c < 3; ++c) {
    group.e1[c] = a[c];
    group.e2[c] = b[c];
  }
}

DEFORMABLE_SURFACE_INLINE void findK(const double* constants, double lambda, double mu, Group& group) {
  Double4 G11, G12, G22, det, area, half_weight;  // half_weight = w A det D
  load(constants, G11);
  load(constants + 4, G12);
  load(constants + 8, G22);
  load(constants + 12, det);
  load(constants + 16, area);
  load(constants + 20, half_weight);
  takeRoots(group.L);
  Double4 T = G11 * group.square1 + G22 * group.square2 + 2.0 * (G12 * group.dot + det * group.L);
  takeRoots(T);
  const Double4 s = lambda - 2.0 * (lambda + mu) / T;
  const Double4 plain = area * (2.0 * mu + s), crossed = half_weight * s / group.L;
  group.K11 = plain * G11 + crossed * group.square2;
  group.K12 = plain * G12 - crossed * group.dot;
  group.K22 = plain * G22 + crossed * group.square1;
}

DEFORMABLE_SURFACE_INLINE void storeForces(const Group& group, double* corner_force) {
  Double4 force0[4], force1[4], force2[4];
  for (int c = 0; c < 3; ++c) {
    force1[c] = -(group.K11 * group.e1[c] + group.K12 * group.e2[c]);
    force2[c] = -(group.K12 * group.e1[c] + group.K22 * group.e2[c]);
    force0[c] = -(force1[c] + force2[c]);
  }
  force0[3] = force1[3] = force2[3] = Double4{};
  transpose(force0[0], force0[1], force0[2], force0[3]);
  transpose(force1[0], force1[1], force1[2], force1[3]);
  transpose(force2[0], force2[1], force2[2], force2[3]);
  for (int lane = 0; lane < 4; ++lane) {
    store(force0[lane], corner_force + 4 * lane);
    store(force1[lane], corner_force + 16 + 4 * lane);
    store(force2[lane], corner_force + 32 + 4 * lane);
  }
}

// The forces of the groups of four triangles from begin to end, as in the header. Returns true if a triangle is
// collapsed; its forces are then not finite. Three loops over a few groups each, so that roots and divisions of one group do not
// wait for those of another.
DEFORMABLE_SURFACE_WIDE bool computeCornerForces(Index begin, Index end, const Index* corners, const double* constants,
                                                 const double* positions, double lambda, double mu, double* corner_force) {
  Group groups[kBatch];
  bool collapsed = false;
  for (Index batch = begin; batch < end; batch += kBatch) {
    const Index size = end - batch < kBatch ? end - batch : kBatch;
    for (Index k = 0; k < size; ++k) loadEdges(corners + 12 * (batch + k), positions, groups[k]);
    for (Index k = 0; k < size; ++k) findK(constants + 24 * (batch + k), lambda, mu, groups[k]);
    for (Index k = 0; k < size; ++k) {
      const auto none = groups[k].L == 0.0;
      collapsed |= none[0] || none[1] || none[2] || none[3];
      storeForces(groups[k], corner_force + 48 * (batch + k));
    }
  }
  return collapsed;
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
  prepareForceLoop(static_cast<Index>(rest.size()));
}

void TriangleMembrane::prepareForceLoop(Index num_points) {
  std::vector<std::pair<Index, Index>> corners;
  corners.reserve(3 * elements_.size());
  for (std::size_t t = 0; t < elements_.size(); ++t)
    for (int c = 0; c < 3; ++c) corners.emplace_back(elements_[t].corner[c], static_cast<Index>(t / 4 * 12 + 4 * c + t % 4));
  incidence_ = groupByPoint(num_points, corners);
  // The same constants once more for the force loop, the last group filled up with the last element.
  const std::size_t groups = (elements_.size() + 3) / 4;
  corner_force_.resize(48 * groups);
  group_corners_.resize(12 * groups);
  group_constants_.resize(24 * groups);
  for (std::size_t t = 0; t < 4 * groups; ++t) {
    const Element& e = elements_[std::min(t, elements_.size() - 1)];
    const Mat2 G = e.inverse * e.inverse.transpose();
    const double det = e.inverse.determinant();
    const double constants[6] = {G(0, 0), G(0, 1), G(1, 1), det, e.area, e.area * det};
    for (std::size_t c = 0; c < 3; ++c) group_corners_[t / 4 * 12 + 4 * c + t % 4] = e.corner[c];
    for (std::size_t c = 0; c < 6; ++c) group_constants_[t / 4 * 24 + 4 * c + t % 4] = constants[c];
  }
}

Mat32 TriangleMembrane::gradient(const Element& e, const State& state) {
  const Vec3& origin = state.positions[e.corner[0]];
  Mat32 edges;
  edges << state.positions[e.corner[1]] - origin, state.positions[e.corner[2]] - origin;
  return edges * e.inverse;
}

// The forces of four triangles at a time; the few collapsed ones are repeated one by one.
void TriangleMembrane::addForces(const State& state, const PaddedPoints& positions, Points& forces) const {
  parallelFor(static_cast<Index>(group_corners_.size() / 12), kBlock, [&](Index begin, Index end) {
    if (computeCornerForces(begin, end, group_corners_.data(), group_constants_.data(), positions.data(), lambda_, mu_,
                            corner_force_.data()))
      repairCollapsed(4 * begin, std::min(4 * end, static_cast<Index>(elements_.size())), state);
  });
  // Gathered by the points.
  parallelFor(incidence_.size(), 2 * kBlock, [&](Index begin, Index end) {
    gatherForces(begin, end, incidence_.offsets.data(), incidence_.items.data(), corner_force_.data(), forces.data()->data());
  });
}

void TriangleMembrane::repairCollapsed(Index begin, Index end, const State& state) const {
  for (Index t = begin; t < end; ++t) {
    double* force[3];
    for (int c = 0; c < 3; ++c) force[c] = &corner_force_[4 * (t / 4 * 12 + 4 * c + t % 4)];
    if (std::isfinite(force[0][0] + force[0][1] + force[0][2])) continue;
    const Mat32 corner = cornerForces(t, state);
    for (int k = 0; k < 3; ++k) {
      force[0][k] = -(corner(k, 0) + corner(k, 1));
      force[1][k] = corner(k, 0);
      force[2][k] = corner(k, 1);
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
