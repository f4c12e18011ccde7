#include "explicit_integrators.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/simd.h"
#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace deformable_surface::solve {
namespace {

// Of the stable step, which holds for small motions only: with longer steps crumpling sheets gain energy, as measured in
// docs/decisions/0001-explicit-first.md.
constexpr double kSafety = 0.5;
constexpr double kMostSubsteps = 2e9;  // fits into an Index
constexpr Index kBlock = 3072;         // coordinates per task: some microseconds of work
constexpr double kJammed = 0.05;       // share of the points that are stopped: more in a jam, fewer where a towel is folded
constexpr Index kPoints = 1024;        // points per task: the same coordinates
constexpr double kSlowCost = 3.0;      // of a pass over the slow forces, in passes over the others: curvature beside triangles

bool allFinite(const State& state) {
  // A sum is finite only if every term is, up to overflow. Such a state is not sound either.
  return std::isfinite(parallelSum(state.size(), kPoints, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index i = begin; i < end; ++i) sum += state.positions[i].cwiseAbs().sum() + state.velocities[i].cwiseAbs().sum();
    return sum;
  }));
}

// Points that are stopped short keep the velocity of their remaining motion: a plastic impact. Held points keep theirs.
void stopShort(const MotionLimit& limit, const System& system, const Points& before, double dt, bool is_first, State& state) {
  for (const Index i : limit.limit(before, state.positions, !is_first))
    if (!system.isHeld(i)) state.velocities[i] = (state.positions[i] - before[i]) / dt;
}

}  // namespace

Index countSubsteps(double step, double max_substep) {
  const double wanted = std::ceil(step / (kSafety * max_substep));
  if (!(wanted < kMostSubsteps)) return static_cast<Index>(kMostSubsteps);
  return wanted < 1.0 ? 1 : static_cast<Index>(wanted);
}

double countPasses(const Substeps& cut) { return cut.outer * (cut.inner + kSlowCost) / (1.0 + kSlowCost); }

Substeps chooseSubsteps(double step, double max_substep, double max_slow_step, Index most_inner) {
  const Index needed = countSubsteps(step, max_substep);
  Substeps best{needed, 1};
  for (Index inner = 2; inner <= std::min(most_inner, needed); ++inner) {
    const Substeps cut{(needed - 1) / inner + 1, inner};
    if (cut.outer >= countSubsteps(step, max_slow_step) && countPasses(cut) < countPasses(best)) best = cut;
  }
  return best;
}

SolveReport ExplicitEuler::advance(const System& system, double time, double step, double, State& state) {
  SolveReport report;
  report.substeps = 1;
  const Timer timer;
  system.computeForces(time, state, forces_);
  report.time_forces = timer.seconds();
  before_ = state.positions;
  for (Index i = 0; i < state.size(); ++i) {
    if (system.isHeld(i)) {
      state.positions[i] += step * state.velocities[i];
      continue;
    }
    const Vec3 acceleration = forces_[i] / system.masses()[i] - system.damping() * state.velocities[i];
    state.positions[i] += step * state.velocities[i];
    state.velocities[i] += step * acceleration;
  }
  if (system.motionLimit()) stopShort(*system.motionLimit(), system, before_, step, true, state);
  system.remember(time + step, step, state);
  report.finite = allFinite(state);
  return report;
}

SolveReport SymplecticEuler::advance(const System& system, double time, double step, double max_substep, State& state) {
  SolveReport report;
  report.substeps = countSubsteps(step, max_substep);
  const double dt = step / report.substeps;
  const double decay = std::exp(-system.damping() * dt);
  if (system.breaking()) report.carrying_work = 0.0;
  for (Index s = 0; s < report.substeps; ++s) {
    if (system.breaking()) begin_ = state;
    const Timer timer;
    system.computeForces(time + s * dt, state, forces_);
    report.time_forces += timer.seconds();
    before_ = state.positions;
    for (Index i = 0; i < state.size(); ++i) {
      if (system.isHeld(i)) {
        state.positions[i] += dt * state.velocities[i];
        continue;
      }
      state.velocities[i] = decay * (state.velocities[i] + dt / system.masses()[i] * forces_[i]);
      state.positions[i] += dt * state.velocities[i];
    }
    if (system.motionLimit()) stopShort(*system.motionLimit(), system, before_, dt, s == 0, state);
    // What pulls on moving pins may be gone at the end of the step.
    if (system.breaking()) *report.carrying_work += system.carryingWork(time + s * dt, time + (s + 1) * dt, begin_, state);
    report.breakStretched(system, state);
    system.remember(time + (s + 1) * dt, dt, state);
  }
  report.finite = allFinite(state);
  return report;
}

