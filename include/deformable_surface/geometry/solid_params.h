// Which solids a tool or a region can be.
#pragma once

#include "deformable_surface/base/params.h"

namespace deformable_surface::geometry {

/// A solid about its own origin, as in shape_msgs/SolidPrimitive: cylinder and cone along z between -height/2 and height/2, the
/// cone's tip at the larger z; the plane is the half-space n . x <= offset |n| with the normal n, which points out of the solid.
struct Solid {
  enum class Kind { kSphere, kBox, kCylinder, kCone, kPlane };
  Kind kind = Kind::kSphere;
  double radius = 0.1;            // m, > 0: sphere, cylinder, base of the cone
  double height = 0.1;            // m, > 0: cylinder, cone
  Vec3 size{0.1, 0.1, 0.1};       // m, > 0: edges of the box
  Vec3 normal{0.0, 0.0, 1.0};     // of the plane, of any length but zero
  double offset = 0.0;            // m: plane
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
    fields.vector("normal", p.normal, "", between(-1e6, 1e6), "points out of the solid; of any length but zero");
    constexpr double kShortest = 1e-9;  // whose direction would be rounding
    fields.require(p.normal.norm() > kShortest, "normal",
                   "found a normal of length " + formatReal(p.normal.norm()) + "; accepted: one with a direction");
    fields.number("offset", p.offset, "m", between(-1e6, 1e6), "of the plane from the tool's origin, along the normal");
    fields.end();
  }
  fields.require(given == 1, "", "found " + std::to_string(given) + " of sphere, box, cylinder, cone and plane; accepted: one");
}

}  // namespace deformable_surface::geometry
