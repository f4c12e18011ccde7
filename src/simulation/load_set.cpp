#include "load_set.h"

#include "renumber_points.h"

namespace deformable_surface::simulation {

LoadSet::LoadSet(const model::DeformableModel& model, const SceneParams& params)
    : gravity(model.masses(), params.gravity),
      pressure(model, params.pressure),
      drag(model, params.viscous_drag),
      forces(model.masses()),
      contact(model.masses()),
      contact_damping(contact, params.integrator.type == solve::IntegratorType::kImplicit),
      friction(contact),
      track(model.masses(), params.input.tracking_gain),
      guide(model, params.oriented_particles.guide) {}

void LoadSet::choose() {
  acting_.clear();
  const auto add = [&](const auto& load) {
    if (!load.isEmpty()) acting_.push_back(&load);
  };
  add(gravity);
  acting_.push_back(&forces);  // windows of time open and close between steps
  add(pressure);
  add(drag);
  add(anchors);
  add(contact);
  add(contact_damping);
  add(friction);
  add(track);
  add(guide);
  if (!self_contact) return;
  if (self_contact->pushes()) acting_.push_back(&self_contact->untangling);
  if (!self_contact->mayAct()) return;
  acting_.push_back(&self_contact->springs);
  acting_.push_back(&self_contact->damping);
  if (self_contact->rubs()) acting_.push_back(&self_contact->friction);
}

double LoadSet::frictionEnergy(double time, const model::State& state) const {
  const double on_tools = friction.isEmpty() ? 0.0 : friction.energy(time, state);
  if (!self_contact || !self_contact->mayAct() || !self_contact->rubs()) return on_tools;
  return on_tools + self_contact->contact.frictionEnergy(state.positions, state.self_friction);
}

void LoadSet::takePart(const LoadSet& whole, const std::vector<Index>& new_index) {
  gravity.gravity = whole.gravity.gravity;
  anchors = whole.anchors;
  anchors.renumber(new_index);
  // If a force acts on other points as well, each point here keeps its share.
  std::vector<NamedForces::Named> shared = whole.forces.all();
  for (NamedForces::Named& force : shared) {
    renumberPoints(new_index, force.points, force.shares);
    force.carriers.reset();  // they are the whole's: it tells which points they act on
  }
  forces.restore(shared);
  contact.takePart(whole.contact, new_index);
  choose();
}

}  // namespace deformable_surface::simulation