namespace {

// Whether no free point has moved, and there is one.
bool doAllStay(const System& system, const Points& before, const Points& after) {
  bool is_any_free = false;
  for (Index i = 0; i < static_cast<Index>(before.size()); ++i) {
    if (system.isHeld(i)) continue;
    if (after[i] != before[i]) return false;
    is_any_free = true;
  }
  return is_any_free;
}

// One number per coordinate: the loops below run over plain arrays. kick: 0 for points that do not drift. from: may be position.
// force: at the beginning; next: its estimate at the end, for the velocity predicted there.
DEFORMABLE_SURFACE_WIDE void kickAndDrift(Index size, double decay, double dt, const double* kick, const double* force,
                                          const double* next, const double* from, double* velocity, double* predicted,
                                          double* position) {
#pragma GCC ivdep
  for (Index k = 0; k < size; ++k) {
    velocity[k] = decay * velocity[k] + kick[k] * force[k];
    position[k] = from[k] + (kick[k] != 0.0 ? dt : 0.0) * velocity[k];
    predicted[k] = decay * (velocity[k] + kick[k] * next[k]);
  }
}

// The end of one sub-step and the beginning of the next.
DEFORMABLE_SURFACE_WIDE void kickTwiceAndDrift(Index size, double decay, double dt, const double* kick, const double* force,
                                               const double* next, const double* from, double* velocity, double* predicted,
                                               double* position) {
#pragma GCC ivdep
  for (Index k = 0; k < size; ++k) {
    const double half_kick = kick[k] * force[k];
    velocity[k] = decay * (decay * (velocity[k] + half_kick)) + half_kick;
    position[k] = from[k] + (kick[k] != 0.0 ? dt : 0.0) * velocity[k];
    predicted[k] = decay * (velocity[k] + kick[k] * next[k]);
  }
}

DEFORMABLE_SURFACE_WIDE void kick(Index size, double decay, const double* kick, const double* force, double* velocity) {
#pragma GCC ivdep
  for (Index k = 0; k < size; ++k) velocity[k] = decay * (velocity[k] + kick[k] * force[k]);
}

// Four sums side by side. kick: scaled by the share.
DEFORMABLE_SURFACE_WIDE double sumSquares(Index size, const double* mass, double share, const double* kick, const double* force,
                                          const double* velocity) {
  Double4 sum{};
  Index k = 0;
  for (; k + 4 <= size; k += 4) {
    Double4 m, kicks, f, v;
    load(mass + k, m);
    load(kick + k, kicks);
    load(force + k, f);
    load(velocity + k, v);
    v += share * kicks * f;
    sum += m * v * v;
  }
  double rest = 0.0;
  for (; k < size; ++k) {
    const double v = velocity[k] + share * kick[k] * force[k];
    rest += mass[k] * v * v;
  }
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + rest;
}

// The kinetic energy, J, after a share of a half kick.
double kineticEnergy(const std::vector<double>& mass, double share, const std::vector<double>& kick, const Points& forces,
                     const Points& velocities) {
  const double *force = forces.data()->data(), *velocity = velocities.data()->data();
  return 0.5 * parallelSum(static_cast<Index>(mass.size()), kBlock, [&](Index begin, Index end) {
           return sumSquares(end - begin, &mass[begin], share, &kick[begin], force + begin, velocity + begin);
         });
}

DEFORMABLE_SURFACE_WIDE void addScaled(Index size, const double* force, double scale, const double* slow, double* sum) {
#pragma GCC ivdep
  for (Index k = 0; k < size; ++k) sum[k] = force[k] + scale * slow[k];
}

DEFORMABLE_SURFACE_WIDE void predict(Index size, double decay, const double* kick, const double* force, double scale,
                                     const double* slow, const double* velocity, double* predicted) {
#pragma GCC ivdep
  for (Index k = 0; k < size; ++k) predicted[k] = decay * (velocity[k] + kick[k] * (force[k] + scale * slow[k]));
}

bool isSame(const Points& a, const Points& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

}  // namespace

bool VelocityVerlet::takeLastForces(const System& system, const State& state, Points& forces) const {
  if (system.internalForcesReadVelocities() || !isSame(last_positions_, state.positions)) return false;
  forces = fast_forces_;
  for (std::size_t i = 0; system.hasSlowForces() && i < forces.size(); ++i) forces[i] += slow_forces_[i];
  return true;
}

// Kicks and masses of the coordinates, and the held points that are carried along: they keep their velocities, which the
// loops below damp.
void VelocityVerlet::prepare(const System& system, double dt, const State& state) {
  const Index n = state.size();
  const std::vector<double>& masses = system.masses();
  kick_.resize(3 * n);
  const bool is_damped = system.damping() > 0.0;
  mass_.resize(is_damped ? 3 * n : 0);
  parallelFor(n, kPoints, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const bool is_held = system.isHeld(i);
      std::fill_n(&kick_[3 * i], 3, is_held ? 0.0 : 0.5 * dt / masses[i]);
      if (is_damped) std::fill_n(&mass_[3 * i], 3, is_held ? 0.0 : masses[i]);
    }
  });
  findCarried(system, state, carried_);
  carrying_work_ = stopping_work_ = 0.0;
  if (system.motionLimit() && !system.motionLimit()->parts().empty()) bearing_.begin(system);
}

