// Which points between simulation points touch tools with springs of their own, in motion, and how far tools grow towards points
// in equilibria. It runs before steps and between searches; contact forces act in every sub-step.
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/simulation/contact_load.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

// Of the radius of a cell, which is about half of the spacing: less is not deeper. The second is for places on triangles.
constexpr double kDeeper = 0.01, kDeeperPlace = 0.02;
// Places on triangles count where the surface is stretched by the first factor, and for tools narrower than the second times the
// radius of the cell. Elsewhere the points carry the surface: a strip that lay on both slid too early over a cylinder.
constexpr double kStretched = 1.1, kSmall = 4.0;
constexpr double kThick = 0.5;  // of the radius of the cell: thinner tools would push places out on the wrong side
constexpr double kNever = std::numeric_limits<double>::infinity();  // s
constexpr double kSettled = 0.01;  // of the largest growth: smaller changes need no new equilibrium

bool isBelow(const ContactLoad::Pressed& a, Index point) { return a.point < point; }
bool isBefore(const ContactLoad::Pressed& a, const ContactLoad::Pressed& b) { return a.point < b.point; }

constexpr Index kLook = 1024;  // points between two checks for an interrupt: milliseconds, also for tools of many triangles

}  // namespace

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

}  // namespace deformable_surface::simulation
