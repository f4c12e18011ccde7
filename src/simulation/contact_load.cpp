#include "deformable_surface/simulation/contact_load.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/timer.h"

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

// Velocity of what a tool touches, less that of the tool there and what is along the normal.
Vec3 findSliding(const tool::Motion& motion, const Vec3& position, const Vec3& velocity, const Vec3& normal) {
  const Vec3 relative = velocity - motion.velocityAt(position);
  return relative - relative.dot(normal) * normal;
}

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

// Calls visit(touch) for every point that the tool acts on.
template <class Visit>
void ContactLoad::forEachTouch(const Body& body, double time, const Points& positions, Visit&& visit) const {
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
    visit(Touch{i, d.distance, d.normal, per_mass * masses_[i] * force * d.normal});
  }
}

void ContactLoad::addForces(double time, const model::State& state, Points& forces) const {
  const Timer timer;
  for (const Body& body : bodies_)
    forEachTouch(body, time, state.positions, [&](const Touch& touch) { forces[touch.point] += touch.force; });
  seconds_ += timer.seconds();
}

double ContactLoad::potentialOf(const Body& body, double time, const Points& positions) const {
  const ToolParams& tool = body.tool;
  double sum = 0.0;
  const bool pushing = isPushing(tool);
  const double per_mass = pushing ? rate_ * rate_ : tool.strength / totalMass();
  forEachTouch(body, time, positions, [&](const Touch& touch) {
    const double d = touch.distance;
    sum += per_mass * masses_[touch.point] * (pushing ? 0.5 * d * d : attractionPotential(d, tool.reach));
  });
  return sum;
}

double ContactLoad::potential(double time, const model::State& state) const {
  double sum = 0.0;
  for (const Body& body : bodies_) sum += potentialOf(body, time, state.positions);
  return sum;
}

double ContactLoad::storedEnergy(double time, const model::State& state) const {
  double sum = 0.0;
  for (const Body& body : bodies_)
    if (isPushing(body.tool)) sum += potentialOf(body, time, state.positions);
  return sum;
}

double ContactLoad::estimateWork(double from, double to, const model::State& before, const model::State& after) const {
  if (bodies_.empty()) return 0.0;
  return std::max({0.0, potential(to, before) - potential(from, before), potential(to, after) - potential(from, after)});
}

// The curvature of the tool's surface would soften a point that slides; leaving it out keeps the matrix positive.
void ContactLoad::addStiffness(double time, const model::State& state, double, BlockSparse& stiffness) const {
  for (const Body& body : bodies_) {
    const ToolParams& tool = body.tool;
    // Also without contact: the pattern stays the same from step to step.
    for (Index i = 0; i < state.size(); ++i) stiffness.add(i, i, Mat3::Zero());
    const double per_mass = isPushing(tool) ? rate_ * rate_ : tool.strength / totalMass();
    forEachTouch(body, time, state.positions, [&](const Touch& touch) {
      stiffness.add(touch.point, touch.point, masses_[touch.point] * per_mass * touch.normal * touch.normal.transpose());
    });
  }
}

void ContactLoad::addRowBounds(double, const model::State& state, std::vector<double>& stiffness, std::vector<double>&) const {
  for (const Body& body : bodies_) {
    const ToolParams& tool = body.tool;
    const double per_mass = isPushing(tool) ? rate_ * rate_ : tool.strength / totalMass();
    for (Index i = 0; i < state.size(); ++i) stiffness[i] += per_mass * masses_[i];
  }
}

void ContactLoad::addReactions(double time, const model::State& state, std::vector<ToolReaction>& reactions) const {
  for (const Body& body : bodies_) {
    const ToolParams& tool = body.tool;
    const auto found = std::find_if(reactions.begin(), reactions.end(), [&](const ToolReaction& r) { return r.id == tool.id; });
    if (found == reactions.end()) continue;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    const tool::Motion motion = tool::findMotion(tool.path, time);
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    forEachTouch(body, time, state.positions, [&](const Touch& touch) {
      const Vec3& x = state.positions[touch.point];
      const Vec3 sliding = findSliding(motion, x, state.velocities[touch.point], touch.normal);
      const Vec3 on_point = touch.force + FrictionLoad::Law(*this, tool, touch).findForce(sliding);
      force -= on_point;
      torque -= (x - pose.position).cross(on_point);
      ++found->contacts;
      found->penetration = std::max(found->penetration, -touch.distance);
    });
    found->force += pose.orientation.conjugate() * force;
    found->torque += pose.orientation.conjugate() * torque;
  }
}

