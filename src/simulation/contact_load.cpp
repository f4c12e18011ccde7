#include "deformable_surface/simulation/contact_load.h"

#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/base/timer.h"

#include <algorithm>
#include <cmath>

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
// Factors on the radius of a cell, which is half of the spacing. Larger balls enter the surface between simulation points by no
// more than a hundredth of the spacing; heights below the second factor hardly count.
constexpr double kLargeBall = 40.0, kFlat = 0.02;

// Whether a tool may touch points of a cell without touching its simulation point.
bool mayTouchBetween(const geometry::Solid& shape, const transfer::SampledPoints& between, Index cell) {
  if (between.begin(cell) == between.end(cell)) return false;
  const bool is_flat = shape.kind == geometry::Solid::Kind::kPlane ||
                       (shape.kind == geometry::Solid::Kind::kSphere && shape.radius > kLargeBall * between.extent(cell));
  return !is_flat || between.height(cell) > kFlat * between.extent(cell);
}

// Distances from the edges of a flat face, over the radius of a cell: nearer than the first all of its points touch, farther
// than the second only its simulation point.
constexpr double kNearEdge = 3.0, kFarFromEdge = 6.0;

// The share with which points of a cell touch a tool beside its simulation point, and its gradient, 1/m.
struct EdgeShare {
  double value = 1.0;
  Vec3 gradient = Vec3::Zero();
};
EdgeShare findEdgeShare(const geometry::Solid& shape, const tool::Pose& pose, const transfer::SampledPoints& between, Index cell,
                        const Points& positions) {
  const double extent = between.extent(cell);
  const bool may_be_flat = shape.kind == geometry::Solid::Kind::kBox && !between.areLinear();
  if (!may_be_flat || between.height(cell) > kFlat * extent) return {};
  const Vec3 place = pose.orientation.conjugate() * (positions[cell] - pose.position);
  const Vec3 beyond = place.cwiseAbs() - 0.5 * shape.size;
  int face, side;
  beyond.maxCoeff(&face);
  side = face == 0 ? 1 : 0;
  for (int k = 0; k < 3; ++k)
    if (k != face && beyond[k] > beyond[side]) side = k;
  const double width = (kFarFromEdge - kNearEdge) * extent, t = (-beyond[side] - kNearEdge * extent) / width;
  if (!(t > 0.0)) return {};
  if (!(t < 1.0)) return {0.0, Vec3::Zero()};
  const double slope = 6.0 * t * (1.0 - t) / width;
  return {1.0 - t * t * (3.0 - 2.0 * t), pose.orientation * Vec3(std::copysign(slope, place[side]) * Vec3::Unit(side))};
}

// Of the radius of a cell, which is about half of the spacing: less is not deeper. The second is for places on triangles.
constexpr double kDeeper = 0.01, kDeeperPlace = 0.02;
// Places on triangles count where the surface is stretched by the first factor, and for tools narrower than the second times the
// radius of the cell. Elsewhere the points carry the surface: a strip that lay on both slid too early over a cylinder.
constexpr double kStretched = 1.1, kSmall = 4.0;
constexpr double kThick = 0.5;  // of the radius of the cell: thinner tools would push places out on the wrong side
constexpr double kNever = std::numeric_limits<double>::infinity();  // s
constexpr double kInstant = 1e-9;                                   // of a step: paths may bend where it ends
constexpr double kSettled = 0.01;  // of the largest growth: smaller changes need no new equilibrium

bool isBelow(const ContactLoad::Pressed& a, Index point) { return a.point < point; }
bool isBefore(const ContactLoad::Pressed& a, const ContactLoad::Pressed& b) { return a.point < b.point; }

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
  auto pressed = std::lower_bound(body.pressed.begin(), body.pressed.end(), m, isBelow);
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

