// What a step does where parts of the surface sleep: what wakes them, the step of what is awake, and what may fall asleep after
// it.
#include "simulation_impl.h"

#include <algorithm>

namespace deformable_surface::simulation {

using solve::IntegratorType;

// An equilibrium couples everything. Of particles only what moves is in parts, not what they live through.
bool Simulation::Impl::canBeInParts() const {
  if (params.integrator.type == IntegratorType::kStatic) return false;
  if (!particles) return true;
  const model::OrientedParticlesParams& p = params.oriented_particles;
  return !(p.yield_curvature > 0.0) && !(p.hold_below > 0.0);
}

bool Simulation::Impl::maySleep() const {
  if (params.activity.sleep == Sleep::kNever) return false;
  if (params.activity.sleep == Sleep::kAuto && params.integrator.type == IntegratorType::kExplicitEuler) return false;
  if (!track.seen().empty()) return false;
  if (params.output.resample) return false;  // what is inserted can ask for more in the next step
  if (!life) return true;
  const model::OrientedParticlesParams& particles = params.oriented_particles;
  if (particles.spin > 0.0) return false;  // axes turn where nothing else does
  return !is_hot && !particles.stretching && particles.growing == model::Growing::kNone;
}

void Simulation::Impl::wakeAll() {
  changed();
  if (activity.isWhole()) return activity.wakeAll();
  activity.wakeAll();
  part.reset();
  march.resume();
}

void Simulation::Impl::loadsChanged() {
  changed();
  march.loadsChanged();
  if (part) part->setLoads(partLoads());
}

// The points on which a force acts.
void Simulation::Impl::wakeForce(const std::string& id) {
  for (const NamedForces::Named& force : forces.all())
    if (force.params.id == id) activity.wake(force.points);
}

// An attraction that all points share, a grip that lets go at a force, and a pressure inside ask for all points.
void Simulation::Impl::setParts() {
  const bool is_blown = params.pressure != 0.0 && model->isClosed();
  const bool only_wholly = is_blown || std::any_of(tools.begin(), tools.end(), [](const tool::ToolParams& tool) {
    return tool.mode == tool::Mode::kAttract || (tool.mode == tool::Mode::kMove && tool.strength > 0.0);
  });
  activity.setOnlyWholly(only_wholly);
  if (only_wholly && !activity.isWhole() && !activity.isAsleep()) wakeAll();
}

// Elements that come and go are those at these positions.
void Simulation::Impl::followPartners(const Points& positions) {
  if (!activity.isInParts() || !particles) return;
  State there;
  there.positions = positions;
  there.traits = state.traits;
  if (model->followPartners(there)) followed = positions;
}

void Simulation::Impl::makePart() {
  part = std::make_unique<ActivePart>(*model, activity.movingPoints(), params, partLoads());
  part->march().setMemory(part_march);
  part->march().setFineness(fineness);
  part->march().setInterrupt(interrupt);
}

NamedForces::Update Simulation::Impl::wakeForStep(double now, double dt) {
  NamedForces::Update update = forces.update(now + 1e-6 * dt, state, pinned);
  const bool was_whole = activity.isWhole();
  if (update.changed) {
    activity.wake(update.points);
    changed();
  }
  // Where they are in the step, and were at the end of the one before.
  for (const Eigen::AlignedBox3d& box : tool_watch.look(tools, static_cast<double>(steps + 1) * dt, dt))
    activity.wakeIn(box);
  if (!tool_watch.changed().empty()) changed();
  grips.findMovingPins(now, now + dt, moving);
  if (!moving.empty()) {
    activity.wake(moving);
    changed();
  }
  if (was_whole || !activity.isWhole()) return update;
  part.reset();
  march.resume();
  return update;
}

solve::TimeMarch::Outcome Simulation::Impl::advanceWhole(double now) {
  if (part) march.resume();
  part.reset();
  return march.step(now, state);
}

// A step of what is awake. Where it reaches a wall within the step, the step is taken again with more of the surface.
solve::TimeMarch::Outcome Simulation::Impl::advance(double now) {
  if (!activity.isWhole() && !maySleep()) wakeAll();
  if (activity.isWhole()) return advanceWhole(now);
  const double end = now + params.integrator.time_step;
  for (bool is_new = false;;) {
    if (!part || part->moving() != activity.movingPoints()) {
      if (part) part_march = part->march().memory();
      part_march.energy = {};
      followPartners(state.positions);
      makePart();
      is_new = true;
    }
    part_march = part->march().memory();
    solve::TimeMarch::Outcome taken = part->step(now, state, held, held_turns);
    if (!taken.ok && interrupt && *interrupt) return taken;
    if (!taken.ok) break;
    if (!followed.empty() && part->hasMoved(followed, model->maxPartMotion())) {
      if (is_new) break;  // too far in one step
      part.reset();
      continue;
    }
    const double at_wall = part->findHits(end, activity.acceleration(), activity.speed(), activity.spacing(), hits);
    if (hits.empty()) {
      activity.leaveAtWall(at_wall);
      part->put(state);
      return taken;
    }
    activity.widen(hits);
    part.reset();
    if (activity.isWhole()) break;
  }
  activity.wakeAll();
  part.reset();
  march.resume();
  return march.step(now, state);
}

// In the first step of a state: what a force or a tool that comes in this step disturbs does not sleep. The step that wakes it is
// the one that somebody waits for, so that what can be known before is found out now.
void Simulation::Impl::beginAsleep(double now) {
  if (!activity.isFresh() || !maySleep()) return;
  followPartners(state.positions);
  if (!activity.beginAsleep(system, now, state)) return;
  march.prepare(now, state);
  part_march = march.memory();
  for (const Eigen::AlignedBox3d& box : tool_watch.changed()) activity.wakeIn(box);
  grips.findMovingPins(now, now + params.integrator.time_step, moving);
  activity.wake(moving);
  changed();
}

// After a step that was taken.
void Simulation::Impl::considerSleep(const solve::SolveReport& report) {
  if (!maySleep()) return;
  if (params.integrator.type == IntegratorType::kStatic) {
    // It has found everything where it was, and would again. What has just come may act from the next step on only.
    const bool is_found = report.converged && report.iterations == 0;
    if (is_found && grips.isEmpty() && tool_watch.changed().empty()) activity.sleepWholly(state);
    return;
  }
  activity.observe(state);
  const bool dissipates = system.dissipates() || lastMarch().lastType() == IntegratorType::kImplicit;
  if (!activity.isLookDue() || !dissipates) return;
  if (activity.isWhole()) {
    part_march = march.memory();
    followPartners(state.positions);
  }
  if (part) {
    activity.fallAsleep(part->system(), time(), part->state(), &part->points(), state);
  } else {
    activity.fallAsleep(system, time(), state, nullptr, state);
  }
}

// A step of a surface that sleeps. Its copies sleep, or will find what they have missed in the next step.
StepOutcome Simulation::Impl::passStep(const Timer& timer, const std::string& notice) {
  ++steps;
  if (estimator) estimator->pass();
  statistics.substeps = statistics.solver_iterations = 0;
  statistics.solver_residual = statistics.time_forces = statistics.time_solve = statistics.time_contact =
      statistics.time_estimate = 0.0;
  statistics.time_transfer = statistics.time_normals = 0.0;
  statistics.time_total = timer.seconds();
  statistics.real_time_factor = params.integrator.time_step / statistics.time_total;
  StepOutcome outcome;
  outcome.notice = notice;
  return outcome;
}

void Simulation::passStep() { ++impl_->steps; }

}  // namespace deformable_surface::simulation
