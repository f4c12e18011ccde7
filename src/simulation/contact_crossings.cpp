// What solid tools pass over within a step, what of it is over again, and what they appear in. Apart from the forces of contact,
// which act in every sub-step: this looks once before a step and once after it.
#include "deformable_surface/simulation/contact_load.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_surface::simulation {
namespace {

using tool::Entry;
using tool::Pose;
using tool::ToolParams;

constexpr int kMaxMoments = 64;
constexpr double kTold = 1e-3;  // of the surface's extent: a tool that appears deeper than that in it is told of
constexpr double kTurn = 0.2;  // rad between two looks at a tool that turns: ways in its frame are then nearly straight

Vec3 toTool(const Pose& pose, const Vec3& point) { return pose.orientation.conjugate() * (point - pose.position); }

struct Moment {
  double share;  // of the step
  Pose pose;
};

// Where a tool is at moments of a step between which it goes straight and turns little. As many as fit: a path with more corners
// in one step than that is seen without the last of them.
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

// The first crossing of a point that moves straight and evenly in the world.
std::optional<Entry> findCrossing(const ToolParams& tool, const Moments& moments, const Vec3& from, const Vec3& to) {
  Vec3 last = toTool(moments.all[0].pose, from);
  for (int k = 1; k < moments.count; ++k) {
    const Vec3 next = toTool(moments.all[k].pose, from + moments.all[k].share * (to - from));
    if (const std::optional<Entry> entry = tool::findCrossing(tool.shape, last, next)) return entry;
    last = next;
  }
  return std::nullopt;
}

bool passes(const ToolParams& tool, double time) {
  return tool.mode == tool::Mode::kSolid && tool.shape.kind != geometry::Solid::Kind::kPlane && tool::isActive(tool, time);
}

// Whether a point went through a triangle while both moved evenly.
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

}  // namespace

// Of a tool that acts for the first time.
void ContactLoad::findOverlaps(double time, double step, const model::State& state, const std::vector<char>& held, Body& body) {
  body.has_appeared = true;
  body.appeared = time;
  body.eased_in = time + std::max(kEaseIn, step);
  body.overlaps.clear();
  const Pose pose = tool::interpolate(body.tool.path, time);
  Eigen::AlignedBox3d extent;
  double deepest = 0.0;
  for (Index i = 0; i < state.size(); ++i) {
    extent.extend(state.positions[i]);
    const double depth = -tool::findSignedDistance(body.tool.shape, pose, state.positions[i], 0.0).distance;
    if (held[i] || !(depth > 0.0)) continue;
    body.overlaps.push_back({i, depth});
    deepest = std::max(deepest, depth);
  }
  if (!(deepest > kTold * extent.diagonal().norm())) return;
  appendNotice(news_, "tool " + quote(body.tool.id) + " appears where " + std::to_string(body.overlaps.size()) + " of " +
                          std::to_string(state.size()) + " simulation points already are, up to " + formatShort(deepest) +
                          " m deep; they are pushed out within " + formatShort(body.eased_in - time) +
                          " s, each by its shortest way, so that it is better to let a tool arrive from outside");
}

bool ContactLoad::beginStep(double time, double step, const model::State& state, const std::vector<char>& held) {
  before_ = state.positions;
  news_.clear();
  bool any = false;
  for (Body& body : bodies_) {
    const bool pushes = body.tool.mode != tool::Mode::kAttract && tool::isActive(body.tool, time);
    if (eases_ && pushes && !body.has_appeared) {
      findOverlaps(time, step, state, held, body);
      any = any || !body.overlaps.empty();
    }
    any = any || !body.passed.empty();
    if (!passes(body.tool, time)) {
      body.passed.clear();
      continue;
    }
    const Moments moments = listMoments(body.tool, time, step);
    scratch_.clear();
    auto passed = body.passed.begin();
    for (Index i = 0; i < state.size(); ++i) {
      const bool was_passed = passed != body.passed.end() && passed->point == i;
      if (was_passed) ++passed;
      if (held[i]) continue;
      if (was_passed) {
        const Entry& entry = (passed - 1)->entry;
        const Vec3 place = toTool(moments.all[0].pose, state.positions[i]);
        const geometry::SignedDistance now = geometry::findSignedDistance(body.tool.shape, place);
        if (!tool::pushesBack(entry, now) && tool::isHeldUp(body.tool.shape, entry, place, now)) {
          scratch_.push_back(*(passed - 1));
          continue;
        }
      }
      const Vec3 next = state.positions[i] + step * state.velocities[i];
      if (const std::optional<Entry> entry = findCrossing(body.tool, moments, state.positions[i], next))
        scratch_.push_back({i, *entry});
    }
    body.passed.swap(scratch_);
    any = any || !body.passed.empty();
  }
  return any;
}

std::string ContactLoad::endStep(double time, double step, const model::State& state, const std::vector<char>& held,
                                 const std::vector<model::WeightedTriangle>& triangles) {
  std::string notice = std::exchange(news_, "");
  for (Body& body : bodies_) {
    if (!passes(body.tool, time)) continue;
    const Moments moments = listMoments(body.tool, time, step);
    scratch_.clear();
    auto passed = body.passed.begin();
    for (Index i = 0; i < state.size(); ++i) {
      if (passed != body.passed.end() && passed->point == i) {
        scratch_.push_back(*passed++);
      } else if (!held[i]) {
        if (const std::optional<Entry> entry = findCrossing(body.tool, moments, before_[i], state.positions[i]))
          scratch_.push_back({i, *entry});
      }
    }
    body.passed.swap(scratch_);

    // A tool that finds its way between the points, its origin going before.
    if (std::find(told_.begin(), told_.end(), body.tool.id) != told_.end()) continue;
    const auto isPassed = [&](Index i) {
      return std::binary_search(body.passed.begin(), body.passed.end(), Passed{i, {}},
                                [](const Passed& a, const Passed& b) { return a.point < b.point; });
    };
    for (const model::WeightedTriangle& t : triangles) {
      const Vec3 before[3] = {before_[t.corner[0]], before_[t.corner[1]], before_[t.corner[2]]};
      const Vec3 after[3] = {state.positions[t.corner[0]], state.positions[t.corner[1]], state.positions[t.corner[2]]};
      if (!wentThrough(moments.all[0].pose.position, moments.all[moments.count - 1].pose.position, before, after)) continue;
      if (isPassed(t.corner[0]) || isPassed(t.corner[1]) || isPassed(t.corner[2])) continue;
      appendNotice(notice, "tool " + quote(body.tool.id) +
                               " has gone through the surface between its simulation points, which alone are seen");
      told_.push_back(body.tool.id);
      break;
    }
  }
  return notice;
}

void ContactLoad::reset() {
  for (Body& body : bodies_) {
    body.passed.clear();
    body.overlaps.clear();
    body.has_appeared = false;
  }
  told_.clear();
}

void ContactLoad::renumber(const std::vector<Index>& new_index) {
  const auto follow = [&](auto& list) {
    std::size_t kept = 0;
    for (auto entry : list) {
      entry.point = new_index[entry.point];
      if (entry.point >= 0) list[kept++] = entry;
    }
    list.resize(kept);
    std::sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.point < b.point; });
  };
  for (Body& body : bodies_) {
    follow(body.passed);
    follow(body.overlaps);
  }
}

}  // namespace deformable_surface::simulation
