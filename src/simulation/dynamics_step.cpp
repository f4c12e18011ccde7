// The step of a dynamics, in its order. The loads of a step are set elsewhere
// (dynamics.cpp), as is what sleeps through it (dynamics_sleep.cpp).
#include "dynamics.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/step_time.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "carried_away.h"
#include "grazing.h"
#include "rest_parts.h"
#include "spacing.h"
#include "step_messages.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kMostGrowth = 0.5;  // of the spacing: the most by which tools grow towards points that press on them
// Share of the surface's area that is not worth a word: even sheets have up to 0.03.
constexpr double kNoContact = 0.05;
constexpr double kPatience = 0.5;  // s without fewer crossings, until nothing is pushed apart any longer
// Implicit steps, and their iterations, until they are compared with Verlet's.
constexpr Index kStepsPerLook = 5, kIterationsPerLook = 60;
// Verlet's sub-steps that are sure to take less time than an iteration of an implicit step. It took as much time as 100 to 700 of
// them with tools in contact, as 38 to 380 on surfaces of 99 to 1000 points without tools, and as 22 to 26 in solids.
constexpr Index kCheapSubsteps = 20;
// Pairs that touch, and pairs that may collide where any are stopped, in a sub-step, for each point: the mean over kStepsPerLook
// steps. docs/contact.md has the scenes on which it was chosen.
constexpr double kManyPairs = 10.0;
constexpr Index kDiced = 8;        // points without links that a step with a knife leaves; cuts along an edge leave none
constexpr int kMostSettling = 20;  // searches for an equilibrium; each leaves about a third of the depth in a stiff surface

}  // namespace

double findLargestDistance(const Points& a, const Points& b) {
  double squared = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) squared = std::max(squared, (a[i] - b[i]).squaredNorm());
  return std::sqrt(squared);
}

// Everything that may change before the step is known to be good is stored, and restored for whatever reason it is refused.
bool Dynamics::beginStep() {
  keepWaiting(before_.waiting);
  const bool was_asleep = activity_.isAsleep();
  woken_ = {};
  if (was_asleep) woken_ = wakeForStep(time(), params_.integrator.time_step);
  has_woken_ = was_asleep;
  has_slept_ = activity_.isAsleep();
  return !has_slept_;
}

Dynamics::Outcome Dynamics::step() { return beginStep() ? takeStep(Request()) : passStep(); }

Dynamics::Outcome Dynamics::passStep() {
  ++steps_;
  last_substeps_ = 0;
  Outcome outcome;
  outcome.has_slept = true;
  outcome.notice = std::move(woken_.notice);
  woken_.notice.clear();
  return outcome;
}

Dynamics::Outcome Dynamics::takeStep(const Request& request) {
  const double dt = params_.integrator.time_step, now = time();
  before_.motion = now_;
  keepHolding(before_.holding);
  const ContactPoints& touching = loads_.contact.points();
  for (ContactLoad::Body& body : before_.holding.bodies) body.pressed.reserve(touching.between() ? touching.size() : 0);
  Outcome outcome;
  try {
    std::optional<InterruptScope> scope;
    if (interrupt_) scope.emplace(*interrupt_);
    const std::string notice_of_life = live(now, dt);
    if (!has_woken_) woken_ = wakeForStep(now, dt);
    for (const std::string& notice : {woken_.notice, notice_of_life}) appendNotice(outcome.notice, notice);
    carryOut(request, scope, outcome);
  } catch (const Interrupted& interrupted) {
    refuse(interrupted.what(), outcome);
  } catch (...) {
    giveBack(before_, false);
    throw;
  }
  if (!outcome.ok) giveBack(before_, false);
  return outcome;
}

// Undoes the last step.
void Dynamics::undoStep() {
  if (!has_slept_) return giveBack(before_, false);
  steps_ = before_.waiting.steps;
  loads_.forces.restore(before_.waiting.forces);
  tool_watch_.setMemory(before_.waiting.watched);
}

