#include "oriented_integrators.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "oriented_motion.h"

namespace deformable_surface::solve {
namespace {

constexpr Index kBlock = 256;  // points per task: some microseconds of work

bool allFinite(const State& state) {
  // A sum is finite only if every term is, up to overflow. Such a state is not sound either.
  double sum = 0.0;
  for (Index i = 0; i < state.size(); ++i)
    sum += state.positions[i].cwiseAbs().sum() + state.velocities[i].cwiseAbs().sum() + state.spins[i].cwiseAbs().sum() +
           state.orientations[i].coeffs().cwiseAbs().sum();
  return std::isfinite(sum);
}

void drift(const System& system, double dt, State& state) {
  for (Index i = 0; i < state.size(); ++i) state.positions[i] += dt * state.velocities[i];  // held ones have none
  turnPoints(0, state.size(), dt, state.spins, system.heldTurns(), state.orientations);
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

template <class Array>
bool isSame(const Array& a, const Array& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
}

}  // namespace

bool OrientedVerlet::isAtLastEnd(const System& system, const State& state) const {
  return !system.internalForcesReadVelocities() && isSame(last_positions_, state.positions) &&
         isSame(last_orientations_, state.orientations);
}

bool OrientedVerlet::takeLastForces(const System& system, const State& state, Points& forces) const {
  if (!isAtLastEnd(system, state)) return false;
  forces = elastic_forces_;
  return true;
}

void OrientedVerlet::evaluate(const System& system, double time, const State& state, When when, SolveReport& report) {
  const Timer timer;
  if (when == When::kBegin && isAtLastEnd(system, state)) {
    forces_ = elastic_forces_;
    torques_ = elastic_torques_;
  } else {
    system.computeElasticForcesAndTorques(state, forces_, torques_);
  }
  SolveReport reached;
  if (when != When::kBegin) reached.breakStretched(system, state);
  if (when == When::kEnd) {
    elastic_forces_ = forces_;
    elastic_torques_ = torques_;
    last_positions_ = state.positions;
    last_orientations_ = state.orientations;
  }
  if (reached.has_broken) {
    // Forces until here and from here on: what breaks between the halves of a kick makes no energy.
    Points forces, torques;
    system.computeElasticForcesAndTorques(state, forces, torques);
    if (when == When::kEnd) {
      elastic_forces_ = forces;
      elastic_torques_ = torques;
    } else {
      for (Index i = 0; i < state.size(); ++i) {
        forces_[i] = 0.5 * (forces_[i] + forces[i]);
        torques_[i] = 0.5 * (torques_[i] + torques[i]);
      }
    }
    report.has_broken = true;
    report.released += reached.released;
  }
  *report.carrying_work += addLoads(system, time, state, carried_, forces_);
  system.holdTurns(torques_);
  report.time_forces += timer.seconds();
}

// Held points keep their velocities.
void OrientedVerlet::prepare(const System& system, double half) {
  const Index n = system.size();
  const double decay = std::exp(-system.damping() * half), spin_decay = std::exp(-system.rotationalDamping() * half);
  decay_.resize(3 * n);
  kick_.resize(3 * n);
  spin_decay_.assign(3 * n, spin_decay);
  spin_kick_.resize(3 * n);
  for (Index k = 0; k < 3 * n; ++k) {
    const bool is_held = system.isHeld(k / 3);
    decay_[k] = is_held ? 1.0 : decay;
    kick_[k] = is_held ? 0.0 : half / system.masses()[k / 3];
    spin_kick_[k] = half / system.inertias()[k / 3];
  }
  predicted_.resize(n);
}

SolveReport OrientedVerlet::advance(const System& system, double time, double step, double max_substep, State& state) {
  SolveReport report;
  report.substeps = countSubsteps(step, max_substep);
  const double dt = step / report.substeps;
  const Index n = state.size();
  prepare(system, 0.5 * dt);
  findCarried(system, state, carried_);
  report.carrying_work = 0.0;
  evaluate(system, time, state, When::kBegin, report);
  const auto forEachBlock = [&](const auto& kick, bool drifts) {
    parallelFor(n, kBlock, [&](Index begin, Index end) {
      const Index at = 3 * begin, size = 3 * (end - begin);
      const HalfKicks half{&decay_[at], &kick_[at]}, spin_half{&spin_decay_[at], &spin_kick_[at]};
      const double *const force = forces_[begin].data(), *const torque = torques_[begin].data();
      double *const velocity = state.velocities[begin].data(), *const spin = state.spins[begin].data();
      kick(size, half, force, velocity);
      kick(size, spin_half, torque, spin);
      if (!drifts) return;
      // Loads that read velocities take those predicted with the acceleration at the beginning, which keeps the order.
      solve::drift(size, dt, half, force, velocity, state.positions[begin].data(), predicted_[begin].data());
      turnPoints(begin, end, dt, state.spins, system.heldTurns(), state.orientations);
    });
  };
  for (Index s = 0; s < report.substeps; ++s) {
    forEachBlock(s == 0 ? kickFirst : kickTwice, true);
    predicted_.swap(state.velocities);
    evaluate(system, time + (s + 1) * dt, state, s + 1 == report.substeps ? When::kEnd : When::kWithin, report);
    system.remember(time + (s + 1) * dt, dt, state);
    predicted_.swap(state.velocities);
  }
  forEachBlock(kickLast, false);
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
