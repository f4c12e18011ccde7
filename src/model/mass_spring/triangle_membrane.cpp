#include "deformable_surface/model/mass_spring/triangle_membrane.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"
#include "deformable_surface/model/mass_spring/incidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::model {
namespace {

using Mat32 = Eigen::Matrix<double, 3, 2>;

constexpr Index kBlock = 1024;  // a multiple of the batch

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
    // Collapsed to a line or a point: any normal perpendicular to the line will do, always the same one.
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

// Some triangles side by side, one quantity in one array.
struct Batch {
  static constexpr Index kSize = 64;  // fits the nearest cache, and the loop's ends do not count
  double edge1[3][kSize], edge2[3][kSize];    // from the first corner, m
  double force1[3][kSize], force2[3][kSize];  // on the second and third corner, N
  double determinant[kSize];                  // 0 = collapsed: the forces are not valid
  double energy[kSize];                       // J

  void collect(Index lane, const Vec3& origin, const Vec3& second, const Vec3& third) {
    for (int c = 0; c < 3; ++c) {
      edge1[c][lane] = second[c] - origin[c];
      edge2[c][lane] = third[c] - origin[c];
    }
  }
};

// The forces of a batch. inverse: (4 x kSize) for the batch, rows i00, i01, i10, i11. Returns true if any triangle is collapsed.
DEFORMABLE_SURFACE_WIDE bool computeForces(Index size, double two_mu, double lambda, const double* inverse, const double* area,
                                           Batch& batch) {
  const double *i00 = inverse, *i01 = inverse + Batch::kSize, *i10 = inverse + 2 * Batch::kSize, *i11 = inverse + 3 * Batch::kSize;
#pragma GCC ivdep
  for (Index l = 0; l < size; ++l) {
    // F = [edge1 edge2] inverse.
    const double a = i00[l], b = i01[l], c = i10[l], d = i11[l];
    const double f1x = batch.edge1[0][l] * a + batch.edge2[0][l] * c, f2x = batch.edge1[0][l] * b + batch.edge2[0][l] * d;
    const double f1y = batch.edge1[1][l] * a + batch.edge2[1][l] * c, f2y = batch.edge1[1][l] * b + batch.edge2[1][l] * d;
    const double f1z = batch.edge1[2][l] * a + batch.edge2[2][l] * c, f2z = batch.edge1[2][l] * b + batch.edge2[2][l] * d;
    // J, T, n.
    const double cx = f1y * f2z - f1z * f2y, cy = f1z * f2x - f1x * f2z, cz = f1x * f2y - f1y * f2x;
    const double J = std::sqrt(cx * cx + cy * cy + cz * cz);
    const double T = std::sqrt(f1x * f1x + f1y * f1y + f1z * f1z + f2x * f2x + f2y * f2y + f2z * f2z + 2.0 * J);
    batch.determinant[l] = J;
    const double nx = cx / J, ny = cy / J, nz = cz / J;
    // P = 2 mu F + (lambda (T - 2) - 2 mu) R, R = (F + cof F) / T.
    const double s = (lambda * (T - 2.0) - two_mu) / T;
    const double p1x = two_mu * f1x + s * (f1x + f2y * nz - f2z * ny), p2x = two_mu * f2x + s * (f2x + ny * f1z - nz * f1y);
    const double p1y = two_mu * f1y + s * (f1y + f2z * nx - f2x * nz), p2y = two_mu * f2y + s * (f2y + nz * f1x - nx * f1z);
    const double p1z = two_mu * f1z + s * (f1z + f2x * ny - f2y * nx), p2z = two_mu * f2z + s * (f2z + nx * f1y - ny * f1x);
    // -A P inverse^T.
    const double w = -area[l];
    batch.force1[0][l] = w * (p1x * a + p2x * b);
    batch.force1[1][l] = w * (p1y * a + p2y * b);
    batch.force1[2][l] = w * (p1z * a + p2z * b);
    batch.force2[0][l] = w * (p1x * c + p2x * d);
    batch.force2[1][l] = w * (p1y * c + p2y * d);
    batch.force2[2][l] = w * (p1z * c + p2z * d);
  }
  return std::find(batch.determinant, batch.determinant + size, 0.0) != batch.determinant + size;
}

// The energies of a batch. With the stretches s1, s2: mu (|F - R|^2) = mu/2 ((T - 2)^2 + (s1 - s2)^2), and s1 - s2 is the length of
// n x f1 - f2, in which nothing large cancels; a collapsed triangle has s1 - s2 = |F|.
DEFORMABLE_SURFACE_WIDE void computeEnergies(Index size, double mu, double lambda, const double* inverse, const double* area,
                                             Batch& batch) {
  const double *i00 = inverse, *i01 = inverse + Batch::kSize, *i10 = inverse + 2 * Batch::kSize, *i11 = inverse + 3 * Batch::kSize;
#pragma GCC ivdep
  for (Index l = 0; l < size; ++l) {
    const double a = i00[l], b = i01[l], c = i10[l], d = i11[l];
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
    batch.energy[l] = 0.5 * area[l] * (mu * (dilation * dilation + difference) + lambda * dilation * dilation);
  }
}

}  // namespace

