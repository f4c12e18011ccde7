#include "tool_passage.h"

#include "deformable_surface/base/value.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::simulation {
namespace {

constexpr int kMostPieces = 16;   // of the paths of a step
constexpr double kFast = 0.25;    // widths of the tool in a step
constexpr double kBehind = 0.5;   // spacings behind a thin tool
constexpr double kMiddle = 0.5;   // of the same, for a narrow one
constexpr double kSteep = 0.7;    // of the normal of a triangle, at most across a flat tool
constexpr double kLasting = 0.2;  // s: a surface that is not back before a tool after that stays behind it

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

// m. Points that a tool holds up deeper than that will not come back. A narrow tool holds few points, and half of the depth
// counts.
double findLastDepth(const PassageStep& step) {
  const double thickness = geometry::findSmallestExtent(step.shape);
  if (thickness > step.spacing) return -1.0;  // any
  const double share = findWidth(step.shape) < step.spacing ? kMiddle : 1.0;
  return share * (thickness + kBehind * step.spacing);
}

// How often a surface goes around a place, by its winding number [Van Oosterom and Strackee 1983]. Where a place goes through the
// surface it jumps by 1, also through an open one. positionOf(i): m.
template <class PositionOf>
double findWinding(const Vec3& place, const std::vector<model::WeightedTriangle>& triangles, const PositionOf& positionOf) {
  double number = 0.0;
  for (const model::WeightedTriangle& t : triangles) {
    const Vec3 a = positionOf(t.corner[0]) - place, b = positionOf(t.corner[1]) - place, c = positionOf(t.corner[2]) - place;
    const double u = a.norm(), v = b.norm(), w = c.norm();
    number += t.weight / (2.0 * kPi) * std::atan2(a.dot(b.cross(c)), u * v * w + w * a.dot(b) + u * b.dot(c) + v * c.dot(a));
  }
  return number;
}

// Whether the tool rests, and no point touched it at the beginning.
bool isFallenOn(const PassageStep& step) {
  if (!std::equal(step.from.begin(), step.from.end(), step.to.begin())) return false;
  return std::all_of(step.before.begin(), step.before.end(), [&](const Vec3& x) {
    return geometry::findSignedDistance(step.shape, toTool(step.pose, x)).distance > 0.0;
  });
}

Passage findReason(const PassageStep& step) {
  if (findWidth(step.shape) < step.spacing) return Passage::kNarrow;
  if (geometry::findSmallestExtent(step.shape) < step.spacing) return Passage::kThin;
  return step.is_equilibrium && isFallenOn(step) ? Passage::kSearched : Passage::kSnapped;
}

// m, of the passed points, below the planes at which they came in.
double findDeepest(const PassageStep& step) {
  double deepest = 0.0;
  for (const ContactLoad::Passed& passed : step.passed)
    deepest = std::max(deepest, -passed.entry.heightOf(toTool(step.pose, step.after[passed.point])));
  return deepest;
}

// Whether a place is within a closed surface.
bool isWithin(const Vec3& place, const std::vector<model::WeightedTriangle>& triangles, const Points& positions) {
  if (triangles.empty()) return false;
  Vec3 low = positions[0], high = positions[0];
  for (const Vec3& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if ((place.array() < low.array()).any() || (place.array() > high.array()).any()) return false;
  return findWinding(place, triangles, [&](Index i) { return positions[i]; }) > 0.5;
}

// m, of the surface past a place, both of which move straight: the longest of its points.
double findWay(const Vec3& from, const Vec3& to, const PassageStep& step) {
  double way = (to - from).norm();
  for (std::size_t i = 0; i < step.before.size(); ++i) way = std::max(way, (to - from - step.after[i] + step.before[i]).norm());
  return way;
}

// A place and a surface that move straight: how often the place goes through in the direction of the normals, less how often
// against it. longest: m, of a piece of the paths in which the winding number jumps only there.
int countCrossings(const Vec3& from, const Vec3& to, const PassageStep& step, double longest) {
  const Points &before = step.before, &after = step.after;
  const double way = findWay(from, to, step);
  const int pieces = std::clamp(static_cast<int>(std::ceil(std::min(way / longest, 1.0 * kMostPieces))), 1, kMostPieces);
  const auto windingAt = [&](double share) {
    return findWinding(from + share * (to - from), step.triangles,
                       [&](Index i) -> Vec3 { return before[i] + share * (after[i] - before[i]); });
  };
  int crossings = 0;
  double last = windingAt(0.0);
  for (int k = 1; k <= pieces; ++k) {
    const double next = windingAt(static_cast<double>(k) / pieces);
    if (std::abs(next - last) > 0.5) crossings += next < last ? 1 : -1;
    last = next;
  }
  return crossings;
}

// Triangles that lie along the tool may be dragged into it over its edge; those that stand steep on it are cut by the edge.
bool comesThroughByEdge(const PassageStep& step) {
  if (!step.edges_to || step.had_passed || !step.passed.empty()) return false;
  const AxisPoints &from = step.edges_from->places, &to = step.edges_to->places;
  if (to.size() == 0) return false;
  Vec3 low = from[0], high = from[0];
  for (const AxisPoints* places : {&from, &to})
    for (const Vec3& p : *places) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  for (const model::WeightedTriangle& t : step.triangles) {
    const Vec3 before[3] = {step.before[t.corner[0]], step.before[t.corner[1]], step.before[t.corner[2]]};
    const Vec3 after[3] = {step.after[t.corner[0]], step.after[t.corner[1]], step.after[t.corner[2]]};
    Vec3 least = before[0], most = before[0];
    for (int c = 0; c < 3; ++c) {
      least = least.cwiseMin(before[c]).cwiseMin(after[c]);
      most = most.cwiseMax(before[c]).cwiseMax(after[c]);
    }
    if ((least.array() > high.array()).any() || (most.array() < low.array()).any()) continue;
    const Vec3 normal = (after[1] - after[0]).cross(after[2] - after[0]);
    if (std::abs(normal.dot(step.edges_to->across)) > kSteep * normal.norm()) continue;
    for (std::size_t k = 0; k < to.size(); ++k)
      if (wentThrough(from[k], to[k], before, after)) return true;
  }
  return false;
}

Passage findPassageOfAxis(const PassageStep& step, ContactLoad::Through& through) {
  const auto isPassed = [&](Index i) {
    return std::binary_search(step.passed.begin(), step.passed.end(), ContactLoad::Passed{i, {}},
                              [](const auto& a, const auto& b) { return a.point < b.point; });
  };
  const double width = findWidth(step.shape);
  // A point of the axis goes through a triangle.
  bool is_pierced = false;
  for (const model::WeightedTriangle& t : step.triangles) {
    const Vec3 before[3] = {step.before[t.corner[0]], step.before[t.corner[1]], step.before[t.corner[2]]};
    const Vec3 after[3] = {step.after[t.corner[0]], step.after[t.corner[1]], step.after[t.corner[2]]};
    for (std::size_t k = 0; k < step.from.size(); ++k) {
      if (!wentThrough(step.from[k], step.to[k], before, after)) continue;
      is_pierced = true;
      if (std::any_of(t.corner, t.corner + 3, isPassed)) break;
      if (!step.has_pressed || width < step.spacing) return findReason(step);  // nothing of it will be pushed back
    }
  }
  // Triangles that turn over are not found above. They are fast.
  if (!is_pierced && step.has_pressed) is_pierced = findWay(step.from[0], step.to[0], step) > kFast * width;
  if (!step.had_passed && step.passed.empty() && !is_pierced && !through.isAny()) return Passage::kNone;
  if (!through.isAny()) through.since = step.begins;
  for (std::size_t k = 0; k < step.from.size(); ++k)
    through.crossings[k] += countCrossings(step.from[k], step.to[k], step, 0.5 * width);
  if (!through.isAny()) return Passage::kNone;
  const bool is_pushed = !step.passed.empty() || step.has_pressed;
  const bool stays = step.is_equilibrium || step.ends - through.since > kLasting;
  const bool is_deep = step.passed.empty() || findDeepest(step) > findLastDepth(step);
  if (is_pushed && !(stays && is_deep)) return Passage::kNone;
  through = {};
  return findReason(step);
}

}  // namespace

Passage findPassage(const PassageStep& step, ContactLoad::Through& through) {
  const Passage of_axis = findPassageOfAxis(step, through);
  return of_axis == Passage::kNone && comesThroughByEdge(step) ? findReason(step) : of_axis;
}

// Triangles of a skin that is pierced may turn over within a step, so that they cannot be followed one by one.
Passage findPassageIntoBody(const PassageStep& step) {
  if (!step.passed.empty() && !step.is_equilibrium) return Passage::kNone;
  const bool is_new = step.had_passed && !step.is_equilibrium;  // what held it back is gone
  for (std::size_t k = 0; k < step.to.size(); ++k)
    if (isWithin(step.to[k], step.triangles, step.after) && (is_new || !isWithin(step.from[k], step.triangles, step.before)))
      return Passage::kIntoBody;
  return Passage::kNone;
}

std::string describe(Passage passage, double spacing) {
  switch (passage) {
    case Passage::kNone: break;
    case Passage::kNarrow:
      return ": it is narrower than the distance of the simulation points, " + formatShort(spacing) +
             " m; a wider tool may prevent it";
    case Passage::kThin:
      return ": it is thinner than the distance of the simulation points; a thicker tool or more simulation points may prevent "
             "it";
    case Passage::kSnapped:
      return ": contact did not hold how far the surface is stretched there; a shorter way, a wider tool or more "
             "simulation points may prevent it";
    case Passage::kSearched:
      return ": the search for an equilibrium led past it; with integrator.type auto the surface falls onto it instead";
    case Passage::kIntoBody:
      return ", between the points of the body; friction on the tool, a wider tool or more points may prevent it";
  }
  return "";
}

}  // namespace deformable_surface::simulation
