#include "implicit_integrators.h"

#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::solve {
namespace {

constexpr double kGrowth = 10.0;       // of the pseudo time step after a full Newton step
constexpr double kShrink = 0.1;        // after a step that had to be cut or failed
constexpr double kFirstStep = 1.0;     // of the caller's step
constexpr double kLongestStep = 1e8;   // of the caller's step: the weight is then rounding beside any stiffness
constexpr double kShortestStep = 1e-6; // of the caller's step: shorter ones do not lead anywhere

bool allFinite(const Points& points) {
  double sum = 0.0;
  for (const Vec3& p : points) sum += p.cwiseAbs().sum();
  return std::isfinite(sum);
}

}  // namespace

SolveReport ImplicitEuler::advance(const System& system, double time, double step, double, State& state) {
  SolveReport report;
  report.substeps = 1;
  const Index n = state.size();
  // Damping by mass adds c m (x - x_n) / h to the balance: a heavier weight about a target nearer to x_n.
  before_ = state.positions;
  target_.resize(n);
  weight_.resize(n);
  const double factor = 1.0 + system.damping() * step;
  for (Index i = 0; i < n; ++i) {
    target_[i] = before_[i] + step / factor * state.velocities[i];
    weight_[i] = factor * system.masses()[i] / (step * step);
    if (!system.isHeld(i)) state.positions[i] = target_[i];
  }
  const NewtonDescent::Problem problem{system, time + step, step, before_, target_, weight_};
  // The forces to balance: what the material and the loads do, and the momentum brought along.
  double scale = system.largestForce(time, state);
  for (Index i = 0; i < n; ++i) scale = std::max(scale, weight_[i] * (target_[i] - before_[i]).norm());
  const double enough = std::max(params_.tolerance * scale, system.roundingForce(time, state));
  report.converged = false;
  for (;;) {
    const Timer timer;
    report.residual = newton_.evaluate(problem, state);
    report.time_forces += timer.seconds();
    if (report.residual <= enough) {
      report.converged = true;
      break;
    }
    if (report.iterations == params_.max_iterations || newton_.descend(problem, state) == 0.0) break;
    ++report.iterations;
  }
  for (Index i = 0; i < n; ++i)
    state.velocities[i] = system.isHeld(i) ? Vec3::Zero().eval() : ((state.positions[i] - before_[i]) / step).eval();
  report.finite = allFinite(state.positions);
  return report;
}

SolveReport StaticSolver::advance(const System& system, double time, double step, double, State& state) {
  SolveReport report;
  report.substeps = 1;
  const Index n = state.size();
  weight_.resize(n);
  anchor_ = state.positions;
  double pseudo_step = kFirstStep * step;
  const double rounding = system.roundingForce(time, state);
  double scale = 0.0;
  report.converged = false;
  for (;;) {
    // The residual without the proximal term: the anchor is where we are.
    anchor_ = state.positions;
    for (Index i = 0; i < n; ++i) weight_[i] = system.masses()[i] / (pseudo_step * pseudo_step);
    const NewtonDescent::Problem problem{system, time + step, 0.0, anchor_, anchor_, weight_};
    const Timer timer;
    report.residual = newton_.evaluate(problem, state);
    report.time_forces += timer.seconds();
    scale = std::max(scale, system.largestForce(time + step, state));
    if (report.residual <= std::max(params_.tolerance * scale, rounding)) {
      report.converged = true;
      break;
    }
    if (report.iterations == params_.max_iterations || pseudo_step < kShortestStep * step) break;
    const double fraction = newton_.descend(problem, state);
    ++report.iterations;
    pseudo_step *= fraction == 1.0 ? kGrowth : kShrink;
    pseudo_step = std::min(pseudo_step, kLongestStep * step);
  }
  state.velocities.assign(n, Vec3::Zero());
  report.finite = allFinite(state.positions);
  return report;
}

}  // namespace deformable_surface::solve
