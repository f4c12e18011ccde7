#include "simulation_impl.h"

#include "deformable_surface/base/error.h"

namespace deformable_surface::simulation {

Simulation::Simulation(const SceneParams& params, cloud::PointCloud input) {
  AccuracyChoice choice;
  RestSurface rest = buildChosen(params, input, choice);
  impl_ = Impl::make(params, std::move(input), std::move(rest));
  impl_->choice = std::move(choice);
  if (params.integrator.type == solve::IntegratorType::kAuto && impl_->choice.integrator != solve::IntegratorType::kAuto)
    impl_->params.integrator.type = impl_->chosen_integrator = impl_->choice.integrator;
  const bool has_estimate = params.accuracy.estimate && !impl_->particles;
  try {
    if (has_estimate) estimateError();
  } catch (const InputError& problem) {
    impl_->notes.push_back(std::string("no error estimate, because its coarser copies cannot be built: ") + problem.what());
  }
  if (impl_->choice.membrane_share < 1.0) softenMembrane(impl_->choice.membrane_share);
}
Simulation::Simulation(const SceneParams& params, RestSurface rest)
    : impl_(Impl::make(params, cloud::PointCloud(), std::move(rest))) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

StepOutcome Simulation::step() {
  if (impl_->is_viewer) return {false, "a viewer takes no steps", ""};
  return impl_->step();
}
void Simulation::undoStep() { impl_->undoStep(); }
double Simulation::time() const { return impl_->time(); }
std::uint64_t Simulation::stepCount() const { return impl_->steps; }
const SceneParams& Simulation::params() const { return impl_->params; }
const cloud::PointCloud& Simulation::input() const { return impl_->input; }
void Simulation::reset() { impl_->reset(); }

void Simulation::setInterrupt(const std::atomic<bool>* interrupt) {
  impl_->interrupt = interrupt;
  impl_->march.setInterrupt(interrupt);
  if (impl_->part) impl_->part->march().setInterrupt(interrupt);
  if (impl_->estimator) impl_->estimator->forward([&](Simulation& copy) { copy.setInterrupt(interrupt); });
}

void Simulation::setFineness(Index fineness) {
  impl_->fineness = fineness;
  impl_->march.setFineness(fineness);
  if (impl_->part) impl_->part->march().setFineness(fineness);
}
void Simulation::setIntegrator(solve::IntegratorType type) {
  if (impl_->params.integrator.type == type) return;
  impl_->params.integrator.type = type;
  impl_->wakeAll();
}
solve::IntegratorType Simulation::lastIntegrator() const { return impl_->lastMarch().lastType(); }
void Simulation::stiffenMembrane() { impl_->stiffenMembrane(""); }
double Simulation::membraneShare() const { return impl_->membrane_share; }
Index Simulation::lastSubsteps() const { return static_cast<Index>(impl_->statistics.substeps); }

std::uint64_t Simulation::revision() const { return impl_->revision; }
std::uint64_t Simulation::surfaceRevision() const { return impl_->surface.revision(); }
const Surface& Simulation::surface(bool with_normals) { return impl_->makeSurface(with_normals); }

Statistics Simulation::statistics() const {
  impl_->measure();
  return impl_->statistics;
}

std::uint64_t Simulation::stateHash() const { return impl_->hash(); }
const model::State& Simulation::state() const { return impl_->state; }
const model::DeformableModel& Simulation::model() const { return *impl_->model; }
const model::OrientedParticles* Simulation::particles() const { return impl_->particles; }
Index Simulation::numFirst() const { return static_cast<Index>(impl_->rest.points.size()); }
bool Simulation::isAsleep() const { return impl_->activity.isAsleep(); }
bool Simulation::isLeftAlone() const { return isAsleep() && impl_->forces.all().empty() && impl_->tools.empty(); }
bool Simulation::hasSnapped() const { return impl_->hasSnapped(); }
bool Simulation::isAwake(Index simulation_point) const { return impl_->activity.isMoving(simulation_point); }
const std::vector<char>& Simulation::pinned() const { return impl_->pinned; }

void Simulation::computeSimulationNormals(Points& normals) const {
  impl_->model->computeAreaVectors(impl_->state, normals);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double area = normals[i].norm();
    normals[i] = area > 0.0 ? Vec3(normals[i] / area) : impl_->rest.normals[std::min(i, impl_->rest.normals.size() - 1)];
  }
}

std::vector<std::pair<Vec3, Vec3>> Simulation::activeForces() const { return impl_->forces.active(impl_->state); }
const AccuracyChoice& Simulation::accuracyChoice() const { return impl_->choice; }
const std::vector<std::string>& Simulation::buildNotes() const { return impl_->notes; }
const std::vector<std::string>& Simulation::buildWarnings() const { return impl_->rest.warnings; }

}  // namespace deformable_surface::simulation
