// What is measured of a simulation's state, and the surface that is made of it. Apart from the step, because both are made only
// when somebody asks.
#include "simulation_impl.h"

#include <algorithm>
#include <cmath>

#include "tool_reach.h"

namespace deformable_surface::simulation {

// The quantities of the state, computed when asked for.
void Simulation::Impl::measure() {
  statistics.simulation_time = time();
  statistics.step = steps;
  if (!is_measured) measureState();
  is_measured = true;
  listSkipped();
}

void Simulation::Impl::measureState() {
  statistics.points = static_cast<std::uint32_t>(input.positions.size());
  statistics.simulation_points = static_cast<std::uint32_t>(state.size());
  statistics.springs = static_cast<std::uint32_t>(model->stretchLinks().size() + model->bendLinks().size());
  statistics.awake = 0;
  for (Index i = 0; i < state.size(); ++i) statistics.awake += !held[i] && activity.isMoving(i);
  statistics.kinetic_energy = system.kineticEnergy(state);
  statistics.elastic_energy = model->elasticEnergy(state);
  statistics.potential_energy = system.loadPotential(time(), state);
  statistics.max_stretch = model->maxStretch(state);
  double squared_speed = 0.0;
  for (const Vec3& v : state.velocities) squared_speed = std::max(squared_speed, v.squaredNorm());
  statistics.max_speed = std::sqrt(squared_speed);
  statistics.has_snapped = hasSnapped();
  statistics.track_residual = track.residual(state);
  statistics.track_points = static_cast<std::uint32_t>(track.seen().size());
  statistics.state_hash = hash();
  readEstimate(statistics);
}

bool Simulation::Impl::hasSnapped() const {
  // Many times what falling asleep may leave of a motion.
  constexpr double kStretched = 1e-3;
  if (params.model != ModelKind::kMassSpring || !activity.isAsleep()) return false;
  if (!gravity.gravity.isZero(0.0) || params.pressure != 0.0 || !params.anchors.empty() || !track.isEmpty()) return false;
  if (!forces.active(state).empty()) return false;
  for (Index i = 0; i < state.size(); ++i)
    if (held[i] && state.positions[i] != rest.points[i]) return false;
  std::vector<ToolReaction> reactions(tools.size());
  contact.addReactions(time(), state, reactions);
  if (std::any_of(reactions.begin(), reactions.end(), [](const ToolReaction& r) { return r.contacts > 0; })) return false;
  return model->maxStretch(state) > kStretched;
}

// A viewer has been told.
void Simulation::Impl::readEstimate(Statistics& into) const {
  if (!estimator) return;
  into.error_time = estimator->time() + activity.lost();
  into.error_space = estimator->space();
  into.error_transfer = estimator->transfer();
  into.error_softening = softening;
  into.error_calibrated = estimator->isCalibrated();
  into.may_buckle = estimator->mayBuckle();
  into.error_estimate = estimator->total() + softening + activity.lost();
}

void Simulation::Impl::listSkipped() {
  statistics.skipped.clear();
  if (activity.isAsleep()) statistics.skipped.push_back("step");
  if (!activity.isAsleep() && !activity.isWhole()) statistics.skipped.push_back("sleeping");
  if (!estimator && !is_estimated_elsewhere) statistics.skipped.push_back("error_estimate");
  if (!surface.isMade()) statistics.skipped.push_back("transfer");
  if (!surface.hasNormals()) statistics.skipped.push_back("normals");
  if (surface.isMade() && surface.hasRested()) statistics.skipped.push_back("resting_tiles");
  if (gravity.gravity.isZero(0.0)) statistics.skipped.push_back("gravity");
  if (params.pressure == 0.0) statistics.skipped.push_back("pressure");
  if (!(params.viscous_drag > 0.0)) statistics.skipped.push_back("drag");
  if (params.anchors.empty()) statistics.skipped.push_back("anchors");
  const auto touches = [&](const ContactLoad::Body& body) {
    return !body.passed.empty() || isInReach(body.tool, time(), state.positions);
  };
  if (std::none_of(contact.all().begin(), contact.all().end(), touches)) statistics.skipped.push_back("contact");
}

const Surface& Simulation::Impl::makeSurface(bool with_normals) {
  const bool wants_normals = with_normals && params.output.normals;
  if (surface.isMade() && (surface.hasNormals() || !wants_normals)) return surface.make(state, with_normals);
  const Timer timer;
  const Surface& made = surface.make(state, with_normals);
  // The operator makes both in one pass; the time counts as that of what was asked for.
  (wants_normals ? statistics.time_normals : statistics.time_transfer) = timer.seconds();
  return made;
}

}  // namespace deformable_surface::simulation
