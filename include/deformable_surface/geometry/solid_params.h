// Which solids a tool or a region can be.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/geometry/polyhedron.h"

#include <cmath>
#include <memory>

namespace deformable_surface::geometry {

/// A solid about its own origin, as in shape_msgs/SolidPrimitive: cylinder and cone along z between -height/2 and height/2, the
/// cone's tip at the larger z; the plane is the half-space n . x <= offset |n| with the normal n, which points out of the solid.
struct Solid {
  enum class Kind { kSphere, kBox, kCylinder, kCone, kPlane, kMesh };
  Kind kind = Kind::kSphere;
  double radius = 0.1;                     // m, > 0: sphere, cylinder, base of the cone
  double height = 0.1;                     // m, > 0: cylinder, cone
  Vec3 size{0.1, 0.1, 0.1};                // m, > 0: edges of the box
  Vec3 normal{0.0, 0.0, 1.0};              // of the plane, of any length but zero
  double offset = 0.0;                     // m: plane
  std::shared_ptr<const Polyhedron> mesh;  // of kMesh, once it has been read
  std::string mesh_file;                   // of kMesh: where it is to be read from; empty once it has been
  double mesh_scale = 1.0;                 // units of the file to metres
};

/// Rows of three as the numbers of a scene.
inline Points toRows(const std::vector<Polyhedron::Triangle>& triangles) {
  Points rows;
  for (const Polyhedron::Triangle& t : triangles) rows.emplace_back(t[0], t[1], t[2]);
  return rows;
}

/// Makes the solid the mesh that the rows describe. Returns why the mesh is refused; empty: it is accepted.
inline std::string setMesh(const Points& vertices, const Points& rows, Solid& solid) {
  std::vector<Polyhedron::Triangle> triangles;
  for (const Vec3& row : rows) {
    if (row != row.array().floor().matrix())
      return "triangles: found a corner that is no whole number; accepted: places of vertices, from 0";
    triangles.push_back({static_cast<Index>(row[0]), static_cast<Index>(row[1]), static_cast<Index>(row[2])});
  }
  try {
    solid.mesh = std::make_shared<const Polyhedron>(vertices, triangles);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

inline void visit(Fields& fields, Solid& p) {
  using Kind = Solid::Kind;
  const Range lengths = between(1e-9, 1e6);
  int given = 0;
  if (fields.begin("sphere", p.kind == Kind::kSphere, "")) {
    ++given;
    p.kind = Kind::kSphere;
    fields.required().number("radius", p.radius, "m", lengths, "radius");
    fields.end();
  }
  if (fields.begin("box", p.kind == Kind::kBox, "")) {
    ++given;
    p.kind = Kind::kBox;
    fields.required().vector("size", p.size, "m", lengths, "edge lengths along x, y and z");
    fields.end();
  }
  if (fields.begin("cylinder", p.kind == Kind::kCylinder, "along z, about its middle")) {
    ++given;
    p.kind = Kind::kCylinder;
    fields.required().number("radius", p.radius, "m", lengths, "radius");
    fields.required().number("height", p.height, "m", lengths, "height");
    fields.end();
  }
  if (fields.begin("cone", p.kind == Kind::kCone, "along z, the tip up, about the middle of its height")) {
    ++given;
    p.kind = Kind::kCone;
    fields.required().number("radius", p.radius, "m", lengths, "radius of the base");
    fields.required().number("height", p.height, "m", lengths, "height");
    fields.end();
  }
  if (fields.begin("plane", p.kind == Kind::kPlane, "")) {
    ++given;
    p.kind = Kind::kPlane;
    fields.vector("normal", p.normal, "", between(-1e6, 1e6), "points out of the solid; any length except zero");
    constexpr double kShortest = 1e-9;  // whose direction would be rounding
    fields.require(p.normal.norm() > kShortest, "normal",
                   "found a normal of length " + formatReal(p.normal.norm()) + "; accepted: one with a direction");
    fields.number("offset", p.offset, "m", between(-1e6, 1e6), "distance of the plane from the tool's origin, along the normal");
    fields.end();
  }
  if (fields.begin("mesh", p.kind == Kind::kMesh, "a closed polyhedron, from a file or written out")) {
    ++given;
    p.kind = Kind::kMesh;
    Points vertices = p.mesh ? p.mesh->vertices() : Points(), triangles = p.mesh ? toRows(p.mesh->triangles()) : Points();
    const Points vertices_before = vertices, triangles_before = triangles;
    fields.text("file", p.mesh_file, "`.ply`, `.stl`, `.obj`, `.off` or `.dae` file: path or `package://PACKAGE/PATH`");
    fields.number("scale", p.mesh_scale, "", between(1e-9, 1e9), "metres per file unit");
    fields.rows("vertices", vertices, "m", between(-kMaxLength, kMaxLength), "vertices, if there is no file");
    fields.rows("triangles", triangles, "", between(0.0, kMaxPoints),
                "three indices into vertices each, from 0; all with the same winding");
    fields.require(p.mesh_file.empty() != vertices.empty(), "",
                   "found both or neither of file and vertices; accepted: one of them");
    if (!vertices.empty() && (!p.mesh || vertices != vertices_before || triangles != triangles_before)) {
      const std::string problem = setMesh(vertices, triangles, p);
      fields.require(problem.empty(), "", problem);
    }
    fields.end();
  }
  fields.require(given == 1, "",
                 "found " + std::to_string(given) + " of sphere, box, cylinder, cone, plane and mesh; accepted: one");
}

}  // namespace deformable_surface::geometry