// Writes the points between that need springs of their own into spare_: of each cell the spare point that is deeper than the
// others, or the touching one that is. After listTouches(), whose near cells it takes.
void ContactLoad::chooseAlone(const Body& body, double time, const Points& positions, const std::vector<char>& held,
                              const std::vector<Touch>& touches, Choice choice) {
  spare_.clear();
  const transfer::SampledPoints* const between = points_.between();
  if (!between || near_.empty()) return;
  deepest_.assign(positions.size(), {});
  auto pressed = body.pressed.begin();
  for (const Touch& touch : touches) {
    while (pressed != body.pressed.end() && pressed->point < touch.point) ++pressed;
    Deepest& deepest = deepest_[points_.simulationPointOf(touch.point)];
    if (points_.isBetween(touch.point) && pressed != body.pressed.end() && pressed->point == touch.point) {
      deepest.has_pressed = true;
      continue;
    }
    const double depth = -touch.distance;
    deepest.next = std::max(deepest.next, std::min(depth, deepest.depth));
    if (depth > deepest.depth) deepest.point = touch.point;
    deepest.depth = std::max(deepest.depth, depth);
  }
  // Beside a point that the tool has passed over, the shortest way out is the wrong one.
  for (const Passed& passed : body.passed) deepest_[passed.point].depth = std::numeric_limits<double>::infinity();
  const tool::Pose pose = tool::interpolate(body.tool.path, time);
  const Index m = points_.numSimulated();
  const bool has_tip = body.tool.shape.kind == geometry::Solid::Kind::kCone;
  const double thickness = geometry::findSmallestExtent(body.tool.shape), width = has_tip ? 0.0 : findWidth(body.tool.shape);
  Index looked = 0;
  for (const NearCell& near : near_) {
    const Deepest& deepest = deepest_[near.cell];
    if ((deepest.point >= 0 || deepest.has_pressed) && isPadded(near.cell)) continue;
    const double radius = between->radius(near.cell), extent = between->extent(near.cell), more = kDeeper * radius;
    const bool takes_cloud = choice.cloud && radius > 0.0;
    const bool needs_places = width < kSmall * extent || near.reach > kStretched * between->restReach(near.cell);
    const bool takes_places = choice.places && needs_places && thickness > kThick * extent;
    const double least_of_place = deepest.depth + kDeeperPlace * extent;
    Pressed chosen{-1, deepest.depth + more};
    auto known = std::lower_bound(body.pressed.begin(), body.pressed.end(), m + between->beginSpare(near.cell), isBelow);
    for (Index s = between->beginSpare(near.cell); s < between->end(near.cell); ++s) {
      while (known != body.pressed.end() && known->point < m + s) ++known;
      const bool is_known = known != body.pressed.end() && known->point == m + s;
      const bool is_place = between->isPlace(s);
      if (!(is_place ? takes_places : takes_cloud)) continue;
      if (is_known || !(near.distance < between->share(s) * near.reach)) continue;
      endIfInterrupted(looked++, kLook);
      const double depth = -tool::findSignedDistance(body.tool.shape, pose, points_.place(m + s, positions), 0.0).distance;
      if (is_place && !(depth > least_of_place)) continue;
      if (depth > chosen.growth && !points_.isSevered(m + s) && !points_.isHeld(m + s, held)) chosen = {m + s, depth};
    }
    const bool is_one_deep = takes_cloud && points_.isBetween(deepest.point) && deepest.depth > deepest.next + more;
    if (chosen.point < 0 && is_one_deep && std::isfinite(deepest.depth)) chosen = {deepest.point, deepest.depth};
    if (chosen.point >= 0) spare_.push_back(chosen);
  }
}

