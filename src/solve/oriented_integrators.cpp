#include "oriented_integrators.h"

#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::solve {
namespace {

bool allFinite(const State& state) {
  // A sum is finite only if every term is, up to overflow. Such a state is not sound either.
  double sum = 0.0;
  for (Index i = 0; i < state.size(); ++i)
    sum += state.positions[i].cwiseAbs().sum() + state.velocities[i].cwiseAbs().sum() + state.spins[i].cwiseAbs().sum() +
           state.orientations[i].coeffs().cwiseAbs().sum();
  return std::isfinite(sum);
}

// The orientation after turning by an angle vector (rad, world).
Quaternion turn(const Vec3& angle, const Quaternion& orientation) {
  constexpr double kSmall = 1e-4;  // below it the series of sin(x / 2) / x is exact to rounding with two terms
  const double squared = angle.squaredNorm(), length = std::sqrt(squared);
  const double s = length > kSmall ? std::sin(0.5 * length) / length : 0.5 - squared / 48.0;
  const Quaternion by(std::cos(0.5 * length), s * angle.x(), s * angle.y(), s * angle.z());
  return (by * orientation).normalized();
}

void drift(const System& system, double dt, State& state) {
  for (Index i = 0; i < state.size(); ++i) {
    state.positions[i] += dt * state.velocities[i];  // held ones have the velocity that they are to keep
    if (!system.isTurnHeld(i)) state.orientations[i] = turn(dt * state.spins[i], state.orientations[i]);
  }
}

// Moves held points with their velocities over a step and stops everything. velocities: of the held points, else zero.
void moveHeld(const System& system, double step, State& state, Points& velocities) {
  velocities.assign(state.positions.size(), Vec3::Zero());
  for (Index i = 0; i < state.size(); ++i) {
    if (!system.isHeld(i)) continue;
    velocities[i] = state.velocities[i];
    state.positions[i] += step * velocities[i];
  }
  state.velocities.assign(state.positions.size(), Vec3::Zero());
}

}  // namespace

void OrientedVerlet::evaluate(const System& system, double time, const State& state, SolveReport& report) {
  const Timer timer;
  system.computeForcesAndTorques(time, state, forces_, torques_);
  report.time_forces += timer.seconds();
}

SolveReport OrientedVerlet::advance(const System& system, double time, double step, double max_substep, State& state) {
  SolveReport report;
  report.substeps = countSubsteps(step, max_substep);
  const double dt = step / report.substeps, half = 0.5 * dt;
  const double decay = std::exp(-system.damping() * half), spin_decay = std::exp(-system.rotationalDamping() * half);
  const Index n = state.size();
  const std::vector<double>&masses = system.masses(), &inertias = system.inertias();
  evaluate(system, time, state, report);
  predicted_ = state;
  for (Index s = 0; s < report.substeps; ++s) {
    for (Index i = 0; i < n; ++i) {
      state.spins[i] = spin_decay * state.spins[i] + half / inertias[i] * torques_[i];
      if (system.isHeld(i)) continue;
      const Vec3 kick = half / masses[i] * forces_[i];
      state.velocities[i] = decay * state.velocities[i] + kick;
      // Loads that read velocities take those predicted with the acceleration at the beginning, which keeps the order.
      predicted_.velocities[i] = decay * (state.velocities[i] + kick);
    }
    drift(system, dt, state);
    predicted_.velocities.swap(state.velocities);
    evaluate(system, time + (s + 1) * dt, state, report);
    predicted_.velocities.swap(state.velocities);
    for (Index i = 0; i < n; ++i) {
      if (!system.isHeld(i)) state.velocities[i] = decay * (state.velocities[i] + half / masses[i] * forces_[i]);
      state.spins[i] = spin_decay * (state.spins[i] + half / inertias[i] * torques_[i]);
    }
    system.remember(time + (s + 1) * dt, dt, state);
  }
  report.finite = allFinite(state);
  return report;
}

