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

std::shared_ptr<const Snapshot::Contents> Simulation::Impl::save(bool is_sight) const {
  Statistics now = statistics;
  readEstimate(now);
  return std::make_shared<const Snapshot::Contents>(
      Snapshot::Contents{scene_hash,
                         state,
                         steps,
                         time(),
                         pinned,
                         pinned_turns,
                         gravity.gravity,
                         forces.all(),
                         tools,
                         values,
                         membrane_share,
                         softening,
                         params.integrator.type,
                         particles ? particles->lattice().spacing : 0.0,
                         findPhysics(params),
                         system.damping(),
                         contact_rate,
                         grips.all(),
                         contact.all(),
                         cutting ? cutting->cuts() : std::vector<model::MassSpring::Link>(),
                         surface.saveCut(),
                         track.seen(),
                         march.memory(),
                         part ? part->march().memory() : part_march,
                         part && !activity.isAsleep(),
                         followed,
                         activity.memory(),
                         tool_watch.memory(),
                         surface.saveInserted(),
                         estimator && !is_sight ? estimator->memory() : nullptr,
                         std::move(now),
                         is_sight,
                         estimator != nullptr,
                         surface.revision()});
}

void Simulation::Impl::restore(const Snapshot::Contents& saved) {
  if (cutting) cutting->setCuts(saved.cuts);
  state = saved.state;
  if (particles && particles->lattice().spacing != saved.spacing) particles->setSpacing(saved.spacing);
  model->adopt(state);
  placeAnchors();
  steps = saved.steps;
  pinned = saved.pinned;
  pinned_turns = saved.pinned_turns;
  clampHeld();
  values = saved.values;
  membrane_share = saved.membrane_share;
  softening = saved.softening;
  setPhysics(saved.physics, params);
  takePhysics();
  contact_rate = saved.contact_rate;
  contact.setRate(contact_rate);
  setDamping(saved.damping);
  gravity.gravity = saved.gravity;
  forces.restore(saved.forces);
  track.restore(saved.seen);
  part.reset();
  setTools(saved.tools);
  params.integrator.type = saved.integrator;
  share_notice.clear();
  grips.restore(saved.grips);
  contact.restore(saved.bodies);
  march.setMemory(saved.march);
  part_march = saved.part_march;
  activity.setMemory(saved.activity, state);
  followed.clear();
  if (!saved.followed.empty() && activity.isInParts()) followPartners(saved.followed);
  if (saved.has_part && !is_viewer) makePart();
  tool_watch.setMemory(saved.watched);
  changed();
  if (estimator && saved.estimate) estimator->setMemory(*saved.estimate);
  if (estimator && !saved.estimate) estimator->lose();
  // What a viewer has made of the same positions is as good as before.
  if (!is_viewer || seen_revision != saved.surface_revision) surface.invalidate();
  if (is_viewer) seen_revision = saved.surface_revision;
  surface.restoreInserted(saved.resampler);
  if (cutting) surface.restoreCut(saved.severed, model->stretchLinks());
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
  std::size_t sum = sizeof(Contents) + bytesOf(c.state.positions) + bytesOf(c.state.velocities) + bytesOf(c.state.orientations) +
                    bytesOf(c.state.spins) + bytesOf(c.state.traits) + bytesOf(c.state.plastic) + bytesOf(c.pinned) +
                    bytesOf(c.pinned_turns) + bytesOf(c.values) + bytesOf(c.seen) + bytesOf(c.followed) + bytesOf(c.cuts) +
                    bytesOf(c.activity.quiet) + bytesOf(c.activity.moves);
  if (c.severed) sum += bytesOf(*c.severed);
  for (const ContactLoad::Body& body : c.bodies) sum += sizeof body + bytesOf(body.tool.path) + bytesOf(body.passed);
  for (const ToolWatch::Seen& seen : c.watched) sum += sizeof seen;
  for (const NamedForces::Named& force : c.forces) sum += sizeof force + bytesOf(force.points) + bytesOf(force.shares);
  for (const tool::ToolParams& tool : c.tools) sum += sizeof tool + bytesOf(tool.path);
  for (const Grips::Grip& grip : c.grips)
    sum += sizeof grip + bytesOf(grip.tool.path) + bytesOf(grip.points) + bytesOf(grip.places);
  if (c.resampler) sum += c.resampler->bytes();
  if (c.estimate)
    sum += bytesOf(c.estimate->dents) + c.estimate->shadow.bytes() + c.estimate->twin.bytes() + c.estimate->verlet.bytes();
  return sum;
}

double Snapshot::time() const { return contents_ ? contents_->time : 0.0; }

}  // namespace deformable_surface::simulation
