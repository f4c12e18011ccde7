#include "deformable_surface/simulation/contact_load.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>

#include "between_touch.h"
#include "tool_arrival.h"
#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

using tool::Mode;
using tool::ToolParams;

// Minus the derivative, and the value, of the attraction potential at a distance, for unit stiffness; see the class.
double attractionForce(double d, double reach) {
  const double rest = 1.0 - d * d / (reach * reach);
  return -d * rest * rest;
}
double attractionPotential(double d, double reach) {
  const double rest = 1.0 - d * d / (reach * reach);
  return -reach * reach / 6.0 * rest * rest * rest;
}

// Factor on the radius of a ball, so that rounding excludes no point.
constexpr double kBallMargin = 1.0 + 1e-9;

// Largest stretch of the surface at which all touching points between simulation points are found.
constexpr double kMostStretch = 4.0;
constexpr double kInstant = 1e-9;  // of a step: paths may bend where it ends

double sumPotential(const ToolParams& tool, const std::vector<ContactLoad::Touch>& touches) {
  const bool pushing = tool::isPushing(tool);
  double sum = 0.0;
  for (const ContactLoad::Touch& touch : touches)
    sum += touch.stiffness * (pushing ? 0.5 * touch.pressed * touch.pressed : attractionPotential(touch.distance, tool.reach));
  return sum;
}

constexpr double kNoPad = std::numeric_limits<double>::infinity();  // N/m

constexpr Index kLook = 1024;  // points between two checks for an interrupt: milliseconds, also for tools of many triangles

}  // namespace

void ContactLoad::setTools(const std::vector<ToolParams>& tools) {
  std::vector<Body> bodies;
  for (const ToolParams& tool : tools) {
    if (!tool::isPushing(tool) && tool.mode != Mode::kAttract) continue;
    Body body;
    body.tool = tool;
    for (Body& before : bodies_) {
      if (before.tool.id != tool.id) continue;
      if (tool.mode == Mode::kSolid) body.passed = std::move(before.passed);
      body.acts = before.acts;
      if (!tool::isPushing(before.tool) || !tool::isPushing(tool) || !geometry::isSame(before.tool.shape, tool.shape)) continue;
      body.arrival = before.arrival;
      body.pressed = before.pressed;
      body.through = before.through;
      body.tool.path = findArrivingPath(tool.path, body.arrival);
    }
    bodies.push_back(std::move(body));
  }
  bodies_ = std::move(bodies);
  forgetTouches();
}

bool ContactLoad::mayHold(const Vec3& point, const Vec3& direction, double time) const {
  constexpr double kFar = 1e3;  // factor on the distance to the tool and its size: the length of the path that is checked
  return std::any_of(bodies_.begin(), bodies_.end(), [&](const Body& body) {
    const ToolParams& tool = body.tool;
    if (!body.acts.value_or(tool::isActive(tool, time))) return false;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    const Vec3 from = pose.orientation.conjugate() * (point - pose.position), along = pose.orientation.conjugate() * direction;
    const double reach = tool::isPushing(tool) ? 0.0 : tool.reach;
    if (geometry::findSignedDistance(tool.shape, from, reach).distance <= reach) return true;
    const bool is_plane = tool.shape.kind == geometry::Solid::Kind::kPlane;
    const double way = kFar * (from.norm() + (is_plane ? 0.0 : findRadius(tool.shape)));
    return tool::isPushing(tool) && tool::findEntry(tool.shape, from, from + way * along).has_value();
  });
}

