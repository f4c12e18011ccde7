// Snapshots of a simulation, sights for viewers, and forks.
#include "simulation_impl.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/hash.h"

#include <limits>

#include "state_hash.h"

namespace deformable_surface::simulation {

// A hash of what does not change from step to step: the points at rest, and the scene without values that no step reads.
std::uint64_t Simulation::Impl::identify(const RestSurface& rest, const SceneParams& params) {
  SceneParams scene = params;
  scene.cloud = CloudParams();
  scene.duration = SceneParams().duration;
  scene.threads = 0;
  scene.accuracy.remember = AccuracyParams().remember;
  scene.save_directory.clear();
  scene.expect.clear();
  std::uint64_t h = kHashBegin;
  for (unsigned char c : toYaml(printParams(scene))) h = mixHash(h, c);
  h = hashPoints(rest.points, h);
  return hashPoints(rest.dense.positions, h);
}

Simulation::Impl::Impl(const Impl& other, bool to_view)
    : CopiedByForks(other),
      shared_input(other.shared_input),
      run(other.run, to_view),
      surface(dynamics().rest(), input, dynamics().params(), dynamics().makeFollower()),
      is_viewer(to_view) {
  dynamics().setCutFollower(&surface);
  restoreLooks(other.saveLooks());
}

Looks Simulation::Impl::saveLooks() const {
  Looks saved;
  saved.softening = softening;
  saved.severed = surface.saveCut();
  saved.resampler = surface.saveInserted();
  saved.statistics = statistics;
  readEstimate(saved.statistics);
  saved.is_estimated = run.estimator() != nullptr;
  if (dynamics().params().output.error) saved.errors = std::make_shared<const LocalErrors>(findLocalErrors());
  saved.surface_revision = surface.revision();
  return saved;
}

void Simulation::Impl::restoreLooks(const Looks& saved) {
  softening = saved.softening;
  surface.restoreCut(saved.severed, stretchLinksOf(dynamics().model()));
  // A viewer's surface of the same positions stays valid.
  if (!is_viewer || seen_revision != saved.surface_revision) surface.invalidate();
  if (is_viewer) {
    seen_revision = saved.surface_revision;
    seen_errors = saved.errors;
  }
  surface.restoreInserted(saved.resampler);
  statistics = saved.statistics;
  measured_revision.reset();
  is_estimated_elsewhere = is_viewer && saved.is_estimated;
}

std::shared_ptr<const Snapshot::Contents> Simulation::Impl::save(bool is_sight) const {
  auto saved = std::make_shared<Snapshot::Contents>();
  saved->scene = scene_hash;
  saved->time = dynamics().time();
  saved->is_sight = is_sight;
  saved->dynamics = dynamics().save();
  saved->looks = saveLooks();
  if (run.estimator() && !is_sight) saved->estimate = run.estimator()->memory();
  return saved;
}

void Simulation::Impl::restore(const Snapshot::Contents& saved) {
  run.restore(saved.dynamics, saved.estimate.get(), is_viewer);
  trial_notice.clear();
  lasting.clear();
  fallbacks.clear();
  stretched.clear();
  tracking.forgetLast();
  is_passage_told = false;
  substeps_since_look = 0;
  largest_error = std::numeric_limits<double>::infinity();  // that of the steps before it is not known
  was_commanded = true;
  restoreLooks(saved.looks);
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

Simulation Simulation::fork() const { return Simulation(std::make_unique<Impl>(*impl_, false)); }
Simulation Simulation::viewer() const { return Simulation(std::make_unique<Impl>(*impl_, true)); }

std::size_t Snapshot::bytes() const {
  if (!contents_) return 0;
  const Contents& c = *contents_;
  std::size_t sum = sizeof(Contents) - sizeof(DynamicsState) + c.dynamics.bytes();
  if (c.looks.severed) sum += c.looks.severed->size() * sizeof(CutTransfer::Memory::value_type);
  if (c.looks.resampler) sum += c.looks.resampler->bytes();
  if (c.looks.errors) sum += c.looks.errors->apart.size() * sizeof(float);
  if (c.estimate) sum += c.estimate->bytes();
  return sum;
}

double Snapshot::time() const { return contents_ ? contents_->time : 0.0; }

}  // namespace deformable_surface::simulation