// In this order: constraints and loads -> sub-steps (forces, integration) -> checks.
void Dynamics::carryOut(const Request& request, std::optional<InterruptScope>& scope, Outcome& outcome) {
  const double dt = params_.integrator.time_step, now = time();
  const bool is_static = params_.integrator.type == solve::IntegratorType::kStatic;
  State& points = now_.points;
  ContactLoad& contact = loads_.contact;

  // Held points may have changed, and with them the clamps. Rounding of the time must not lose a step.
  clampHeld();
  Grips::Update grip;
  if (!grips_.isEmpty()) grip = updateGrips(now, dt);
  if (woken_.changed || grip.changed) followLoads();
  appendNotice(outcome.notice, grip.notice);
  appendNotice(outcome.notice, describeCompliance());
  beginSelfContact(dt, outcome.notice);
  beginAsleep(now);
  if (activity_.isAsleep()) {
    woken_.notice = std::move(outcome.notice);
    outcome = passStep();
    return;
  }

  beginToolContact(now, dt, outcome);
  evolution_->beginStep(now, tools_, points.positions);
  system_.setBreaking(burst_.over(evolution_->breaking()));

  if (is_static) {
    findLoose(now + dt);
    if (loose_.areAll())
      return refuse(
          "has no equilibrium: nothing holds the surface against loads that sum up to " + formatShort(loose_.load()) + " N",
          outcome);
    appendNotice(outcome.notice, holdLoose());
  }
  std::optional<State> start;  // of a second search
  if (is_static && request.second_search > 0.0) start = points;
  const bool was_closed = isClosed(*model_);
  const solve::TimeMarch::Outcome taken = findMotion(now, request);
  outcome.report = taken.report;
  outcome.is_static = taken.type == solve::IntegratorType::kStatic;
  outcome.retried = taken.retried;
  outcome.is_retried_implicitly = taken.is_retried_implicitly;
  appendNotice(outcome.notice, describeChange(taken, params_.integrator));
  if (!taken.ok) return refuse(describeRefusal(taken.failure, params_.integrator.type, system_.hasStiffness()), outcome);
  if (is_static && !contact.isEmpty()) {
    const Points &before = before_.motion.points.positions, &after = points.positions;
    const double way = findCarriedAway(system_, contact, now + dt, load_stiffness_, before, after);
    if (way > 0.0) return refuse(describeCarriedAway(way), outcome);
  }
  const Timer search_timer;
  if (start && taken.report.converged) outcome.second_distance = searchAgain(now, request.second_search, *start);
  outcome.search_seconds = search_timer.seconds();
  if (!contact.isEmpty()) {
    const Timer contact_timer;
    const ContactLoad::Skin skin{outside(), skin_.has_value(), activity_.spacing()};
    appendNotice(outcome.notice, contact.endStep(now, dt, points, held_, skin));
    points.escaped.clear();
    appendNotice(outcome.notice, describeGrazing(now + dt));
    outcome.contact_seconds += contact_timer.seconds() + contact.takeSeconds() + (part_ ? part_->takeContactSeconds() : 0.0);
  }
  appendNotice(outcome.notice, describeCostlySteps(taken.report));
  appendNotice(outcome.notice, describeCostlyContact(taken.report));
  const bool may_dice = !told_.dicing && hasKnife(now);
  const Index single = may_dice ? countSinglePoints() : 0;
  const auto [has_cut, has_flowed, leaves_copies] = evolution_->endStep(now, dt, tools_, points, cut_follower_);
  outcome.has_cut = has_cut;
  outcome.leaves_copies = leaves_copies;
  if (has_cut) {
    const Index cut_off = may_dice ? countSinglePoints() - single : 0;
    if (cut_off >= kDiced) {
      told_.dicing = true;
      appendNotice(outcome.notice, describeDicing(cut_off));
    }
    followCuts();
    loads_.forces.followCut();
    if (was_closed && !isClosed(*model_) && !loads_.pressure.isEmpty())
      appendNotice(outcome.notice,
                   "the surface is no longer closed, but pressure goes on acting on its pieces, along their normals: "
                   "nothing lets it escape; pressure 0 ends it");
  }
  appendNotice(outcome.notice, endUntangling(dt));
  Changes changes;
  // Stored data of the whole surface are void once it is cut.
  changes.parts = changes.motion = outcome.has_cut;
  changes.everywhere = outcome.has_cut || has_flowed;
  if (has_flowed) march_.forcesChanged();
  follow(changes);
  scope.reset();  // from here on only copies look, which take their own steps
  ++steps_;
  last_substeps_ = static_cast<Index>(taken.report.substeps);
  if (!has_flowed) considerSleep(taken.report);
  ++revision_;
}