void ContactLoad::listTouches(std::size_t b, double time, const model::State& state, const geometry::PointBoxes& boxes,
                              bool to_choose, std::vector<Touch>& touches) const {
  const Body& body = bodies_[b];
  const Points& positions = state.positions;
  touches.clear();
  near_.clear();
  const ToolParams& tool = body.tool;
  if (!body.acts.value_or(tool::isActive(tool, time))) return;
  const tool::Pose pose = tool::interpolate(tool.path, time);
  const bool pushing = tool::isPushing(tool);
  const double per_mass = pushing ? stiffening_ * rate_ * rate_ : tool.strength / points_.totalMass();
  const double radius = findRadius(tool.shape), ball = kBallMargin * (radius + (pushing ? 0.0 : tool.reach));
  const double squared_ball = ball * ball;
  const transfer::SampledPoints* const between = pushing ? points_.between() : nullptr;
  double largest_growth = 0.0;
  for (const Pressed& point : body.pressed) largest_growth = std::max(largest_growth, point.growth);
  const double farthest_between = between ? radius + largest_growth + kMostStretch * between->largestExtent() : 0.0;
  const double farthest = std::max(ball, farthest_between);
  if (body.passed.empty() && body.pressed.empty() && !boxes.mayMeet(pose.position, farthest)) return;
  touches.reserve(points_.size());
  near_.reserve(between ? positions.size() : 0);
  auto passed = body.passed.begin();
  auto pressed = body.pressed.begin();
  const auto lookAt = [&](Index i) {
    // Most points are far from most tools, and are skipped here.
    const bool is_passed = passed != body.passed.end() && passed->point == i;
    const bool is_pressed = pressed != body.pressed.end() && pressed->point == i;
    const double growth = is_pressed ? pressed->growthAt(time) : 0.0;
    double returning = is_pressed ? pressed++->withdrawal.rateAt(time) : 0.0;
    const double squared_distance = (positions[i] - pose.position).squaredNorm();
    double reach = 0.0;
    const bool has_near = between && (to_choose || between->beginSpare(i) > between->begin(i));
    if (has_near && mayTouchBetween(tool.shape, *between, i)) {
      const double farthest_of_cell = radius + largest_growth + kMostStretch * between->extent(i);
      if (!(squared_distance > farthest_of_cell * farthest_of_cell)) {
        const bool is_inland = findEdgeShare(tool.shape, pose, *between, i, positions).value == 0.0;
        if (!is_inland) reach = between->findReach(i, positions);
      }
    }
    if (!is_passed && growth == 0.0 && squared_distance > squared_ball && reach == 0.0) return;
    const double look = reach > 0.0 ? reach + largest_growth : growth;
    geometry::SignedDistance d = tool::findSignedDistance(tool.shape, pose, positions[i], pushing ? look : tool.reach);
    if (reach > 0.0 && d.distance < look) near_.push_back({i, d.distance, reach});
    bool is_held_up = false;
    if (is_passed) {
      const Vec3 place = pose.orientation.conjugate() * (positions[i] - pose.position);
      const tool::Entry& entry = passed->entry;
      is_held_up = !state.hasEscaped(static_cast<Index>(b), i) && tool::isHeldUp(tool.shape, entry, place, d);
      if (is_held_up) {
        d = {entry.heightOf(place) + passed->withdrawal.at(time), pose.orientation * entry.normal};
        returning = passed->withdrawal.rateAt(time);
      }
      ++passed;
    }
    double stiffness = per_mass * points_.massOf(i);
    if (!pushing) {
      if (!(std::abs(d.distance) < tool.reach)) return;
      const double force = stiffness * attractionForce(d.distance, tool.reach);
      touches.push_back({i, positions[i], d.distance, d.normal, force * d.normal, 0.0, stiffness, 1.0, 0.0});
      return;
    }
    const double depth = (is_held_up ? 0.0 : growth) - d.distance;
    if (!(depth > 0.0)) return;
    const double pad = padAt(tool, pose, i, positions);
    const double softness = stiffness > pad ? pad / stiffness : 1.0;
    if (softness == 0.0) return;  // inside a body
    Vec3 force = std::min(stiffness, pad) * depth * d.normal;
    if (pad < stiffness && isShared(tool.shape, i)) {
      // The area that the points between leave to it.
      const double change = padOf(i, true) - padOf(i, false);
      force -= 0.5 * change * depth * depth * findEdgeShare(tool.shape, pose, *between, i, positions).gradient;
    }
    stiffness = std::min(stiffness, pad);
    touches.push_back({i, positions[i], d.distance, d.normal, force, depth, stiffness, softness, returning});
  };
  const Index n = static_cast<Index>(positions.size());
  for (Index begin = 0; begin < n; begin += geometry::PointBoxes::kRun) {
    endIfInterrupted(begin, kLook);
    const Index end = std::min(n, begin + geometry::PointBoxes::kRun);
    const bool is_near = boxes.mayMeet(begin / geometry::PointBoxes::kRun, pose.position, farthest);
    const bool has_passed = passed != body.passed.end() && passed->point < end;
    const bool has_pressed = pressed != body.pressed.end() && pressed->point < end;
    if (!is_near && !has_passed && !has_pressed) continue;
    for (Index i = begin; i < end; ++i) lookAt(i);
  }
  if (between) listTouchesBetween(body, time, pose, positions, largest_growth, touches);
}

