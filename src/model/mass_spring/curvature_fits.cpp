// The fits of curvature at rest: which neighbours, by least squares, at the edges of clamps on one side. Apart from what follows
// from them at every state (curvature_bending.cpp).
#include "deformable_surface/model/mass_spring/clamps.h"
#include "deformable_surface/model/mass_spring/curvature_bending.h"

#include <Eigen/QR>

#include <algorithm>

namespace deformable_surface::model {
namespace {

constexpr Index kFitPoints = CurvatureBending::kFitPoints;
constexpr double kReach = 1.05;    // kernel support over the farthest neighbour's distance, so that it still counts
constexpr double kRankTolerance = 1e-3;  // smallest pivot over the largest for a fit to count as determined

// The nearest kFitPoints that i may see among the first, second and, if those are too few, third ring.
std::vector<Index> chooseFitPoints(Index i, const Points& rest, const Lists& ring, const Clamps& clamps) {
  std::vector<Index> found{i};
  std::size_t level = 0;
  for (int depth = 0; depth < 3 && (depth < 2 || static_cast<Index>(found.size()) <= kFitPoints); ++depth) {
    const std::size_t end = found.size();
    for (; level < end; ++level)
      for (const Index* j = ring.begin(found[level]); j != ring.end(found[level]); ++j)
        if (clamps.sees(i, *j) && std::find(found.begin(), found.end(), *j) == found.end()) found.push_back(*j);
  }
  found.erase(found.begin());
  std::sort(found.begin(), found.end(), [&](Index a, Index b) {
    const double da = (rest[a] - rest[i]).squaredNorm(), db = (rest[b] - rest[i]).squaredNorm();
    return da != db ? da < db : a < b;
  });
  if (static_cast<Index>(found.size()) > kFitPoints) found.resize(kFitPoints);
  return found;
}

// For each neighbour the five coefficients that a unit of its position adds.
using Fit = Eigen::Matrix<double, 5, Eigen::Dynamic>;

// The solution of least squares with rows already weighted; false if they do not determine it.
template <int Columns>
bool solveLeastSquares(const Eigen::Matrix<double, Eigen::Dynamic, Columns>& design, const Eigen::VectorXd& root_weight,
                       Eigen::Matrix<double, Columns, Eigen::Dynamic>& inverse) {
  if (design.rows() < Columns) return false;
  Eigen::ColPivHouseholderQR<Eigen::Matrix<double, Eigen::Dynamic, Columns>> solver(design);
  const auto pivots = solver.matrixQR().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > kRankTolerance * pivots.maxCoeff())) return false;
  const Eigen::MatrixXd weights = root_weight.asDiagonal();
  inverse = solver.solve(weights);
  return true;
}

// At the edge of a clamp: the slope from what is held, then, with that slope, the curvature from what is free and the edge.
bool solveClamped(const Eigen::Matrix<double, Eigen::Dynamic, 5>& design, const Eigen::VectorXd& root_weight,
                  const std::vector<Index>& fit, const Clamps& clamps, Fit& inverse) {
  const Index k = static_cast<Index>(fit.size());
  std::vector<Index> held, free;
  for (Index m = 0; m < k; ++m) {
    if (clamps.isHeld(fit[m])) held.push_back(m);
    if (!clamps.isInner(fit[m])) free.push_back(m);
  }
  const auto pick = [&](const std::vector<Index>& which, auto& rows, Eigen::VectorXd& weights, Index first) {
    rows.resize(which.size(), rows.cols());
    weights.resize(which.size());
    for (std::size_t r = 0; r < which.size(); ++r) {
      rows.row(r) = design.row(which[r]).segment(first, rows.cols());
      weights[r] = root_weight[which[r]];
    }
  };
  Eigen::VectorXd weights;
  Eigen::Matrix<double, Eigen::Dynamic, 5> quadratic;
  Eigen::Matrix<double, Eigen::Dynamic, 2> linear;
  Fit slopes_of_quadratic;
  Eigen::Matrix<double, 2, Eigen::Dynamic> slopes;
  pick(held, quadratic, weights, 0);
  if (solveLeastSquares(quadratic, weights, slopes_of_quadratic)) {
    slopes = slopes_of_quadratic.topRows<2>();
  } else {
    pick(held, linear, weights, 0);
    if (!solveLeastSquares(linear, weights, slopes)) return false;
  }
  Eigen::Matrix<double, Eigen::Dynamic, 3> bent;
  Eigen::Matrix<double, 3, Eigen::Dynamic> curvatures;
  pick(free, bent, weights, 2);
  if (!solveLeastSquares(bent, weights, curvatures)) return false;
  inverse = Fit::Zero(5, k);
  for (std::size_t r = 0; r < held.size(); ++r) inverse.col(held[r]).head<2>() += slopes.col(r);
  for (std::size_t r = 0; r < free.size(); ++r) {
    inverse.col(free[r]).tail<3>() += curvatures.col(r);
    // Less what the slope alone gives there. A row of the design is weighted, and so is the curvature's answer to it.
    const Vec2 place = design.row(free[r]).head<2>().transpose() / root_weight[free[r]];
    for (std::size_t h = 0; h < held.size(); ++h) inverse.col(held[h]).tail<3>() -= curvatures.col(r) * place.dot(slopes.col(h));
  }
  return true;
}

}  // namespace

