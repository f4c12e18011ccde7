#include "explicit_integrators.h"

#include "deformable_surface/base/timer.h"

#include <cmath>

namespace deformable_surface::solve {
namespace {

// Of the stable step, which holds for small motions only: sheets that crumple gain energy with longer ones, as measured in
// docs/decisions/0001-explicit-first.md.
constexpr double kSafety = 0.5;

bool allFinite(const State& state) {
  // A sum is finite only if every term is, up to overflow, which is no sound state either.
  double sum = 0.0;
  for (Index i = 0; i < state.size(); ++i) sum += state.positions[i].cwiseAbs().sum() + state.velocities[i].cwiseAbs().sum();
  return std::isfinite(sum);
}

}  // namespace

Index countSubsteps(double step, double max_substep) {
  const double wanted = std::ceil(step / (kSafety * max_substep));
  if (!(wanted < 2e9)) return 2000000000;
  return wanted < 1.0 ? 1 : static_cast<Index>(wanted);
}

SolveReport ExplicitEuler::advance(const System& system, double time, double step, double, State& state) {
  SolveReport report;
  report.substeps = 1;
  const Timer timer;
  system.computeForces(time, state, forces_);
  report.time_forces = timer.seconds();
  for (Index i = 0; i < state.size(); ++i) {
    if (system.isHeld(i)) continue;
    const Vec3 acceleration = forces_[i] / system.masses()[i] - system.damping() * state.velocities[i];
    state.positions[i] += step * state.velocities[i];
    state.velocities[i] += step * acceleration;
  }
  report.finite = allFinite(state);
  return report;
}

SolveReport SymplecticEuler::advance(const System& system, double time, double step, double max_substep, State& state) {
  SolveReport report;
  report.substeps = countSubsteps(step, max_substep);
  const double dt = step / report.substeps;
  const double decay = std::exp(-system.damping() * dt);
  for (Index s = 0; s < report.substeps; ++s) {
    const Timer timer;
    system.computeForces(time + s * dt, state, forces_);
    report.time_forces += timer.seconds();
    for (Index i = 0; i < state.size(); ++i) {
      if (system.isHeld(i)) continue;
      state.velocities[i] = decay * (state.velocities[i] + dt / system.masses()[i] * forces_[i]);
      state.positions[i] += dt * state.velocities[i];
    }
  }
  report.finite = allFinite(state);
  return report;
}

SolveReport VelocityVerlet::advance(const System& system, double time, double step, double max_substep, State& state) {
  SolveReport report;
  report.substeps = countSubsteps(step, max_substep);
  const double dt = step / report.substeps;
  const double half_decay = std::exp(-0.5 * system.damping() * dt);
  const auto evaluate = [&](double at, const State& where) {
    const Timer timer;
    system.computeForces(at, where, forces_);
    report.time_forces += timer.seconds();
  };
  evaluate(time, state);
  predicted_.velocities.resize(state.size());
  for (Index s = 0; s < report.substeps; ++s) {
    // Half kick and drift. The velocity at the end is predicted with the acceleration of the beginning.
    for (Index i = 0; i < state.size(); ++i) {
      if (system.isHeld(i)) {
        predicted_.velocities[i] = state.velocities[i];
        continue;
      }
      const Vec3 half_kick = 0.5 * dt / system.masses()[i] * forces_[i];
      state.velocities[i] = half_decay * state.velocities[i] + half_kick;
      state.positions[i] += dt * state.velocities[i];
      predicted_.velocities[i] = half_decay * (state.velocities[i] + half_kick);
    }
    // Forces at the new place, and the second half kick.
    predicted_.positions.swap(state.positions);
    evaluate(time + (s + 1) * dt, predicted_);
    predicted_.positions.swap(state.positions);
    for (Index i = 0; i < state.size(); ++i) {
      if (system.isHeld(i)) continue;
      state.velocities[i] = half_decay * (state.velocities[i] + 0.5 * dt / system.masses()[i] * forces_[i]);
    }
  }
  report.finite = allFinite(state);
  return report;
}

}  // namespace deformable_surface::solve
