// The blade with which a knife cuts a surface of particles. Private to this model.
#pragma once

#include "deformable_surface/model/state.h"
#include "deformable_surface/tool/blade.h"

#include <vector>

namespace deformable_surface::simulation {

/// A particle within a knife lies on neither side of it. Those within a thick knife would lose the bonds to both sides and be
/// debris. Here a knife cuts along its middle instead:
/// - a box along its middle plane across its thinnest edge,
/// - what is as wide as it is thick (a needle: cylinders, cones, spheres, square rods) along the way of its axis relative to the
///   particles near it. The axis of a sphere is along their mean normal. A needle that does not move sideways cuts nothing.
/// Meshes cut as they are.
struct ThinBlade {
  tool::ToolParams tool;
  double begin = 0.0, step = 0.0;  // s: the part of the step for which it stands
  Points before, after;            // (n x 3) m, at the beginning and the end of that part
};

/// The blades of a step, in the order of time: one for each straight part of the way. before: positions at its beginning,
/// (n x 3) m; after: at its end. orientations (n): z axes are normals. reach: m, how far from the knife
/// particles matter. spacing: m, of the particles.
std::vector<ThinBlade> findBlades(const tool::ToolParams& knife, double time, double step, const Points& before,
                                  const Points& after, const Orientations& orientations, double reach, double spacing);

}  // namespace deformable_surface::simulation