CurvatureBending::CurvatureBending(const Points& rest, const Points& normals, const Lists& ring,
                                   const std::vector<double>& areas, double rigidity, double poisson_ratio,
                                   const std::vector<char>& held)
    : poisson_ratio_(poisson_ratio) {
  const Index n = static_cast<Index>(rest.size());
  const Clamps clamps(rest, ring, held);
  neighbors_.offsets.assign(1, 0);
  rest_curvature_.assign(n, Vec3::Zero());
  weight_.assign(n, 0.0);
  for (Index i = 0; i < n; ++i) {
    const std::vector<Index> fit = chooseFitPoints(i, rest, ring, clamps);
    const Index k = static_cast<Index>(fit.size());
    neighbors_.items.push_back(i);
    rows_.emplace_back(Row{Vec2::Zero(), Vec3::Zero()});
    if (k >= 5) {
      // The weighted quadratic in tangent coordinates scaled by the reach.
      const Vec3 e1 = normals[i].unitOrthogonal(), e2 = normals[i].cross(e1);
      const double reach = kReach * (rest[fit.back()] - rest[i]).norm();
      Eigen::Matrix<double, Eigen::Dynamic, 5> design(k, 5);
      Eigen::VectorXd root_weight(k);
      for (Index m = 0; m < k; ++m) {
        const Vec3 d = (rest[fit[m]] - rest[i]) / reach;
        const double a = d.dot(e1), b = d.dot(e2), q = 1.0 - d.squaredNorm();
        root_weight[m] = q;
        design.row(m) << a, b, 0.5 * a * a, a * b, 0.5 * b * b;
        design.row(m) *= q;
      }
      Fit inverse;
      const bool determined = clamps.isEdge(i) ? solveClamped(design, root_weight, fit, clamps, inverse)
                                               : solveLeastSquares(design, root_weight, inverse);
      if (determined) {
        Row own{Vec2::Zero(), Vec3::Zero()};
        for (Index m = 0; m < k; ++m) {
          const Row row{inverse.block<2, 1>(0, m) / reach, inverse.block<3, 1>(2, m) / (reach * reach)};
          own.first -= row.first;
          own.second -= row.second;
          neighbors_.items.push_back(fit[m]);
          rows_.push_back(row);
        }
        rows_[neighbors_.offsets.back()] = own;
        weight_[i] = rigidity * areas[i] * clamps.freeShare(i);
      } else {
        ++num_without_fit_;
      }
    } else {
      ++num_without_fit_;
    }
    neighbors_.offsets.push_back(static_cast<Index>(neighbors_.items.size()));
  }
  for (Index i = 0; i < n; ++i)
    if (weight_[i] != 0.0) rest_curvature_[i] = shapeAt(i, sumDerivativesAt(i, rest.data()->data(), 3)).change;
  prepareForceLoop();
}

}  // namespace deformable_surface::model