void Dynamics::beginSelfContact(double dt, std::string& notice) {
  if (!loads_.self_contact) return;
  const contact::PairList& pairs = loads_.self_contact->contact.pairs();
  const bool is_told = params_.contact.untangle ? std::exchange(untangling_.is_told, true) : steps_ > 0;
  if (!is_told && pairs.numCrossed() > 0) appendNotice(notice, describeCrossed());
  if (steps_ == 0) {
    const double share = loads_.self_contact->skin()->share_without;
    if (share > kNoContact)
      appendNotice(notice, formatShort(100.0 * share) +
                               " % of the surface's area has no contact with itself, because triangles overlap there at rest: "
                               "layers that are joined, or a very uneven cloud; parts can pass through each other there");
  }
  const bool has_changed = loads_.self_contact->beginStep(now_.points, dt, untangles());
  setParts();
  if (!has_changed) return;
  if (!loads_.self_contact->mayAct()) now_.points.self_friction.clear();
  followLoads();
}

// Whether crossed parts are being pushed apart.
bool Dynamics::untangles() const {
  return params_.contact.untangle && untangling_.time < kPatience && loads_.self_contact->contact.pairs().numCrossed() > 0;
}

std::string Dynamics::describeCrossed() const {
  const contact::PairList& pairs = loads_.self_contact->contact.pairs();
  const bool untangles = params_.contact.untangle;
  return std::to_string(pairs.numCrossed()) + " triangles are crossed by others" + (untangles ? "" : " at rest") +
         ", one of them near " + formatPlace(pairs.firstCrossing()) +
         " m: " + (untangles ? "they are pushed apart" : "there the surface passes through itself");
}

// What crosses is looked for after each step, until nothing does: contact then keeps it so.
std::string Dynamics::endUntangling(double dt) {
  if (!params_.contact.untangle || loads_.self_contact->contact.pairs().numCrossed() == 0) return "";
  SelfContactLoads& self = *loads_.self_contact;
  const bool has_pushed = self.pushes();
  self.followCrossings(now_.points.positions);
  if (has_pushed) followLoads();
  const Index num = static_cast<Index>(self.contact.pairs().crossings().size());
  const bool has_fewer = num < untangling_.fewest, was_patient = untangling_.time < kPatience;
  untangling_ = {std::min(num, untangling_.fewest), has_fewer ? 0.0 : untangling_.time + dt, true};
  if (num == 0) return "no triangle that has contact is crossed any longer";
  if (!was_patient || untangling_.time < kPatience) return "";
  return std::to_string(self.contact.pairs().numCrossed()) +
         " triangles are still crossed by others and are not pushed apart any longer: the surface goes on passing through itself";
}

// Of pads that are harder than contact without them, once until the next reset.
std::string Dynamics::describeCompliance() {
  const double stated = params_.contact.compliance;
  if (!(stated > 0.0) || !(now_.contact_rate > 0.0) || std::exchange(told_.compliance, true)) return "";
  std::string where;
  const auto add = [&](double own, const char* what) {
    if (stated < own) where += (where.empty() ? "" : " and ") + std::string(what) + formatShort(own) + " m/Pa";
  };
  // In equilibria tools grow by what their contact yields more.
  if (!loads_.contact.isEmpty() && params_.integrator.type != solve::IntegratorType::kStatic)
    add(loads_.contact.ownCompliance(), "with tools by up to ");
  if (loads_.self_contact) add(loads_.self_contact->contact.ownCompliance(), "between parts by up to ");
  if (where.empty()) return "";
  return "contact.compliance is " + formatShort(stated) + " m/Pa, but contact without pads already yields " + where +
         ": where this is more, pads have no effect";
}

// Of links that a knife may cut.
bool Dynamics::hasKnife(double now) const {
  const auto isKnife = [now](const tool::ToolParams& t) { return t.mode == tool::Mode::kCut && tool::isActive(t, now); };
  return model_->links() && std::any_of(tools_.begin(), tools_.end(), isKnife);
}

