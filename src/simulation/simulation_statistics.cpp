// Statistics of a simulation, and the surface of its state. Both are computed only on
// demand.
#include "simulation_impl.h"

#include <algorithm>
#include <cmath>

#include "tool_reach.h"

namespace deformable_surface::simulation {

// Quantities of the state, computed on demand.
const Statistics& Simulation::Impl::measure() {
  statistics.simulation_time = dynamics().time();
  statistics.step = dynamics().stepCount();
  if (measured_revision != dynamics().revision()) measureState();
  measured_revision = dynamics().revision();
  listSkipped();
  return statistics;
}

void Simulation::Impl::measureState() {
  const Dynamics& now = dynamics();
  const model::State& state = now.state();
  const model::DeformableModel& model = now.model();
  statistics.points = static_cast<std::uint32_t>(input.positions.size());
  statistics.simulation_points = static_cast<std::uint32_t>(state.size());
  statistics.awake = 0;
  for (Index i = 0; i < state.size(); ++i) statistics.awake += !now.held()[i] && now.activity().isMoving(i);
  statistics.kinetic_energy = now.system().kineticEnergy(state);
  statistics.elastic_energy = model.elasticEnergy(state);
  // After the energies, which find the links of this state.
  statistics.links = static_cast<std::uint32_t>(stretchLinksOf(model).size() + bendLinksOf(model).size());
  statistics.potential_energy = now.system().loadPotential(now.time(), state) + now.loads().frictionEnergy(now.time(), state);
  statistics.max_stretch = maxStretchOf(model, state);
  double squared_speed = 0.0;
  for (const Vec3& v : state.velocities) squared_speed = std::max(squared_speed, v.squaredNorm());
  statistics.max_speed = std::sqrt(squared_speed);
  statistics.has_snapped = now.hasSnapped();
  statistics.tracking_residual = now.loads().track.residual(state);
  statistics.tracked_points = static_cast<std::uint32_t>(now.loads().track.seen().size());
  if (SelfContactLoads* const self = now.loads().self_contact.get()) {
    statistics.self_contacts = static_cast<std::uint32_t>(self->contact.countTouching(state.positions));
    statistics.self_distance = self->contact.leastDistance(state.positions);
    statistics.stopped_points = static_cast<std::uint32_t>(self->numStopped());
  }
  statistics.state_hash = now.stateHash();
  readEstimate(statistics);
}

// A viewer has no estimate of its own: its statistics came with the sight.
void Simulation::Impl::readEstimate(Statistics& into) const {
  const ErrorEstimator* const estimator = run.estimator();
  if (!estimator) return;
  into.error_time = run.timeError();
  into.error_space = estimator->space();
  into.error_transfer = estimator->transfer();
  into.error_stiffness = softening;
  into.error_calibrated = estimator->isCalibrated();
  into.error_bounded = estimator->isBounded();
  into.may_buckle = estimator->mayBuckle();
  into.error_estimate = estimator->total() + softening + dynamics().activity().lost();
}

// Of a simulation, not of a viewer.
LocalErrors Simulation::Impl::findLocalErrors() const {
  LocalErrors errors;
  Statistics now;
  readEstimate(now);
  errors.most = now.error_estimate;
  if (!run.estimator()) return errors;
  errors.apart = run.estimator()->apart();
  errors.everywhere = now.error_time + run.estimator()->others() + softening;
  return errors;
}

void Simulation::Impl::listSkipped() {
  const Dynamics& now = dynamics();
  std::vector<std::string>& skipped = statistics.skipped;
  const auto list = [&](bool is_skipped, const char* stage) {
    if (is_skipped) skipped.push_back(stage);
  };
  skipped.clear();
  list(now.activity().isAsleep(), "step");
  list(!now.activity().isAsleep() && !now.activity().isWhole(), "sleeping");
  list(!run.estimator() && !is_estimated_elsewhere, "error_estimate");
  list(!surface.isMade(), "transfer");
  list(!surface.hasNormals(), "normals");
  list(surface.isMade() && surface.hasRested(), "resting_tiles");
  list(now.loads().gravity.isEmpty(), "gravity");
  list(now.loads().pressure.isEmpty(), "pressure");
  list(now.loads().drag.isEmpty(), "drag");
  list(now.params().anchors.empty(), "anchors");
  bool may_touch = false;
  const ContactLoad& contact = now.loads().contact;
  const auto& touches = contact.findTouches(now.time(), now.state());
  for (std::size_t b = 0; b < contact.all().size() && !may_touch; ++b)
    may_touch = !contact.all()[b].passed.empty() || isInReach(contact.all()[b].tool, now.time(), now.state().positions) ||
                !touches[b].empty();
  list(!may_touch, "contact");
  list(now.loads().self_contact && !now.loads().self_contact->mayAct(), "self_contact");
}

// Steps that were not taken as meant, since rest.
void Simulation::Impl::countSteps(const EstimatedDynamics::Outcome& taken) {
  const solve::SolveReport& report = taken.report;
  const SelfContactLoads* const self = dynamics().loads().self_contact.get();
  statistics.stopped_steps += self && self->numStopped() > 0;
  statistics.halted_steps += report.halted > 0;
  statistics.retried_steps += taken.retried.kind != solve::StepFailure::Kind::kNone;
  statistics.fallback_steps += report.fallbacks > 0;
}

// Results and costs of a step.
void Simulation::Impl::takeStatistics(const EstimatedDynamics::Outcome& taken, double seconds) {
  const solve::SolveReport& report = taken.report;
  if (!taken.has_slept) countSteps(taken);
  statistics.substeps = static_cast<std::uint32_t>(report.substeps);
  statistics.solver_iterations = static_cast<std::uint32_t>(report.iterations);
  if (!taken.has_slept) statistics.is_quasi_newton = report.is_quasi_newton;
  statistics.solver_residual = report.residual;
  statistics.time_forces = report.time_forces;
  statistics.time_contact = taken.contact_seconds;
  statistics.time_estimate = taken.estimate_seconds;
  statistics.time_total = seconds;
  statistics.time_solve = taken.has_slept ? 0.0 : seconds - report.time_forces - taken.estimate_seconds;
  statistics.real_time_factor = dynamics().params().integrator.time_step / seconds;
  statistics.time_transfer = statistics.time_normals = 0.0;
}

const Surface& Simulation::Impl::makeSurface(bool with_normals) {
  const model::State& state = dynamics().state();
  const bool wants_normals = with_normals && dynamics().params().output.normals;
  if (surface.isMade() && (surface.hasNormals() || !wants_normals)) return surface.make(state, with_normals);
  const Timer timer;
  const Surface& made = surface.make(state, with_normals);
  if (dynamics().params().output.error) surface.setErrors(seen_errors ? *seen_errors : findLocalErrors());
  // The operator makes both in one pass; the time counts for what was asked for.
  (wants_normals ? statistics.time_normals : statistics.time_transfer) = timer.seconds();
  return made;
}

}  // namespace deformable_surface::simulation
