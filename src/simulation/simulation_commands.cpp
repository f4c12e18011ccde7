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
  for (std::size_t i = 0; i < n; ++i) {
    const std::string point = "state of simulation point " + std::to_string(i) + ": ";
    if (!isWithin(state.positions[i], kMaxLength))
      throw InputError(point + "found a coordinate that is not finite or too large; accepted: up to " +
                       formatReal(kMaxLength) + " m");
    if (!isWithin(state.velocities[i], kMaxSpeed))
      throw InputError(point + "found a velocity that is not finite or too large; accepted: up to " +
                       formatReal(kMaxSpeed) + " m/s");
    if (impl_->pinned[i] && !state.velocities[i].isZero(0.0))
      throw InputError(point + "found a velocity though it is pinned; accepted: zero");
  }
  impl_->state.positions = state.positions;
  impl_->state.velocities = state.velocities;
  impl_->march.restart();
  impl_->part.reset();
  impl_->activity.reset();
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

void Simulation::estimateError(const RestSurface& full) {
  impl_->estimator = std::make_unique<ErrorEstimator>(impl_->params, full, impl_->rest);
}

void Simulation::disturb(double size) {
  impl_->wakeAll();
  std::uint32_t seed = 12345u;
  for (Index i = 0; i < impl_->state.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      seed = seed * 1664525u + 1013904223u;
      if (!impl_->pinned[i]) impl_->state.positions[i][axis] += size * (static_cast<double>(seed >> 8) / (1u << 23) - 1.0);
    }
}

void Simulation::setTool(const tool::ToolParams& tool) {
  std::vector<std::string> problems = checkParams(tool);
  if (!hasToolMode(impl_->params.model, tool.mode)) problems.push_back(std::string("mode: ") + kToolModes);
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

bool Simulation::removeTool(const std::string& id) {
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
  for (Index i = 0; i < impl_->state.size(); ++i) {
    if (!region.contains(impl_->state.positions[i])) continue;
    impl_->pinned[i] = 1;
    if (!impl_->pinned_turns.empty() && orientation) impl_->pinned_turns[i] = 1;
    impl_->state.velocities[i].setZero();
    ++changed;
  }
  if (changed > 0) impl_->wakeAll();
  impl_->forward([&](Simulation& copy) { copy.pin(region, orientation); });
  return changed;
}

Index Simulation::unpin(const geometry::Region& region) {
  Index changed = 0;
  for (Index i = 0; i < impl_->state.size(); ++i)
    if (impl_->pinned[i] && region.contains(impl_->state.positions[i])) {
      impl_->pinned[i] = impl_->pinned_turns[i] = 0;
      ++changed;
    }
  if (changed > 0) impl_->wakeAll();
  impl_->forward([&](Simulation& copy) { copy.unpin(region); });
  return changed;
}

void Simulation::setGravity(const Vec3& gravity) {
  requireFinite(gravity, "gravity");
  if (impl_->gravity.gravity == gravity) return;
  impl_->gravity.gravity = gravity;
  impl_->wakeAll();
  impl_->loadsChanged();
  impl_->forward([&](Simulation& copy) { copy.setGravity(gravity); });
}

std::vector<Index> Simulation::editParticles(const ParticleEdit& edit) {
  impl_->requireParticles();
  const ParticleLife::Changes changes = impl_->life->edit(edit, impl_->state, impl_->pinned, impl_->pinned_turns);
  impl_->follow(changes);
  impl_->rest.model->adopt(impl_->state);
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
  impl_->rest.model->adopt(impl_->state);
  impl_->march.restart();
  impl_->wakeAll();
  impl_->surface.invalidate();
  return changes.notice;
}

}  // namespace deformable_surface::simulation