// Points without links.
Index Dynamics::countSinglePoints() {
  linked_.assign(now_.points.size(), 0);
  for (const auto& [a, b] : stretchLinksOf(*model_)) linked_[a] = linked_[b] = 1;
  return static_cast<Index>(std::count(linked_.begin(), linked_.end(), 0));
}

// Reported once until the next reset.
std::string Dynamics::describeGrazing(double now) {
  if (told_.grazing || !kind_.traits().is_surface) return "";
  const Grazing found = findGrazing(loads_.contact, now, now_.points, params_.material.thickness);
  if (!found.slider) return "";
  told_.grazing = true;
  return "tool " + quote(found.slider->id) + " slides over the surface on tool " + quote(found.support->id) +
         " without touching it, " + formatShort(found.gap) +
         " m above points that have no thickness (material.thickness: " + formatShort(params_.material.thickness) +
         "); to push the surface along, it must reach below them";
}

// Once until the next reset. It counts work and no seconds, so that a run says the same on every machine.
std::string Dynamics::describeCostlySteps(const solve::SolveReport& report) {
  Told::ImplicitWork& seen = told_.implicit_work;
  const bool is_asked = params_.integrator.type == solve::IntegratorType::kImplicit && !hasChosenIntegrator();
  if (!is_asked || seen.is_told || report.iterations == 0) return "";
  seen.iterations += report.iterations;
  if (++seen.steps < kStepsPerLook || seen.iterations < kIterationsPerLook) return "";
  const double iterations = static_cast<double>(seen.iterations) / seen.steps;
  seen = {};
  const double dt = params_.integrator.time_step;
  const Index substeps = solve::countSubsteps(dt, march_.findStableStep(time() + dt, now_.points));
  if (!(substeps <= kCheapSubsteps * iterations)) return "";
  seen.is_told = true;
  const auto& touches = loads_.contact.findTouches(time() + dt, now_.points);
  const bool is_touched = std::any_of(touches.begin(), touches.end(), [](const auto& of_tool) { return !of_tool.empty(); });
  return simulation::describeCostlySteps(is_touched, iterations, substeps, params_.integrator);
}

// Once until the next reset, counted as well: where a few steps have as many near pairs as many ordinary ones. Implicit steps
// have the same pairs in each iteration, and describeCostlySteps() tells of these.
std::string Dynamics::describeCostlyContact(const solve::SolveReport& report) {
  Told::ContactWork& seen = told_.contact_work;
  if (!loads_.self_contact) return "";
  const std::size_t near = loads_.self_contact->contact.numNear(), before = std::exchange(seen.near, near);
  if (seen.is_told || report.iterations > 0) return "";
  const double calls = static_cast<double>(report.substeps + 1) * now_.points.size();  // at both ends of all sub-steps
  if (calls > 0.0) seen.pairs += static_cast<double>(near - std::min(before, near)) / calls;
  const bool are_many = seen.pairs >= kManyPairs * kStepsPerLook;
  if (++seen.steps < kStepsPerLook && !are_many) return "";
  seen.pairs = 0.0;
  seen.steps = 0;
  if (!are_many) return "";
  seen.is_told = true;
  std::vector<std::string> attracting;
  for (const tool::ToolParams& tool : tools_)
    if (tool.mode == tool::Mode::kAttract && tool::isActive(tool, time())) attracting.push_back(tool.id);
  return simulation::describeCostlyContact(attracting);
}

// The triangles that a tool passes through where it comes between the points: those of the model, or around a body in space.
const std::vector<model::WeightedTriangle>& Dynamics::outside() {
  const std::vector<model::WeightedTriangle>& triangles = trianglesOf(*model_);
  const auto mayPass = [](const tool::ToolParams& tool) {
    return tool.mode == tool::Mode::kSolid && tool.shape.kind != geometry::Solid::Kind::kPlane;
  };
  if (!triangles.empty() || !rest_->across.isZero(0.0) || std::none_of(tools_.begin(), tools_.end(), mayPass)) return triangles;
  if (!skin_) skin_ = kind_.findSkin(*rest_, *model_);
  return *skin_;
}

