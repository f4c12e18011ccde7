// Contact wrenches on tools and pins, where contact stopped points, and whether the surface has snapped. Nothing changes here.
#include "dynamics.h"

#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>

#include "tool_forces.h"

namespace deformable_surface::simulation {
namespace {

// Spacings: layers pressed by what pushes them are no farther from it. Chosen on a few scenes of 2 to 4 layers between boxes and
// pins.
constexpr double kNearJam = 3.0;

}  // namespace

std::vector<ToolReaction> Dynamics::toolReactions() const {
  std::vector<ToolReaction> reactions(tools_.size());
  for (std::size_t t = 0; t < reactions.size(); ++t) reactions[t].id = tools_[t].id;
  addReactions(loads_, time(), now_.points, reactions);
  if (grips_.isEmpty()) return reactions;
  system_.computeForcesOnAll(time(), now_.points, forces_on_all_);
  grips_.addReactions(time(), now_.points, forces_on_all_, reactions);
  return reactions;
}

std::vector<Contact> Dynamics::contacts() const {
  std::vector<Contact> contacts;
  const std::vector<tool::ToolParams>& tools = tools_;
  for (Index t = 0; t < static_cast<Index>(tools.size()); ++t)
    appendContacts(loads_, time(), now_.points, tools[t].id, t, contacts);
  return contacts;
}

std::vector<SelfTouch> Dynamics::selfTouches() const {
  std::vector<SelfTouch> touches;
  if (!loads_.self_contact) return touches;
  const State& state = now_.points;
  for (const contact::SelfContactForce& found :
       loads_.self_contact->contact.listForces(state.positions, state.velocities, state.self_friction)) {
    SelfTouch touch;
    touch.position.setZero();
    for (int v = 0; v < 4; ++v) {
      touch.points[v] = found.pair.vertices[v];
      touch.weights[v] = found.closest.weight[v];
      touch.position += 0.5 * std::abs(touch.weights[v]) * state.positions[touch.points[v]];
    }
    touch.normal = found.closest.gap.normalized();
    touch.depth = found.depth;
    touch.force = found.force;
    touches.push_back(touch);
  }
  return touches;
}

std::vector<PinReaction> Dynamics::pinReactions() const {
  const std::vector<PinParams>& pins = params_.pins;
  std::vector<PinReaction> reactions(pins.size() + 1);
  for (std::size_t p = 0; p < pins.size(); ++p) reactions[p].id = "pins[" + std::to_string(p) + "]";
  reactions.back().id = kOtherPins;
  const State& state = now_.points;
  system_.computeForcesOnAll(time(), state, forces_on_all_);
  for (Index i = 0; i < state.size(); ++i) {
    if (!now_.pinned[i]) continue;
    const Index first = state.traits.empty() ? i : state.traits[i].id;  // its place at rest
    const bool is_first = first < static_cast<Index>(rest_->points.size());
    PinReaction& reaction = reactions[is_first ? findPin(first) : pins.size()];
    reaction.force += forces_on_all_[i];
    reaction.torque += state.positions[i].cross(forces_on_all_[i]);
    reaction.points += now_.pinned[i] == kInPin;
  }
  if (reactions.back().points == 0) reactions.pop_back();
  return reactions;
}

std::optional<Jam> Dynamics::findJam() const {
  const SelfContactLoads* const self = loads_.self_contact.get();
  if (!self || self->numStopped() == 0) return {};
  const State& state = now_.points;
  const std::vector<char>& stopped = self->limit.stopped();
  Jam jam;
  Vec3 middle = Vec3::Zero();
  for (Index i = 0; i < state.size(); ++i) {
    if (!stopped[i]) continue;
    middle += state.positions[i];
    ++jam.points;
  }
  middle /= static_cast<double>(jam.points);
  Index nearest = -1;
  for (Index i = 0; i < state.size(); ++i) {
    if (stopped[i] && (nearest < 0 || (state.positions[i] - middle).norm() < (state.positions[nearest] - middle).norm()))
      nearest = i;
  }
  jam.place = state.positions[nearest];

  std::vector<Jam::Actor> near, elsewhere;
  const std::vector<Index>& parts = self->limit.parts();
  using Act = Jam::Actor::Act;
  const auto addNew = [](std::vector<Jam::Actor>& actors, const std::string& name, Act act, bool moves) {
    const auto is_it = [&](const Jam::Actor& actor) { return actor.name == name; };
    if (std::none_of(actors.begin(), actors.end(), is_it)) actors.push_back({name, act, moves});
  };
  const double reach = kNearJam * activity_.spacing();
  const auto add = [&](Index point, const std::string& name, Act act, bool moves) {
    const bool is_near = (state.positions[point] - jam.place).norm() < reach;
    if (is_near || parts[point] == parts[nearest]) addNew(is_near ? near : elsewhere, name, act, moves);
  };
  for (const Contact& contact : contacts()) {
    const tool::ToolParams& tool = tools_[contact.tool];
    const bool moves = !tool::findMotion(tool.path, time()).velocityAt(contact.position).isZero(0.0);
    const Act act = tool.mode == tool::Mode::kAttract ? Act::kPulls : Act::kPushes;
    if (!contact.force.isZero(0.0)) add(contact.point, "tool " + quote(tool.id), act, moves);
  }
  for (const tool::ToolParams& tool : tools_) {
    if (!tool::isPushing(tool) || !tool::isActive(tool, time())) continue;
    if (tool::findSignedDistance(tool.shape, tool::interpolate(tool.path, time()), jam.place).distance > reach) continue;
    addNew(near, "tool " + quote(tool.id), Act::kIsNear, !tool::findMotion(tool.path, time()).velocityAt(jam.place).isZero(0.0));
  }
  for (const Grips::Grip& grip : grips_.all())
    for (const Index i : grip.points)
      add(i, grip.is_pin ? grip.tool.id : "tool " + quote(grip.tool.id), Act::kHolds, !state.velocities[i].isZero(0.0));
  for (Index i = 0; i < state.size(); ++i) {
    if (!now_.pinned[i] || grips_.isOnPin(i)) continue;
    const std::size_t pin = findPin(i);
    add(i, pin < params_.pins.size() ? "pins[" + std::to_string(pin) + "]" : "a pin set by a command", Act::kHolds, false);
  }
  jam.are_near = !near.empty();
  jam.actors = jam.are_near ? std::move(near) : std::move(elsewhere);
  return jam;
}

double Dynamics::measureLag() const {
  const SelfContactLoads* const self = loads_.self_contact.get();
  if (!self || self->numStopped() == 0) return 0.0;
  double lag = 0.0;
  for (const Grips::Grip& grip : grips_.all()) {
    const tool::Pose pose = tool::interpolate(grip.tool.path, time());
    for (std::size_t k = 0; k < grip.points.size(); ++k) {
      const Index i = grip.points[k];
      if (!self->limit.stopped()[i]) continue;
      lag = std::max(lag, (now_.points.positions[i] - pose.position - pose.orientation * grip.places[k]).norm());
    }
  }
  return lag;
}

bool Dynamics::hasSnapped() const {
  // Many times the motion that falling asleep may leave.
  constexpr double kStretched = 1e-3;
  if (!kind_.traits().can_snap || !activity_.isAsleep()) return false;
  if (!loads_.gravity.isEmpty() || !loads_.pressure.isEmpty() || !loads_.track.isEmpty()) return false;
  if (!params_.anchors.empty()) return false;
  if (!loads_.forces.active(now_.points).empty()) return false;
  for (Index i = 0; i < now_.points.size(); ++i)
    if (held_[i] && now_.points.positions[i] != rest_->points[i]) return false;
  std::vector<ToolReaction> reactions(tools_.size());
  addReactions(loads_, time(), now_.points, reactions);
  if (std::any_of(reactions.begin(), reactions.end(), [](const ToolReaction& r) { return r.contacts > 0; })) return false;
  return maxStretchOf(*model_, now_.points) > kStretched;
}

}  // namespace deformable_surface::simulation
