#include "implicit_integrators.h"

#include "deformable_surface/base/timer.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::solve {
namespace {

// Of the forces: the largest imbalance of a stage without an iteration; the inertial forces would hide more.
constexpr double kUntouched = 1e-6;
constexpr double kGrowth = 10.0;        // of the pseudo time step after a full Newton step
constexpr double kShrink = 0.1;         // after a step that had to be cut or failed
constexpr double kFirstStep = 1.0;      // of the caller's step
constexpr double kLongestStep = 1e8;    // of the caller's step: the weight is then rounding beside any stiffness
constexpr double kShortestStep = 1e-6;  // of the caller's step: shorter ones do not lead anywhere
constexpr double kStride = 0.5;         // of a link: motion of a held point in one part of a static step
constexpr double kMostParts = 64.0;
constexpr double kRow = 1e-6;           // spread of points across a row over that along it, squared
constexpr double kRigid = 1e-9;         // of the motion: distance from a rigid one that is rounding
constexpr double kRough = 0.05;         // tolerance of all parts but the last
constexpr Index kRoughIterations = 10;  // of Newton's method in each of them
constexpr Index kTrial = 4;             // iterations of a trial: the first stretches what turns, the next undo most of it

void missBalance(double scale, bool is_out_of_iterations, SolveReport& report) {
  report.converged = false;
  report.unbalanced = std::max(report.unbalanced, report.residual / scale);
  report.is_out_of_iterations = report.is_out_of_iterations || is_out_of_iterations;
}

// If the held points move as one rigid body from before to after (n x 3, m), the free ones move with it, and true is returned.
bool moveRigidly(const System& system, const Points& before, Points& after) {
  Index count = 0;
  for (Index i = 0; i < system.size(); ++i) count += system.isHeld(i);
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Index i = 0, k = 0; i < system.size(); ++i) {
    if (!system.isHeld(i)) continue;
    from.col(k) = before[i];
    to.col(k++) = after[i];
  }
  const double motion = (to - from).colwise().norm().maxCoeff();
  const auto isFit = [&](const Eigen::Isometry3d& rigid) {
    return (rigid * from - to).colwise().norm().maxCoeff() <= kRigid * motion;
  };
  Eigen::Isometry3d rigid(Eigen::Translation3d((to - from).rowwise().mean()));
  if (!isFit(rigid)) {
    // The turn of points in a row about it is not known.
    const Eigen::Matrix3Xd centered = from.colwise() - from.rowwise().mean();
    const Vec3 spread = Eigen::SelfAdjointEigenSolver<Mat3>(centered * centered.transpose()).eigenvalues();
    if (!(spread[1] > kRow * spread[2])) return false;
    rigid.matrix() = Eigen::umeyama(from, to, false);
    if (!isFit(rigid)) return false;
  }
  for (Index i = 0; i < system.size(); ++i)
    if (!system.isHeld(i)) after[i] = rigid * before[i];
  return true;
}

bool allFinite(const Points& points) {
  double sum = 0.0;
  for (const Vec3& p : points) sum += p.cwiseAbs().sum();
  return std::isfinite(sum);
}

constexpr int kStuck = 3;           // iterations in a row that were shortened and brought nothing
constexpr double kTooMuch = 1e-6;   // of the kinetic energy: far above rounding
constexpr double kRounding = 1e-9;  // of the energies of a step: far above rounding

// The energy that a step may gain: what loads put in, and what the tolerance of its balance lets pass. What loads without a
// potential do relative to the tools that drive them only takes energy, but for springs of friction: it counts where it gives
// some.
class EnergyBudget {
 public:
  /// time: s, for which a stage counts; step: s, its length.
  void add(double time, double step, const System::DrivingPower& power, const ImplicitStage& stage, const State& state) {
    driven_ += time * (power.of_potentials + power.of_others);
    relative_ += time / step * stage.remainderWork(state) - time * power.of_others;
    unbalanced_ += time / step * stage.unbalancedWork(state);
  }
  double most() const { return driven_ + std::max(0.0, relative_) + std::max(0.0, unbalanced_); }  // J

 private:
  double driven_ = 0.0, relative_ = 0.0, unbalanced_ = 0.0;
};

bool isAnyHeld(const System& system) {
  for (Index i = 0; i < system.size(); ++i)
    if (system.isHeld(i)) return true;
  return false;
}

