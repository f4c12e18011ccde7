// Continuous collision detection between solid tools and points, and when a recorded crossing ends. It runs once before and once
// after each step; contact forces act in every sub-step.
#include "deformable_surface/base/interrupt.h"
#include "deformable_surface/simulation/contact_load.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>

#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

using tool::Entry;
using tool::Pose;
using tool::ToolParams;

constexpr double kRounding = 1e-6;  // fraction of a step: possible rounding error of the time of its beginning
constexpr Index kLook = 64;         // points between two checks for an interrupt: each may be traced over all moments
constexpr double kBack = 0.01;      // of the depth of a passed point: a withdrawal that is as good as none
constexpr int kMaxMoments = 64;
constexpr double kTurn = 0.2;  // rad between two samples of a turning tool: paths in its frame are then nearly straight

Vec3 toWorld(const Pose& pose, const Vec3& place) { return pose.position + pose.orientation * place; }
Vec3 toTool(const Pose& pose, const Vec3& point) { return pose.orientation.conjugate() * (point - pose.position); }

struct Moment {
  double share;  // fraction of the step
  Pose pose;
};

// Poses of a tool at moments of a step between which it moves straight and turns little. A path with too many corners in one step
// loses the last of them.
struct Moments {
  Moment all[kMaxMoments];
  int count = 0;
};

Moments listMoments(const ToolParams& tool, double time, double step) {
  Moments moments;
  const auto add = [&](double at) {
    if (moments.count < kMaxMoments) moments.all[moments.count++] = {(at - time) / step, tool::interpolate(tool.path, at)};
  };
  double from = time;
  const auto goTo = [&](double corner) {
    const double turn =
        moments.all[moments.count - 1].pose.orientation.angularDistance(tool::interpolate(tool.path, corner).orientation);
    const int pieces = 1 + static_cast<int>(turn / kTurn);
    for (int k = 1; k < pieces; ++k) add(from + (corner - from) * k / pieces);
    add(corner);
    from = corner;
  };
  add(time);
  for (const tool::WaypointParams& w : tool.path)
    if (w.time > time && w.time < time + step) goTo(w.time);
  goTo(time + step);
  moments.all[moments.count - 1] = {1.0, tool::interpolate(tool.path, time + step)};
  return moments;
}

// The first crossing of a point with constant velocity in the world.
std::optional<Entry> findCrossing(const ToolParams& tool, const Moments& moments, const Vec3& from, const Vec3& to) {
  Vec3 last = toTool(moments.all[0].pose, from);
  for (int k = 1; k < moments.count; ++k) {
    const Vec3 next = toTool(moments.all[k].pose, from + moments.all[k].share * (to - from));
    if (const std::optional<Entry> entry = tool::findCrossing(tool.shape, last, next)) return entry;
    last = next;
  }
  return std::nullopt;
}

// A point that has been passed over, at a place of the world. The plane is where the solid alone would push as much.
ContactLoad::Passed findPassed(Index point, const Entry& entry, const ToolParams& tool, const Pose& pose, const Vec3& at,
                               double time) {
  const Vec3 place = toTool(pose, at);
  const double depth = std::max(0.0, -geometry::findSignedDistance(tool.shape, place).distance);
  return {point, entry, {std::max(0.0, -entry.heightOf(place) - depth), time}};
}

bool passes(const ContactLoad::Body& body) {
  return body.tool.mode == tool::Mode::kSolid && body.tool.shape.kind != geometry::Solid::Kind::kPlane && *body.acts;
}

// Whether a point went through a triangle, all with constant velocities.
bool wentThrough(const Vec3& from, const Vec3& to, const Vec3 (&before)[3], const Vec3 (&after)[3]) {
  const Vec3 across_before = (before[1] - before[0]).cross(before[2] - before[0]);
  const Vec3 across_after = (after[1] - after[0]).cross(after[2] - after[0]);
  const double side_before = across_before.dot(from - before[0]), side_after = across_after.dot(to - after[0]);
  if (!((side_before < 0.0) != (side_after < 0.0))) return false;
  const double height_before = side_before / across_before.norm(), height_after = side_after / across_after.norm();
  const double share = height_before / (height_before - height_after);
  const Vec3 at = from + share * (to - from);
  Vec3 corner[3];
  for (int c = 0; c < 3; ++c) corner[c] = before[c] + share * (after[c] - before[c]);
  const Vec3 across = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  for (int c = 0; c < 3; ++c)
    if (!(across.dot((corner[(c + 1) % 3] - corner[c]).cross(at - corner[c])) >= 0.0)) return false;
  return true;
}