TriangleMembrane::TriangleMembrane(const std::vector<WeightedTriangle>& triangles, const Points& rest, double membrane_stiffness,
                                   double poisson_ratio)
    : mu_(membrane_stiffness / (2.0 * (1.0 + poisson_ratio))),
      lambda_(membrane_stiffness * poisson_ratio / (1.0 - poisson_ratio * poisson_ratio)) {
  std::vector<std::pair<Index, Index>> corners;
  for (const WeightedTriangle& t : triangles) {
    const Vec3 a = rest[t.corner[1]] - rest[t.corner[0]], b = rest[t.corner[2]] - rest[t.corner[0]];
    const double twice_area = a.cross(b).norm();
    if (!(twice_area > 0.0)) continue;
    // Edges in the triangle's own plane, first axis along a.
    const double length = a.norm();
    Mat2 edges;
    edges << length, a.dot(b) / length, 0.0, twice_area / length;
    Element e{{t.corner[0], t.corner[1], t.corner[2]}, edges.inverse(), 0.5 * t.weight * twice_area};
    if (!e.inverse.allFinite()) continue;
    for (int c = 0; c < 3; ++c) corners.emplace_back(t.corner[c], static_cast<Index>(3 * elements_.size()) + c);
    elements_.push_back(e);
  }
  incidence_ = groupByPoint(static_cast<Index>(rest.size()), corners);
  corner_force_.resize(3 * elements_.size());
  // The same constants once more as arrays, batch by batch.
  const std::size_t padded = (elements_.size() + Batch::kSize - 1) / Batch::kSize * Batch::kSize;
  inverse_.assign(4 * padded, 0.0);
  area_.assign(padded, 0.0);
  for (std::size_t t = 0; t < elements_.size(); ++t) {
    const std::size_t batch = 4 * (t - t % Batch::kSize), lane = t % Batch::kSize;
    for (int r = 0; r < 4; ++r) inverse_[batch + r * Batch::kSize + lane] = elements_[t].inverse(r / 2, r % 2);
    area_[t] = elements_[t].area;
  }
}

Mat32 TriangleMembrane::gradient(const Element& e, const State& state) {
  const Vec3& origin = state.positions[e.corner[0]];
  Mat32 edges;
  edges << state.positions[e.corner[1]] - origin, state.positions[e.corner[2]] - origin;
  return edges * e.inverse;
}

// Per block: the edges are collected from all over the surface into arrays, the forces come from them in one loop that the
// compiler turns into vector instructions, and the few collapsed triangles are done again one by one.
void TriangleMembrane::addForces(const State& state, Points& forces) const {
  const Index n = static_cast<Index>(elements_.size());
  parallelFor(n, kBlock, [&](Index block_begin, Index block_end) {
    Batch batch;
    for (Index begin = block_begin; begin < block_end; begin += Batch::kSize) {
      const Index size = std::min(Batch::kSize, block_end - begin);
      for (Index l = 0; l < size; ++l) {
        const Element& e = elements_[begin + l];
        batch.collect(l, state.positions[e.corner[0]], state.positions[e.corner[1]], state.positions[e.corner[2]]);
      }
      const bool collapsed = computeForces(size, 2.0 * mu_, lambda_, &inverse_[4 * begin], &area_[begin], batch);
      for (Index l = 0; l < size; ++l) {
        Vec3 force1(batch.force1[0][l], batch.force1[1][l], batch.force1[2][l]);
        Vec3 force2(batch.force2[0][l], batch.force2[1][l], batch.force2[2][l]);
        if (collapsed && batch.determinant[l] == 0.0) {
          const Mat32 corner = cornerForces(begin + l, state);
          force1 = corner.col(0);
          force2 = corner.col(1);
        }
        corner_force_[3 * (begin + l) + 1] = force1;
        corner_force_[3 * (begin + l) + 2] = force2;
        corner_force_[3 * (begin + l)] = -force1 - force2;
      }
    }
  });
  // Gathered by the points.
  parallelFor(incidence_.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Vec3 sum = Vec3::Zero();
      for (const Index* c = incidence_.begin(i); c != incidence_.end(i); ++c) sum += corner_force_[*c];
      forces[i] += sum;
    }
  });
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
    Batch batch;
    double sum = 0.0;
    for (Index begin = block_begin; begin < block_end; begin += Batch::kSize) {
      const Index size = std::min(Batch::kSize, block_end - begin);
      for (Index l = 0; l < size; ++l) {
        const Element& e = elements_[begin + l];
        batch.collect(l, state.positions[e.corner[0]], state.positions[e.corner[1]], state.positions[e.corner[2]]);
      }
      computeEnergies(size, mu_, lambda_, &inverse_[4 * begin], &area_[begin], batch);
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
    // turned (spin in the plane), and n v_k^T (tilt out of the plane). c is what the rotation's change takes away.
    const double c = 2.0 * mu_ - lambda_ * (p.trace - 2.0);
    const double spin = std::max(lowest, 2.0 * mu_ - (p.trace > 0.0 ? 2.0 * c / p.trace : 0.0)) - 2.0 * mu_;
    Mat2 turn;
    turn << 0.0, -1.0, 1.0, 0.0;
    const Mat32 spin_mode = p.rotation * turn / std::sqrt(2.0), dilation_mode = p.rotation / std::sqrt(2.0);
    double tilt[2];
    for (int k = 0; k < 2; ++k)
      tilt[k] = std::max(lowest, 2.0 * mu_ - (stretch[k] > 1e-9 ? c / stretch[k] : 0.0)) - 2.0 * mu_;

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
