// Commands to a simulation: each checks what it is given, applies it and passes it on to the copies that estimate the error.
#include "simulation_impl.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

constexpr double kMaxSpeed = 1e8;  // m/s that a given state may have: a third of that of light is no surface's

void requireFinite(const Vec3& v, const std::string& what) {
  if (!v.allFinite()) throw InputError(what + ": found a value that is not finite; accepted: finite numbers");
}

bool isWithin(const Vec3& v, double largest) { return (v.array().abs() <= largest).all(); }

}  // namespace

void Simulation::setState(const model::State& state) {
  const std::size_t n = impl_->state.positions.size();
  if (state.positions.size() != n || state.velocities.size() != n)
    throw InputError("state: found " + std::to_string(state.positions.size()) + " positions and " +
                     std::to_string(state.velocities.size()) + " velocities; accepted: " + std::to_string(n) + " of each");
  const bool has_flowed = !state.plastic.empty();
  if (has_flowed && state.plastic.size() != impl_->state.plastic.size())
    throw InputError("state: found " + std::to_string(state.plastic.size()) +
                     " rest states of flow; accepted: none, or, of a solid that "
                     "flows, one a simulation point");
  for (const Mat3& plastic : state.plastic)
    if (!(plastic.determinant() > 0.0) || !plastic.allFinite() || !(state.dissipated >= 0.0))
      throw InputError(
          "state: found a rest state of flow that turns matter inside out or is not finite, or dissipated energy below 0; "
          "accepted: what this solid came to");
  for (std::size_t i = 0; i < n; ++i) {
    const std::string point = "state of simulation point " + std::to_string(i) + ": ";
    if (!isWithin(state.positions[i], kMaxLength))
      throw InputError(point + "found a coordinate that is not finite or too large; accepted: up to " +
                       formatReal(kMaxLength) + " m");
    if (!isWithin(state.velocities[i], kMaxSpeed))
      throw InputError(point + "found a velocity that is not finite or too large; accepted: up to " +
                       formatReal(kMaxSpeed) + " m/s");
    if (impl_->pinned[i] && !impl_->grips.isOnPin(static_cast<Index>(i)) && !state.velocities[i].isZero(0.0))
      throw InputError(point + "found a velocity though it is pinned; accepted: zero");
  }
  impl_->leaveTrial("a state was given");
  impl_->state.positions = state.positions;
  impl_->state.velocities = state.velocities;
  if (has_flowed) {
    impl_->state.plastic = state.plastic;
    impl_->state.dissipated = state.dissipated;
    impl_->model->adopt(impl_->state);
  }
  impl_->march.restart();
  impl_->part.reset();
  impl_->part_march = {};
  impl_->activity.reset();
  const Index first = numFirst();
  if (impl_->particles && (impl_->state.size() != first || impl_->state.next_id != first)) impl_->activity.leaveParts();
  impl_->changed();
  if (impl_->estimator) impl_->estimator->setState(state);
  impl_->surface.invalidate();
}

void Simulation::setForce(const ForceParams& force) {
  // The same checks as for the forces of a scene.
  std::vector<std::string> problems = checkParams(force);
  for (std::string& problem : problems) problem = "force " + quote(force.id) + " " + problem;
  if (!problems.empty()) throw InputError(std::move(problems));
  impl_->wakeForce(force.id);
  impl_->forces.set(force);
  impl_->loadsChanged();
  impl_->forward([&](Simulation& copy) { copy.setForce(force); });
}

void Simulation::removeForce(const std::string& id) {
  impl_->wakeForce(id);
  impl_->forces.remove(id);
  impl_->loadsChanged();
  impl_->forward([&](Simulation& copy) { copy.removeForce(id); });
}

std::vector<std::string> Simulation::forceIds() const {
  std::vector<std::string> ids;
  for (const NamedForces::Named& force : impl_->forces.all()) ids.push_back(force.params.id);
  return ids;
}

