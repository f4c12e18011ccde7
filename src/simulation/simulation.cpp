// The simulation: passes commands and steps to its dynamics, and updates what is displayed.
#include "simulation_impl.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/params.h"
#include "deformable_surface/base/step_time.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "accuracy.h"
#include "accuracy_probe.h"
#include "command_checks.h"
#include "rest_parts.h"
#include "spacing.h"
#include "step_messages.h"

namespace deformable_surface::simulation {
namespace {

template <class... Kinds>
bool isOne(const Command& command) {
  return (std::holds_alternative<Kinds>(command) || ...);
}

/// What a scene file would not be accepted with is not accepted from a program either.
const SceneParams& checked(const SceneParams& params) {
  std::vector<std::string> problems = checkParams(params);
  if (!problems.empty()) throw InputError(std::move(problems));
  return params;
}

constexpr double kHaltedShare = 0.5;  // of the sub-steps of a step: from here on the motion is told to be wrong
// Sub-steps between two looks for parts that pass through each other. A look takes about as long as twelve of them, a step
// besides its sub-steps as long as some, an implicit one as thirty or more.
constexpr Index kSubstepsPerLook = 400, kOfStep = 4, kOfImplicitStep = 30;
// Contact that stops fewer points than this share, and holds no carried point back by more spacings, changes what few see. In
// sheets that were lifted, folded and grasped it stopped up to 0.094 of the points, in jams and jumps 0.22 to 1.
constexpr double kManyStopped = 0.15, kFarBehind = 0.5;
constexpr Index kFewestPassed = 8;     // triangles: fewer crumple, as where one point is pulled
constexpr double kThickContact = 1.5;  // spacings: at two a run took four times as long as at a half

// Refuses lengths in millimetres for metres, for example. Warns of a thickness that makes steps slow.
void checkContactThickness(const SceneParams& params, const RestSurface& surface, std::vector<std::string>& warnings) {
  const Points& rest = surface.points;
  const double thickness = findContactThickness(params, surface);
  Eigen::AlignedBox3d box;
  for (const Vec3& p : rest) box.extend(p);
  const double extent = box.sizes().maxCoeff();
  if (thickness >= extent)
    throw InputError("contact.thickness: found " + formatShort(thickness) + " m" +
                     (params.contact.thickness.is_auto ? " (material.thickness)" : "") + "; accepted: below " +
                     formatShort(extent) + " m, the largest extent of the surface");
  const double spacing = findSpacing(surface.area, rest.size());
  if (thickness > kThickContact * spacing)
    warnings.push_back(
        "contact.thickness is " + formatShort(std::round(10.0 * thickness / spacing) / 10.0) +
        " times the spacing of the simulation points: each has many others in reach, and steps are slow; half of a "
        "spacing or less is faster");
}

bool doesAnyTouch(const Dynamics& dynamics) { return !dynamics.contacts().empty() || !dynamics.selfTouches().empty(); }

// What a step takes, as so many sub-steps.
Index costOf(const solve::SolveReport& report) { return kOfStep + (report.iterations > 0 ? kOfImplicitStep : report.substeps); }

}  // namespace

Simulation::Impl::Impl(const SceneParams& params, cloud::PointCloud&& cloud, RestSurface&& rest, AccuracyChoice&& chosen)
    : shared_input(std::make_shared<const cloud::PointCloud>(std::move(cloud))),
      run(params, std::move(rest)),
      surface(dynamics().rest(), input, dynamics().params(), dynamics().makeFollower()) {
  scene_hash = identify(dynamics().rest(), params);
  choice = std::move(chosen);
  notes = params.notices;
  const std::vector<std::string>& built = dynamics().rest().notes;
  notes.insert(notes.end(), built.begin(), built.end());
  warnings = dynamics().rest().warnings;
  if (dynamics().loads().self_contact) checkContactThickness(params, dynamics().rest(), warnings);
  dynamics().setCutFollower(&surface);
  if (!dynamics().growthNotice().empty()) notes.push_back(dynamics().growthNotice());
  if (!dynamics().growthWarning().empty()) warnings.push_back(dynamics().growthWarning());
  if (params.integrator.type == solve::IntegratorType::kAuto && choice.integrator != solve::IntegratorType::kAuto)
    dynamics().chooseIntegrator(choice.integrator);
  const ModelKind& kind = dynamics().kind();
  if (isSelfContactOff()) {
    const RestSurface& rest = dynamics().rest();
    const bool is_in_space = rest.across.isZero(0.0);
    notes.push_back("contact.self: auto is off, and parts can pass through each other: " + dynamics().whyNoSelfContact() +
                    (is_in_space ? "; true switches it on" : ""));
    if (is_in_space) passages.emplace(rest.points, dynamics().skinWithoutContact());
  }
  const std::string refused = kind.refuseEstimate(params);
  if (params.accuracy.estimate && !refused.empty())
    notes.push_back(std::string("no error estimate: model ") + kind.name() + " " + refused);
  try {
    if (params.accuracy.estimate && refused.empty()) run.estimateError();
  } catch (const InputError& problem) {
    notes.push_back(std::string("no error estimate, because its coarser copies cannot be built: ") + problem.what());
  }
  if (choice.membrane_share < 1.0) run.softenMembrane(choice.membrane_share);
  run.expectFirstStep(std::move(choice.first_step));
  surface.reset();
}

// Whether `auto` has left it off.
bool Simulation::Impl::isSelfContactOff() const {
  return dynamics().params().contact.self.is_auto && dynamics().kind().traits().meets_itself && !dynamics().loads().self_contact;
}

Changes Simulation::Impl::apply(const Command& command) {
  check(command, dynamics());
  Changes changes = run.apply(command);
  if (!changes.done) return changes;
  was_commanded = true;
  if (isOne<command::Observe>(command)) tracking.see(static_cast<Index>(dynamics().loads().track.seen().size()));
  if (changes.moved || isOne<command::SetParams>(command)) surface.invalidate();
  const bool is_tool = isOne<command::SetTool, command::MoveTool, command::RemoveTool>(command) && !dynamics().tools().empty();
  leaveTrial(is_tool ? "a tool came" : isOne<command::SetState>(command) ? "a state was given" : "a command came");
  return changes;
}

// From now on the run differs from the trial.
void Simulation::Impl::leaveTrial(const char* how) {
  if (!(dynamics().params().accuracy.position_error > 0.0)) return;
  const std::string why = std::string(how) + ", and the trials of accuracy.position_error do not cover what follows";
  const double share = dynamics().membraneShare();
  if (share < 1.0) {
    trial_notice = "the membrane has its stated stiffness again, no longer " + formatReal(share) + " of it: " + why;
    run.stiffenMembrane();
  }
  if (!dynamics().hasChosenIntegrator()) return;
  dynamics().setIntegrator(solve::IntegratorType::kAuto);
  appendNotice(trial_notice, "integrator.type is auto again: " + why);
}

void Simulation::Impl::reset() {
  run.reset();
  const std::string& grown = dynamics().growthNotice();
  if (!grown.empty() && std::find(notes.begin(), notes.end(), grown) == notes.end()) notes.push_back(grown);
  const std::string& warning = dynamics().growthWarning();
  if (!warning.empty() && std::find(warnings.begin(), warnings.end(), warning) == warnings.end()) warnings.push_back(warning);
  softening = 0.0;
  trial_notice.clear();
  lasting.clear();
  fallbacks.clear();
  stretched.clear();
  is_target_missed = is_target_kept = was_commanded = is_passage_told = false;
  substeps_since_look = 0;
  largest_error = 0.0;
  tracking = {};
  surface.reset();
  statistics = Statistics{};
  measured_revision.reset();
}

StepOutcome Simulation::Impl::step() {
  const Timer timer;
  const double dt = dynamics().params().integrator.time_step, now = dynamics().time();
  StepOutcome outcome;
  EstimatedDynamics::Outcome taken;
  if (!run.beginStep()) {
    taken = run.passStep();
  } else {
    if (now + kTimeRounding * dt >= dynamics().params().duration) leaveTrial("the duration of the scene is over");
    outcome.notice = std::exchange(trial_notice, {});
    const std::shared_ptr<const CutTransfer::Memory> severed = surface.saveCut();
    const auto giveBack = [&] { surface.restoreCut(severed, stretchLinksOf(dynamics().model())); };
    try {
      taken = run.takeStep();
    } catch (...) {
      giveBack();
      throw;
    }
    if (!taken.ok) giveBack();
  }
  if (taken.ok && !taken.has_slept) finishStep(taken);
  if (taken.ok) takeStatistics(taken, timer.seconds());
  appendNotice(outcome.notice, taken.notice);
  outcome.ok = taken.ok;
  outcome.has_converged = taken.report.converged;
  outcome.was_retried = taken.retried.kind != solve::StepFailure::Kind::kNone;
  if (taken.ok) {
    appendNotice(outcome.notice, tellTargetKept());
    appendNotice(outcome.notice, tellWhatLasts(taken));
    appendNotice(outcome.notice, tellStretch(taken));
    if (!taken.has_slept) appendNotice(outcome.notice, tellPassage(taken));
    if (fallbacks.endStep(dynamics().time(), dt, taken.report.fallbacks > 0))
      appendNotice(outcome.notice, describeFallbacks(dynamics().lastIntegrator(), fallbacks.count(), fallbacks.steps()));
    outcome.notice = lasting.endStep(now, dt, taken.is_static, outcome.notice);
  }
  if (!taken.ok)
    outcome.problem = "step " + std::to_string(dynamics().stepCount() + 1) + " at " + formatReal(now) + " s " + taken.failure +
                      "; the state before it is kept";
  return outcome;
}

// The beginnings, with the place if contact stopped points.
std::string Simulation::Impl::tellWhatLasts(const EstimatedDynamics::Outcome& taken) {
  const solve::SolveReport& report = taken.report;
  const SelfContactLoads* const self = dynamics().loads().self_contact.get();
  const Index stopped = self && !taken.has_slept ? self->numStopped() : 0;
  std::string begun;
  const bool are_many = static_cast<double>(stopped) >= kManyStopped * static_cast<double>(dynamics().state().size());
  if (stopped > 0 && lasting.see(Lasting::kStopped, static_cast<double>(stopped),
                                 are_many || dynamics().measureLag() > kFarBehind * dynamics().activity().spacing()))
    appendNotice(begun,
                 "parts meet faster, or press harder, than the springs of contact can stop: contact limits the motion of "
                 "points, which takes energy (statistics: stopped_points); slower paths of what pushes and holds, and more room "
                 "between, help");
  if (report.halted > kHaltedShare * report.substeps && lasting.see(Lasting::kHalted)) appendNotice(begun, describeHalt(report));
  if (taken.retried.kind != solve::StepFailure::Kind::kNone && lasting.see(Lasting::kRetried))
    appendNotice(begun, describeRetry(taken.retried, taken.is_retried_implicitly, report.substeps));
  if (!report.converged && lasting.see(Lasting::kUnbalanced, report.unbalanced))
    appendNotice(begun, describeUnbalance(report, dynamics().params().integrator, taken.is_static,
                                          stopped > 0                ? Touch::kStopped
                                          : doesAnyTouch(dynamics()) ? Touch::kTouches
                                                                     : Touch::kNone));
  if (!begun.empty())
    if (const std::optional<Jam> jam = dynamics().findJam()) appendNotice(begun, describeJam(*jam));
  if (tracking.isLost() && lasting.see(Lasting::kUntracked))
    appendNotice(
        begun, "the tracked cloud shows " + std::to_string(tracking.last()) + " of " + std::to_string(dynamics().state().size()) +
                   " simulation points" + (tracking.most() > 0 ? ", and has shown " + std::to_string(tracking.most()) : "") +
                   ": the others move by physics alone, and fall if nothing else holds them; a surface that has left its "
                   "cloud does not come back before a reset or a new one (statistics: tracked_points)");
  return begun;
}

void Simulation::Impl::finishStep(EstimatedDynamics::Outcome& taken) {
  const std::uint64_t steps = dynamics().stepCount();
  if (dynamics().membraneShare() < 1.0 || dynamics().hasChosenIntegrator())
    if (steps <= choice.softening.size()) softening = choice.softening[steps - 1];
  surface.invalidate();
  surface.resample(dynamics().state());
  if (!run.estimator()) return;
  // The target was met in the trial but is missed now; reported once.
  const double target = dynamics().params().accuracy.position_error;
  const double error = run.estimator()->inRegions() + softening;
  const bool is_bounded = run.estimator()->isBounded() && std::isfinite(error);
  largest_error = std::max(largest_error, is_bounded ? error : std::numeric_limits<double>::infinity());
  if (!(target > 0.0 && choice.is_met && error > target && run.estimator()->isBounded()) || is_target_missed) return;
  appendNotice(taken.notice, "the expected error, " + formatReal(error) + " m, has grown beyond accuracy.position_error, " +
                                 formatReal(target) + " m");
  is_target_missed = true;
}

// At the end of the scene's duration.
bool Simulation::Impl::isAtEnd() const {
  const SceneParams& params = dynamics().params();
  return std::abs(dynamics().time() - params.duration) < 0.5 * params.integrator.time_step;
}

// Its beginning. Links of oriented particles come and go before they are as long.
std::string Simulation::Impl::tellStretch(const EstimatedDynamics::Outcome& taken) {
  if (dynamics().kind().traits().is_oriented) return {};
  if (!taken.has_slept)
    stretched.endStep(dynamics().model(), dynamics().state(), costOf(taken.report), taken.is_static || isAtEnd());
  if (!stretched.isOver() || !lasting.see(Lasting::kStretched, stretched.stretch())) return {};
  return describeOverstretch(findOverstretch(dynamics()));
}

// Once. Looks are far apart, so that they take next to no time.
std::string Simulation::Impl::tellPassage(const EstimatedDynamics::Outcome& taken) {
  if (is_passage_told || !passages) return {};
  substeps_since_look += costOf(taken.report);
  if (substeps_since_look < kSubstepsPerLook && !taken.is_static && !isAtEnd()) return {};
  substeps_since_look = 0;
  const bool is_surface = dynamics().kind().traits().is_surface;
  const auto found = passages->look(dynamics().state().positions, is_surface ? &trianglesOf(dynamics().model()) : nullptr);
  if (!found || found->triangles < kFewestPassed) return {};
  is_passage_told = true;
  return "parts of the surface have come to pass through each other (" +
         formatCount(found->triangles, "of its triangles are crossed by others, one of them near ") + formatPlace(found->place) +
         " m): contact.self: auto is off here; true keeps them apart";
}

// Once, at the end of the duration, of a target of which the choice could not tell whether it would be met.
std::string Simulation::Impl::tellTargetKept() {
  const SceneParams& params = dynamics().params();
  const double target = params.accuracy.position_error, dt = params.integrator.time_step;
  const double error = largest_error + dynamics().activity().lost();
  if (is_target_kept || !choice.is_asked || choice.is_met || !run.estimator() || !(target > 0.0 && error <= target)) return "";
  if (!(dynamics().time() + kTimeRounding * dt >= params.duration)) return "";
  is_target_kept = true;
  return "accuracy.position_error, " + formatReal(target) + " m, was met in all " + std::to_string(dynamics().stepCount()) +
         " steps, which trials could not tell: the expected error was at most " + formatShort(error) + " m, and a bound";
}

Simulation::Simulation(const SceneParams& params, cloud::PointCloud input) {
  AccuracyChoice choice;
  RestSurface rest = buildChosen(checked(params), input, choice);
  impl_ = std::make_unique<Impl>(params, std::move(input), std::move(rest), std::move(choice));
}
Simulation::Simulation(const SceneParams& params, cloud::PointCloud input, RestSurface&& prepared) {
  AccuracyChoice choice;
  RestSurface rest = buildChosen(checked(params), std::move(prepared), choice);
  impl_ = std::make_unique<Impl>(params, std::move(input), std::move(rest), std::move(choice));
}
Simulation Simulation::untried(const SceneParams& params, cloud::PointCloud input) {
  AccuracyChoice choice;
  RestSurface rest = buildUntried(checked(params), input, choice);
  return Simulation(std::make_unique<Impl>(params, std::move(input), std::move(rest), std::move(choice)));
}
Simulation::Simulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

StepOutcome Simulation::step() {
  if (impl_->is_viewer) return {false, "a viewer takes no steps", ""};
  return impl_->step();
}
void Simulation::setInterrupt(const std::atomic<bool>* interrupt) { impl_->run.setInterrupt(interrupt); }
std::string Simulation::lastingNotices() const { return impl_->lasting.endRun(); }
double Simulation::time() const { return dynamics().time(); }
std::uint64_t Simulation::stepCount() const { return dynamics().stepCount(); }
const SceneParams& Simulation::params() const { return dynamics().params(); }
const cloud::PointCloud& Simulation::input() const { return impl_->input; }
void Simulation::reset() { impl_->reset(); }

Changes Simulation::apply(const Command& command) { return impl_->apply(command); }
void Simulation::setState(const model::State& state) { apply(command::SetState{state}); }
void Simulation::setForce(const ForceParams& force) { apply(command::SetForce{force}); }
void Simulation::removeForce(const std::string& id) { apply(command::RemoveForce{id}); }
void Simulation::setTool(const tool::ToolParams& tool) { apply(command::SetTool{tool}); }
void Simulation::moveTool(const std::string& id, const std::vector<tool::WaypointParams>& path) {
  apply(command::MoveTool{id, path});
}
bool Simulation::removeTool(const std::string& id) { return apply(command::RemoveTool{id}).done; }
Index Simulation::pin(const geometry::Region& region, bool orientation) {
  return apply(command::Pin{region, orientation}).points;
}
Index Simulation::pinAlong(const std::string& id, const geometry::Region& region, const std::vector<tool::WaypointParams>& path) {
  return apply(command::PinAlong{id, region, path}).points;
}
void Simulation::movePin(const std::string& id, const std::vector<tool::WaypointParams>& path) {
  apply(command::MovePin{id, path});
}
Index Simulation::unpin(const geometry::Region& region) { return apply(command::Unpin{region}).points; }
void Simulation::setGravity(const Vec3& gravity) { apply(command::SetGravity{gravity}); }
Index Simulation::setMaterial(const geometry::Region* region, const MaterialChangeParams& change) {
  return apply(command::SetMaterial{region ? std::optional<geometry::Region>(*region) : std::nullopt, change}).points;
}
void Simulation::setDamping(double damping) { apply(command::SetDamping{damping}); }
void Simulation::observe(const cloud::PointCloud& cloud) { observe(std::make_shared<const ObservedCloud>(cloud)); }
void Simulation::observe(std::shared_ptr<const ObservedCloud> cloud) { apply(command::Observe{std::move(cloud)}); }
void Simulation::setParams(const SceneParams& params) { apply(command::SetParams{params}); }
std::vector<Index> Simulation::editParticles(const ParticleEdit& edit) { return apply(command::EditParticles{edit}).added; }
std::string Simulation::growSurface(const model::GrowthParams& growth) { return apply(command::GrowSurface{growth}).notice; }

std::vector<std::string> Simulation::forceIds() const {
  std::vector<std::string> ids;
  for (const NamedForces::Named& force : dynamics().loads().forces.all()) ids.push_back(force.params.id);
  return ids;
}
const std::vector<tool::WaypointParams>* Simulation::findPinPath(const std::string& id) const {
  const Grips::Grip* const pin = dynamics().grips().findPin(id);
  return pin ? &pin->tool.path : nullptr;
}
const std::vector<tool::ToolParams>& Simulation::tools() const { return dynamics().tools(); }
std::vector<ToolReaction> Simulation::toolReactions() const { return dynamics().toolReactions(); }
std::vector<Contact> Simulation::contacts() const { return dynamics().contacts(); }
std::vector<SelfTouch> Simulation::selfTouches() const { return dynamics().selfTouches(); }
std::vector<PinReaction> Simulation::pinReactions() const { return dynamics().pinReactions(); }
Index Simulation::numOwnMaterial() const { return dynamics().numOwnMaterial(); }
double Simulation::membraneShare() const { return dynamics().membraneShare(); }
solve::IntegratorType Simulation::lastIntegrator() const { return dynamics().lastIntegrator(); }

Dynamics& Simulation::dynamics() { return impl_->dynamics(); }
const Dynamics& Simulation::dynamics() const { return impl_->dynamics(); }
std::uint64_t Simulation::revision() const { return dynamics().revision(); }
std::uint64_t Simulation::surfaceRevision() const { return impl_->surface.revision(); }
const Surface& Simulation::surface(bool with_normals) { return impl_->makeSurface(with_normals); }
Statistics Simulation::statistics() const { return impl_->measure(); }
double Simulation::energyExcess() const { return dynamics().energyExcess(); }
std::uint64_t Simulation::stateHash() const { return dynamics().stateHash(); }
const model::State& Simulation::state() const { return dynamics().state(); }
const model::DeformableModel& Simulation::model() const { return dynamics().model(); }
Index Simulation::numFirst() const { return static_cast<Index>(dynamics().rest().points.size()); }
bool Simulation::isAsleep() const { return dynamics().activity().isAsleep(); }
bool Simulation::isLeftAlone() const { return isAsleep() && dynamics().loads().forces.all().empty() && tools().empty(); }
bool Simulation::hasSnapped() const { return dynamics().hasSnapped(); }
bool Simulation::isAwake(Index simulation_point) const { return dynamics().activity().isMoving(simulation_point); }
const std::vector<char>& Simulation::pinned() const { return dynamics().pinned(); }

void Simulation::computeSimulationNormals(Points& normals) const {
  const Points& at_rest = dynamics().rest().normals;
  computeAreaVectors(model(), state(), normals);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double area = normals[i].norm();
    normals[i] = area > 0.0 ? Vec3(normals[i] / area) : at_rest[std::min(i, at_rest.size() - 1)];
  }
}

std::vector<std::pair<Vec3, Vec3>> Simulation::activeForces() const { return dynamics().loads().forces.active(state()); }
bool Simulation::wasCommanded() const { return impl_->was_commanded; }
const AccuracyChoice& Simulation::accuracyChoice() const { return impl_->choice; }
const std::vector<std::string>& Simulation::buildNotes() const { return impl_->notes; }
const std::vector<std::string>& Simulation::buildWarnings() const { return impl_->warnings; }

}  // namespace deformable_surface::simulation