void VelocityVerlet::bearSlow(const Points& positions) {
  for (CarriedPoint& c : carried_) carrying_work_ += c.slow.moveTo(positions[c.point], slow_forces_[c.point]);
}

// The forces where an outer step begins or ends. The slow forces' kick is that of all its sub-steps.
void VelocityVerlet::addSlow(Index inner) {
  forces_with_slow_.resize(forces_.size());
  const double *const force = forces_.data()->data(), *const slow = slow_forces_.data()->data();
  double* const sum = forces_with_slow_.data()->data();
  parallelFor(3 * static_cast<Index>(forces_.size()), kBlock, [&](Index begin, Index end) {
    addScaled(end - begin, force + begin, static_cast<double>(inner), slow + begin, sum + begin);
  });
}

// The forces at the beginning of a step. The model's are those of the last end, if this is where it was.
void VelocityVerlet::beginForces(const System& system, double time, Index inner, const State& state) {
  const bool has_slow = system.hasSlowForces();
  if (system.internalForcesReadVelocities() || !isSame(last_positions_, state.positions)) {
    system.computeFastForces(state, fast_forces_);
    if (has_slow) system.computeSlowForces(state, slow_forces_);
  }
  forces_ = fast_forces_;
  carrying_work_ += addLoads(system, time, state, carried_, forces_);
  if (!has_slow) return;
  bearSlow(state.positions);
  addSlow(inner);
}