// The pressed points, and those of the cells that are near.
void ContactLoad::listTouchesBetween(const Body& body, double time, const tool::Pose& pose, const Points& positions,
                                     double largest_growth, std::vector<Touch>& touches) const {
  const transfer::SampledPoints& between = *points_.between();
  const Index m = points_.numSimulated();
  Index looked = 0;
  const auto look = [&](Index p, const Pressed* pressed) {
    if (points_.isSevered(p)) return;
    endIfInterrupted(looked++, kLook);
    const double growth = pressed ? pressed->growthAt(time) : 0.0;
    const double returning = pressed ? pressed->withdrawal.rateAt(time) : 0.0;
    const bool is_alone = pressed && !grows_ && !between.isPlace(p - m);
    const Vec3 position = points_.place(p, positions);
    const geometry::SignedDistance d = tool::findSignedDistance(body.tool.shape, pose, position, std::max(growth, 0.0));
    const double depth = growth - d.distance;
    if (!(depth > 0.0)) return;
    const EdgeShare share = findEdgeShare(body.tool.shape, pose, between, points_.simulationPointOf(p), positions);
    if (share.value == 0.0) return;
    const double own = stiffening_ * rate_ * rate_ * (is_alone ? points_.ownMassOf(p) : points_.massOf(p)), pad = padOf(p, true);
    const double stiffness = std::min(own, pad), softness = own > pad ? pad / own : 1.0;
    const Vec3 force = share.value * stiffness * depth * d.normal - 0.5 * stiffness * depth * depth * share.gradient;
    touches.push_back(
        {p, position, d.distance, d.normal, force, depth, share.value * stiffness, share.value * softness, returning});
  };
  auto pressed =
      std::lower_bound(body.pressed.begin(), body.pressed.end(), m, [](const Pressed& a, Index p) { return a.point < p; });
  const auto lookPressedBefore = [&](Index p) {
    for (; pressed != body.pressed.end() && pressed->point < p; ++pressed) look(pressed->point, &*pressed);
  };
  for (const NearCell& near : near_)
    for (Index s = between.begin(near.cell); s < between.beginSpare(near.cell); ++s) {
      lookPressedBefore(m + s);
      const bool is_pressed = pressed != body.pressed.end() && pressed->point == m + s;
      if (!is_pressed && near.distance < between.share(s) * near.reach + largest_growth) look(m + s, nullptr);
    }
  lookPressedBefore(points_.size());
}

bool ContactLoad::isShared(const geometry::Solid& shape, Index cell) const {
  return points_.between() && mayTouchBetween(shape, *points_.between(), cell);
}

double ContactLoad::padAt(const ToolParams& tool, const tool::Pose& pose, Index point, const Points& positions) const {
  const Index cell = points_.simulationPointOf(point);
  if (!(compliance_ > 0.0) || !isShared(tool.shape, cell)) return padOf(point, false);
  const double share = findEdgeShare(tool.shape, pose, *points_.between(), cell, positions).value;
  if (share == 1.0) return padOf(point, true);
  return points_.isBetween(point) ? share * padOf(point, true) : share * padOf(point, true) + (1.0 - share) * padOf(point, false);
}

double ContactLoad::ownCompliance() const {
  double largest = 0.0;
  for (const Body& body : bodies_)
    for (Index i = 0; tool::isPushing(body.tool) && i < points_.numSimulated(); ++i)
      largest =
          std::max(largest, points_.areaOf(i, isShared(body.tool.shape, i)) / (stiffening_ * rate_ * rate_ * points_.massOf(i)));
  return largest;
}

