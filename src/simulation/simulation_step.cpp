// A step of a simulation, in its order, and what belongs to single parts of it. What acts in a step is set elsewhere
// (simulation_making.cpp), who sleeps through it too (activity_steps.cpp).
#include "simulation_impl.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nested_start.h"

namespace deformable_surface::simulation {

// What may change before it is known that the step is good is kept, and given back whatever it was that refused it.
StepOutcome Simulation::Impl::step() {
  const Timer timer;
  const double dt = params.integrator.time_step;
  const double now = time();
  keepAsleep(before);
  const bool was_asleep = activity.isAsleep();
  NamedForces::Update update;
  if (was_asleep) update = wakeForStep(now, dt);
  has_slept = activity.isAsleep();
  if (has_slept) return passStep(timer, update.notice);
  if (now + 1e-6 * dt >= params.duration) leaveTrial("its time has come to an end");
  keepAwake(before);
  StepOutcome outcome;
  try {
    std::optional<InterruptScope> scope;
    if (interrupt) scope.emplace(*interrupt);
    std::string news;
    if (life) news = live(now, dt);
    if (!was_asleep) update = wakeForStep(now, dt);
    for (const std::string& notice : {update.notice, news}) appendNotice(outcome.notice, notice);
    takeStep(timer, update.changed, scope, outcome);
  } catch (const Interrupted& interrupted) {
    refuse(interrupted.what(), outcome);
  } catch (...) {
    giveBack(before);
    throw;
  }
  if (!outcome.ok) giveBack(before);
  return outcome;
}

void Simulation::Impl::refuse(const std::string& why, StepOutcome& outcome) const {
  outcome.ok = false;
  outcome.problem = "step " + std::to_string(before.steps + 1) + " at " +
                    formatReal(static_cast<double>(before.steps) * params.integrator.time_step) + " s " + why +
                    "; the state before it is kept";
}

// As if the last step had not been taken.
void Simulation::Impl::undoStep() {
  if (!has_slept) return giveBack(before);
  --steps;
  forces.restore(before.forces);
  tool_watch.setMemory(before.watched);
}

// In this order: commands -> sub-steps (forces, integration) -> checks. What follows from the new state (transfer, normals,
// markers) is made when somebody asks for it.
void Simulation::Impl::takeStep(const Timer& timer, bool have_loads_changed, std::optional<InterruptScope>& scope,
                                StepOutcome& outcome) {
  const double dt = params.integrator.time_step;
  const double now = time();

  // Commands. What is held can have changed, and with it the clamps. Rounding of the time must not lose a step to the one before.
  clampHeld();
  Grips::Update grip;
  if (!grips.isEmpty()) grip = updateGrips(now, dt);
  if (have_loads_changed || grip.changed) loadsChanged();
  for (const std::string& notice : {grip.notice, share_notice}) appendNotice(outcome.notice, notice);
  share_notice.clear();
  beginAsleep(now);
  if (activity.isAsleep()) {
    outcome = passStep(timer, outcome.notice);
    return;
  }

  double contact_seconds = 0.0;
  bool has_new_arrival = false;
  if (!contact.isEmpty()) {
    const Timer contact_timer;
    const bool has_changed = contact.beginStep(now, dt, state, held);
    appendNotice(outcome.notice, contact.news());
    has_new_arrival = contact.hasNewArrival();
    if (contact.hasNewDetour()) wakeAll();  // where it comes from nobody has looked for sleepers
    if (has_changed) loadsChanged();
    contact_seconds = contact_timer.seconds();
  }

  const bool may_be_cut = cutting && cutting->beginStep(tools, now, state.positions);

  if (params.integrator.type == solve::IntegratorType::kStatic) {
    findLoose(now + dt);
    if (loose.areAll())
      return refuse("has no equilibrium: nothing holds the surface against loads that sum up to " + formatShort(loose.load()) +
                        " N",
                    outcome);
    if (!loose.areAll()) appendNotice(outcome.notice, holdLoose());
  }
  std::unique_ptr<model::State> start;  // of a second search
  if (params.integrator.type == solve::IntegratorType::kStatic && estimator && estimator->wantsSecondSearch())
    start = std::make_unique<model::State>(state);
  const bool is_nested = beginNested();
  solve::TimeMarch::Outcome taken = advance(now);
  if (is_nested && !taken.ok) {
    state.positions = rest.points;
    march.restart();
    taken = march.step(now, state);
  }
  const solve::SolveReport& report = taken.report;
  appendNotice(outcome.notice, taken.notice);
  if (!taken.ok) return refuse(taken.failure, outcome);
  const Timer search_timer;
  std::optional<double> other;
  if (start && report.converged) other = searchAgain(now, *start);
  const double search_seconds = search_timer.seconds();
  if (!contact.isEmpty()) {
    const Timer contact_timer;
    appendNotice(outcome.notice, contact.endStep(now, dt, state, held, model->triangles()));
    contact_seconds += contact_timer.seconds() + contact.takeSeconds() + (part ? part->takeContactSeconds() : 0.0);
  }
  bool has_parted = false;
  if (may_be_cut) has_parted = cutting->endStep(tools, now, dt, state.positions, surface);
  if (has_parted) endCuts();
  const bool has_flowed = solid && solid->flow(dt, state);
  if (has_flowed) {
    march.forcesChanged();
    wakeAll();
  }
  scope.reset();  // from here on only the copies look, which take their own steps
  ++steps;
  if (isAsTried() && steps <= choice.softening.size()) softening = choice.softening[steps - 1];
  surface.invalidate();
  if (estimator) {
    if (has_new_arrival) estimator->forward([&](Simulation& copy) { copy.impl_->contact.adoptArrivals(contact); });
    if (has_parted) loseEstimate(outcome);
    estimate(report, outcome);
    if (other) appendNotice(outcome.notice, estimator->learnSecondSearch(*other));
    statistics.time_estimate += search_seconds;
  }
  surface.resample(state);
  if (!has_flowed) considerSleep(report);
  changed();

  // What it was.
  statistics.substeps = static_cast<std::uint32_t>(report.substeps);
  statistics.solver_iterations = static_cast<std::uint32_t>(report.iterations);
  statistics.is_quasi_newton = report.is_quasi_newton;
  statistics.solver_residual = report.residual;
  statistics.time_forces = report.time_forces;
  statistics.time_contact = contact_seconds;
  statistics.time_total = timer.seconds();
  statistics.time_solve = statistics.time_total - report.time_forces - statistics.time_estimate;
  statistics.real_time_factor = dt / statistics.time_total;
  statistics.time_transfer = statistics.time_normals = 0.0;
}

// Whether the middle of the surface lies among its pins: most such surfaces sag between them and do not swing down.
bool Simulation::Impl::isHeldAround() const {
  Eigen::AlignedBox3d pins;
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < rest.points.size(); ++i) {
    middle += rest.points[i] / static_cast<double>(rest.points.size());
    if (pinned[i]) pins.extend(rest.points[i]);
  }
  if (pins.isEmpty()) return false;
  const Vec3 rounding = Vec3::Constant(1e-9 * pins.diagonal().norm());
  return Eigen::AlignedBox3d(pins.min() - rounding, pins.max() + rounding).contains(middle);
}

