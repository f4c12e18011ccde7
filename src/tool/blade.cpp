#include "deformable_surface/tool/blade.h"

#include "deformable_surface/tool/crossing.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::tool {
namespace {

using geometry::SignedDistance;

constexpr double kOut = 1e-6;        // fraction of the segment: offset outside at which a point from inside begins
constexpr double kMostLooks = 1e15;  // per step: as many as there are distinguishable times within it
// With more samples than this in a step, those of a part in which the tool hardly moves, in fractions of the resolution, are
// merged. Otherwise a tool that waits and then jumps would be sampled endlessly where it waits.
constexpr BladeSweep::Look kMany = 10000;
constexpr double kStill = 0.1;
constexpr double kGrazed =
    1.01;  // factor on half of the distance between two points: farther from its middle nothing lies across it

// Of the spacing: a knife moves by no more between two checks of what it passes through, or by half its own passage if that lies
// between the two.
constexpr double kFinest = 0.02, kCoarsest = 0.25;

// The shortest path, m, on which a knife passes a point that moves by up to `slip` (m) in the step. For a box that moves straight
// along its flat side the path is long; else it is the smallest extent.
double findPassage(const ToolParams& tool, double time, double step, double slip) {
  const double smallest = geometry::findSmallestExtent(tool.shape);
  if (tool.shape.kind != geometry::Solid::Kind::kBox) return smallest;
  const Pose first = interpolate(tool.path, time), last = interpolate(tool.path, time + step);
  bool has_corner = false;
  forEachCorner(tool.path, time, time + step, [&](double) { has_corner = true; });
  const Vec3 way = first.orientation.conjugate() * (last.position - first.position);
  if (has_corner || first.orientation.coeffs() != last.orientation.coeffs() || !(way.norm() > slip)) return smallest;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) least = std::min(least, tool.shape.size[k] * way.norm() / (std::abs(way[k]) + slip));
  return std::max(smallest, least);
}

Vec3 toTool(const Pose& pose, const Vec3& point) { return pose.orientation.conjugate() * (point - pose.position); }

Vec3 pushOut(const geometry::Solid& solid, const Vec3& point, double margin) {
  const SignedDistance d = geometry::findSignedDistance(solid, point, 0.0);
  return d.distance > 0.0 ? point : Vec3(point + (margin - d.distance) * d.normal);
}

}  // namespace

bool isBetween(const geometry::Solid& solid, const Vec3& a, const Vec3& b) {
  const double margin = kOut * (b - a).norm();
  const Vec3 from = pushOut(solid, a, margin), to = pushOut(solid, b, margin);
  const std::optional<Entry> in = findEntry(solid, from, to);
  if (!in) return false;
  const std::optional<Entry> out = findEntry(solid, to, from);
  return out && in->normal.dot(out->normal) < 0.0;
}

double findBladeResolution(const ToolParams& tool, double time, double step, const Points& before, const Points& after,
                           double spacing) {
  double slip = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) slip = std::max(slip, (after[i] - before[i]).norm());
  return std::min(kCoarsest * spacing, std::max(kFinest * spacing, 0.5 * findPassage(tool, time, step, slip)));
}

// A plane has no other side, so it cannot lie between two points.
BladeSweep::BladeSweep(const ToolParams& tool, double time, double step, const Points& before, const Points& after, double reach,
                       double resolution)
    : tool_(tool), time_(time), step_(step), reach_(reach), first_(interpolate(tool.path, time)) {
  if (tool.shape.kind == geometry::Solid::Kind::kPlane) return;
  const Pose last = interpolate(tool.path, time + step);
  // A path with corners or rotation is longer than the distance between its ends.
  double longer = 1.0;
  forEachCorner(tool.path, time, time + step, [&](double) { longer += 1.0; });
  bool is_near = false;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vec3 from = toTool(first_, before[i]), to = toTool(last, after[i]);
    const double travel = (to - from).norm();
    if (!(geometry::findSignedDistance(tool.shape, from, reach + travel).distance <= reach + travel)) continue;
    is_near = true;
    travel_ = std::max(travel_, travel);
  }
  if (!is_near) return;
  travel_ *= longer;
  num_looks_ = 1 + static_cast<Look>(std::min(travel_ / resolution, kMostLooks));
  if (num_looks_ > kMany) still_ = kStill * resolution;
  addPieces();
}

