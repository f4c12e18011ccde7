#include "deformable_surface/solve/stable_step.h"

#include "deformable_surface/base/interrupt.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::solve {
namespace {

// The stable step of a frequency w with a damping rate, both in 1/s; see the header.
double limit(double w, double rate) {
  if (!(w > 0.0)) return rate > 0.0 ? 2.0 / rate : std::numeric_limits<double>::infinity();
  const double z = 0.5 * rate / w;
  return 2.0 / w * (std::sqrt(1.0 + z * z) - z);
}

}  // namespace

double StableStep::estimate(double time, const State& state, const System& system) {
  const double known = system.findStableStep(state);
  if (known > 0.0)
    return limit(std::sqrt(4.0 / (known * known) + system.loadStiffness(time, state)), system.dampingRate(time, state));
  if (!system.hasStiffnessMatrix()) return limit(std::sqrt(system.boundStiffness(time, state)), system.dampingRate(time, state));
  const Index n = system.size();
  stiffness_.begin(n);
  system.addStiffness(time, state, 0.0, model::Hessian::kPositive, stiffness_);
  scale_.resize(3 * n);
  for (Index i = 0; i < n; ++i)
    scale_.segment<3>(3 * i).setConstant(system.isHeld(i) ? 0.0 : 1.0 / std::sqrt(system.masses()[i]));
  stiffness_.finish();
  // Of D K D with D = 1 / sqrt(mass), zero on held points.
  double eigenvalue = std::max(0.0, lanczos_.boundLargest(scale_, [this](const Eigen::VectorXd& v, Eigen::VectorXd& product) {
    endIfInterrupted();
    scaled_ = scale_.cwiseProduct(v);
    stiffness_.multiply(scaled_, product);
    product = scale_.cwiseProduct(product);
  }));
  const double coefficient = system.rankOneStiffness(state, rank_one_);
  if (coefficient > 0.0)
    for (Index i = 0; i < n; ++i) eigenvalue += coefficient * rank_one_[i].squaredNorm() / system.masses()[i];
  return limit(std::sqrt(eigenvalue), system.dampingRate(time, state));
}

}  // namespace deformable_surface::solve