// A first equilibrium is looked for from that of fewer points, but where steps that cost little find it from rest. Returns
// whether the state was changed.
bool Simulation::Impl::beginNested() {
  if (params.integrator.type != solve::IntegratorType::kStatic || system.isOriented() || steps > 0) return false;
  if (pinned != rest.pinned || grips.hasPins() || state.positions != rest.points) return false;
  if (isHeldAround() && system.hasElasticityAlone(time() + params.integrator.time_step, state)) return false;
  SceneParams scene = params;
  scene.gravity = gravity.gravity;
  scene.forces.clear();
  for (const NamedForces::Named& force : forces.all()) scene.forces.push_back(force.params);
  Points start = findNestedStart(scene, rest, interrupt);
  if (start.empty()) return false;
  state.positions = std::move(start);
  return true;
}

// The parts without an equilibrium. Bonds of particles come and go within a step: they count as one part.
void Simulation::Impl::findLoose(double time) {
  const Index n = state.size();
  loose.follow(n, system.isOriented() ? nullptr : &model->stretchLinks());
  load_stiffness.assign(n, 0.0);
  load_damping.assign(n, 0.0);
  forces_on_all.assign(n, Vec3::Zero());
  for (const solve::ExternalLoad* load : loads) {
    if (load == &contact || load == &friction) continue;
    load->addRowBounds(time, state, load_stiffness, load_damping);
    load->addForces(time, state, forces_on_all);
  }
  model->confine(forces_on_all);
  loose.find(held, load_stiffness, forces_on_all, state.positions, contact, time);
}

// Returns what a user should know of it, if that is news.
std::string Simulation::Impl::holdLoose() {
  if (loose.numPoints() > 0)
    for (Index i = 0; i < state.size(); ++i) {
      if (!loose.isLoose(i)) continue;
      held[i] = 1;
      state.velocities[i].setZero();
    }
  const bool is_news = loose.numPoints() > 0 && loose.numPoints() != loose_said;
  loose_said = loose.numPoints();
  return is_news ? loose.describe() : "";
}

