// A rigid tool: shape, mode and path.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/params.h"
#include "deformable_surface/geometry/solid_params.h"
#include "deformable_surface/tool/tool_modes.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::tool {

constexpr double kLengthTolerance = 1e-3;  // tolerance on the length of a quaternion written with few digits

/// Pose of a tool at a time.
struct WaypointParams {
  double time = 0.0;                     // s
  Vec3 position = Vec3::Zero();          // m
  Vec4 orientation{0.0, 0.0, 0.0, 1.0};  // unit quaternion x, y, z, w
};

struct ToolParams {
  std::string id;
  Mode mode = Mode::kSolid;
  geometry::Solid shape;
  double friction = 0.0;               // coefficient of static friction, >= 0
  OrAuto<double> kinetic_friction;     // coefficient of kinetic friction, at most the static one; auto = friction
  double strength = 0.0;               // >= 0; unit and meaning: kModes
  double reach = 0.0;                  // m, range of its effect from its surface
  double start = -1e300, end = 1e300;  // s: acts in the steps that begin at start <= t < end
  std::vector<WaypointParams> path;    // ascending times, at least one; interpolated between, constant outside
};

/// Modes and their strengths, from the table, for the page of parameters.
const char* describeModes();
const char* describeStrengths();
std::vector<std::pair<const char*, Mode>> listModes();

inline void visit(Fields& fields, WaypointParams& p) {
  fields.number("time", p.time, "s", anyFinite(), "time of the waypoint");
  fields.required().vector("position", p.position, "m", between(-kMaxLength, kMaxLength),
                           "position of the frame's origin, in frame_id");
  fields.vector("orientation", p.orientation, "", between(-1.0, 1.0), "quaternion x, y, z, w of length 1");
  fields.require(std::abs(p.orientation.norm() - 1.0) <= kLengthTolerance, "orientation",
                 "found a quaternion of length " + formatReal(p.orientation.norm()) + "; accepted: length 1");
}

inline void visitPath(Fields& fields, std::vector<WaypointParams>& path, const char* meaning) {
  fields.list("path", path, meaning);
  for (std::size_t i = 1; i < path.size(); ++i)
    fields.require(
        path[i - 1].time < path[i].time, "path[" + std::to_string(i) + "].time",
        "found " + formatReal(path[i].time) + " after " + formatReal(path[i - 1].time) + "; accepted: ascending times");
}

inline void visit(Fields& fields, ToolParams& p) {
  fields.required().text("id", p.id, "unique name, not empty");
  fields.require(!p.id.empty(), "id", "found empty text; accepted: a name");
  fields.choice("mode", p.mode, listModes(), describeModes());
  fields.section(
      "shape", p.shape,
      "One of sphere, box, cylinder, cone, plane and mesh. `plane: {}` is solid below z = 0 of the tool's frame. A cone's tip is "
      "up.");
  fields.number("friction", p.friction, "", between(0.0, 1e3), "Coulomb coefficient of solid, and of cut (oriented particles)");
  fields.number("kinetic_friction", p.kinetic_friction, "", between(0.0, 1e3),
                "Coulomb coefficient of points that slide, at most `friction`; `auto` = friction");
  fields.require(p.kinetic_friction.valueOr(p.friction) <= p.friction, "kinetic_friction",
                 "found " + formatReal(p.kinetic_friction.valueOr(0.0)) + ", more than friction, " + formatReal(p.friction) +
                     "; accepted: at most friction");
  fields.number("strength", p.strength, "", between(0.0, 1e12), describeStrengths());
  const ModeInfo& mode = infoOf(p.mode);
  fields.require(!mode.needs_strength || p.strength > 0.0, "strength",
                 "found 0, with which " + std::string(mode.name) + " does nothing; accepted: above 0");
  fields.number("reach", p.reach, "m", between(0.0, kMaxLength), "attract: distance from the tool's surface up to which it acts");
  fields.require(p.mode != Mode::kAttract || p.reach > 0.0, "reach",
                 "found 0, with which attract does nothing; accepted: above 0");
  fields.number("start", p.start, "s", anyFinite(), "active in the steps that begin at start <= t < end");
  fields.number("end", p.end, "s", anyFinite(), "end of the active time; the default never ends");
  fields.require(p.start < p.end, "end",
                 "found " + formatReal(p.end) + ", which is not after start, " + formatReal(p.start) + "; accepted: start < end");
  visitPath(fields, p.path, "Poses over time. Interpolated between the times, constant outside.");
  fields.require(!p.path.empty(), "path", "found no waypoint; accepted: at least one");
}

}  // namespace deformable_surface::tool
