// The effects of commands on a dynamics, and the one function that wakes, restarts and chooses after changes. Commands are
// checked before (command_checks.h).
#include "dynamics.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/random.h"

#include <algorithm>

namespace deformable_surface::simulation {

Changes Dynamics::apply(const Command& command) {
  Changes changes = std::visit([&](const auto& c) { return perform(c); }, command);
  // Not only in the next step: a state saved before it must know that the march begins anew.
  if (model_->clamping()) clampHeld();
  follow(changes);
  return changes;
}

// Nothing else wakes parts, restarts the march or chooses loads after a change.
void Dynamics::follow(const Changes& changes) {
  if (changes.material) findContactRateAgain();
  if (changes.motion) march_.restart();
  if (changes.everywhere) wakeAll();
  if (!changes.disturbed.empty()) activity_.wake(changes.disturbed);
  if (changes.loads) {
    loads_.choose();
    march_.loadsChanged();
    if (part_) part_->setLoads(loads_);
  }
  if (changes.parts) setParts();
  revision_ += changes.material || changes.motion || changes.everywhere || changes.loads || changes.parts;
}

// The points on which the force acts are disturbed, whatever changes.
Changes Dynamics::changeForce(const std::string& id) {
  Changes changes;
  changes.loads = true;
  for (const NamedForces::Named& force : loads_.forces.all())
    if (force.params.id == id) changes.disturbed = force.points;
  return changes;
}

Changes Dynamics::perform(const command::SetForce& c) {
  Changes changes = changeForce(c.force.id);
  loads_.forces.set(c.force);
  placeLoadPoints();
  return changes;
}

Changes Dynamics::perform(const command::RemoveForce& c) {
  Changes changes = changeForce(c.id);
  loads_.forces.remove(c.id);
  return changes;
}

Changes Dynamics::replaceTools(std::vector<tool::ToolParams> tools) {
  setTools(std::move(tools));
  Changes changes;
  changes.loads = changes.parts = true;
  return changes;
}

Changes Dynamics::perform(const command::SetTool& c) {
  std::vector<tool::ToolParams> tools = tools_;
  const auto same = std::find_if(tools.begin(), tools.end(), [&](const tool::ToolParams& t) { return t.id == c.tool.id; });
  if (same != tools.end()) {
    *same = c.tool;
  } else {
    tools.push_back(c.tool);
  }
  return replaceTools(std::move(tools));
}

Changes Dynamics::perform(const command::MoveTool& c) {
  std::vector<tool::ToolParams> tools = tools_;
  for (tool::ToolParams& tool : tools)
    if (tool.id == c.id) tool.path = c.path;
  return replaceTools(std::move(tools));
}

Changes Dynamics::perform(const command::RemoveTool& c) {
  std::vector<tool::ToolParams> tools = tools_;
  const auto same = std::remove_if(tools.begin(), tools.end(), [&](const tool::ToolParams& t) { return t.id == c.id; });
  Changes nothing;
  nothing.done = false;
  if (same == tools.end()) return nothing;
  tools.erase(same, tools.end());
  return replaceTools(std::move(tools));
}

// Holds the points in the region where they are; inside (n): overwritten.
std::vector<Index> Dynamics::pinInside(const geometry::Region& region, std::vector<char>& inside) {
  std::vector<Index> points;
  inside.assign(now_.points.positions.size(), 0);
  for (Index i = 0; i < now_.points.size(); ++i) {
    if (!region.contains(now_.points.positions[i])) continue;
    inside[i] = now_.pinned[i] = kInPin;
    now_.points.velocities[i].setZero();
    points.push_back(i);
  }
  return points;
}

Changes Dynamics::perform(const command::Pin& c) {
  std::vector<char> inside;
  const std::vector<Index> points = pinInside(c.region, inside);
  if (!now_.pinned_turns.empty() && c.orientation)
    for (const Index i : points) {
      now_.pinned_turns[i] = 1;
      if (!now_.points.spins.empty()) now_.points.spins[i].setZero();
    }
  std::vector<char> kept(inside.size());  // on their moving pins
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = !inside[i];
  grips_.keepOnPins(kept);
  Changes changes;
  changes.points = static_cast<Index>(points.size());
  changes.everywhere = !points.empty();
  if (!points.empty()) clampPin(inside, [&](const Vec3& place) { return c.region.contains(place); });
  return changes;
}

Changes Dynamics::perform(const command::PinAlong& c) {
  std::vector<char> inside;
  std::vector<Index> points = pinInside(c.region, inside);
  Changes changes;
  changes.points = static_cast<Index>(points.size());
  changes.everywhere = !points.empty();
  if (points.empty()) return changes;
  const std::vector<Index> riding = clampPin(inside, [&](const Vec3& place) { return c.region.contains(place); });
  points.insert(points.end(), riding.begin(), riding.end());
  std::sort(points.begin(), points.end());
  grips_.addPin(c.id, c.path, time(), std::move(points), now_.points);
  return changes;
}

// In a coarser copy the region may contain no point.
Changes Dynamics::perform(const command::MovePin& c) {
  Changes changes;
  const Grips::Grip* const pin = grips_.findPin(c.id);
  if (!pin) return changes;
  const tool::Pose before = tool::interpolate(pin->tool.path, time()), after = tool::interpolate(c.path, time());
  if (before.position != after.position || before.orientation.coeffs() != after.orientation.coeffs())
    changes.disturbed = pin->points;
  grips_.movePin(c.id, c.path);
  return changes;
}

Changes Dynamics::perform(const command::Unpin& c) {
  Changes changes;
  for (Index i = 0; i < now_.points.size(); ++i)
    if (now_.pinned[i] && c.region.contains(now_.points.positions[i])) {
      now_.pinned[i] = now_.pinned_turns[i] = 0;
      ++changes.points;
    }
  changes.everywhere = changes.points > 0;
  if (changes.everywhere) endClamps();
  grips_.keepOnPins(now_.pinned);
  return changes;
}

Changes Dynamics::perform(const command::SetGravity& c) {
  Changes changes;
  changes.done = changes.loads = changes.everywhere = loads_.gravity.gravity != c.gravity;
  loads_.gravity.gravity = c.gravity;
  setContactRate(now_.contact_rate);
  return changes;
}

Changes Dynamics::perform(const command::SetMaterial& c) {
  Changes changes;
  for (Index i = 0; i < now_.points.size(); ++i) {
    if (c.region && !c.region->contains(now_.points.positions[i])) continue;
    values_[i].take(c.change);
    ++changes.points;
  }
  changes.material = changes.motion = changes.everywhere = applyMaterial();
  return changes;
}

Changes Dynamics::perform(const command::SetDamping& c) {
  system_.setDamping(c.damping);
  Changes changes;
  changes.motion = changes.everywhere = true;
  return changes;
}

Changes Dynamics::perform(const command::SetParams& c) {
  if (c.params.gravity != params_.gravity) perform(command::SetGravity{c.params.gravity});
  if (c.params.material.damping != params_.material.damping) system_.setDamping(c.params.material.damping);
  params_ = withRunTimeValues(std::move(params_), c.params);
  loads_.pressure.setPressure(params_.pressure);
  loads_.drag.setDrag(params_.viscous_drag);
  Changes changes;
  changes.material = applyMaterial();
  changes.loads = changes.parts = changes.motion = changes.everywhere = true;
  return changes;
}

Changes Dynamics::perform(const command::Observe& c) {
  constexpr double kReach = 3.0;  // spacings that a surface lags behind by at most; beyond it lies something else
  Points normals;
  computeAreaVectors(*model_, now_.points, normals);
  for (Vec3& normal : normals) normal.normalize();
  loads_.track.observe(*c.cloud, now_.points, normals, params_.input.tracking_distance.valueOr(kReach * activity_.spacing()));
  Changes changes;
  changes.loads = changes.motion = changes.everywhere = true;
  return changes;
}

Changes Dynamics::perform(const command::SetState& c) {
  now_.points.positions = c.state.positions;
  now_.points.velocities = c.state.velocities;
  now_.points.friction.clear();
  now_.points.self_friction.clear();
  if (!c.state.plastic.empty()) {
    now_.points.plastic = c.state.plastic;
    now_.points.dissipated = c.state.dissipated;
    adopt(*model_, now_.points);
  }
  findTangles();
  part_.reset();
  part_march_ = {};
  activity_.reset();
  const Index first = static_cast<Index>(rest_->points.size());
  if (kind_.traits().has_population && (now_.points.size() != first || now_.points.next_id != first)) activity_.leaveParts();
  Changes changes;
  changes.motion = changes.moved = true;
  return changes;
}

Changes Dynamics::perform(const command::EditParticles& c) {
  const Population population = evolution_->edit(c.edit, now_.points, now_.pinned, now_.pinned_turns);
  followPopulation(population);
  grips_.keepOnPins(now_.pinned);
  adopt(*model_, now_.points);
  Changes changes;
  changes.motion = changes.everywhere = changes.moved = true;
  for (Index id = now_.points.next_id - population.born; id < now_.points.next_id; ++id) changes.added.push_back(id);
  return changes;
}

Changes Dynamics::perform(const command::GrowSurface& c) {
  Changes changes;
  const bool is_start = steps_ == 0;
  const Population grown = evolution_->growSurface(c.growth, is_start ? now_.pinned : held_,
                                                   is_start ? now_.pinned_turns : held_turns_, is_start, now_.points);
  followPopulation(grown);
  changes.notice = grown.notice;
  appendNotice(changes.notice, grown.warning);
  adopt(*model_, now_.points);  // the particles of before may have moved
  changes.motion = changes.everywhere = changes.moved = true;
  return changes;
}

// Renumbers everything that is stored by point.
void Dynamics::followPopulation(const Population& population) {
  if (!population.new_index.empty()) {
    loads_.forces.renumber(population.new_index);
    loads_.anchors.renumber(population.new_index);
    grips_.renumber(population.new_index);
    loads_.contact.renumber(population.new_index);
    renumberFriction(population.new_index, now_.points.friction);
    keepThose(population.new_index, now_.pinned);
    keepThose(population.new_index, now_.pinned_turns);
  }
  if (population.new_index.empty() && population.born == 0) return;
  now_.pinned.resize(now_.points.positions.size(), 0);
  now_.pinned_turns.resize(now_.points.positions.size(), 0);
  adopt(*model_, now_.points);
  loads_.track.restore({});
  part_.reset();
  activity_.leaveParts();
  now_.followed.clear();
  Changes changes;
  changes.loads = changes.motion = changes.everywhere = true;
  follow(changes);
}

void Dynamics::disturb(double size) {
  const Points before = now_.points.positions;
  disturb(size, now_.points.positions);
  if (loads_.self_contact) {
    loads_.self_contact->contact.forgetMotion();
    loads_.self_contact->limit.limit(before, now_.points.positions, false);
  }
  Changes changes;
  changes.everywhere = true;
  follow(changes);
}

// By up to size along each axis, except pinned points.
void Dynamics::disturb(double size, Points& positions) const {
  std::uint32_t seed = kRandomSeed;
  for (std::size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      nextRandom(seed);
      if (!now_.pinned[i]) positions[i][axis] += size * (static_cast<double>(seed >> 8) / (1u << 23) - 1.0);
    }
}

}  // namespace deformable_surface::simulation