// The same step from disturbed positions, of which nothing is left: how far from the equilibrium it ends, m, infinity where it
// finds none. An equilibrium near where the search began is not searched for again; nothing, if interrupted.
std::optional<double> Simulation::Impl::searchAgain(double now, model::State& start) const {
  if (findLargestDistance(state.positions, start.positions) < std::sqrt(rest.area / state.size())) return 0.0;
  disturb(estimator->searchDisturbance(), start.positions);
  solve::TimeMarch second(system, *model, params.integrator);
  second.setInterrupt(interrupt);
  const solve::TimeMarch::Outcome taken = second.step(now, start);
  if (interrupt && *interrupt) return {};
  if (!taken.ok || !taken.report.converged) return std::numeric_limits<double>::infinity();
  return findLargestDistance(state.positions, start.positions);
}

Grips::Update Simulation::Impl::updateGrips(double now, double dt) {
  if (grips.readForces()) system.computeForcesOnAll(now, state, forces_on_all);
  const Grips::Update update = grips.update(now, 1e-6 * dt, state, pinned, forces_on_all);
  grips.carry(now, dt, state, held);
  return update;
}

// What knives passed and what was stretched too far is severed; what was kept of the whole surface is then worth nothing.
void Simulation::Impl::endCuts() {
  wakeAll();
  setParts();
  march.restart();
}

void Simulation::Impl::loseEstimate(StepOutcome& outcome) {
  if (std::isfinite(estimator->total()))
    appendNotice(outcome.notice,
                 "the surface is cut, which its coarser copies do not follow: there is no error estimate until the next reset");
  estimator->lose();
}

// Particles cool, go and are born; those that are too cold are held.
std::string Simulation::Impl::live(double now, double dt) {
  const double interval = params.oriented_particles.growth_interval;
  const bool looks = std::floor((now + 1e-6 * dt) / interval) > std::floor((now - (1.0 - 1e-6) * dt) / interval);
  const ParticleLife::Changes changes = life->update(now, dt, looks, tools, state);
  // Heat changes the energy of bonds, and so does flow.
  is_hot = changes.are_hot || changes.has_flowed;
  if (is_hot) march.restart();
  follow(changes);
  return changes.notice;
}

ParticleLife::Changes Simulation::Impl::fit(const model::GrowthParams& growth) {
  const ParticleLife::Changes changes = life->fit(growth, steps > 0 ? held : pinned, steps == 0, state);
  follow(changes);
  return changes;
}

void Simulation::Impl::requireParticles() const {
  if (!life) throw InputError("model: found one that has no particles to edit or to grow; accepted: oriented_particles");
}

// Everything that is by point follows a change of the population.
void Simulation::Impl::follow(const ParticleLife::Changes& changes) {
  if (!changes.new_index.empty()) {
    forces.renumber(changes.new_index);
    anchors.renumber(changes.new_index);
    grips.renumber(changes.new_index);
    contact.renumber(changes.new_index);
    keepThose(changes.new_index, pinned);
    keepThose(changes.new_index, pinned_turns);
  }
  if (changes.new_index.empty() && changes.born == 0) return;
  pinned.resize(state.positions.size(), 0);
  pinned_turns.resize(state.positions.size(), 0);
  model->adopt(state);
  track.restore({});
  chooseLoads();
  march.restart();
  wakeAll();
  activity.leaveParts();
  followed.clear();
  surface.invalidate();
}

// The copies take the same step; if that is interrupted, none of them has.
void Simulation::Impl::estimate(const solve::SolveReport& report, StepOutcome& outcome) {
  const Timer timer;
  appendNotice(outcome.notice,
               estimator->follow(state.positions, lastMarch().lastType(), report.substeps, forces.all(), interrupt));
  estimator->learnBalance(params.integrator.type != solve::IntegratorType::kStatic || report.converged);
  // Asked for, kept in the trial, but not kept now; said once.
  const double wish = params.accuracy.position_error, error = estimator->total() + softening;
  if (wish > 0.0 && choice.is_met && error > wish && std::isfinite(error) && !is_wish_missed) {
    appendNotice(outcome.notice, "the estimated error, " + formatReal(error) + " m, has grown beyond accuracy.position_error, " +
                                     formatReal(wish) + " m");
    is_wish_missed = true;
  }
  statistics.time_estimate = timer.seconds();
}

}  // namespace deformable_surface::simulation