void Dynamics::beginToolContact(double now, double dt, Outcome& outcome) {
  ContactLoad& contact = loads_.contact;
  if (contact.isEmpty()) return;
  const Timer contact_timer;
  contact.setGrowing(params_.integrator.type == solve::IntegratorType::kStatic, kMostGrowth * activity_.spacing());
  now_.points.escaped.reserve(now_.points.size());
  const bool has_changed = contact.beginStep(now, dt, now_.points, held_);
  appendNotice(outcome.notice, contact.notice());
  outcome.has_new_arrival = contact.hasNewArrival();
  if (contact.hasNewDetour()) wakeAll();  // sleeping points on the detour were not looked for
  if (has_changed) followLoads();
  outcome.contact_seconds = contact_timer.seconds();
}

// An equilibrium is first searched without contact where no parts are near each other. If parts met on the straight way to it, or
// touch there, the search begins again with contact.
solve::TimeMarch::Outcome Dynamics::findMotion(double now, const Request& request) {
  SelfContactLoads* const self = loads_.self_contact.get();
  if (self) system_.setMotionLimit(&self->limit);
  if (!self || self->mayAct() || params_.integrator.type != solve::IntegratorType::kStatic)
    return advanceFromStart(now, beginElsewhere(request));
  system_.setMotionLimit(nullptr);
  before_search_ = now_.points;
  loads_.contact.copyAll(tools_before_search_);
  const solve::TimeMarch::Memory memory = march_.memory();
  const solve::TimeMarch::Outcome apart = advanceFromStart(now, beginElsewhere(request));
  if (!apart.ok && interrupt_ && *interrupt_) return apart;
  if (apart.ok && self->contact.staysApart(before_search_.positions, now_.points.positions)) return apart;
  system_.setMotionLimit(&self->limit);
  self->setMayAct(true);
  followLoads();
  now_.points = before_search_;
  loads_.contact.restore(tools_before_search_);
  march_.setMemory(memory);
  solve::TimeMarch::Outcome taken = advanceFromStart(now, false);
  taken.report.iterations += apart.report.iterations;
  taken.report.time_forces += apart.report.time_forces;
  return taken;
}

// The sub-steps. An equilibrium that is not found from elsewhere is searched again from rest.
solve::TimeMarch::Outcome Dynamics::advanceFromStart(double now, bool is_elsewhere) {
  solve::TimeMarch::Outcome taken = advance(now);
  if (is_elsewhere && !taken.ok) {
    now_.points.positions = rest_->points;
    march_.restart();
    taken = march_.step(now, now_.points);
  }
  if (params_.integrator.type == solve::IntegratorType::kStatic && !loads_.contact.isEmpty()) settleContact(now, taken);
  return taken;
}

// The equilibrium in which points lie on tools, not in them.
void Dynamics::settleContact(double now, solve::TimeMarch::Outcome& taken) {
  const double end = now + params_.integrator.time_step;
  for (int k = 0; k < kMostSettling && taken.ok && taken.report.converged && loads_.contact.settle(end, now_.points, held_);
       ++k) {
    const solve::TimeMarch::Outcome next = march_.step(now, now_.points);
    if (!next.ok) return;
    const Index before = taken.report.iterations;
    taken = next;
    taken.report.iterations += before;
  }
}

void Dynamics::refuse(const std::string& why, Outcome& outcome) {
  outcome.ok = false;
  outcome.failure = why;
}

// Whether the middle of the surface lies among its pins: most such surfaces sag between them and do not swing down.
bool Dynamics::isHeldAround() const {
  const Points& rest = rest_->points;
  Eigen::AlignedBox3d pins;
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < rest.size(); ++i) {
    middle += rest[i] / static_cast<double>(rest.size());
    if (now_.pinned[i]) pins.extend(rest[i]);
  }
  if (pins.isEmpty()) return false;
  const Vec3 rounding = Vec3::Constant(1e-9 * pins.diagonal().norm());
  return Eigen::AlignedBox3d(pins.min() - rounding, pins.max() + rounding).contains(middle);
}

