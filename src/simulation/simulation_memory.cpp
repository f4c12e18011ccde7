// What a simulation hands out of itself: snapshots, and forks that go their own way. Apart from its life, because here stands
// what belongs to the state, what is shared for ever and what can be made anew.
#include "simulation_impl.h"

#include "deformable_surface/base/error.h"

namespace deformable_surface::simulation {
namespace {

template <class T>
std::size_t bytesOf(const std::vector<T>& items) {
  return items.size() * sizeof(T);
}

}  // namespace

// Of what stays the same from step to step: the points at rest, and the scene but for what no step reads. FNV-1a.
std::uint64_t Simulation::Impl::identify(const RestSurface& rest, const SceneParams& params) {
  SceneParams scene = params;
  scene.cloud = CloudParams();
  scene.duration = SceneParams().duration;
  scene.threads = 0;
  scene.save_directory.clear();
  scene.expect.clear();
  std::uint64_t h = kHashBegin;
  for (unsigned char c : toYaml(printParams(scene))) h = (h ^ c) * 1099511628211ull;
  h = hashPoints(rest.points, h);
  return hashPoints(rest.dense.positions, h);
}

// Both reuse the room of what they overwrite.
void Simulation::Impl::keepAsleep(Checkpoint& checkpoint) const {
  checkpoint.forces = forces.all();
  checkpoint.watched = tool_watch.memory();
  checkpoint.activity = activity.memory();
  checkpoint.march = march.memory();
  checkpoint.part_march = part ? part->march().memory() : part_march;
  checkpoint.has_part = part && !activity.isAsleep();
}

void Simulation::Impl::keepAwake(Checkpoint& checkpoint) const {
  checkpoint.state = state;
  checkpoint.steps = steps;
  checkpoint.pinned = pinned;
  checkpoint.pinned_turns = pinned_turns;
  checkpoint.clamp_edges = clamp_edges;
  checkpoint.membrane_share = membrane_share;
  checkpoint.softening = softening;
  checkpoint.integrator = params.integrator.type;
  checkpoint.contact_rate = contact_rate;
  checkpoint.grips = grips.all();
  checkpoint.bodies = contact.all();
  if (cutting) checkpoint.cuts = cutting->cuts();
  checkpoint.severed = surface.saveCut();
  checkpoint.seen = track.seen();
  checkpoint.followed = followed;
}

void Simulation::Impl::giveBack(const Checkpoint& checkpoint) {
  if (cutting) cutting->setCuts(checkpoint.cuts);
  pinned = checkpoint.pinned;
  pinned_turns = checkpoint.pinned_turns;
  clamp_edges = checkpoint.clamp_edges;
  state = checkpoint.state;
  model->adopt(state);
  placeAnchors();
  clampHeld();
  state = checkpoint.state;  // cold particles may have been moving
  steps = checkpoint.steps;
  membrane_share = checkpoint.membrane_share;
  softening = checkpoint.softening;
  params.integrator.type = checkpoint.integrator;
  applyMaterial();
  contact_rate = checkpoint.contact_rate;
  contact.setRate(contact_rate);
  forces.restore(checkpoint.forces);
  track.restore(checkpoint.seen);
  grips.restore(checkpoint.grips);
  contact.restore(checkpoint.bodies);
  chooseLoads();
  setParts();
  part.reset();
  march.setMemory(checkpoint.march);
  part_march = checkpoint.part_march;
  activity.setMemory(checkpoint.activity, state);
  followed.clear();
  if (!checkpoint.followed.empty() && activity.isInParts()) followPartners(checkpoint.followed);
  if (checkpoint.has_part && !is_viewer) makePart();
  tool_watch.setMemory(checkpoint.watched);
  if (cutting) surface.restoreCut(checkpoint.severed, model->stretchLinks());
  changed();
}

std::shared_ptr<const Snapshot::Contents> Simulation::Impl::save(bool is_sight) const {
  auto saved = std::make_shared<Snapshot::Contents>();
  saved->scene = scene_hash;
  keepAsleep(saved->checkpoint);
  keepAwake(saved->checkpoint);
  saved->time = time();
  saved->gravity = gravity.gravity;
  saved->tools = tools;
  saved->values = values;
  saved->spacing = particles ? particles->lattice().spacing : 0.0;
  saved->physics = findPhysics(params);
  saved->damping = system.damping();
  saved->resampler = surface.saveInserted();
  saved->estimate = estimator && !is_sight ? estimator->memory() : nullptr;
  saved->statistics = statistics;
  readEstimate(saved->statistics);
  saved->is_sight = is_sight;
  saved->is_estimated = estimator != nullptr;
  saved->surface_revision = surface.revision();
  return saved;
}

void Simulation::Impl::restore(const Snapshot::Contents& saved) {
  if (particles && particles->lattice().spacing != saved.spacing) particles->setSpacing(saved.spacing);
  values = saved.values;
  membrane_share = saved.checkpoint.membrane_share;
  setPhysics(saved.physics, params);
  takePhysics();
  contact_rate = saved.checkpoint.contact_rate;
  setDamping(saved.damping);
  gravity.gravity = saved.gravity;
  setTools(saved.tools);
  giveBack(saved.checkpoint);
  share_notice.clear();
  if (estimator && saved.estimate) estimator->setMemory(*saved.estimate);
  if (estimator && !saved.estimate) estimator->lose();
  // What a viewer has made of the same positions is as good as before.
  if (!is_viewer || seen_revision != saved.surface_revision) surface.invalidate();
  if (is_viewer) seen_revision = saved.surface_revision;
  surface.restoreInserted(saved.resampler);
  statistics = saved.statistics;
  is_estimated_elsewhere = is_viewer && saved.is_estimated;
}

std::unique_ptr<Simulation::Impl> Simulation::Impl::fork(bool to_view) const {
  std::unique_ptr<model::DeformableModel> copy = model->clone();
  if (!copy) throw InputError("model: found one that cannot be copied; accepted: one of this package");
  auto fork = std::make_unique<Impl>(params, shared_input, std::move(copy), shared_rest);
  if (fork->particles) fork->life = std::make_unique<ParticleLife>(*fork->particles);
  fork->notes = notes;
  fork->choice = choice;
  fork->is_wish_missed = is_wish_missed;
  fork->shares = shares;
  fork->made = made;
  fork->chosen_membrane_share = chosen_membrane_share;
  fork->chosen_integrator = chosen_integrator;
  fork->scene_hash = scene_hash;
  fork->is_viewer = to_view;
  if (estimator && !to_view) fork->estimator = std::make_unique<ErrorEstimator>(*estimator);
  fork->restore(*save(to_view));
  return fork;
}

Snapshot Simulation::snapshot() const {
  Snapshot snapshot;
  snapshot.contents_ = impl_->save(false);
  return snapshot;
}

Snapshot Simulation::sight() const {
  Snapshot sight;
  sight.contents_ = impl_->save(true);
  return sight;
}

void Simulation::restore(const Snapshot& snapshot) {
  if (!snapshot.contents_) throw InputError("snapshot: found one of nothing; accepted: one that this surface gave");
  if (snapshot.contents_->scene != impl_->scene_hash)
    throw InputError("snapshot: found one of another surface or scene; accepted: those of this cloud with these parameters");
  if (snapshot.contents_->is_sight && !impl_->is_viewer)
    throw InputError("snapshot: found a sight, which is without what steps need; accepted: a snapshot");
  impl_->restore(*snapshot.contents_);
}

Simulation::Simulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Simulation Simulation::fork() const { return Simulation(impl_->fork(false)); }
Simulation Simulation::viewer() const { return Simulation(impl_->fork(true)); }

std::size_t Snapshot::bytes() const {
  if (!contents_) return 0;
  const Contents& c = *contents_;
  const Checkpoint& m = c.checkpoint;
  std::size_t sum = sizeof(Contents) + bytesOf(m.state.positions) + bytesOf(m.state.velocities) +
                    bytesOf(m.state.orientations) + bytesOf(m.state.spins) + bytesOf(m.state.traits) + bytesOf(m.state.plastic) +
                    bytesOf(m.pinned) + bytesOf(m.pinned_turns) + bytesOf(m.clamp_edges) + bytesOf(c.values) + bytesOf(m.seen) +
                    bytesOf(m.followed) + bytesOf(m.cuts) + bytesOf(m.activity.quiet) + bytesOf(m.activity.moves);
  if (m.severed) sum += bytesOf(*m.severed);
  for (const ContactLoad::Body& body : m.bodies) sum += sizeof body + bytesOf(body.tool.path) + bytesOf(body.passed);
  for (const ToolWatch::Seen& seen : m.watched) sum += sizeof seen;
  for (const NamedForces::Named& force : m.forces) sum += sizeof force + bytesOf(force.points) + bytesOf(force.shares);
  for (const tool::ToolParams& tool : c.tools) sum += sizeof tool + bytesOf(tool.path);
  for (const Grips::Grip& grip : m.grips)
    sum += sizeof grip + bytesOf(grip.tool.path) + bytesOf(grip.points) + bytesOf(grip.places);
  if (c.resampler) sum += c.resampler->bytes();
  if (c.estimate)
    sum += bytesOf(c.estimate->dents) + c.estimate->shadow.bytes() + c.estimate->twin.bytes() + c.estimate->verlet.bytes();
  return sum;
}

double Snapshot::time() const { return contents_ ? contents_->time : 0.0; }

}  // namespace deformable_surface::simulation
