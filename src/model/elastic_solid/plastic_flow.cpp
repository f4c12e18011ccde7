#include "deformable_surface/model/elastic_solid/plastic_flow.h"

#include "deformable_surface/base/parallel.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;  // points a task
// Of the yield, by Green's strain, which is half the stretch's where lengths have shrunk to nothing.
constexpr double kClearlyBelow = 0.5;
constexpr double kRounding = 1e-12;  // relative: nothing flows if the largest strain is already reached

using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;
using Row = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;

Row deviatorOf(const Row& v) { return v.array() - v.mean(); }

}  // namespace

PlasticFlow::PlasticFlow(const SolidRest& rest, const PlasticityParams& params) : params_(params), at_rest_(rest.gradients) {
  const bool is_planar = !rest.across.isZero(0.0);
  axes_ = Mat3::Identity();
  if (is_planar) {
    const Vec3 u = rest.across.unitOrthogonal();
    axes_.resize(3, 2);
    axes_ << u, rest.across.cross(u);
  }
  stress_of_deviator_ = 2.0 * rest.mu * std::sqrt(is_planar ? 2.0 : 1.5);
}

void PlasticFlow::apply(const std::vector<Mat3>& plastic, SolidPasses& passes) const {
  parallelFor(passes.size(), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) passes.setPlastic(i, at_rest_, plastic[i]);
  });
}

// Returns whether the point flows, and then its new F_p^-1. F: F_e.
bool PlasticFlow::flowAt(Index i, double share, const Mat3& F, const SolidRest& rest, Mat3& plastic) const {
  const bool is_planar = axes_.cols() == 2;
  if (rest.fit.rank[i] < axes_.cols() || !(F.determinant() > 0.0)) return false;
  const Square square = axes_.transpose() * F.transpose() * F * axes_;
  const double mean = square.trace() / static_cast<double>(square.rows());
  const Square green = 0.5 * (square - mean * Square::Identity(square.rows(), square.cols()));
  // In Green's strain, two stretches differ by their difference times half their sum: the bound holds unless all is crushed.
  if (mean > 2.0 / 3.0 && !(stress_of_deviator_ * green.norm() > kClearlyBelow * params_.yield_stress)) return false;
  const Eigen::SelfAdjointEigenSolver<Square> solver(square);
  const Row stretch = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const double stress = stress_of_deviator_ * deviatorOf(stretch).norm();
  if (!(stress > params_.yield_stress) || !(stretch.minCoeff() > 0.0)) return false;

  const Row flown = -share * (1.0 - params_.yield_stress / stress) * deviatorOf(stretch.array().log());
  const Square change = solver.eigenvectors() * Row(flown.array().exp()).asDiagonal() * solver.eigenvectors().transpose();
  Mat3 all = axes_ * change * axes_.transpose();
  if (is_planar) all += rest.across * rest.across.transpose();
  const Mat3 before = plastic;
  plastic = Mat3(plastic * all);

  // The largest strain: its whole logarithm is scaled.
  const Eigen::JacobiSVD<Mat3> svd(plastic, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vec3 logarithm = svd.singularValues().array().log();
  const double strain = std::sqrt(2.0 / 3.0) * logarithm.norm();
  if (strain > params_.max_strain)
    plastic =
        svd.matrixU() * Vec3((params_.max_strain / strain * logarithm).array().exp()).asDiagonal() * svd.matrixV().transpose();
  return !plastic.isApprox(before, kRounding);
}

bool PlasticFlow::flow(double dt, const double* positions, SolidPasses& passes, State& state) const {
  const double share = params_.creep.is_auto ? 1.0 : -std::expm1(-params_.creep.value * dt);
  std::atomic<bool> any{false};
  // Each point has rows of its own; no other fit reads them.
  const double lost = parallelSum(passes.size(), kBlock, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index i = begin; i < end; ++i) {
      const Mat3 F = passes.fitGradient(i, positions);
      Mat3 plastic = state.plastic[i];
      if (!flowAt(i, share, F, passes.rest, plastic)) continue;
      any = true;
      const double before = passes.findDensity(StressLaw::kCorotated, F);
      passes.setPlastic(i, at_rest_, plastic);
      state.plastic[i] = plastic;
      sum += passes.rest.volumes[i] * (before - passes.findDensity(StressLaw::kCorotated, passes.fitGradient(i, positions)));
    }
    return sum;
  });
  state.dissipated += lost;
  return any;
}

}  // namespace deformable_surface::model
