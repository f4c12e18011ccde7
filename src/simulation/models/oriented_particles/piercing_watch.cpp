#include "piercing_watch.h"

#include "deformable_surface/base/interrupt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "../../tool_reach.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kTouching = 0.5;  // spacings: the particle as a disc
constexpr double kClear = 0.25;    // mean cosine between normals and the lines to the tool: in a hole it is near 0
constexpr Index kLook = 1024;      // particles between two looks at an interrupt

// A fluid surface under a tension T forms tubes of the radius sqrt(D / 2 T). These bonds carry T = 0.054 E h at most: the tube
// that hangs on the tool, with the widest ring around it, has at least 3 sqrt(D / E h). Both factors were chosen on spheres of
// 500 to 2000 particles with balls of 0.2 and 0.3 of their radius.
constexpr double kSpacings = 4.0;  // below it neither the ball nor the tube behind it stays wider than bonds reach
constexpr double kStiffLengths = 16.0;

}  // namespace

std::vector<const tool::ToolParams*> PiercingWatch::look(double time, const std::vector<tool::ToolParams>& tools,
                                                         const model::State& state, double spacing) {
  std::vector<const tool::ToolParams*> gone_through;
  for (const tool::ToolParams& tool : tools) {
    if (tool.mode != tool::Mode::kSolid || tool.shape.kind == geometry::Solid::Kind::kPlane) continue;
    Side& side = sides_[tool.id];
    const tool::Pose pose = tool::interpolate(tool.path, time);
    const Vec3& origin = pose.position;
    // Another one of this name, or one that was put elsewhere.
    if (!((origin - std::exchange(side.place, origin)).norm() <= 0.5 * findWidth(tool.shape))) side.sign = 0.0;
    double nearest = std::numeric_limits<double>::infinity();
    if (tool::isActive(tool, time)) {
      distances_.clear();
      for (Index i = 0; i < state.size(); ++i) {
        endIfInterrupted(i, kLook);
        distances_.push_back(tool::findSignedDistance(tool.shape, pose, state.positions[i]).distance);
        nearest = std::min(nearest, distances_.back());
      }
    }
    const double disc = kTouching * spacing;
    const bool touches = nearest <= disc;
    // One that has just left the surface: on the side on which it came?
    if (!touches && side.sign == 0.0) continue;
    double sum = 0.0, count = 0.0;
    if (std::isfinite(nearest)) {
      const double reach = std::max(disc, nearest + disc);
      for (Index i = 0; i < state.size(); ++i) {
        if (!(distances_[i] <= reach)) continue;
        sum += (state.orientations[i] * Vec3::UnitZ()).dot((origin - state.positions[i]).normalized());
        count += 1.0;
      }
    }
    const double before = std::exchange(side.sign, touches ? side.sign : 0.0);
    if (!(std::abs(sum) > kClear * count)) continue;
    const double sign = sum > 0.0 ? 1.0 : -1.0;
    if (before * sign < 0.0 && !std::exchange(side.is_told, true)) gone_through.push_back(&tool);
    if (touches) side.sign = sign;
  }
  return gone_through;
}

double findLeastWidth(double spacing, double stiff_length) { return std::max(kSpacings * spacing, kStiffLengths * stiff_length); }

}  // namespace deformable_surface::simulation