void Simulation::estimateError() {
  impl_->estimator = std::make_unique<ErrorEstimator>(impl_->params, impl_->rest, *impl_->model);
  impl_->is_measured = false;
}

void Simulation::softenMembrane(double share) {
  impl_->chosen_membrane_share = impl_->membrane_share = share;
  impl_->applyMaterial();
  if (impl_->estimator) impl_->estimator->softenMembrane(share);
}

void Simulation::disturb(double size) {
  impl_->wakeAll();
  impl_->disturb(size, impl_->state.positions);
}

// By up to size along each axis, but for pinned points.
void Simulation::Impl::disturb(double size, Points& positions) const {
  std::uint32_t seed = 12345u;
  for (std::size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      seed = seed * 1664525u + 1013904223u;
      if (!pinned[i]) positions[i][axis] += size * (static_cast<double>(seed >> 8) / (1u << 23) - 1.0);
    }
}

void Simulation::setTool(const tool::ToolParams& tool) {
  std::vector<std::string> problems = checkParams(tool);
  for (const ToolProblem& problem : findToolProblems(impl_->params.model, tool))
    problems.push_back(problem.field + ": " + problem.sentence);
  for (std::string& problem : problems) problem = "tool " + quote(tool.id) + " " + problem;
  if (!problems.empty()) throw InputError(std::move(problems));
  std::vector<tool::ToolParams> tools = impl_->tools;
  const auto same = std::find_if(tools.begin(), tools.end(), [&](const tool::ToolParams& t) { return t.id == tool.id; });
  if (same != tools.end()) {
    *same = tool;
  } else {
    tools.push_back(tool);
  }
  impl_->setTools(std::move(tools));
  impl_->forward([&](Simulation& copy) { copy.setTool(tool); });
}

void Simulation::moveTool(const std::string& id, const std::vector<tool::WaypointParams>& path) {
  const std::string problem = tool::findProblem(path);
  if (!problem.empty()) throw InputError("tool " + quote(id) + " " + problem);
  std::vector<tool::ToolParams> tools = impl_->tools;
  const auto moved = std::find_if(tools.begin(), tools.end(), [&](const tool::ToolParams& t) { return t.id == id; });
  if (moved == tools.end()) throw InputError("tool " + quote(id) + ": there is none; accepted: one of those there are");
  moved->path = path;
  impl_->setTools(std::move(tools));
  impl_->forward([&](Simulation& copy) { copy.moveTool(id, path); });
}

bool Simulation::removeTool(const std::string& given) {
  const std::string id = given;  // which may be that of the tool itself, and goes with it
  std::vector<tool::ToolParams> tools = impl_->tools;
  const auto same = std::remove_if(tools.begin(), tools.end(), [&](const tool::ToolParams& t) { return t.id == id; });
  if (same == tools.end()) return false;
  tools.erase(same, tools.end());
  impl_->setTools(std::move(tools));
  impl_->forward([&](Simulation& copy) { copy.removeTool(id); });
  return true;
}

const std::vector<tool::ToolParams>& Simulation::tools() const { return impl_->tools; }

Index Simulation::pin(const geometry::Region& region, bool orientation) {
  Index changed = 0;
  std::vector<char> kept(impl_->state.positions.size(), 1), inside(kept.size(), 0);  // on the pins that carry them; in this one
  for (Index i = 0; i < impl_->state.size(); ++i) {
    if (!region.contains(impl_->state.positions[i])) continue;
    kept[i] = 0;
    inside[i] = impl_->pinned[i] = kInPin;
    impl_->state.velocities[i].setZero();
    if (!impl_->pinned_turns.empty() && orientation) {
      impl_->pinned_turns[i] = 1;
      if (!impl_->state.spins.empty()) impl_->state.spins[i].setZero();
    }
    ++changed;
  }
  impl_->grips.keepOnPins(kept);
  if (changed > 0) {
    impl_->findClamps(inside, [&](const Vec3& place) { return region.contains(place); });
    impl_->wakeAll();
  }
  impl_->forward([&](Simulation& copy) { copy.pin(region, orientation); });
  return changed;
}

