// A rigid tool: what it is, what it does and where it goes.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/geometry/solid_params.h"

#include <cmath>
#include <string>
#include <vector>

namespace deformable_surface::tool {

enum class Mode { kSolid };

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
  double friction = 0.0;               // Coulomb's coefficient, >= 0
  std::vector<WaypointParams> path;    // ascending times, at least one; interpolated between and held outside
};

inline void visit(Fields& fields, WaypointParams& p) {
  fields.number("time", p.time, "s", anyFinite(), "when");
  fields.required().vector("position", p.position, "m", between(-1e6, 1e6), "of the tool's origin, in frame_id");
  fields.vector("orientation", p.orientation, "", between(-1.0, 1.0), "quaternion x, y, z, w of length 1");
  constexpr double kLengthTolerance = 1e-3;  // what a quaternion written with few digits may miss
  fields.require(std::abs(p.orientation.norm() - 1.0) <= kLengthTolerance, "orientation",
                 "found a quaternion of length " + formatReal(p.orientation.norm()) + "; accepted: length 1");
}

inline void visit(Fields& fields, ToolParams& p) {
  fields.required().text("id", p.id, "its name, not empty; no two tools share one");
  fields.require(!p.id.empty(), "id", "found empty text; accepted: a name");
  fields.choice("mode", p.mode, {{"solid", Mode::kSolid}}, "`solid` keeps the surface out", {"attract", "move", "erase", "cut", "heat"});
  fields.section("shape", p.shape, "One of sphere, box, cylinder, cone and plane (`plane: {}` is solid below z = 0 of the tool's frame).");
  fields.number("friction", p.friction, "", between(0.0, 1e3), "Coulomb's coefficient; other values than 0 are not built yet");
  fields.require(p.friction == 0.0, "friction", "found a value other than 0, which is not built yet; accepted: 0");
  fields.list("path", p.path, "Where it is; interpolated between the times and held outside them.");
  fields.require(!p.path.empty(), "path", "found no waypoint; accepted: at least one");
  for (std::size_t i = 1; i < p.path.size(); ++i)
    fields.require(p.path[i - 1].time < p.path[i].time, "path[" + std::to_string(i) + "].time",
                   "found " + formatReal(p.path[i].time) + " after " + formatReal(p.path[i - 1].time) + "; accepted: ascending times");
}

}  // namespace deformable_surface::tool