SolveReport FireRelaxation::advance(const System& system, double time, double step, double max_substep, State& state) {
  // The constants of [Guenole 2020], table 1.
  constexpr double kMixing = 0.25, kMixingFalls = 0.99, kGrowth = 1.1, kShrink = 0.5;
  constexpr int kDelay = 20;
  constexpr double kLargest = 0.4, kFirst = 0.04;  // of the stable step
  constexpr Index kStepsPerIteration = 100;        // relaxation steps that count as one iteration: they are that much cheaper
  constexpr double kRounding = 64.0;               // times the force that rounding of the positions makes
  constexpr Index kLook = 50;                      // steps between two estimates of that force, which cost as much as a step

  SolveReport report;
  report.substeps = 1;
  const double end = time + step;
  const Index n = state.size();
  const std::vector<double>&masses = system.masses(), &inertias = system.inertias();
  moveHeld(system, step, state, carried_);
  state.spins.assign(n, Vec3::Zero());
  state.friction.clear();  // an equilibrium is one without friction
  state.self_friction.clear();
  double dt = kFirst * max_substep, mixing = kMixing, largest = 0.0;
  int downhill = 0;
  const Index most = params_.max_iterations * kStepsPerIteration;
  report.converged = false;
  Index taken = 0;
  double rounding = 0.0;
  for (; taken < most && !(interrupt_ && *interrupt_); ++taken) {
    const Timer timer;
    system.computeForcesAndTorques(end, state, forces_, torques_);
    report.time_forces += timer.seconds();
    double power = 0.0, speed = 0.0, push = 0.0, residual = 0.0;
    for (Index i = 0; i < n; ++i) {
      power += forces_[i].dot(state.velocities[i]) + torques_[i].dot(state.spins[i]);
      speed += masses[i] * state.velocities[i].squaredNorm() + inertias[i] * state.spins[i].squaredNorm();
      push += forces_[i].squaredNorm() / masses[i] + torques_[i].squaredNorm() / inertias[i];
      residual = std::max({residual, forces_[i].squaredNorm(), torques_[i].squaredNorm() * masses[i] / inertias[i]});
    }
    report.residual = std::sqrt(residual);
    report.finite = std::isfinite(push) && std::isfinite(speed);
    largest = std::max(largest, report.residual);
    if (!report.finite) break;
    const auto findRounding = [&] { return kRounding * system.roundingForce(end, state); };
    if (taken % kLook == 0) rounding = findRounding();
    const bool is_round = report.residual <= rounding && report.residual <= (rounding = findRounding());
    if (report.residual <= params_.tolerance * largest || is_round) {
      report.converged = true;
      break;
    }
    if (power > 0.0) {
      if (++downhill > kDelay) {
        dt = std::min(kGrowth * dt, kLargest * max_substep);
        mixing *= kMixingFalls;
      }
    } else {
      downhill = 0;
      if (taken > kDelay) dt = std::max(kShrink * dt, kFirst * kFirst * max_substep);
      mixing = kMixing;
      // Half a step back, as the last one led uphill.
      drift(system, -0.5 * dt, state);
      state.velocities.assign(n, Vec3::Zero());
      state.spins.assign(n, Vec3::Zero());
      speed = 0.0;
    }
    const double towards = push > 0.0 ? mixing * std::sqrt(speed / push) : 0.0;
    for (Index i = 0; i < n; ++i) {
      state.velocities[i] = (1.0 - mixing) * state.velocities[i] + (towards + dt) / masses[i] * forces_[i];
      state.spins[i] = (1.0 - mixing) * state.spins[i] + (towards + dt) / inertias[i] * torques_[i];
    }
    drift(system, dt, state);
  }
  report.iterations = (taken + kStepsPerIteration - 1) / kStepsPerIteration;
  report.unbalanced = report.converged ? 0.0 : report.residual / largest;
  report.is_out_of_iterations = taken == most;
  state.velocities = carried_;
  state.spins.assign(n, Vec3::Zero());
  report.finite = report.finite && allFinite(state);
  return report;
}

}  // namespace deformable_surface::solve