SolveReport VelocityVerlet::advance(const System& system, double time, double step, double max_substep, State& state) {
  const bool has_slow = system.hasSlowForces();
  const Substeps cut = chooseSubsteps(step, max_substep, max_slow_step_, has_slow ? most_inner_ : 1);
  SolveReport report;
  report.substeps = cut.outer * cut.inner;
  report.passes = countPasses(cut);
  const double dt = step / report.substeps;
  const double half_decay = std::exp(-0.5 * system.damping() * dt);
  const MotionLimit* const limit = system.motionLimit();
  const std::vector<Index>* stopped = nullptr;  // in the last sub-step
  const Index n = state.size();
  prepare(system, dt, state);
  const Timer timer;
  beginForces(system, time, cut.inner, state);
  report.time_forces += timer.seconds();
  predicted_.velocities.resize(n);
  if (limit) before_.resize(n);
  predicted_.friction = state.friction;
  predicted_.self_friction = state.self_friction;
  predicted_.escaped.reserve(state.escaped.capacity());  // whoever steps reserves for all, so that no sub-step allocates
  predicted_.escaped = state.escaped;
  double *const velocity = state.velocities.data()->data(), *const predicted = predicted_.velocities.data()->data();
  bool slow_acts = has_slow;  // at this end of a sub-step
  // Damping acts once at the beginning and the end of the step, twice between two sub-steps.
  const bool is_damped = system.damping() > 0.0;
  const double once = 1.0 - half_decay * half_decay, twice = 1.0 - std::pow(half_decay, 4);
  if (is_damped) report.dissipated = once * kineticEnergy(mass_, 0.0, kick_, forces_, state.velocities);
  for (Index s = 0; s < report.substeps; ++s) {
    if (limit) before_.swap(state.positions);
    // Half kicks and drift. The velocity at the end is predicted with the acceleration of the beginning.
    const bool ends = has_slow && (s + 1) % cut.inner == 0;
    if (ends && !slow_acts) addSlow(cut.inner);
    const double* const force = (slow_acts ? forces_with_slow_ : forces_).data()->data();
    const double* const next = (ends ? forces_with_slow_ : forces_).data()->data();
    double* const position = state.positions.data()->data();
    const double* const from = limit ? before_.data()->data() : position;
    parallelFor(3 * n, kBlock, [&](Index begin, Index end) {
      (s == 0 ? kickAndDrift : kickTwiceAndDrift)(end - begin, half_decay, dt, &kick_[begin], force + begin, next + begin,
                                                  from + begin, velocity + begin, predicted + begin, position + begin);
    });
    for (const CarriedPoint& c : carried_) {
      state.positions[c.point] = Eigen::Map<const Vec3>(from + 3 * c.point) + dt * c.velocity;
      predicted_.velocities[c.point] = c.velocity;
    }
    if (limit) {
      stopped = &limitMotion(system, *limit, dt, half_decay, s == 0, force, state);
      report.stopped += stopped->size() > kJammed * n;
      report.halted += !stopped->empty() && doAllStay(system, before_, state.positions);
    }
    // Forces at the new place.
    const Timer forces_timer;
    predicted_.positions.swap(state.positions);
    system.computeFastForces(predicted_, forces_);
    const bool is_last = s + 1 == report.substeps;
    if (is_last) fast_forces_ = forces_;
    SolveReport reached;
    reached.breakStretched(system, predicted_);
    if (reached.has_broken) {
      // Forces until here and from here on: what breaks between the halves of a kick makes no energy.
      Points forces;
      system.computeFastForces(predicted_, forces);
      if (is_last) fast_forces_ = forces;
      for (Index i = 0; !is_last && i < n; ++i) forces_[i] = 0.5 * (forces_[i] + forces[i]);
      report.has_broken = true;
      report.released += reached.released;
    }
    if (ends) system.computeSlowForces(predicted_, slow_forces_);
    addAllLoads(system, time + (s + 1) * dt, ends ? cut.inner : 0, half_decay, state, stopped);
    endIfInterrupted();
    system.remember(time + (s + 1) * dt, dt, predicted_);
    if (ends) {
      bearSlow(predicted_.positions);
      addSlow(cut.inner);
    }
    predicted_.positions.swap(state.positions);
    report.time_forces += forces_timer.seconds();
    slow_acts = ends;
    if (is_damped)
      report.dissipated += (s + 1 == report.substeps ? once : twice) *
                           kineticEnergy(mass_, 1.0, kick_, ends ? forces_with_slow_ : forces_, state.velocities);
  }
  const double* const last_force = (has_slow ? forces_with_slow_ : forces_).data()->data();
  parallelFor(3 * n, kBlock, [&](Index begin, Index end) {
    kick(end - begin, half_decay, &kick_[begin], last_force + begin, velocity + begin);
  });
  if (stopped && !stopped->empty()) bearLastKick(system, dt, *stopped, has_slow ? forces_with_slow_ : forces_, state);
  if (!removeStoppingWork(system, state)) report.halted = report.substeps;
  for (const CarriedPoint& c : carried_) state.velocities[c.point] = c.velocity;
  report.carrying_work = carrying_work_;
  state.friction.swap(predicted_.friction);
  state.escaped = predicted_.escaped;
  state.self_friction.swap(predicted_.self_friction);
  last_positions_ = state.positions;
  report.finite = allFinite(state);
  return report;
}