bool ContactLoad::boxPoints(const Points& positions) const {
  if (touched_at_ == positions) return false;
  touched_at_ = positions;
  boxes_at_.update(positions);
  return true;
}

const std::vector<std::vector<ContactLoad::Touch>>& ContactLoad::findTouches(double time, const model::State& state) const {
  touches_.resize(bodies_.size());
  if (bodies_.empty()) return touches_;
  const bool have_moved = boxPoints(state.positions);
  if (are_touches_known_ && touched_time_ == time && !have_moved) return touches_;
  for (std::size_t b = 0; b < bodies_.size(); ++b) listTouches(b, time, state, boxes_at_, false, touches_[b]);
  touched_time_ = time;
  are_touches_known_ = true;
  return touches_;
}

void ContactLoad::addForces(double time, const model::State& state, Points& forces) const {
  const Timer timer;
  for (const std::vector<Touch>& touches : findTouches(time, state))
    for (const Touch& touch : touches) points_.addForce(touch.point, state.positions, touch.force, forces);
  seconds_ += timer.seconds();
}

double ContactLoad::potential(double time, const model::State& state) const {
  const std::vector<std::vector<Touch>>& touches = findTouches(time, state);
  double sum = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) sum += sumPotential(bodies_[b].tool, touches[b]);
  return sum;
}

// The tool's motion is that at the end of the step.
double ContactLoad::drivingPower(double time, double step, const model::State& state) const {
  const std::vector<std::vector<Touch>>& touches = findTouches(time, state);
  double power = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (touches[b].empty()) continue;
    const tool::Motion motion = tool::findMotion(bodies_[b].tool.path, time - kInstant * step);
    for (const Touch& touch : touches[b])
      power += touch.force.dot(motion.velocityAt(touch.position)) + touch.stiffness * touch.pressed * touch.returning;
  }
  return power;
}

double ContactLoad::storedEnergy(double time, const model::State& state) const {
  const std::vector<std::vector<Touch>>& touches = findTouches(time, state);
  double sum = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (tool::isPushing(bodies_[b].tool)) sum += sumPotential(bodies_[b].tool, touches[b]);
  return sum;
}

double ContactLoad::estimateWork(double from, double to, const model::State& before, const model::State& after) const {
  if (bodies_.empty()) return 0.0;
  return std::max({0.0, potential(to, before) - potential(from, before), potential(to, after) - potential(from, after)});
}

void ContactLoad::remember(double time, double, model::State& state) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = bodies_[b];
    if (body.passed.empty()) continue;
    const tool::Pose pose = tool::interpolate(body.tool.path, time);
    for (const Passed& passed : body.passed) {
      const Vec3 place = pose.orientation.conjugate() * (state.positions[passed.point] - pose.position);
      if (state.hasEscaped(static_cast<Index>(b), passed.point) || !(passed.entry.heightOf(place) < 0.0)) continue;
      if (!tool::isBeside(body.tool.shape, passed.entry, place, geometry::findSignedDistance(body.tool.shape, place))) continue;
      const std::pair out(static_cast<Index>(b), passed.point);
      state.escaped.insert(std::lower_bound(state.escaped.begin(), state.escaped.end(), out), out);
    }
  }
}

// The curvature of the tool's surface would soften a sliding point. It is left out, so that the matrix stays positive
// semidefinite.
void ContactLoad::addStiffness(double time, const model::State& state, double, BlockSparse& stiffness) const {
  if (bodies_.empty()) return;
  // Also without contact: the sparsity pattern stays the same from step to step.
  for (Index i = 0; i < state.size(); ++i) stiffness.add(i, i, Mat3::Zero());
  for (const std::vector<Touch>& touches : findTouches(time, state))
    for (const Touch& touch : touches)
      points_.addStiffness(touch.point, touch.stiffness * touch.normal * touch.normal.transpose(), stiffness);
}

bool ContactLoad::mayBeDamped(double time, double within, const model::State& state) const {
  if (!hasDamped()) return false;
  const std::vector<std::vector<Touch>>& touches = findTouches(time, state);
  const double fastest = findFastest(state);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!isDamped(bodies_[b].tool)) continue;
    if (!touches[b].empty()) return true;
    listNear(b, time, within, fastest, state);
    if (!near_points_.empty()) return true;
  }
  return false;
}

