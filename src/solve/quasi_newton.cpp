#include "quasi_newton.h"

#include "deformable_surface/base/simd.h"
#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::solve {
namespace {

constexpr Index kMemory = 12;              // pairs: 20 save three iterations of 27, 4 cost one more, and each pair takes time
constexpr Index kMost = 120;               // iterations: more cost as much as Newton's method
constexpr Index kTrial = 30;               // iterations in each of which the largest force
constexpr double kEnergyRounding = 1e-14;  // of an energy: some tens of units in the last place
constexpr double kFall = 0.2;              // has to fall to this share of itself: where all is well it does so in ten
// With at least this many points an iteration of Newton's method costs as much as hundreds of these, and the largest force rises
// for longer before it falls: the first trial is then omitted.
constexpr Index kMany = 4096;
constexpr Index kMostOfMany = 600;
constexpr Index kFirstRefresh = 6;  // iterations after which the preconditioner is renewed; doubled each time
constexpr double kGoodFall = 0.1;   // of the largest force in these, with which it need not be
// For System::findCouplings(): far from the equilibrium, and near it, where tension has almost its final value.
constexpr double kFarSupport = 1.0, kNearSupport = 0.3;
constexpr int kMostTrials = 12;  // of lengths: beyond it the direction is rounding
// Wolfe's conditions: the share of the first slope that may be left, before and after the least energy.
constexpr double kLeft = 0.9, kBeyond = 0.8;
constexpr double kMostStretch = 64.0;  // of a length that was too short
constexpr double kCut = 0.1;           // of one that led to no numbers, and the nearest to a known end that a guess may come

Eigen::Map<Eigen::VectorXd> flatten(Points& points) {
  return {points.data()->data(), 3 * static_cast<Eigen::Index>(points.size())};
}

DEFORMABLE_SURFACE_WIDE double sumProducts(Eigen::Index size, const double* a, const double* b) {
  Double4 sums[2] = {}, p, q;
  Eigen::Index i = 0;
  for (; i + 8 <= size; i += 8)
    for (int half = 0; half < 2; ++half) {
      load(a + i + 4 * half, p);
      load(b + i + 4 * half, q);
      sums[half] += p * q;
    }
  sums[0] += sums[1];
  double sum = (sums[0][0] + sums[0][1]) + (sums[0][2] + sums[0][3]);
  for (; i < size; ++i) sum += a[i] * b[i];
  return sum;
}

DEFORMABLE_SURFACE_WIDE void addScaled(Eigen::Index size, double scale, const double* a, double* sum) {
  for (Eigen::Index i = 0; i < size; ++i) sum[i] += scale * a[i];
}

double dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return sumProducts(a.size(), a.data(), b.data()); }

// sum += scale a
void add(double scale, const Eigen::VectorXd& a, Eigen::VectorXd& sum) { addScaled(a.size(), scale, a.data(), sum.data()); }

}  // namespace

double QuasiNewton::findGradient(const System& system, double time, const std::vector<double>& rounding, State& state,
                                 SolveReport& report) {
  const Timer timer;
  scale_ = system.computeForcesAndLargest(time, state, forces_);
  report.time_forces += timer.seconds();
  gradient_ = -flatten(forces_);
  double squared = 0.0;
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const double unbalanced = forces_[i].squaredNorm();
    if (!(unbalanced <= rounding[i] * rounding[i])) squared = std::max(squared, unbalanced);
  }
  return std::sqrt(squared);
}

// The two loops of Nocedal.
void QuasiNewton::findDirection(const System& system) {
  const Index count = std::min(num_found_, kMemory);
  work_ = -gradient_;
  for (Index age = 0; age < count; ++age) {
    Pair& p = remember(age);
    p.share = p.inverse * dot(p.step, work_);
    add(-p.share, p.change, work_);
  }
  preconditioner_.apply(system, work_, direction_);
  for (Index age = count; age-- > 0;) {
    const Pair& p = remember(age);
    add(p.share - p.inverse * dot(p.change, direction_), p.step, direction_);
  }
}

