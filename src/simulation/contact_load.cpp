#include "deformable_surface/simulation/contact_load.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/simulation/friction_load.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tool_arrival.h"
#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

using tool::Mode;
using tool::ToolParams;

// Minus the derivative, and the value, of the attraction for unit stiffness at a distance, see the class.
double attractionForce(double d, double reach) {
  const double rest = 1.0 - d * d / (reach * reach);
  return -d * rest * rest;
}
double attractionPotential(double d, double reach) {
  const double rest = 1.0 - d * d / (reach * reach);
  return -reach * reach / 6.0 * rest * rest * rest;
}

// A ball is asked with a little more than its radius, so that rounding leaves nothing out.
constexpr double kBallMargin = 1.0 + 1e-9;

constexpr Index kLook = 1024;  // points between two looks at an interrupt: milliseconds, also of tools of many triangles

bool isPushing(const ToolParams& tool) { return tool.mode == Mode::kSolid || tool.mode == Mode::kCut; }

}  // namespace

void ContactLoad::setTools(const std::vector<ToolParams>& tools) {
  std::vector<Body> bodies;
  for (const ToolParams& tool : tools) {
    if (!isPushing(tool) && tool.mode != Mode::kAttract) continue;
    Body body;
    body.tool = tool;
    for (Body& before : bodies_) {
      if (before.tool.id != tool.id) continue;
      if (tool.mode == Mode::kSolid) body.passed = std::move(before.passed);
      body.acts = before.acts;
      if (!isPushing(before.tool) || !isPushing(tool) || !geometry::isSame(before.tool.shape, tool.shape)) continue;
      body.arrival = before.arrival;
      body.tool.path = findArrivingPath(tool.path, body.arrival);
    }
    bodies.push_back(std::move(body));
  }
  bodies_ = std::move(bodies);
  forgetTouches();
}

bool ContactLoad::mayHold(const Vec3& point, const Vec3& direction, double time) const {
  constexpr double kFar = 1e3;  // of the distance to the tool and its size: so far a way is followed
  return std::any_of(bodies_.begin(), bodies_.end(), [&](const Body& body) {
    const ToolParams& tool = body.tool;
    if (!body.acts.value_or(tool::isActive(tool, time))) return false;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    const Vec3 from = pose.orientation.conjugate() * (point - pose.position), along = pose.orientation.conjugate() * direction;
    const double reach = isPushing(tool) ? 0.0 : tool.reach;
    if (geometry::findSignedDistance(tool.shape, from, reach).distance <= reach) return true;
    const bool is_plane = tool.shape.kind == geometry::Solid::Kind::kPlane;
    const double way = kFar * (from.norm() + (is_plane ? 0.0 : findRadius(tool.shape)));
    return isPushing(tool) && tool::findEntry(tool.shape, from, from + way * along).has_value();
  });
}

double ContactLoad::totalMass() const { return std::accumulate(masses_.begin(), masses_.end(), 0.0); }

void ContactLoad::listTouches(const Body& body, double time, const Points& positions, std::vector<Touch>& touches) const {
  touches.clear();
  touches.reserve(positions.size());
  const ToolParams& tool = body.tool;
  auto passed = body.passed.begin();
  if (!body.acts.value_or(tool::isActive(tool, time))) return;
  const tool::Pose pose = tool::interpolate(tool.path, time);
  const bool pushing = isPushing(tool);
  const double per_mass = pushing ? rate_ * rate_ : tool.strength / totalMass();
  const double ball = kBallMargin * (findRadius(tool.shape) + (pushing ? 0.0 : tool.reach)), squared_ball = ball * ball;
  for (Index i = 0; i < static_cast<Index>(positions.size()); ++i) {
    endIfInterrupted(i, kLook);
    // Most points are far from most tools, and need no more of them.
    const bool is_passed = passed != body.passed.end() && passed->point == i;
    if (!is_passed && (positions[i] - pose.position).squaredNorm() > squared_ball) continue;
    geometry::SignedDistance d = tool::findSignedDistance(tool.shape, pose, positions[i], pushing ? 0.0 : tool.reach);
    if (is_passed) {
      const tool::Entry& entry = passed++->entry;
      const Vec3 place = pose.orientation.conjugate() * (positions[i] - pose.position);
      if (tool::isHeldUp(tool.shape, entry, place, d)) d = {entry.heightOf(place), pose.orientation * entry.normal};
    }
    if (!(pushing ? d.distance < 0.0 : std::abs(d.distance) < tool.reach)) continue;
    const double force = pushing ? -d.distance : attractionForce(d.distance, tool.reach);
    touches.push_back({i, d.distance, d.normal, per_mass * masses_[i] * force * d.normal});
  }
}