// Adds the loads to the other fast forces at the predicted state. inner: what the slow forces are taken times, 0: they do not
// act. state: its velocities are those of the drift; stopped: the points that keep them.
void VelocityVerlet::addAllLoads(const System& system, double time, Index inner, double decay, const State& state,
                                 const std::vector<Index>* stopped) {
  if (!system.hasSplitLoads()) {
    carrying_work_ += addLoads(system, time, predicted_, carried_, forces_);
    return;
  }
  system.addLoadsOnAll(time, predicted_, System::Loads::kOthers, forces_);
  at_rest_ = forces_;
  system.addSplitLoadsAtRest(time, predicted_, at_rest_);
  const double *const force = at_rest_.data()->data(), *const slow = (inner > 0 ? slow_forces_ : forces_).data()->data(),
                      *const velocity = state.velocities.data()->data();
  double* const predicted = predicted_.velocities.data()->data();
  parallelFor(3 * static_cast<Index>(forces_.size()), kBlock, [&](Index begin, Index end) {
    predict(end - begin, decay, &kick_[begin], force + begin, inner, slow + begin, velocity + begin, predicted + begin);
  });
  if (stopped)
    for (const Index i : *stopped)
      if (!system.isHeld(i)) predicted_.velocities[i] = state.velocities[i];
  for (const CarriedPoint& c : carried_) predicted_.velocities[c.point] = c.velocity;
  system.addLoadsOnAll(time, predicted_, System::Loads::kSplitOff, forces_);
  carrying_work_ += bear(system, predicted_.positions, carried_, forces_);
}

// Stops points short after a drift from before_. Returns those that were stopped. force (3 n) N: of the kick before the drift.
//
// Stopping changes momentum by J = m (u' - v): v is the velocity of the drift that was wanted, u' that of the drift that remains.
// Verlet keeps its energy because the work of a force over two drifts, with velocities u and u', is that of its kick between
// them: F dt (u + u') / 2. So J does the work J (u + u') / 2. Though a collision loses kinetic energy against v, this work is
// positive where the kick has reversed the motion: u then points along J. The first drift of a step follows a state whose energy
// is counted at its own velocity v0: there the work is J u' - m |u' - v0|^2 / 2, never positive without held points. u and v0 are
// the velocities before damping: damping acts between the halves of a kick, where the velocity in a jam is far from any motion.
const std::vector<Index>& VelocityVerlet::limitMotion(const System& system, const MotionLimit& limit, double dt,
                                                      double half_decay, bool is_first, const double* force, State& state) {
  const std::vector<Index>& stopped = limit.limit(before_, state.positions, !is_first);
  if (stopped.empty()) return stopped;
  bearing_.addStopped(limit, stopped);
  double work = 0.0;
  for (const Index i : stopped) {
    if (system.isHeld(i)) continue;
    const Vec3 wanted = state.velocities[i], now = (state.positions[i] - before_[i]) / dt,
               kick = kick_[3 * i] * Eigen::Map<const Vec3>(force + 3 * i), damped = (wanted - kick) / half_decay,
               last = is_first ? damped : Vec3(damped / half_decay - kick);
    work += system.masses()[i] *
            (is_first ? now.dot(now - wanted) - 0.5 * (now - last).squaredNorm() : 0.5 * (now - wanted).dot(now + last));
    state.velocities[i] = now;
  }
  // What carries held points makes up for the momentum that they give.
  double carried = 0.0;
  for (const CarriedPoint& c : carried_) {
    const Vec3 now = (state.positions[c.point] - before_[c.point]) / dt;
    carried += system.masses()[c.point] * (c.velocity - now).dot(now);
  }
  carrying_work_ += carried;
  stopping_work_ += work - carried;
  for (const Index i : stopped)
    if (!system.isHeld(i)) predicted_.velocities[i] = state.velocities[i];
  return stopped;
}

// Takes the energy that stopping has made in the step from the parts that were stopped. Not in each sub-step: in a jam points
// move to and fro by a little, and each way back returns what the way out has taken. The parts would halt though nothing had been
// made.
bool VelocityVerlet::removeStoppingWork(const System& system, State& state) {
  if (!(stopping_work_ > 0.0) || !bearing_.areAnyFree(system)) return true;
  return bearing_.take(system, stopping_work_, state) == stopping_work_;
}

// What stops a point at the end of a step also bears the force on it: the last half kick would give it a wrong velocity.
void VelocityVerlet::bearLastKick(const System& system, double dt, const std::vector<Index>& stopped, const Points& forces,
                                  State& state) {
  for (const Index i : stopped) {
    state.velocities[i] = (state.positions[i] - before_[i]) / dt;
    stopping_work_ -= system.masses()[i] * kick_[3 * i] * forces[i].dot(state.velocities[i]);  // no kick on held points
  }
}

}  // namespace deformable_surface::solve