// Starts the search for a first equilibrium from that of fewer points, unless cheap steps find it from rest or there are grips:
// what these clamp can be a hinge to fewer points. Returns whether the state was changed.
bool Dynamics::beginElsewhere(const Request& request) {
  if (!request.find_start || system_.motionLimit() || params_.integrator.type != solve::IntegratorType::kStatic ||
      system_.isOriented() || steps_ > 0)
    return false;
  if (now_.pinned != rest_->pinned || !grips_.isEmpty() || now_.points.positions != rest_->points) return false;
  if (isHeldAround() && system_.hasElasticityAlone(time() + params_.integrator.time_step, now_.points)) return false;
  SceneParams scene = params_;
  scene.gravity = loads_.gravity.gravity;
  scene.forces.clear();
  for (const NamedForces::Named& force : loads_.forces.all()) scene.forces.push_back(force.params);
  Points start = request.find_start(scene);
  if (start.empty()) return false;
  now_.points.positions = std::move(start);
  return true;
}

// The parts without an equilibrium. Without links, or if these change within a step (particles), all points count as one
// part.
void Dynamics::findLoose(double time) {
  const Index n = now_.points.size();
  loose_.follow(n, system_.isOriented() || !model_->links() ? nullptr : &model_->links()->stretchLinks());
  load_stiffness_.assign(n, 0.0);
  load_damping_.assign(n, 0.0);
  forces_on_all_.assign(n, Vec3::Zero());
  for (const solve::ExternalLoad* load : loads_.acting()) {
    if (load == &loads_.contact || load == &loads_.friction) continue;
    load->addRowBounds(time, now_.points, load_stiffness_, load_damping_);
    load->addForces(time, now_.points, forces_on_all_);
  }
  system_.confine(forces_on_all_);
  loose_.find(held_, load_stiffness_, forces_on_all_, now_.points.positions, loads_.contact, time);
}

// Returns the notice about loose parts if it is new.
std::string Dynamics::holdLoose() {
  if (loose_.numPoints() > 0)
    for (Index i = 0; i < now_.points.size(); ++i) {
      if (!loose_.isLoose(i)) continue;
      held_[i] = 1;
      now_.points.velocities[i].setZero();
    }
  const bool has_changed = loose_.numPoints() > 0 && loose_.numPoints() != told_.loose;
  told_.loose = loose_.numPoints();
  return has_changed ? loose_.describe() : "";
}

// Repeats the step from disturbed positions, on a copy: distance of its end from the equilibrium, m, infinity if it finds none.
// Zero if the equilibrium is near the start of the first search, which needs no second one; none if interrupted.
std::optional<double> Dynamics::searchAgain(double now, double disturbance, model::State& start) const {
  const Points& found = now_.points.positions;
  if (findLargestDistance(found, start.positions) < findSpacing(rest_->area, now_.points.size())) return 0.0;
  disturb(disturbance, start.positions);
  solve::TimeMarch second(system_, *model_, params_.integrator);
  second.setInterrupt(interrupt_);
  const solve::TimeMarch::Outcome taken = second.step(now, start);
  if (interrupt_ && *interrupt_) return {};
  if (!taken.ok || !taken.report.converged) return std::numeric_limits<double>::infinity();
  // The first search may have been one without contact: the second one must not have passed through the surface.
  const bool has_passed =
      loads_.self_contact && !system_.motionLimit() && !loads_.self_contact->contact.staysApart(found, start.positions);
  return has_passed ? std::numeric_limits<double>::infinity() : findLargestDistance(found, start.positions);
}

Grips::Update Dynamics::updateGrips(double now, double dt) {
  if (grips_.readForces()) system_.computeForcesOnAll(now, now_.points, forces_on_all_);
  Grips::Update update = grips_.update(now, kTimeRounding * dt, now_.points, now_.pinned, forces_on_all_);
  appendNotice(update.notice, clampGrips(update.begun));
  if (update.changed) clampHeld();
  grips_.carry(now, dt, params_.integrator.type == solve::IntegratorType::kStatic, now_.points, held_);
  return update;
}

// Before the step: changes of the model beside the motion.
std::string Dynamics::live(double now, double dt) {
  const bool had_points = now_.points.size() > 0;
  const Evolution::Change change = evolution_->beforeStep(now, dt, tools_, now_.points);
  if (change.has_energy) march_.restart();
  followPopulation(change.population);
  std::string notice = change.population.notice;
  if (had_points && now_.points.size() == 0)
    appendNotice(notice, "the last particle has been removed: nothing is left that could move");
  return notice;
}

}  // namespace deformable_surface::simulation
