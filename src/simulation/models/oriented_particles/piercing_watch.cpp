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
constexpr double kBeside = 1.0;    // spacings: the rim of a hole around the tool
// Particles whose neighbours part before growth puts another one between them are open for a few looks, one or two at a time.
constexpr int kLeastTorn = 2;
constexpr int kLasting = 10;   // looks
constexpr Index kLook = 1024;  // particles between two looks at an interrupt

// A fluid surface under a tension T forms tubes of the radius sqrt(D / 2 T). These bonds carry T = 0.054 E h at most: the tube
// that hangs on the tool, with the widest ring around it, has at least 3 sqrt(D / E h). Both factors were chosen on spheres of
// 500 to 2000 particles with balls of 0.2 and 0.3 of their radius.
constexpr double kSpacings = 4.0;  // below it neither the ball nor the tube behind it stays wider than bonds reach
constexpr double kStiffLengths = 16.0;

bool isWatched(const tool::ToolParams& tool) {
  return tool.mode == tool::Mode::kSolid && tool.shape.kind != geometry::Solid::Kind::kPlane;
}

}  // namespace

std::vector<PiercingWatch::Found> PiercingWatch::look(double time, const std::vector<tool::ToolParams>& tools,
                                                      const model::State& state, double spacing, const KeepOpen& keepOpen) {
  std::vector<Found> found;
  for (auto& [id, watched] : tools_) {
    const auto isIt = [&id = id](const tool::ToolParams& tool) { return tool.id == id; };
    if (std::none_of(tools.begin(), tools.end(), isIt)) watched.forgetLooks();
  }
  for (const tool::ToolParams& tool : tools) {
    if (!isWatched(tool)) continue;
    Watched& watched = tools_[tool.id];
    if (watched.is_through) continue;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    distances_.assign(state.positions.size(), std::numeric_limits<double>::infinity());
    if (tool::isActive(tool, time)) {
      for (Index i = 0; i < state.size(); ++i) {
        endIfInterrupted(i, kLook);
        distances_[i] = tool::findSignedDistance(tool.shape, pose, state.positions[i]).distance;
      }
    }
    const Open open = findOpen(state, spacing, keepOpen, watched);
    if (hasGoneThrough(tool, time, state, spacing, open.is_edge, watched)) {
      watched.is_through = true;
      found.push_back({&tool, true, !watched.has_torn});
      watched.forgetLooks();
    } else if (!watched.has_torn && open.torn >= kLeastTorn) {
      watched.has_torn = true;
      found.push_back({&tool, false, true});
    }
  }
  return found;
}

std::vector<const tool::ToolParams*> PiercingWatch::lookAtBroken(double time, const std::vector<tool::ToolParams>& tools,
                                                                 const Points& broken, double spacing) {
  std::vector<const tool::ToolParams*> found;
  for (const tool::ToolParams& tool : tools) {
    if (!isWatched(tool) || !tool::isActive(tool, time)) continue;
    const tool::Pose pose = tool::interpolate(tool.path, time);
    const bool is_beside = std::any_of(broken.begin(), broken.end(), [&](const Vec3& p) {
      return tool::findSignedDistance(tool.shape, pose, p).distance <= kBeside * spacing;
    });
    if (is_beside && !std::exchange(tools_[tool.id].has_torn, true)) found.push_back(&tool);
  }
  return found;
}

bool PiercingWatch::hasGoneThrough(const tool::ToolParams& tool, double time, const model::State& state, double spacing,
                                   bool is_edge, Watched& watched) {
  const AxisPoints axis = listAxisPoints(tool.shape);
  if (watched.signs.size() != axis.size()) {
    watched.signs.assign(axis.size(), 0.0);
    watched.places.assign(axis.size(), Vec3::Constant(std::numeric_limits<double>::infinity()));
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (const double distance : distances_) nearest = std::min(nearest, distance);
  const double disc = kTouching * spacing;
  const bool touches = nearest <= disc;
  // The edge of a sheet that slides around the tool comes to the other side, too.
  const bool is_at_edge = std::exchange(watched.is_at_edge, is_edge) || is_edge;
  const tool::Pose pose = tool::interpolate(tool.path, time);
  bool is_through = false;
  for (std::size_t k = 0; k < axis.size(); ++k) {
    const Vec3 at = pose.position + pose.orientation * axis[k];
    double& sign = watched.signs[k];
    // Another one of this name, or one that was put elsewhere.
    if (!((at - std::exchange(watched.places[k], at)).norm() <= std::max(0.5 * findWidth(tool.shape), spacing))) sign = 0.0;
    // One that has just left the surface: on the side on which it came?
    if (!touches && sign == 0.0) continue;
    double sum = 0.0, count = 0.0;
    if (std::isfinite(nearest)) {
      const double reach = std::max(disc, nearest + disc);
      for (Index i = 0; i < state.size(); ++i) {
        if (!(distances_[i] <= reach)) continue;
        sum += (state.orientations[i] * Vec3::UnitZ()).dot((at - state.positions[i]).normalized());
        count += 1.0;
      }
    }
    const double before = std::exchange(sign, touches ? sign : 0.0);
    if (!(std::abs(sum) > kClear * count)) continue;
    const double now = sum > 0.0 ? 1.0 : -1.0;
    if (touches) sign = now;
    is_through = is_through || (before * now < 0.0 && !is_at_edge);
  }
  return is_through;
}

PiercingWatch::Open PiercingWatch::findOpen(const model::State& state, double spacing, const KeepOpen& keepOpen,
                                            Watched& watched) {
  Open open;
  is_open_.assign(distances_.size(), 0);
  bool is_any = false;
  for (std::size_t i = 0; i < distances_.size(); ++i) {
    is_open_[i] = distances_[i] <= kBeside * spacing;
    is_any = is_any || is_open_[i];
  }
  if (!is_any) return open;
  keepOpen(is_open_);
  watched.open_looks.resize(state.next_id, 0);
  for (Index i = 0; i < state.size(); ++i) {
    if (!(distances_[i] <= kBeside * spacing)) continue;
    std::uint8_t& looks = watched.open_looks[state.traits[i].id];
    if (!is_open_[i]) {
      looks = 1;
    } else if (looks > 0) {
      looks = static_cast<std::uint8_t>(std::min(looks + 1, kLasting + 1));
      open.torn += looks > kLasting;
    } else {
      open.is_edge = true;
    }
  }
  return open;
}

double findLeastWidth(double spacing, double stiff_length) { return std::max(kSpacings * spacing, kStiffLengths * stiff_length); }

}  // namespace deformable_surface::simulation
