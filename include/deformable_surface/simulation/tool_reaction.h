// Contact wrenches on tools and pins, and contact points with tools and of the surface with itself, as data. Loads compute it;
// the node publishes and draws it.
#pragma once

#include "deformable_surface/base/types.h"

#include <string>

namespace deformable_surface::simulation {

/// The wrench of the surface on a tool.
struct ToolReaction {
  std::string id;
  Vec3 force = Vec3::Zero();   // N, in the tool's frame
  Vec3 torque = Vec3::Zero();  // N m, in the tool's frame about its origin
  Index contacts = 0;          // points that it touches (simulation points and those between) or holds
  double penetration = 0.0;    // m, the deepest
};

/// A contact: a tool pushes or draws a point. World frame.
struct Contact {
  Index tool;     // place among Simulation::tools()
  Index point;    // the simulation point, or the nearest one where the tool touches a point between
  Vec3 position;  // m, of the point that the tool touches
  Vec3 normal;    // unit, out of the tool
  double depth;   // m, of the point inside the tool; negative: it is drawn from outside
  Vec3 force;     // N, on the point, friction included
};

/// A contact of the surface with itself: two parts push each other apart. World frame.
struct SelfTouch {
  Index points[4];    // simulation points: of a vertex and a triangle, or of two edges
  double weights[4];  // of the two nearest places: those of the first part sum to 1, those of the second to -1
  Vec3 position;      // m, midway between these places
  Vec3 normal;        // unit, from the second part to the first
  double depth;       // m, the thickness less the distance
  Vec3 force;         // N, on the first part, friction included
};

/// The wrench of the surface on the pins of a region.
struct PinReaction {
  std::string id;              // "pins[0]": that of the scene; kOtherPins: points that were pinned by commands
  Vec3 force = Vec3::Zero();   // N, in the surface's frame
  Vec3 torque = Vec3::Zero();  // N m, in the surface's frame about its origin
  Index points = 0;            // simulation points in it that are held now
};

constexpr char kOtherPins[] = "others";

}  // namespace deformable_surface::simulation