// Removes energy, J, from the motion of free points relative to their mean. A free body keeps its momentum; a held one has none
// to keep. Held points keep their velocities. Returns false if a free body's momentum has more.
bool takeFromAll(const System& system, double energy, bool is_any_held, State& state) {
  const double kinetic = system.kineticEnergy(state), limit = kinetic - energy;
  Vec3 mean = Vec3::Zero();
  double mass = 0.0, kept = 0.0;
  for (Index i = 0; i < state.size(); ++i) {
    const double m = system.masses()[i];
    if (system.isHeld(i)) kept += 0.5 * m * state.velocities[i].squaredNorm();
    mean += m * state.velocities[i];
    mass += m;
  }
  mean = is_any_held ? Vec3::Zero() : Vec3(mean / mass);
  if (!is_any_held) kept = 0.5 * mass * mean.squaredNorm();
  const double scale = std::sqrt(std::max(0.0, limit - kept) / std::max(kinetic - kept, std::numeric_limits<double>::min()));
  for (Index i = 0; i < state.size(); ++i)
    if (!system.isHeld(i)) state.velocities[i] = mean + std::min(1.0, scale) * (state.velocities[i] - mean);
  return is_any_held || kept <= limit + kTooMuch * kinetic;
}

}  // namespace

void ImplicitStage::solve(const System& system, double time, double step, const Points& from, const Points& velocity,
                          double energy, State& state, SolveReport& report) {
  const Index n = state.size();
  from_ = from;
  // Damping by mass adds c m (x - from) / h to the balance: a heavier weight about a target nearer to `from`.
  target_.resize(n);
  weight_.resize(n);
  const double factor = 1.0 + system.damping() * step;
  for (Index i = 0; i < n; ++i) {
    target_[i] = from[i] + (system.isHeld(i) ? step : step / factor) * velocity[i];
    weight_[i] = factor * system.masses()[i] / (step * step);
  }
  newton_.begin(interrupt_);
  // The size of the forces to balance: material, loads and inertia.
  double scale = system.largestForce(time, state);
  for (Index i = 0; i < n; ++i) scale = std::max(scale, weight_[i] * (target_[i] - from[i]).norm());
  system.computeRounding(time, state, rounding_);
  const double enough = enough_ = params_.tolerance * scale, untouched = std::min(params_.tolerance, kUntouched) * scale;
  NewtonDescent::Problem problem{system, time, step, from_, target_, weight_, rounding_, enough};
  // The start of the search.
  guess_ = state.positions;
  for (Index i = 0; i < n; ++i)
    if (system.isHeld(i)) guess_[i] = target_[i];
  begin_ = state.positions;
  state.positions = target_;
  if (const MotionLimit* const limit = system.motionLimit()) {
    limit->limit(begin_, guess_, false);
    stopped_.begin(system);
    stopped_.addStopped(*limit, limit->limit(begin_, state.positions, false));
    // Parts that nothing stops move on.
    if (newton_.potential(problem, state) > energy && stopped_.areAnyFree(system)) {
      for (Index i = 0; i < n; ++i)
        if (stopped_.contains(system, i)) state.positions[i] = guess_[i];
      limit->limit(begin_, state.positions, false);
    }
  }
  if (newton_.potential(problem, state) > energy) state.positions = guess_;

  const Index first = report.iterations, last = first + params_.max_iterations;
  double dropped = 0.0;  // J
  for (int stuck = 0;;) {
    const Timer timer;
    report.residual = newton_.evaluate(problem, state);
    report.time_forces += timer.seconds();
    report.passes += newton_.takePasses();
    const bool is_enough = report.residual <= enough, is_untouched = report.iterations == first;
    if (is_enough && (!is_untouched || report.residual <= untouched)) break;
    report.is_given_up = report.passes > most_passes_;
    if (report.is_given_up) break;
    problem.enough = is_enough ? untouched : enough;  // of a direction that is not needed for more than its motion
    // What contact stops and cannot move on, it bears, once all else is in balance.
    const bool is_over =
        report.iterations == last || newton_.isInterrupted() || (stuck >= kStuck && newton_.residualOfOthers(problem) <= enough);
    NewtonDescent::Step taken{};
    if (!is_over) taken = newton_.descend(problem, state);
    if (taken.fraction == 0.0) {
      if (!is_enough) missBalance(scale, report.iterations == last, report);
      break;
    }
    ++report.iterations;
    dropped += taken.drop;
    stuck = taken.is_shortened && taken.drop <= params_.tolerance * dropped ? stuck + 1 : 0;
  }
  report.passes += newton_.takePasses();
  for (Index i = 0; i < n; ++i)
    state.velocities[i] = system.isHeld(i) ? velocity[i] : ((state.positions[i] - from_[i]) / step).eval();
}

