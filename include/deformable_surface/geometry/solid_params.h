// Which solids a tool or a region can be.
#pragma once

#include "deformable_surface/base/params.h"

namespace deformable_surface::geometry {

/// A solid about its own origin, as in shape_msgs/SolidPrimitive: cylinder and cone along z between -height/2 and height/2, the cone's tip
/// at the larger z; the plane is the half-space z <= 0.
struct Solid {
  enum class Kind { kSphere, kBox, kCylinder, kCone, kPlane };
  Kind kind = Kind::kSphere;
  double radius = 0.1;            // m, > 0: sphere, cylinder, base of the cone
  double height = 0.1;            // m, > 0: cylinder, cone
  Vec3 size{0.1, 0.1, 0.1};       // m, > 0: edges of the box
};

inline void visit(Fields& fields, Solid& p) {
  using Kind = Solid::Kind;
  const Range lengths = between(1e-9, 1e6);
  int given = 0;
  if (fields.begin("sphere", p.kind == Kind::kSphere, "")) {
    ++given;
    p.kind = Kind::kSphere;
    fields.required().number("radius", p.radius, "m", lengths, "its radius");
    fields.end();
  }
  if (fields.begin("box", p.kind == Kind::kBox, "")) {
    ++given;
    p.kind = Kind::kBox;
    fields.required().vector("size", p.size, "m", lengths, "its edges along x, y and z");
    fields.end();
  }
  if (fields.begin("cylinder", p.kind == Kind::kCylinder, "along z, about its middle")) {
    ++given;
    p.kind = Kind::kCylinder;
    fields.required().number("radius", p.radius, "m", lengths, "its radius");
    fields.required().number("height", p.height, "m", lengths, "its height");
    fields.end();
  }
  if (fields.begin("cone", p.kind == Kind::kCone, "along z, the tip up, about the middle of its height")) {
    ++given;
    p.kind = Kind::kCone;
    fields.required().number("radius", p.radius, "m", lengths, "of its base");
    fields.required().number("height", p.height, "m", lengths, "its height");
    fields.end();
  }
  if (fields.begin("plane", p.kind == Kind::kPlane, "")) {
    ++given;
    p.kind = Kind::kPlane;
    fields.end();
  }
  fields.require(given == 1, "", "found " + std::to_string(given) + " of sphere, box, cylinder, cone and plane; accepted: one");
}

}  // namespace deformable_surface::geometry
