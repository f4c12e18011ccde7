#include "quasi_newton.h"

#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::solve {
namespace {

constexpr Index kMemory = 12;       // pairs: with 20 three iterations of 27 fewer, with 4 one more, and each pair costs time
constexpr Index kMost = 120;        // iterations: more cost as much as Newton's method
constexpr Index kTrial = 30;        // iterations, in each so many of which the largest force
constexpr double kFall = 0.1;       // has to fall to this share of itself: where all is well it does so in ten
constexpr Index kFirstRefresh = 10; // iterations after which the preconditioner is taken anew; doubled each time
constexpr double kGoodFall = 0.1;   // of the largest force in these, with which it need not be
constexpr Index kScaleInterval = 8; // iterations between two looks at the largest force there is
constexpr int kMostTrials = 12;     // of lengths: beyond it the direction is rounding
// Wolfe's conditions: the share of the first slope that may be left, before and after the least energy.
constexpr double kLeft = 0.9, kBeyond = 0.8;
constexpr double kStretch = 4.0;    // of a length that was too short
constexpr double kCut = 0.1;        // of one that led to no numbers, and the nearest to a known end that a guess may come

Eigen::Map<Eigen::VectorXd> flatten(Points& points) {
  return {points.data()->data(), 3 * static_cast<Eigen::Index>(points.size())};
}

}  // namespace

double QuasiNewton::findGradient(const System& system, double time, State& state, SolveReport& report) {
  const Timer timer;
  system.computeForces(time, state, forces_);
  report.time_forces += timer.seconds();
  gradient_ = -flatten(forces_);
  double squared = 0.0;
  for (const Vec3& force : forces_) squared = std::max(squared, force.squaredNorm());
  return std::sqrt(squared);
}

// The two loops of Nocedal.
void QuasiNewton::findDirection(const System& system) {
  const Index count = std::min(num_found_, kMemory);
  work_ = -gradient_;
  for (Index age = 0; age < count; ++age) {
    Pair& p = remember(age);
    p.share = p.inverse * p.step.dot(work_);
    work_ -= p.share * p.change;
  }
  preconditioner_.apply(system, work_, direction_);
  for (Index age = count; age-- > 0;) {
    const Pair& p = remember(age);
    direction_ += (p.share - p.inverse * p.change.dot(direction_)) * p.step;
  }
}

// By the zero of the slope that a straight line between two known ones has.
bool QuasiNewton::search(const System& system, double time, State& state, SolveReport& report) {
  const double slope = gradient_.dot(direction_), residual = report.residual;
  if (!(slope < 0.0)) return false;
  start_ = flatten(state.positions);
  gradient_before_.swap(gradient_);
  double low = 0.0, low_slope = slope, high = 0.0, high_slope = 0.0;  // high = 0: not known
  fraction_ = 1.0;
  for (int trial = 0; trial < kMostTrials; ++trial) {
    flatten(state.positions) = start_ + fraction_ * direction_;
    report.residual = findGradient(system, time, state, report);
    const double there = gradient_.dot(direction_);
    if (there >= kLeft * slope && there <= -kBeyond * slope) {
      Pair& p = pairs_[num_found_++ % kMemory];
      p.step = fraction_ * direction_;
      p.change = gradient_ - gradient_before_;
      p.inverse = 1.0 / p.step.dot(p.change);
      return true;
    }
    if (!std::isfinite(there)) {
      fraction_ = low + kCut * (fraction_ - low);
      continue;
    }
    (there > 0.0 ? high : low) = fraction_;
    (there > 0.0 ? high_slope : low_slope) = there;
    const double width = high - low;
    const double zero = low - low_slope * width / (high_slope - low_slope);
    fraction_ = high > 0.0 ? std::clamp(zero, low + kCut * width, high - kCut * width) : kStretch * fraction_;
  }
  flatten(state.positions) = start_;
  gradient_.swap(gradient_before_);
  report.residual = residual;
  return false;
}

bool QuasiNewton::descend(const System& system, double time, double tolerance, double rounding,
                          const std::atomic<bool>* interrupt, State& state, SolveReport& report) {
  report.residual = findGradient(system, time, state, report);
  double scale = system.largestForce(time, state);
  const auto isEnough = [&] { return report.residual <= std::max(tolerance * scale, rounding); };
  if (isEnough()) return true;
  if (!preconditioner_.prepare(system, state)) return false;
  const double energy = system.potentialEnergy(time, state);
  double at_trial = report.residual, at_refresh = report.residual;
  Index refresh = kFirstRefresh;
  for (Index k = 1; k <= kMost && !(interrupt && *interrupt); ++k) {
    findDirection(system);
    if (!search(system, time, state, report)) return false;
    ++report.iterations;
    // The largest force of another place says nothing: far from the equilibrium it is larger by far, at rest smaller.
    if (isEnough() || k % kScaleInterval == 0) scale = system.largestForce(time, state);
    if (isEnough()) return system.potentialEnergy(time, state) <= energy + 1e-14 * std::abs(energy);
    if (k % kTrial == 0) {
      if (!(report.residual <= kFall * at_trial)) return false;
      at_trial = report.residual;
    }
    // What is flat at first has no tension yet, and a first step that had to be cut says so.
    if ((k == 1 && fraction_ != 1.0) || (k == refresh && report.residual > kGoodFall * at_refresh)) {
      if (!preconditioner_.prepare(system, state)) return false;
    }
    if (k == refresh) {
      refresh *= 2;
      at_refresh = report.residual;
    }
  }
  return false;
}

bool QuasiNewton::solve(const System& system, double time, double tolerance, double rounding, const std::atomic<bool>* interrupt,
                        State& state, SolveReport& report) {
  if (!system.hasElasticityAlone(time, state)) return false;
  pairs_.resize(kMemory);
  for (Pair& pair : pairs_) {
    pair.step.resize(3 * state.size());
    pair.change.resize(3 * state.size());
  }
  num_found_ = 0;
  first_ = state.positions;
  const Index iterations = report.iterations;
  if (descend(system, time, tolerance, rounding, interrupt, state, report)) return true;
  state.positions = first_;
  report.iterations = iterations;
  return false;
}

}  // namespace deformable_surface::solve