bool EnergyLimit::apply(const System& system, double time, double step, double limit, bool is_forced, const State& before,
                        State& state) {
  double energy = system.kineticEnergy(state) - limit;
  if (!(energy > 0.0)) return true;
  const bool is_any_held = isAnyHeld(system);
  bearing_.begin(system);
  bearing_.addChanged(system, time, step, before, state);
  if (bearing_.areAnyFree(system)) energy -= bearing_.take(system, energy, state);
  if (energy > 0.0 && is_any_held) energy -= bearing_.take(system, energy, state, false);
  if (!(energy > 0.0) || !is_forced) return !(energy > 0.0);
  return takeFromAll(system, energy, is_any_held, state);
}

SolveReport ImplicitStage::takeEulerStep(const System& system, double time, double step, const State& before, State& state) {
  SolveReport report;
  report.substeps = 1;
  const double kinetic = system.kineticEnergy(state), begin = system.potentialEnergy(time, state) + kinetic;
  const double energy = system.potentialEnergy(time + step, state) + kinetic;
  solve(system, time + step, step, before.positions, before.velocities, energy, state, report);
  if (report.is_given_up) return report;
  report.carrying_work = system.workAgainst(time + step, state, before.positions, state.positions);
  EnergyBudget budget;
  budget.add(step, step, system.drivingPower(time + step, step, state), *this, state);
  const double potential = system.potentialEnergy(time + step, state);
  const double allowed =
      begin + budget.most() + *report.carrying_work + kRounding * (std::abs(begin) + std::abs(potential) + kinetic);
  energy_limit_.apply(system, time, step, allowed - potential, true, before, state);
  system.remember(time + step, step, state);
  report.finite = allFinite(state.positions);
  return report;
}

SolveReport ImplicitSecondOrder::advance(const System& system, double time, double step, double, State& state) {
  // gamma and the rows of the tableau: (gamma, 0), (1 - gamma, gamma); the last row is the end of the step.
  static const double gamma = 1.0 - std::sqrt(0.5);
  const double part = gamma * step, rest = step - part;
  SolveReport report;
  report.substeps = 1;
  before_ = state;
  stage_.setInterrupt(interrupt_);
  stage_.setMostPasses(most_passes_);
  const double kinetic = system.kineticEnergy(state), begin = system.potentialEnergy(time, state) + kinetic;
  const double energy = system.potentialEnergy(time + step, state) + kinetic;
  const Index n = state.size();

  stage_.solve(system, time + part, part, before_.positions, before_.velocities, energy, state, report);
  if (report.is_given_up) return report;
  EnergyBudget budget;
  budget.add(rest, part, system.drivingPower(time + part, part, state), stage_, state);
  // The start of the second stage: the first one's velocity and acceleration over the rest of the step.
  from_ = before_.positions;
  velocity_ = before_.velocities;
  for (Index i = 0; i < n; ++i) {
    from_[i] += rest * state.velocities[i];
    if (system.isHeld(i)) continue;
    velocity_[i] += rest / part * (state.velocities[i] - before_.velocities[i]);
  }
  // The work of what moves held points, by the weights of the method.
  report.carrying_work = system.workAgainst(time + part, state, before_.positions, from_);
  stage_.solve(system, time + step, part, from_, velocity_, energy, state, report);
  if (report.is_given_up) return report;
  budget.add(part, part, system.drivingPower(time + step, part, state), stage_, state);
  *report.carrying_work += system.workAgainst(time + step, state, from_, state.positions);
  const double potential = system.potentialEnergy(time + step, state);
  const double allowed =
      begin + budget.most() + *report.carrying_work + kRounding * (std::abs(begin) + std::abs(potential) + kinetic);
  report.finite = allFinite(state.positions);
  if (report.finite && potential <= allowed &&
      energy_limit_.apply(system, time, step, allowed - potential, false, before_, state)) {
    system.remember(time + step, step, state);
    return report;
  }
  state = before_;
  const Index iterations = report.iterations;
  const double passes = report.passes;
  stage_.setMostPasses(most_passes_ - passes);
  report = stage_.takeEulerStep(system, time, step, before_, state);
  report.iterations += iterations;
  report.passes += passes;
  report.fallbacks = report.substeps;
  return report;
}

