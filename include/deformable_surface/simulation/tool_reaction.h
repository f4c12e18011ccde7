// What the surface does to a tool: contact forces as data. Apart from the loads that give it, because the node publishes it.
#pragma once

#include "deformable_surface/base/types.h"

#include <string>

namespace deformable_surface::simulation {

/// What the surface does to a tool.
struct ToolReaction {
  std::string id;
  Vec3 force = Vec3::Zero();   // N, in the tool's frame
  Vec3 torque = Vec3::Zero();  // N m, in the tool's frame about its origin
  Index contacts = 0;          // simulation points that it touches or holds
  double penetration = 0.0;    // m, the deepest
};

}  // namespace deformable_surface::simulation
