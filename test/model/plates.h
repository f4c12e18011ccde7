// Plates with small bending: only the motion of points across the plane z = 0 counts. The problem is then linear, and exact
// answers are in every textbook.
#pragma once

#include "../support/surfaces.h"
#include "deformable_surface/cloud/simplification.h"
#include "deformable_surface/linear/block_sparse.h"
#include "deformable_surface/model/mass_spring/curvature_bending.h"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

namespace deformable_surface::test {

inline model::PlateRest plateOf(const Surface& surface, double rigidity, double poisson_ratio) {
  model::PlateRest plate;
  plate.points = surface.points;
  plate.normals = surface.normals;
  plate.ring = surface.rings.ring;
  for (const cloud::Triangle& t : surface.rings.triangles)
    plate.triangles.push_back({{t.corner[0], t.corner[1], t.corner[2]}, t.weight});
  plate.rigidity = rigidity;
  plate.poisson_ratio = poisson_ratio;
  return plate;
}

enum class Scatter { kGrid, kJittered, kPoisson, kSimplified };

/// Points on [0, length] x [-width / 2, width / 2], about `along` spacings in the length: jittered by 0.3 of the spacing and at
/// least 0.8 of it apart, or simplified from a jittered cloud with nine times as many.
inline Surface makeScattered(Scatter scatter, Index along, double length, double width, unsigned seed = 1) {
  const double h = length / along;
  const Index across = static_cast<Index>(std::lround(width / h));
  const double jitter = scatter == Scatter::kGrid ? 0.0 : 0.3;
  if (scatter == Scatter::kSimplified) {
    const Surface dense = makeSheet(3 * along + 1, 3 * across + 1, length, width, jitter, seed);
    const cloud::Simplification order = cloud::simplify(dense.points, dense.normals, 16, (along + 1) * (across + 1), {});
    Points points;
    for (const Index i : order.keepCount((along + 1) * (across + 1))) points.push_back(dense.points[i]);
    return connect(points, Points(points.size(), Vec3::UnitZ()));
  }
  if (scatter != Scatter::kPoisson) return makeSheet(along + 1, across + 1, length, width, jitter, seed);
  std::mt19937 generator(seed);
  Points points;
  for (Index i = 0; i <= along; ++i)
    for (const double y : {-0.5 * width, 0.5 * width}) points.emplace_back(i * h, y, 0.0);
  for (Index j = 1; j < across; ++j)
    for (const double x : {0.0, length}) points.emplace_back(x, j * width / across - 0.5 * width, 0.0);
  for (int misses = 0; misses < 2000;) {
    const double u = uniform(generator), v = uniform(generator);
    const Vec3 p(0.5 * (1.0 + u) * length, 0.5 * v * width, 0.0);
    const auto isNear = [&](const Vec3& q) { return (p - q).squaredNorm() < 0.64 * h * h; };
    if (std::any_of(points.begin(), points.end(), isNear)) {
      ++misses;
    } else {
      points.push_back(p);
      misses = 0;
    }
  }
  return connect(points, Points(points.size(), Vec3::UnitZ()));
}

using SparseMatrix = Eigen::SparseMatrix<double>;

/// The stiffness for motions across the plane, N/m: (n x n).
inline SparseMatrix stiffnessAcross(const Surface& s, const model::CurvatureBending& bending) {
  BlockSparse stiffness;
  stiffness.begin(static_cast<Index>(s.points.size()));
  bending.addStiffness({s.points, Points(s.points.size(), Vec3::Zero())}, model::Hessian::kPositive, stiffness);
  stiffness.finish();
  std::vector<Eigen::Triplet<double>> entries;
  const Lists& pattern = stiffness.pattern();
  for (Index column = 0; column < pattern.size(); ++column)
    for (Index k = pattern.offsets[column]; k < pattern.offsets[column + 1]; ++k) {
      entries.emplace_back(pattern.items[k], column, stiffness.values()[k](2, 2));
      if (pattern.items[k] != column) entries.emplace_back(column, pattern.items[k], stiffness.values()[k](2, 2));
    }
  SparseMatrix matrix(pattern.size(), pattern.size());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// The motion of the free points under forces across the plane (n, N), m.
inline Eigen::VectorXd solveHeld(const SparseMatrix& stiffness, const std::vector<char>& held, const Eigen::VectorXd& forces) {
  std::vector<Index> free, place(held.size(), -1);
  for (Index i = 0; i < static_cast<Index>(held.size()); ++i) {
    if (held[i]) continue;
    place[i] = static_cast<Index>(free.size());
    free.push_back(i);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (Index column = 0; column < stiffness.cols(); ++column)
    for (SparseMatrix::InnerIterator entry(stiffness, column); entry; ++entry)
      if (place[entry.row()] >= 0 && place[column] >= 0) entries.emplace_back(place[entry.row()], place[column], entry.value());
  SparseMatrix matrix(free.size(), free.size());
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXd right(free.size());
  for (std::size_t k = 0; k < free.size(); ++k) right[k] = forces[free[k]];
  const Eigen::VectorXd solution = Eigen::SimplicialLDLT<SparseMatrix>(matrix).solve(right);
  Eigen::VectorXd motion = Eigen::VectorXd::Zero(held.size());
  for (std::size_t k = 0; k < free.size(); ++k) motion[free[k]] = solution[k];
  return motion;
}

/// The quadratic 1, x, y, x^2 / 2, x y, y^2 / 2 about a place that fits motions best at points near to it.
template <class IsNear>
Eigen::VectorXd fitQuadratic(const Surface& s, const Eigen::VectorXd& motion, const Vec3& place, const IsNear& isNear) {
  std::vector<Index> near;
  for (Index i = 0; i < static_cast<Index>(s.points.size()); ++i)
    if (isNear(s.points[i])) near.push_back(i);
  Eigen::MatrixXd design(near.size(), 6);
  Eigen::VectorXd values(near.size());
  for (std::size_t k = 0; k < near.size(); ++k) {
    const Vec3 d = s.points[near[k]] - place;
    design.row(k) << 1.0, d.x(), d.y(), 0.5 * d.x() * d.x(), d.x() * d.y(), 0.5 * d.y() * d.y();
    values[k] = motion[near[k]];
  }
  return design.colPivHouseholderQr().solve(values);
}

}  // namespace deformable_surface::test