// In motion, before a step: chosen points that are outside are free again, and new ones are chosen. Places on triangles are by
// where all will be at present velocities: one that is chosen before it is deep stores no energy. Returns whether anything has
// changed.
bool ContactLoad::updateAlone(double time, double step, const model::State& state, const std::vector<char>& held, std::size_t b) {
  Body& body = bodies_[b];
  const transfer::SampledPoints* const between = points_.between();
  body.pressed.reserve(points_.size());
  spare_.reserve(state.size());
  const tool::Pose pose = tool::interpolate(body.tool.path, time);
  const tool::Motion motion = tool::findMotion(body.tool.path, time);
  const auto distanceOf = [&](const Vec3& place, double reach) {
    return tool::findSignedDistance(body.tool.shape, pose, place, reach).distance;
  };
  std::size_t kept = 0;
  bool has_changed = false;
  for (const Pressed& pressed : body.pressed) {
    if (!points_.isBetween(pressed.point)) continue;
    const double small = kDeeper * between->extent(points_.simulationPointOf(pressed.point));
    const Vec3 place = points_.place(pressed.point, state.positions);
    const double distance = distanceOf(place, small);
    if (!(distance < small)) continue;
    const double speed = between->isPlace(pressed.point - points_.numSimulated()) ? 0.0 : motion.velocityAt(place).norm();
    const Withdrawal withdrawal = pressed.withdrawal.goOn(time, -distance, speed);
    has_changed = has_changed || pressed.growth > 0.0 || withdrawal.begins != pressed.withdrawal.begins;
    body.pressed[kept++] = {pressed.point, 0.0, withdrawal};
  }
  has_changed = has_changed || kept != body.pressed.size();
  body.pressed.resize(kept);
  if (!between || !*body.acts || !tool::isPushing(body.tool)) return has_changed;
  const auto addChosen = [&] {
    for (const Pressed& chosen : spare_) {
      // The force on it stays.
      const double share = points_.isSpare(chosen.point) ? 0.0 : points_.massOf(chosen.point) / points_.ownMassOf(chosen.point);
      const double depth = std::max(0.0, -distanceOf(points_.place(chosen.point, state.positions), 0.0));
      Withdrawal withdrawal{(1.0 - share) * depth, time};
      if (between->isPlace(chosen.point - points_.numSimulated())) withdrawal.ease = kNever;
      body.pressed.push_back({chosen.point, 0.0, withdrawal});
    }
    std::sort(body.pressed.begin(), body.pressed.end(), isBefore);
    has_changed = has_changed || !spare_.empty();
  };
  if (!between->areLinear()) {
    listTouches(b, time, state, boxes_before_, true, pressing_);
    chooseAlone(body, time, state.positions, held, pressing_, {true, false});
    addChosen();
  }
  // A pad yields to the points of the cloud.
  if (between->hasPlaces() && (between->areLinear() || compliance_ == 0.0)) {
    listTouches(b, time + step, ahead_, boxes_ahead_, true, pressing_);
    chooseAlone(body, time + step, ahead_.positions, held, pressing_, {false, true});
    addChosen();
  }
  return has_changed;
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

// Writes what the growth is to be into grown_. Returns by how much a growth changes at most, m: by the depth, up to its limit.
double ContactLoad::grow(double time, const model::State& state, const std::vector<char>& held, std::size_t b) {
  Body& body = bodies_[b];
  double change = 0.0;
  grown_.clear();
  if (!tool::isPushing(body.tool)) return change;
  boxPoints(state.positions);
  const tool::Pose pose = tool::interpolate(body.tool.path, time);
  listTouches(b, time, state, boxes_at_, true, pressing_);
  auto passed = body.passed.begin();
  for (const Touch& touch : pressing_) {
    while (passed != body.passed.end() && passed->point < touch.point) ++passed;
    const bool is_passed = passed != body.passed.end() && passed->point == touch.point;
    if (is_passed || points_.isHeld(touch.point, held)) continue;
    // The growth so far and the depth, less that of the pad.
    const double pad = padAt(body.tool, pose, touch.point, state.positions);
    grown_.push_back({touch.point, std::clamp((1.0 - touch.stiffness / pad) * touch.pressed, 0.0, most_growth_)});
    const double before = touch.pressed + touch.distance;
    change = std::max(change, std::abs(grown_.back().growth - before));
  }
  chooseAlone(body, time, state.positions, held, pressing_, {true, true});
  for (const Pressed& spare : spare_) {
    if (!points_.isSpare(spare.point)) continue;
    const double depth = std::min(spare.growth, most_growth_);
    grown_.push_back({spare.point, isPadded(spare.point) ? 0.0 : depth});
    change = std::max(change, depth);
  }
  std::sort(grown_.begin(), grown_.end(), isBefore);
  return change;
}

bool ContactLoad::settle(double time, const model::State& state, const std::vector<char>& held) {
  bool has_grown = false;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const double change = grow(time, state, held, b);
    double largest = 0.0;
    for (const Pressed& point : grown_) largest = std::max(largest, point.growth);
    if (!(change > kSettled * largest)) continue;
    bodies_[b].pressed = grown_;
    has_grown = true;
  }
  forgetTouches();
  return has_grown;
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
  const double farthest = is_bounded ? (radius + beside + within * speed) / (1.0 - turn) : kNever;
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