// Whether a place is within a closed surface, by its winding number [Van Oosterom and Strackee 1983].
bool isWithin(const Vec3& place, const std::vector<model::WeightedTriangle>& triangles, const Points& positions) {
  if (triangles.empty()) return false;
  Vec3 low = positions[0], high = positions[0];
  for (const Vec3& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if ((place.array() < low.array()).any() || (place.array() > high.array()).any()) return false;
  double number = 0.0;
  for (const model::WeightedTriangle& t : triangles) {
    const Vec3 a = positions[t.corner[0]] - place, b = positions[t.corner[1]] - place, c = positions[t.corner[2]] - place;
    const double u = a.norm(), v = b.norm(), w = c.norm();
    number += t.weight / (2.0 * kPi) * std::atan2(a.dot(b.cross(c)), u * v * w + w * a.dot(b) + u * b.dot(c) + v * c.dot(a));
  }
  return number > 0.5;
}

}  // namespace

bool ContactLoad::beginStep(double time, double step, const model::State& state, const std::vector<char>& held) {
  before_ = state.positions;
  forgetTouches();
  notice_.clear();
  has_new_arrival_ = has_new_detour_ = false;
  bool any = false;
  for (Body& body : bodies_) {
    const bool acts = tool::isActive(body.tool, time + kRounding * step);
    any = any || body.acts != acts;
    body.acts = acts;
    if (!acts) body.arrival = {};
    if (acts && !body.arrival.is_known && body.tool.mode != tool::Mode::kAttract) {
      findArrival(time, step, state, held, body);
      has_new_arrival_ = true;
      has_new_detour_ = has_new_detour_ || !body.arrival.offset.isZero(0.0);
    }
    any = any || !body.passed.empty();
    if (!passes(body)) {
      body.passed.clear();
      continue;
    }
    const Moments moments = listMoments(body.tool, time, step);
    const tool::Motion motion = tool::findMotion(body.tool.path, time);
    scratch_.clear();
    scratch_.reserve(state.size());
    auto passed = body.passed.begin();
    for (Index i = 0; i < state.size(); ++i) {
      endIfInterrupted(i, kLook);
      const bool was_passed = passed != body.passed.end() && passed->point == i;
      if (was_passed) ++passed;
      if (held[i]) continue;
      if (was_passed) {
        const Entry& entry = (passed - 1)->entry;
        const Vec3 place = toTool(moments.all[0].pose, state.positions[i]);
        const geometry::SignedDistance now = geometry::findSignedDistance(body.tool.shape, place);
        const double depth = -entry.heightOf(place);
        const Withdrawal withdrawal = (passed - 1)->withdrawal.goOn(time, depth, motion.velocityAt(state.positions[i]).norm());
        const bool is_back = withdrawal.at(time) <= kBack * depth;
        if (!(is_back && tool::pushesBack(entry, now)) && tool::isHeldUp(body.tool.shape, entry, place, now)) {
          scratch_.push_back({i, entry, withdrawal});
          continue;
        }
      }
      const Vec3 next = state.positions[i] + step * state.velocities[i];
      if (const std::optional<Entry> entry = findCrossing(body.tool, moments, state.positions[i], next))
        scratch_.push_back(findPassed(i, *entry, body.tool, moments.all[0].pose, state.positions[i], time));
    }
    body.passed.swap(scratch_);
    any = any || !body.passed.empty();
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (!grows_ && (!bodies_[b].pressed.empty() || points_.between())) any = updateAlone(time, state, held, b) || any;
  forgetTouches();
  return any || has_new_detour_;
}

std::string ContactLoad::endStep(double time, double step, const model::State& state, const std::vector<char>& held,
                                 const std::vector<model::WeightedTriangle>& triangles, bool is_body) {
  std::string notice;
  gone_through_.clear();
  forgetTouches();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    if (!passes(body)) continue;
    const bool had_passed = !body.passed.empty();
    const Moments moments = listMoments(body.tool, time, step);
    const Pose &from = moments.all[0].pose, &to = moments.all[moments.count - 1].pose;
    scratch_.clear();
    scratch_.reserve(state.size());
    auto passed = body.passed.begin();
    for (Index i = 0; i < state.size(); ++i) {
      endIfInterrupted(i, kLook);
      if (passed != body.passed.end() && passed->point == i) {
        if (!state.hasEscaped(static_cast<Index>(b), i)) scratch_.push_back(*passed);
        ++passed;
      } else if (!held[i]) {
        if (const std::optional<Entry> entry = findCrossing(body.tool, moments, before_[i], state.positions[i]))
          scratch_.push_back(findPassed(i, *entry, body.tool, to, state.positions[i], time + step));
      }
    }
    body.passed.swap(scratch_);

    // A tool that passes between the points: a point of its axis goes through a triangle, or comes into a body.
    const AxisPoints axis = listAxisPoints(body.tool.shape);
    const auto isPassed = [&](Index i) {
      return std::binary_search(body.passed.begin(), body.passed.end(), Passed{i, {}},
                                [](const Passed& a, const Passed& b) { return a.point < b.point; });
    };
    const auto isPierced = [&](const model::WeightedTriangle& t) {
      const Vec3 before[3] = {before_[t.corner[0]], before_[t.corner[1]], before_[t.corner[2]]};
      const Vec3 after[3] = {state.positions[t.corner[0]], state.positions[t.corner[1]], state.positions[t.corner[2]]};
      return std::any_of(axis.begin(), axis.end(),
                         [&](const Vec3& p) { return wentThrough(toWorld(from, p), toWorld(to, p), before, after); }) &&
             !isPassed(t.corner[0]) && !isPassed(t.corner[1]) && !isPassed(t.corner[2]);
    };
    // Triangles of a skin that is pierced may turn over within a step, so that they cannot be followed one by one.
    const auto hasComeIn = [&] {
      return body.passed.empty() && std::any_of(axis.begin(), axis.end(), [&](const Vec3& p) {
               return isWithin(toWorld(to, p), triangles, state.positions) &&
                      (had_passed || !isWithin(toWorld(from, p), triangles, before_));
             });
    };
    if (!(is_body ? hasComeIn() : std::any_of(triangles.begin(), triangles.end(), isPierced))) continue;
    gone_through_ = body.tool.id;
    if (std::find(reported_.begin(), reported_.end(), body.tool.id) != reported_.end()) continue;
    appendNotice(notice, "tool " + quote(body.tool.id) + " has passed through the surface" +
                             (is_body ? ", between the points of the body; friction on the tool, a wider tool or more points may "
                                        "prevent it"
                                      : ": it is narrower than the distance of the points that touch tools"));
    reported_.push_back(body.tool.id);
  }
  return notice;
}

