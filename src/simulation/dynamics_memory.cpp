// What a dynamics stores for a refused step, saves to a snapshot and restores from one, and how it forks.
#include "dynamics.h"

#include "deformable_surface/base/error.h"
#include "state_hash.h"

namespace deformable_surface::simulation {

void Dynamics::keepWaiting(DynamicsState::Waiting& waiting) const {
  waiting.steps = steps_;
  waiting.forces = loads_.forces.all();
  waiting.watched = tool_watch_.memory();
  waiting.activity = activity_.memory();
  waiting.march = march_.memory();
  waiting.part_march = part_ ? part_->march().memory() : part_march_;
  waiting.has_part = part_ && !activity_.isAsleep();
}

void Dynamics::keepHolding(DynamicsState::Holding& holding) const {
  holding.integrator = params_.integrator.type;
  holding.grips = grips_.all();
  loads_.contact.copyAll(holding.bodies);
  holding.evolution = evolution_->memory();
  holding.tracked = loads_.track.seen();
  holding.self_contact = loads_.self_contact ? loads_.self_contact->memory() : SelfContactLoads::Memory();
  holding.untangling = untangling_;
}

DynamicsState Dynamics::save() const {
  DynamicsState saved;
  keepWaiting(saved.waiting);
  saved.motion = now_;
  keepHolding(saved.holding);
  saved.settings.tools = tools_;
  saved.settings.values = values_;
  saved.settings.gravity = loads_.gravity.gravity;
  saved.settings.damping = system_.damping();
  saved.settings.physics = findPhysics(params_);
  return saved;
}

void Dynamics::restore(const DynamicsState& saved, bool to_look) {
  const DynamicsState::Settings& settings = saved.settings;
  tools_ = settings.tools;
  values_ = settings.values;
  setPhysics(settings.physics, params_);
  loads_.gravity.gravity = settings.gravity;
  loads_.pressure.setPressure(params_.pressure);
  loads_.drag.setDrag(params_.viscous_drag);
  system_.setDamping(settings.damping);
  giveContactTools();
  giveBack(saved, to_look);
}

// For a refused step; for a snapshot, after its settings.
void Dynamics::giveBack(const DynamicsState& saved, bool to_look) {
  const auto& [waiting, motion, holding, settings] = saved;
  const bool was_cut = evolution_->memory() != nullptr;
  evolution_->setMemory(holding.evolution);
  if (was_cut || holding.evolution) followCuts();
  now_ = motion;
  placePointsBetween();
  adopt(*model_, now_.points);
  placeAnchors();
  grips_.restore(holding.grips);
  clampHeld();
  now_.points = motion.points;  // cold particles may have been moving
  steps_ = waiting.steps;
  params_.integrator.type = holding.integrator;
  applyMaterial();
  setContactRate(now_.contact_rate);
  loads_.forces.restore(waiting.forces);
  placeLoadPoints();
  loads_.track.restore(holding.tracked);
  loads_.contact.restore(holding.bodies);
  if (loads_.self_contact) loads_.self_contact->setMemory(holding.self_contact);
  findTangles();
  untangling_ = holding.untangling;
  loads_.choose();
  setParts();
  part_.reset();
  march_.setMemory(waiting.march);
  part_march_ = waiting.part_march;
  activity_.setMemory(waiting.activity, now_.points);
  now_.followed.clear();
  if (!motion.followed.empty() && activity_.isInParts()) followPartners(motion.followed);
  if (waiting.has_part && !to_look) makePart();
  tool_watch_.setMemory(waiting.watched);
  ++revision_;
}

std::unique_ptr<Dynamics> Dynamics::fork(bool to_look) const {
  const SelfContactLoads* const self = loads_.self_contact.get();
  SceneParams params = params_;
  params.integrator.type = chosen_.made_for;  // contact is made for it; restore() sets the one of now
  Made made{rest_, model_->clone(), self ? self->skin() : nullptr, true, self && self->contact.looksFirst()};
  made.areas = loads_.contact.points().areas();
  std::unique_ptr<Dynamics> fork(new Dynamics(params, std::move(made)));
  fork->chosen_ = chosen_;
  fork->shares_ = shares_;
  fork->growth_notice_ = growth_notice_;
  fork->growth_warning_ = growth_warning_;
  fork->has_between_ = has_between_;
  fork->num_links_ = num_links_;
  fork->has_load_points_ = has_load_points_;
  fork->loads_.forces.setLoadPoints(loads_.forces.loadPoints());
  fork->loads_.contact.setBetween(loads_.contact.points().sharedBetween());
  fork->restore(save(), to_look);
  return fork;
}

std::uint64_t Dynamics::stateHash() const { return evolution_->addToHash(hashState(now_.points)); }

}  // namespace deformable_surface::simulation