Index Simulation::pinAlong(const std::string& id, const geometry::Region& region,
                           const std::vector<tool::WaypointParams>& path) {
  const std::string problem = tool::findProblem(path);
  if (!problem.empty()) throw InputError("pin " + quote(id) + " " + problem);
  if (impl_->grips.findPin(id)) throw InputError("pin " + quote(id) + ": there is one already; accepted: a name of its own");
  std::vector<Index> points;
  std::vector<char> inside(impl_->state.positions.size(), 0);
  for (Index i = 0; i < impl_->state.size(); ++i) {
    if (!region.contains(impl_->state.positions[i])) continue;
    inside[i] = impl_->pinned[i] = kInPin;
    impl_->state.velocities[i].setZero();
    points.push_back(i);
  }
  const Index changed = static_cast<Index>(points.size());
  if (changed > 0) {
    const std::vector<Index> riding = impl_->findClamps(inside, [&](const Vec3& place) { return region.contains(place); });
    points.insert(points.end(), riding.begin(), riding.end());
    std::sort(points.begin(), points.end());
    impl_->grips.addPin(id, path, impl_->time(), std::move(points), impl_->state);
    impl_->wakeAll();
  }
  impl_->forward([&](Simulation& copy) { copy.pinAlong(id, region, path); });
  return changed;
}

void Simulation::movePin(const std::string& id, const std::vector<tool::WaypointParams>& path) {
  const std::string problem = tool::findProblem(path);
  if (!problem.empty()) throw InputError("pin " + quote(id) + " " + problem);
  // A coarser copy may have had no point in the region.
  if (const Grips::Grip* const pin = impl_->grips.findPin(id)) {
    const tool::Pose before = tool::interpolate(pin->tool.path, impl_->time()), after = tool::interpolate(path, impl_->time());
    if (before.position != after.position || before.orientation.coeffs() != after.orientation.coeffs())
      impl_->activity.wake(pin->points);
    impl_->grips.movePin(id, path);
  }
  impl_->forward([&](Simulation& copy) { copy.movePin(id, path); });
}

const std::vector<tool::WaypointParams>* Simulation::findPinPath(const std::string& id) const {
  const Grips::Grip* const pin = impl_->grips.findPin(id);
  return pin ? &pin->tool.path : nullptr;
}

Index Simulation::unpin(const geometry::Region& region) {
  Index changed = 0;
  for (Index i = 0; i < impl_->state.size(); ++i)
    if (impl_->pinned[i] && region.contains(impl_->state.positions[i])) {
      impl_->pinned[i] = impl_->pinned_turns[i] = 0;
      ++changed;
    }
  if (changed > 0) impl_->endClamps();
  impl_->grips.keepOnPins(impl_->pinned);
  if (changed > 0) impl_->wakeAll();
  impl_->forward([&](Simulation& copy) { copy.unpin(region); });
  return changed;
}

void Simulation::setGravity(const Vec3& gravity) {
  requireFinite(gravity, "gravity");
  if (impl_->gravity.gravity == gravity) return;
  impl_->gravity.gravity = gravity;
  impl_->chooseLoads();
  impl_->wakeAll();
  impl_->loadsChanged();
  impl_->forward([&](Simulation& copy) { copy.setGravity(gravity); });
}

Index Simulation::setMaterial(const geometry::Region* region, const MaterialChangeParams& change) {
  std::vector<std::string> problems = checkParams(change);
  const std::string problem = findMaterialProblem(impl_->params, change);
  if (!problem.empty()) problems.push_back(problem);
  if (!problems.empty()) throw InputError(std::move(problems));
  Index changed = 0;
  for (Index i = 0; i < impl_->state.size(); ++i) {
    if (region && !region->contains(impl_->state.positions[i])) continue;
    impl_->values[i].take(change);
    ++changed;
  }
  impl_->applyMaterial();
  impl_->forward([&](Simulation& copy) { copy.setMaterial(region, change); });
  return changed;
}

