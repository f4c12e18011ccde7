#include "tool_depth.h"

#include "deformable_surface/contact/closest_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "points_between.h"
#include "tool_reach.h"

namespace deformable_surface::simulation {
namespace {

// Points in a cell at most. All others are then within about a fifth of the spacing of one of them.
constexpr Index kWatched = 16;

// Depth of a tool that counts as in the surface, over the spacing and over the tool's smallest extent. Tools are less deep when
// they have just met it.
constexpr double kUnfelt = 0.1, kInside = 0.25, kLeastInside = 0.01;
// Width of a needle, over the spacing of the cloud: with 1.0 the looks of a needle of 1.4 spacings still had too low a bound.
constexpr double kNeedle = 1.5;
constexpr int kProjections = 16;
// Fractions of that depth: by which projections aim deeper, so that they get there in finitely many steps; and the least by which
// each must come nearer.
constexpr double kSlack = 0.1, kLeastGain = 0.01;

Vec3 findClosest(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<double, 4> weight = contact::findClosestToTriangle(p, a, b, c).weight;
  return -(weight[1] * a + weight[2] * b + weight[3] * c);
}

// Whether a place of the triangle is that deep in a convex solid: alternating projections onto both. Others may be missed.
bool isInside(const geometry::Solid& shape, const tool::Pose& pose, const Vec3& a, const Vec3& b, const Vec3& c, double depth) {
  const double reach = findRadius(shape);
  const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  if ((a - pose.position).squaredNorm() > (reach + longest) * (reach + longest)) return false;
  Vec3 place = findClosest(pose.position, a, b, c);
  if ((place - pose.position).squaredNorm() > reach * reach) return false;
  double before = longest;  // farther away, no place of it is inside
  for (int k = 0; k < kProjections; ++k) {
    const geometry::SignedDistance d = tool::findSignedDistance(shape, pose, place, longest);
    if (d.distance <= -depth) return true;
    if (!(d.distance < before - kLeastGain * depth)) return false;
    before = d.distance;
    place = findClosest(place - (d.distance + (1.0 + kSlack) * depth) * d.normal, a, b, c);
  }
  return false;
}

std::shared_ptr<const transfer::SampledPoints> chooseWatched(const Dynamics& level) {
  SceneParams params = level.params();
  const RestSurface& rest = level.rest();
  // No points between particles touch tools, but they are watched.
  if (rest.dense.positions.size() <= rest.points.size() && rest.between == nullptr) return nullptr;
  const bool touches = !level.kind().traits().is_oriented;
  if (touches && params.contact.cloud_points >= kWatched) return level.loads().contact.points().sharedBetween();
  params.contact.cloud_points = kWatched;
  return touches ? level.kind().makeBetween(params, rest, trianglesOf(level.model()))
                 : choosePointsBetween(params, rest.dense, rest, false);
}

}  // namespace

ToolDepth::ToolDepth(const Dynamics& level) : ToolDepth(static_cast<std::size_t>(level.state().size()), chooseWatched(level)) {}

ToolDepth::ToolDepth(std::size_t num_points, std::shared_ptr<const transfer::SampledPoints> between) : masses_(num_points, 1.0) {
  contact_.setBetween(std::move(between));
}

double ToolDepth::measure(const Dynamics& level) {
  level.loads().contact.copyAll(bodies_);
  for (ContactLoad::Body& body : bodies_) body.pressed.clear();
  contact_.restore(bodies_);
  const auto& touches = contact_.findTouches(level.time(), level.state());
  double deepest = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].tool.mode != tool::Mode::kSolid) continue;
    for (const ContactLoad::Touch& touch : touches[b])
      if (!contact_.points().isHeld(touch.point, level.held())) deepest = std::max(deepest, -touch.distance);
  }
  return deepest;
}

ToolDepth::Unfelt ToolDepth::findUnfelt(const Dynamics& level, double spacing) const {
  const ContactLoad& contact = level.loads().contact;
  const Points& positions = level.state().positions;
  const double cloud_spacing =
      static_cast<Index>(level.rest().dense.positions.size()) > level.state().size() ? level.rest().dense_spacing : 0.0;
  for (std::size_t b = 0; b < contact.all().size(); ++b) {
    const ContactLoad::Body& body = contact.all()[b];
    if (body.tool.mode != tool::Mode::kSolid || body.tool.shape.kind == geometry::Solid::Kind::kPlane) continue;
    if (!body.acts.value_or(false)) continue;
    const auto& touches = contact.findTouches(level.time(), level.state())[b];
    const auto isPushed = [&](const ContactLoad::Touch& touch) { return !contact.points().isHeld(touch.point, level.held()); };
    const bool is_needle = findWidth(body.tool.shape) < kNeedle * cloud_spacing;
    if (std::any_of(touches.begin(), touches.end(), isPushed)) {
      if (is_needle) return {&body.tool, true};
      continue;
    }
    const double wanted =
        std::min(kUnfelt * spacing, (is_needle ? kLeastInside : kInside) * geometry::findSmallestExtent(body.tool.shape));
    const tool::Pose pose = tool::interpolate(body.tool.path, level.time());
    for (const model::WeightedTriangle& t : trianglesOf(level.model())) {
      const auto& [i, j, k] = t.corner;
      const bool is_held = level.held()[i] && level.held()[j] && level.held()[k];
      if (!is_held && isInside(body.tool.shape, pose, positions[i], positions[j], positions[k], wanted))
        return {&body.tool, is_needle};
    }
  }
  return {};
}

}  // namespace deformable_surface::simulation