const std::vector<ContactLoad::Touch>& ContactLoad::findTouches(std::size_t body, double time, const Points& positions) const {
  if (touches_.size() != bodies_.size() || touched_time_ != time || touched_at_ != positions) {
    touches_.resize(bodies_.size());
    for (Touches& touches : touches_) touches.are_known = false;
    touched_time_ = time;
    touched_at_ = positions;
  }
  Touches& touches = touches_[body];
  if (!touches.are_known) listTouches(bodies_[body], time, positions, touches.list);
  touches.are_known = true;
  return touches.list;
}

void ContactLoad::addForces(double time, const model::State& state, Points& forces) const {
  const Timer timer;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    for (const Touch& touch : findTouches(b, time, state.positions)) forces[touch.point] += touch.force;
  seconds_ += timer.seconds();
}

double ContactLoad::potentialOf(std::size_t body, double time, const Points& positions) const {
  const ToolParams& tool = bodies_[body].tool;
  double sum = 0.0;
  const bool pushing = isPushing(tool);
  const double per_mass = pushing ? rate_ * rate_ : tool.strength / totalMass();
  for (const Touch& touch : findTouches(body, time, positions)) {
    const double d = touch.distance;
    sum += per_mass * masses_[touch.point] * (pushing ? 0.5 * d * d : attractionPotential(d, tool.reach));
  }
  return sum;
}

double ContactLoad::potential(double time, const model::State& state) const {
  double sum = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) sum += potentialOf(b, time, state.positions);
  return sum;
}

double ContactLoad::storedEnergy(double time, const model::State& state) const {
  double sum = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (isPushing(bodies_[b].tool)) sum += potentialOf(b, time, state.positions);
  return sum;
}

double ContactLoad::estimateWork(double from, double to, const model::State& before, const model::State& after) const {
  if (bodies_.empty()) return 0.0;
  return std::max({0.0, potential(to, before) - potential(from, before), potential(to, after) - potential(from, after)});
}

// The curvature of the tool's surface would soften a point that slides; leaving it out keeps the matrix positive.
void ContactLoad::addStiffness(double time, const model::State& state, double, BlockSparse& stiffness) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const ToolParams& tool = bodies_[b].tool;
    // Also without contact: the pattern stays the same from step to step.
    for (Index i = 0; i < state.size(); ++i) stiffness.add(i, i, Mat3::Zero());
    const double per_mass = isPushing(tool) ? rate_ * rate_ : tool.strength / totalMass();
    for (const Touch& touch : findTouches(b, time, state.positions))
      stiffness.add(touch.point, touch.point, masses_[touch.point] * per_mass * touch.normal * touch.normal.transpose());
  }
}

void ContactLoad::addRowBounds(double, const model::State& state, std::vector<double>& stiffness, std::vector<double>&) const {
  for (const Body& body : bodies_) {
    const ToolParams& tool = body.tool;
    const double per_mass = isPushing(tool) ? rate_ * rate_ : tool.strength / totalMass();
    for (Index i = 0; i < state.size(); ++i) stiffness[i] += per_mass * masses_[i];
  }
}

void ContactLoad::addReactions(double time, const model::State& state, const FrictionLoad& friction,
                               std::vector<ToolReaction>& reactions) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const ToolParams& tool = bodies_[b].tool;
    const auto found = std::find_if(reactions.begin(), reactions.end(), [&](const ToolReaction& r) { return r.id == tool.id; });
    if (found == reactions.end()) continue;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const Touch& touch : findTouches(b, time, state.positions)) {
      const Vec3 on_point = touch.force + friction.findForce(b, time, state, touch);
      force -= on_point;
      torque -= (state.positions[touch.point] - pose.position).cross(on_point);
      ++found->contacts;
      found->penetration = std::max(found->penetration, -touch.distance);
    }
    found->force += pose.orientation.conjugate() * force;
    found->torque += pose.orientation.conjugate() * torque;
  }
}

void ContactLoad::appendContacts(double time, const model::State& state, const FrictionLoad& friction, const std::string& id,
                                 Index place, std::vector<Contact>& contacts) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].tool.id != id) continue;
    for (const Touch& touch : findTouches(b, time, state.positions))
      contacts.push_back({place, touch.point, state.positions[touch.point], touch.normal, -touch.distance,
                          touch.force + friction.findForce(b, time, state, touch)});
  }
}

}  // namespace deformable_surface::simulation