Index Simulation::numOwnMaterial() const {
  return static_cast<Index>(
      std::count_if(impl_->values.begin(), impl_->values.end(), [](const PointValues& v) { return v.areOwn(); }));
}

void Simulation::setDamping(double damping) {
  model::MaterialParams checked;
  checked.damping = damping;
  std::vector<std::string> problems = checkParams(checked);
  if (!problems.empty()) throw InputError(std::move(problems));
  impl_->setDamping(damping);
  impl_->march.restart();
  impl_->forward([&](Simulation& copy) { copy.setDamping(damping); });
}

void Simulation::observe(const cloud::PointCloud& cloud) { observe(ObservedCloud(cloud)); }

void Simulation::observe(const ObservedCloud& cloud) {
  if (impl_->solid)
    throw InputError("model: found elastic_solid, which has no sides that a cloud could show; accepted: a surface");
  constexpr double kReach = 3.0;  // spacings that a surface lags behind by at most; beyond it lies something else
  const double spacing = std::sqrt(impl_->rest.area / static_cast<double>(impl_->rest.points.size()));
  Points normals;
  impl_->model->computeAreaVectors(impl_->state, normals);
  for (Vec3& normal : normals) normal.normalize();
  impl_->track.observe(cloud, impl_->state, normals, impl_->params.input.track_distance.valueOr(kReach * spacing));
  impl_->wakeAll();
  impl_->chooseLoads();
  impl_->march.restart();
  impl_->forward([&](Simulation& copy) { copy.observe(cloud); });
}

void Simulation::setParams(const SceneParams& params) {
  std::vector<std::string> problems = checkParams(params);
  if (!problems.empty()) throw InputError(std::move(problems));
  SceneParams& now = impl_->params;
  SceneParams changed = withRunTimeValues(now, params);
  if (toYaml(printParams(changed)) != toYaml(printParams(params))) {
    std::string keys;
    for (const std::string& key : runTimeKeys()) keys += (keys.empty() ? "" : ", ") + key;
    throw InputError("found another value of one that cannot change while a surface runs; accepted: others of " + keys);
  }
  if (params.material.young_modulus != now.material.young_modulus) {
    MaterialChangeParams stiffness;
    stiffness.young_modulus = params.material.young_modulus;
    const std::string problem = findMaterialProblem(now, stiffness);
    if (!problem.empty()) throw InputError("material.young_modulus: " + problem);
  }
  const bool is_damping_new = params.material.damping != now.material.damping;
  if (params.gravity != now.gravity) setGravity(params.gravity);
  now = std::move(changed);
  impl_->takePhysics();
  if (is_damping_new) impl_->setDamping(now.material.damping);
  impl_->march.restart();
  impl_->surface.invalidate();
  impl_->forward([&](Simulation& copy) { copy.setParams(withRunTimeValues(copy.params(), params)); });
}

std::vector<Index> Simulation::editParticles(const ParticleEdit& edit) {
  impl_->requireParticles();
  const ParticleLife::Changes changes = impl_->life->edit(edit, impl_->state, impl_->pinned, impl_->pinned_turns);
  impl_->follow(changes);
  impl_->grips.keepOnPins(impl_->pinned);
  impl_->model->adopt(impl_->state);
  impl_->march.restart();
  impl_->wakeAll();
  impl_->surface.invalidate();
  std::vector<Index> added;
  for (Index id = impl_->state.next_id - changes.born; id < impl_->state.next_id; ++id) added.push_back(id);
  return added;
}

std::string Simulation::fit(const model::GrowthParams& growth) {
  impl_->requireParticles();
  std::vector<std::string> problems = checkParams(growth);
  if (!problems.empty()) throw InputError(std::move(problems));
  const ParticleLife::Changes changes = impl_->fit(growth);
  // The particles of before may have moved.
  impl_->model->adopt(impl_->state);
  impl_->march.restart();
  impl_->wakeAll();
  impl_->surface.invalidate();
  return changes.notice;
}

}  // namespace deformable_surface::simulation