SolveReport StaticSolver::advance(const System& system, double time, double step, double, State& state) {
  SolveReport report;
  report.substeps = 1;
  const Index n = state.size();
  carried_.assign(n, Vec3::Zero());
  for (Index i = 0; i < n; ++i)
    if (system.isHeld(i)) carried_[i] = state.velocities[i];
  std::fill(state.velocities.begin(), state.velocities.end(), Vec3::Zero());
  state.friction.clear();  // an equilibrium is one without friction
  state.self_friction.clear();
  const double end = time + step;
  begin_ = end_ = state.positions;
  for (Index i = 0; i < n; ++i) end_[i] += step * carried_[i];
  const auto countStrides = [&] { return system.findCarriedStrain(begin_, end_) / kStride; };
  double strides = countStrides();
  if (strides > 1.0) report.carrying_work = -system.potentialEnergy(end, state);
  if (strides > 1.0 && moveRigidly(system, begin_, end_)) {
    state.positions = end_;
    strides = 1.0;
  }
  const Index parts = static_cast<Index>(std::ceil(std::clamp(strides, 1.0, kMostParts)));
  for (Index part = 1; part <= parts && !isInterrupted(); ++part) {
    anchor_ = state.positions;
    for (Index i = 0; i < n; ++i)
      if (system.isHeld(i)) state.positions[i] = begin_[i] + step * (static_cast<double>(part) / parts) * carried_[i];
    if (system.motionLimit()) system.motionLimit()->limit(anchor_, state.positions, false);
    if (report.carrying_work) *report.carrying_work += system.potentialEnergy(end, state);
    if (part == parts) break;
    search(system, end, step, std::max(kRough, params_.tolerance), std::min(kRoughIterations, params_.max_iterations), state,
           report);
    *report.carrying_work -= system.potentialEnergy(end, state);
  }
  const Result result = search(system, end, step, params_.tolerance, params_.max_iterations, state, report);
  if (!result.converged) missBalance(result.scale, result.is_out_of_iterations, report);
  state.velocities = carried_;
  report.finite = allFinite(state.positions);
  return report;
}

StaticSolver::Result StaticSolver::search(const System& system, double time, double step, double tolerance, Index most,
                                          State& state, SolveReport& report) {
  const Index n = state.size();
  system.computeRounding(time, state, rounding_);
  report.is_quasi_newton = quasi_newton_.solve(system, time, tolerance, rounding_, interrupt_, state, report);
  if (report.is_quasi_newton) return {true, false, 0.0};
  weight_.resize(n);
  double pseudo_step = kFirstStep * step;
  double scale = 0.0, safe_energy = 0.0;
  Index iterations = 0;
  Index trial = 0;       // iterations since safe_, as long as none has come below its energy
  bool careful = false;  // the last trial led nowhere
  newton_.begin(interrupt_);
  bool converged = false;
  while (!newton_.isInterrupted()) {
    // The residual without the proximal term: the anchor is the present state.
    anchor_ = state.positions;
    if (trial == 0) {
      safe_ = state.positions;
      safe_energy = system.potentialEnergy(time, state);
    }
    for (Index i = 0; i < n; ++i) weight_[i] = system.masses()[i] / (pseudo_step * pseudo_step);
    const NewtonDescent::Problem problem{system, time, 0.0, safe_, anchor_, weight_, rounding_, tolerance * scale};
    const Timer timer;
    report.residual = newton_.evaluate(problem, state);
    report.time_forces += timer.seconds();
    if (trial == 0) {
      scale = std::max(scale, system.largestForce(time, state));
      if (report.residual <= tolerance * scale) {
        converged = true;
        break;
      }
      if (iterations == most || pseudo_step < kShortestStep * step) break;
    }
    if (iterations == most) {  // the trial comes to no end
      state.positions = safe_;
      trial = 0;
      continue;
    }
    const NewtonDescent::Step taken = newton_.descend(problem, state, trial == 0 && !careful);
    ++iterations;
    ++report.iterations;
    if (trial == 0 && !taken.raised) {
      pseudo_step *= taken.fraction == 1.0 ? kGrowth : kShrink;
      careful = false;
    } else if (system.potentialEnergy(time, state) - newton_.remainderWork(safe_, state) < safe_energy) {
      pseudo_step *= kGrowth;
      trial = 0;
    } else if (++trial > kTrial || taken.fraction == 0.0) {
      state.positions = safe_;
      trial = 0;
      careful = true;
    }
    pseudo_step = std::min(pseudo_step, kLongestStep * step);
  }
  return {converged, iterations == most, scale};
}

}  // namespace deformable_surface::solve