void ContactLoad::appendContacts(double time, const model::State& state, const std::string& id, Index place,
                                 std::vector<Contact>& contacts) const {
  for (const Body& body : bodies_) {
    const ToolParams& tool = body.tool;
    if (tool.id != id) continue;
    const tool::Motion motion = tool::findMotion(tool.path, time);
    forEachTouch(body, time, state.positions, [&](const Touch& touch) {
      const Vec3& x = state.positions[touch.point];
      const Vec3 sliding = findSliding(motion, x, state.velocities[touch.point], touch.normal);
      contacts.push_back(
          {place, touch.point, x, touch.normal, touch.force + FrictionLoad::Law(*this, tool, touch).findForce(sliding)});
    });
  }
}

bool FrictionLoad::rubs(const ToolParams& tool) { return tool.friction > 0.0 && isPushing(tool); }

bool FrictionLoad::isEmpty() const {
  return std::none_of(contact_.bodies_.begin(), contact_.bodies_.end(),
                      [](const ContactLoad::Body& body) { return rubs(body.tool); });
}

FrictionLoad::Law::Law(const ContactLoad& contact, const ToolParams& tool, const ContactLoad::Touch& touch)
    : limit(rubs(tool) ? tool.friction * touch.force.norm() : 0.0), creep(rubs(tool) ? creepOf(contact, touch.point) : 0.0) {}

double FrictionLoad::Law::creepOf(const ContactLoad& contact, Index point) { return contact.masses_[point] * contact.rate_; }

Vec3 FrictionLoad::Law::findForce(const Vec3& sliding) const {
  const double speed = sliding.norm();
  if (!(speed > 0.0)) return Vec3::Zero();
  return -std::min(limit, creep * speed) / speed * sliding;
}

double FrictionLoad::Law::findDamping(const Vec3& sliding) const {
  const double speed = sliding.norm();
  return speed > 0.0 ? std::min(limit / speed, creep) : creep;
}

// Calls visit(touch, law, motion) for every point that a tool rubs; motion: that of the tool at the time motion_time.
template <class Visit>
void FrictionLoad::forEachRub(double motion_time, double time, const Points& positions, Visit&& visit) const {
  for (const ContactLoad::Body& body : contact_.bodies_) {
    if (!rubs(body.tool)) continue;
    const tool::Motion motion = tool::findMotion(body.tool.path, motion_time);
    contact_.forEachTouch(body, time, positions,
                          [&](const ContactLoad::Touch& touch) { visit(touch, Law(contact_, body.tool, touch), motion); });
  }
}

void FrictionLoad::addForces(double time, const model::State& state, Points& forces) const {
  const Timer timer;
  forEachRub(time, time, state.positions, [&](const ContactLoad::Touch& touch, const Law& law, const tool::Motion& motion) {
    const Index i = touch.point;
    forces[i] += law.findForce(findSliding(motion, state.positions[i], state.velocities[i], touch.normal));
  });
  contact_.seconds_ += timer.seconds();
}

double FrictionLoad::estimateWork(double from, double to, const model::State&, const model::State& after) const {
  double work = 0.0;
  forEachRub(from, to, after.positions, [&](const ContactLoad::Touch& touch, const Law& law, const tool::Motion& motion) {
    work += law.limit * (to - from) * motion.velocityAt(after.positions[touch.point]).norm();
  });
  return work;
}

void FrictionLoad::addStiffness(double time, const model::State& state, double step, BlockSparse& stiffness) const {
  if (!(step > 0.0)) return;
  forEachRub(time, time, state.positions, [&](const ContactLoad::Touch& touch, const Law& law, const tool::Motion& motion) {
    const Index i = touch.point;
    const double damping = law.findDamping(findSliding(motion, state.positions[i], state.velocities[i], touch.normal));
    stiffness.add(i, i, damping / step * (Mat3::Identity() - touch.normal * touch.normal.transpose()));
  });
}

void FrictionLoad::addRowBounds(double, const model::State& state, std::vector<double>&, std::vector<double>& damping) const {
  for (const ContactLoad::Body& body : contact_.bodies_)
    for (Index i = 0; rubs(body.tool) && i < state.size(); ++i) damping[i] += Law::creepOf(contact_, i);
}

}  // namespace deformable_surface::simulation
