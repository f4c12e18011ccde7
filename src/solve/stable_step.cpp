#include "deformable_surface/solve/stable_step.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::solve {
namespace {

// Of the largest entry of the matrix: slow forces below it are bounded, not measured. Largest eigenvalues were 1.3 to 2 times the
// largest entry (sheets of 1024 and 4096 points with and without jitter, flat and falling): the step is then up to 1.5 % shorter,
// and measuring takes several times as long.
constexpr double kFaint = 0.04;
constexpr Index kBlock = 1024;  // points per task: some microseconds of work

// The stable step of a frequency w with a damping rate, both in 1/s; see the header.
double limit(double w, double rate) {
  if (!(w > 0.0)) return rate > 0.0 ? 2.0 / rate : std::numeric_limits<double>::infinity();
  const double z = rate / w;
  return 2.0 / w * (std::sqrt(1.0 + z * z) - z);
}

}  // namespace

double StableStep::findLimit(double squared_frequency, double time, const State& state, const System& system, bool splits) const {
  using Loads = System::Loads;
  const double with_damping =
      limit(std::sqrt(squared_frequency), system.dampingRate(time, state, splits ? Loads::kOthers : Loads::kAll));
  if (!splits || !system.hasSplitLoads()) return with_damping;
  return std::min(with_damping, limit(0.0, system.boundSplitLoads(time, state).damping));
}

double StableStep::estimate(double time, const State& state, const System& system, bool splits) {
  slow_rate_ = system.boundSlowRate(state);
  const double known = system.findStableStep(state);
  // Row bounds of contact springs hold for those of friction, too, which act in other directions.
  if (known > 0.0) return findLimit(4.0 / (known * known) + system.loadStiffness(time, state), time, state, system, splits);
  if (!system.hasStiffnessMatrix()) return findLimit(system.boundStiffness(time, state), time, state, system, splits);
  const Index n = system.size();
  const std::vector<double>& masses = system.masses();
  scale_.resize(3 * n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) scale_.segment<3>(3 * i).setConstant(system.isHeld(i) ? 0.0 : 1.0 / std::sqrt(masses[i]));
  });
  const auto [matrix, left_out] = fillStiffness(time, state, system);
  // Of D K D with D = 1 / sqrt(mass), zero on held points.
  scaled_.resize(3 * n);
  const auto scale = [&](const Eigen::VectorXd& from, Eigen::VectorXd& to) {
    parallelFor(3 * n, 3 * kBlock, [&](Index begin, Index end) {
      const Index size = end - begin;
      to.segment(begin, size) = scale_.segment(begin, size).cwiseProduct(from.segment(begin, size));
    });
  };
  double eigenvalue =
      left_out +
      std::max(0.0, lanczos_.boundLargest(scale_, [&, matrix = matrix](const Eigen::VectorXd& v, Eigen::VectorXd& product) {
        endIfInterrupted();
        scale(v, scaled_);
        matrix->multiply(scaled_, product);
        scale(product, product);
      }));
  const double coefficient = system.rankOneStiffness(state, rank_one_);
  if (coefficient > 0.0)
    for (Index i = 0; i < n; ++i) eigenvalue += coefficient * rank_one_[i].squaredNorm() / system.masses()[i];
  if (splits && system.hasSplitLoads()) eigenvalue += system.boundSplitLoads(time, state).stiffness;
  return findLimit(eigenvalue, time, state, system, splits);
}

// Slow forces couple many more points than the others: they are most of the work, and on a thin surface they do not matter. Loads
// with a stiffness couple points as widely, and others in every step: the pattern of slow forces has a place for them.
std::pair<const BlockSparse*, double> StableStep::fillStiffness(double time, const State& state, const System& system) {
  if (system.hasSlowForces() && !(system.loadStiffness(time, state) > 0.0)) {
    fast_.begin(system.size());
    system.addFastStiffness(state, fast_);
    fast_.finish();
    if (slow_rate_ <= kFaint * largestEntry(fast_)) return {&fast_, slow_rate_};
  }
  whole_.begin(system.size());
  system.addStiffness(time, state, 0.0, model::Hessian::kPositive, whole_);
  whole_.finish();
  return {&whole_, 0.0};
}

// No eigenvalue is less than this.
double StableStep::largestEntry(const BlockSparse& stiffness) const {
  return parallelMax(stiffness.pattern().size(), kBlock, [&](Index begin, Index end) {
    double largest = 0.0;
    for (Index i = begin; i < end; ++i) {
      const Mat3& block = stiffness.values()[stiffness.pattern().offsets[i]];
      largest = std::max(largest, scale_[3 * i] * scale_[3 * i] * block.diagonal().maxCoeff());
    }
    return largest;
  });
}

}  // namespace deformable_surface::solve