double ContactLoad::findFastest(const model::State& state) {
  double squared = 0.0;
  for (const Vec3& v : state.velocities) squared = std::max(squared, v.squaredNorm());
  return std::sqrt(squared);
}

void ContactLoad::listNear(std::size_t b, double time, double within, double fastest, const model::State& state) const {
  near_points_.clear();
  near_points_.reserve(state.size());
  const ToolParams& tool = bodies_[b].tool;
  if (!bodies_[b].acts.value_or(tool::isActive(tool, time))) return;
  const double radius = kBallMargin * findRadius(tool.shape);
  const tool::Pose pose = tool::interpolate(tool.path, time);
  const tool::Motion now = tool::findMotion(tool.path, time), later = tool::findMotion(tool.path, time + within);
  const transfer::SampledPoints* const between = tool::isPushing(tool) ? points_.between() : nullptr;
  const std::vector<Touch>& touches = findTouches(time, state)[b];
  touched_.reserve(state.size());
  touched_.assign(touches.empty() ? 0 : state.size(), 0.0);
  for (const Touch& touch : touches) points_.addRowBound(touch.point, 1.0, touched_);
  const auto mayBeNear = [&](Index i) {
    if (!touched_.empty() && touched_[i] > 0.0) return true;
    const Vec3 &x = state.positions[i], &v = state.velocities[i];
    const double way =
        within * std::sqrt(std::max((v - now.velocityAt(x)).squaredNorm(), (v - later.velocityAt(x)).squaredNorm()));
    const double of_cell = between && mayTouchBetween(tool.shape, *between, i) ? kMostStretch * between->extent(i) : 0.0;
    const double reach = way + (tool::isPushing(tool) ? of_cell : tool.reach);
    if ((x - pose.position).norm() > radius + reach) return false;
    // Triangles are not searched: the ball around them is enough for a bound.
    return tool.shape.kind == geometry::Solid::Kind::kMesh ||
           tool::findSignedDistance(tool.shape, pose, x, reach).distance <= reach;
  };
  // The speed past a tool that turns grows with the distance from it. Points that a tool has passed over are pushed from afar.
  const double speed = fastest + std::max(now.velocity.norm(), later.velocity.norm());
  const double turn = within * std::max(now.angular_velocity.norm(), later.angular_velocity.norm());
  const double beside =
      std::max(between ? kMostStretch * between->largestExtent() : 0.0, tool::isPushing(tool) ? 0.0 : tool.reach);
  const bool is_bounded = touches.empty() && turn < 1.0;
  const double farthest =
      is_bounded ? (radius + beside + within * speed) / (1.0 - turn) : std::numeric_limits<double>::infinity();
  for (Index begin = 0; begin < state.size(); begin += geometry::PointBoxes::kRun) {
    endIfInterrupted(begin, kLook);
    if (!boxes_at_.mayMeet(begin / geometry::PointBoxes::kRun, pose.position, farthest)) continue;
    for (Index i = begin; i < std::min(state.size(), begin + geometry::PointBoxes::kRun); ++i)
      if (mayBeNear(i)) near_points_.push_back(i);
  }
}

void ContactLoad::addRowBounds(double time, const model::State& state, std::vector<double>& stiffness,
                               std::vector<double>&) const {
  if (bodies_.empty()) return;
  const double fastest = findFastest(state);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const bool pushes = tool::isPushing(bodies_[b].tool);
    const double per_mass = pushes ? stiffening_ * rate_ * rate_ : bodies_[b].tool.strength / points_.totalMass();
    listNear(b, time, ahead(), fastest, state);
    for (const Index i : near_points_) stiffness[i] += std::min(per_mass * points_.massOf(i), pushes ? padOf(i, false) : kNoPad);
    if (!points_.between()) continue;
    for (const Touch& touch : findTouches(time, state)[b])
      if (points_.isBetween(touch.point)) points_.addRowBound(touch.point, touch.stiffness, stiffness);
  }
}

}  // namespace deformable_surface::simulation