// From corner to corner of the path. A sample belongs to the segment in which interpolate() finds it.
void BladeSweep::addPieces() {
  const auto firstFrom = [this](double corner) {
    Look look = static_cast<Look>((corner - time_) / step_ * static_cast<double>(num_looks_));
    while (look > 0 && timeAt(look - 1) >= corner) --look;
    while (look <= num_looks_ && timeAt(look) < corner) ++look;
    return look;
  };
  double from = time_;
  Look first = 0;
  const auto add = [&](double to, Look next) {
    const Pose a = interpolate(tool_.path, from), b = interpolate(tool_.path, to);
    const double share = step_ / (to - from) / static_cast<double>(num_looks_);  // fraction of the segment, between samples
    if (next > first)
      pieces_.push_back(
          {{first, next - 1}, share * (b.position - a.position), share * a.orientation.angularDistance(b.orientation)});
    from = to;
    first = next;
  };
  forEachCorner(tool_.path, time_, time_ + step_, [&](double corner) { add(corner, firstFrom(corner)); });
  add(time_ + step_, num_looks_ + 1);
}

Pose BladeSweep::poseAt(Look look) const { return interpolate(tool_.path, timeAt(look)); }

bool BladeSweep::isNear(const Vec3& point) const {
  const double reach = reach_ + travel_;
  return isNear() && geometry::findSignedDistance(tool_.shape, toTool(first_, point), reach).distance <= reach;
}

// Calls visit(look, pose) at the samples of a segment until it returns true: at all samples at which the tool may touch a ball
// with constant velocity, and otherwise only at those that bisect the rest.
template <class Visit>
bool BladeSweep::visitNear(const Piece& piece, const Looks& looks, const Vec3& before, const Vec3& after, double radius,
                           const Visit& visit) const {
  if (looks.last < looks.first) return false;
  const Look middle = looks.first + (looks.last - looks.first) / 2;
  const Pose pose = poseAt(middle);
  const Vec3 center = toTool(pose, before + static_cast<double>(middle) / static_cast<double>(num_looks_) * (after - before));
  // Path of the ball in the tool's frame from here to either end.
  const double longest = static_cast<double>(looks.last - middle);
  const double way = longest * ((after - before) / static_cast<double>(num_looks_) - piece.move).norm();
  const double reach = radius + way + longest * piece.turn * (center.norm() + way);
  const double distance = geometry::findSignedDistance(tool_.shape, center, reach).distance;
  if (!(distance <= reach)) return false;
  if (visit(middle, pose, distance <= radius)) return true;
  if (reach - radius < still_) return false;
  return visitNear(piece, {looks.first, middle - 1}, before, after, radius, visit) ||
         visitNear(piece, {middle + 1, looks.last}, before, after, radius, visit);
}

BladeSweep::Looks BladeSweep::findLooks(const Vec3& before, const Vec3& after, double radius) const {
  Looks found;
  for (const Piece& piece : pieces_)
    visitNear(piece, piece.looks, before, after, radius, [&](Look look, const Pose&, bool is_near) {
      if (!is_near) return false;
      found = found.last < found.first ? Looks{look, look} : Looks{std::min(found.first, look), std::max(found.last, look)};
      return false;
    });
  return found;
}

bool BladeSweep::isBetweenAt(const Pose& pose, double share, const Pair& pair) const {
  return isBetween(tool_.shape, toTool(pose, pair.a_before + share * (pair.a_after - pair.a_before)),
                   toTool(pose, pair.b_before + share * (pair.b_after - pair.b_before)));
}

bool BladeSweep::wentBetween(const Vec3& a_before, const Vec3& a_after, const Vec3& b_before, const Vec3& b_after,
                             const Looks& looks, std::int64_t* taken) const {
  if (!isNear()) return false;
  const Pair pair{a_before, a_after, b_before, b_after, 0.5 * std::max((b_before - a_before).norm(), (b_after - a_after).norm())};
  const Vec3 before = 0.5 * (a_before + b_before), after = 0.5 * (a_after + b_after);
  const double reach = 0.5 * (b_before - a_before).norm() + travel_;
  if (!(geometry::findSignedDistance(tool_.shape, toTool(first_, before), reach).distance <= reach)) return false;
  for (const Piece& piece : pieces_) {
    const Looks now{std::max(looks.first, piece.looks.first), std::min(looks.last, piece.looks.last)};
    const bool went = visitNear(piece, now, before, after, kGrazed * pair.half, [&](Look look, const Pose& pose, bool is_near) {
      if (taken) ++*taken;
      return is_near && isBetweenAt(pose, static_cast<double>(look) / static_cast<double>(num_looks_), pair);
    });
    if (went) return true;
  }
  return false;
}

}  // namespace deformable_surface::tool