// Between two known slopes by the zero of the line through them.
bool QuasiNewton::search(const System& system, double time, const std::vector<double>& rounding, State& state,
                         SolveReport& report) {
  const double slope = dot(gradient_, direction_), residual = report.residual;
  if (!(slope < 0.0)) return false;
  start_ = flatten(state.positions);
  gradient_before_.swap(gradient_);
  double low = 0.0, low_slope = slope, high = 0.0, high_slope = 0.0;  // high = 0: not known
  double bound = HUGE_VAL;                                            // a length that led to no numbers
  fraction_ = 1.0;
  for (int trial = 0; trial < kMostTrials; ++trial) {
    flatten(state.positions) = start_ + fraction_ * direction_;
    report.residual = findGradient(system, time, rounding, state, report);
    const double there = dot(gradient_, direction_);
    if (there >= kLeft * slope && there <= -kBeyond * slope) {
      Pair& p = pairs_[num_found_++ % kMemory];
      p.step = fraction_ * direction_;
      p.change = gradient_ - gradient_before_;
      p.inverse = 1.0 / dot(p.step, p.change);
      return true;
    }
    if (!std::isfinite(there)) {
      bound = fraction_;
      fraction_ = low + kCut * (fraction_ - low);
      continue;
    }
    (there > 0.0 ? high : low) = fraction_;
    (there > 0.0 ? high_slope : low_slope) = there;
    if (high > 0.0) {
      const double width = high - low, zero = low - low_slope * width / (high_slope - low_slope);
      fraction_ = std::clamp(zero, low + kCut * width, high - kCut * width);
    } else {
      // The sag of a flat surface grows with the cube root of its load: the slope changes with the third power of the length.
      const double cubed = there > slope ? slope / (slope - there) : HUGE_VAL;
      fraction_ = std::min(fraction_ * std::min(std::cbrt(cubed), kMostStretch), 0.5 * (fraction_ + bound));
    }
  }
  flatten(state.positions) = start_;
  gradient_.swap(gradient_before_);
  report.residual = residual;
  return false;
}

bool QuasiNewton::descend(const System& system, double time, double tolerance, const std::vector<double>& rounding,
                          const std::atomic<bool>* interrupt, State& state, SolveReport& report) {
  report.residual = findGradient(system, time, rounding, state, report);
  const auto isEnough = [&] { return report.residual <= tolerance * scale_; };
  if (isEnough()) return true;
  if (!preconditioner_.prepare(system, state, kFarSupport)) return false;
  const double energy = system.potentialEnergy(time, state);
  double at_trial = report.residual, at_refresh = report.residual;
  Index refresh = kFirstRefresh;
  const bool are_many = state.size() > kMany;
  for (Index k = 1; k <= (are_many ? kMostOfMany : kMost) && !(interrupt && *interrupt); ++k) {
    findDirection(system);
    if (!search(system, time, rounding, state, report)) return false;
    ++report.iterations;
    if (isEnough()) return system.potentialEnergy(time, state) <= energy + kEnergyRounding * std::abs(energy);
    if (k % kTrial == 0) {
      if (!(are_many && k == kTrial) && !(report.residual <= kFall * at_trial)) return false;
      at_trial = report.residual;
    }
    // A surface that is flat at first has no tension yet; a first step that had to be shortened shows this.
    if ((k == 1 && fraction_ != 1.0) || (k == refresh && report.residual > kGoodFall * at_refresh)) {
      if (!preconditioner_.prepare(system, state, k == 1 ? kFarSupport : kNearSupport)) return false;
      if (k == 1) num_found_ = 0;  // the stiffness has changed over so long a step
    }
    if (k == refresh) {
      refresh *= 2;
      at_refresh = report.residual;
    }
  }
  return false;
}

bool QuasiNewton::solve(const System& system, double time, double tolerance, const std::vector<double>& rounding,
                        const std::atomic<bool>* interrupt, State& state, SolveReport& report) {
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