void ContactLoad::reset() {
  for (Body& body : bodies_) {
    body.passed.clear();
    body.pressed.clear();
  }
  forgetTouches();
  reported_.clear();
}

void ContactLoad::takePart(const ContactLoad& whole, const std::vector<Index>& new_index) {
  bodies_ = whole.bodies_;
  points_.takePart(whole.points_, new_index);
  renumber(new_index);
  setRate(whole.rate_);
  setStiffening(whole.stiffening_);
  compliance_ = whole.compliance_;
}

void ContactLoad::renumber(const std::vector<Index>& new_index) {
  forgetTouches();
  for (Body& body : bodies_) {
    std::size_t kept = 0;
    for (const Passed& passed : body.passed)
      if (new_index[passed.point] >= 0) body.passed[kept++] = {new_index[passed.point], passed.entry, passed.withdrawal};
    body.passed.resize(kept);
    std::sort(body.passed.begin(), body.passed.end(), [](const Passed& a, const Passed& b) { return a.point < b.point; });
    const std::vector<Index>& new_number = points_.between() ? points_.numberInPart() : new_index;
    kept = 0;
    for (const Pressed& pressed : body.pressed)
      if (new_number[pressed.point] >= 0) body.pressed[kept++] = {new_number[pressed.point], pressed.growth, pressed.withdrawal};
    body.pressed.resize(kept);
    std::sort(body.pressed.begin(), body.pressed.end(), [](const Pressed& a, const Pressed& b) { return a.point < b.point; });
  }
}

}  // namespace deformable_surface::simulation
