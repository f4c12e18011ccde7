// A rigid tool: what it is, what it does and where it goes.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/geometry/solid_params.h"

#include <cmath>
#include <string>
#include <vector>

namespace deformable_surface::tool {

/// What a tool does; see docs/tools.md.
enum class Mode { kSolid, kAttract, kMove, kErase, kCut, kHeat };

constexpr double kLengthTolerance = 1e-3;  // what the length of a quaternion written with few digits may miss

/// Where a tool is at a time.
struct WaypointParams {
  double time = 0.0;                   // s
  Vec3 position = Vec3::Zero();        // m
  Vec4 orientation{0.0, 0.0, 0.0, 1.0};  // unit quaternion x, y, z, w
};

struct ToolParams {
  std::string id;
  Mode mode = Mode::kSolid;
  geometry::Solid shape;
  double friction = 0.0;               // Coulomb's coefficient, >= 0: solid, cut
  // >= 0; attract: N/m; move: N at which the grip lets go, 0 = never; heat, cut: K above ambient.
  double strength = 0.0;
  double reach = 0.0;                  // m, > 0: attract: how far from its surface it is felt
  double start = -1e300, end = 1e300;  // s: acts in the steps that begin at start <= t < end
  std::vector<WaypointParams> path;    // ascending times, at least one; interpolated between and held outside
};

inline void visit(Fields& fields, WaypointParams& p) {
  fields.number("time", p.time, "s", anyFinite(), "when");
  fields.required().vector("position", p.position, "m", between(-kMaxLength, kMaxLength), "of the tool's origin, in frame_id");
  fields.vector("orientation", p.orientation, "", between(-1.0, 1.0), "quaternion x, y, z, w of length 1");
  fields.require(std::abs(p.orientation.norm() - 1.0) <= kLengthTolerance, "orientation",
                 "found a quaternion of length " + formatReal(p.orientation.norm()) + "; accepted: length 1");
}

inline void visit(Fields& fields, ToolParams& p) {
  fields.required().text("id", p.id, "its name, not empty; no two tools share one");
  fields.require(!p.id.empty(), "id", "found empty text; accepted: a name");
  fields.choice(
      "mode", p.mode,
      {{"solid", Mode::kSolid},
       {"attract", Mode::kAttract},
       {"move", Mode::kMove},
       {"erase", Mode::kErase},
       {"cut", Mode::kCut},
       {"heat", Mode::kHeat}},
      "`solid` keeps the surface out; `attract` draws it to the tool's surface; `move` carries what is inside when it "
      "begins; `cut` cuts what it goes between (mass_spring), or is solid and heats what it touches (oriented particles); "
      "`erase` takes away what is inside, `heat` warms it (oriented particles)");
  fields.section(
      "shape", p.shape,
      "One of sphere, box, cylinder, cone, plane and mesh (`plane: {}` is solid below z = 0 of the tool's frame; a cone's tip "
      "is up).");
  fields.number("friction", p.friction, "", between(0.0, 1e3), "Coulomb's coefficient of solid and cut");
  fields.number(
      "strength", p.strength, "", between(0.0, 1e12),
      "attract: N/m, shared among all points by mass; move: N at which the grip lets go, 0 = never; heat and cut: K above "
      "ambient, with cut 0 = where bonds are gone");
  const bool needs_strength = p.mode == Mode::kAttract || p.mode == Mode::kHeat;
  fields.require(!needs_strength || p.strength > 0.0, "strength",
                 "found 0, with which attract and heat do nothing; accepted: above 0");
  fields.number("reach", p.reach, "m", between(0.0, kMaxLength), "attract: how far from its surface it is felt");
  fields.require(p.mode != Mode::kAttract || p.reach > 0.0, "reach",
                 "found 0, with which attract does nothing; accepted: above 0");
  fields.number("start", p.start, "s", anyFinite(), "acts in the steps that begin at start <= t < end");
  fields.number("end", p.end, "s", anyFinite(), "the default never ends");
  fields.require(p.start < p.end, "end",
                 "found " + formatReal(p.end) + ", which is not after start, " + formatReal(p.start) + "; accepted: start < end");
  fields.list("path", p.path, "Where it is; interpolated between the times and held outside them.");
  fields.require(!p.path.empty(), "path", "found no waypoint; accepted: at least one");
  for (std::size_t i = 1; i < p.path.size(); ++i)
    fields.require(p.path[i - 1].time < p.path[i].time, "path[" + std::to_string(i) + "].time",
                   "found " + formatReal(p.path[i].time) + " after " + formatReal(p.path[i - 1].time) +
                       "; accepted: ascending times");
}

}  // namespace deformable_surface::tool
