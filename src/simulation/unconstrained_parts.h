// What a scene holds from the beginning, and what becomes of the parts that nothing holds (input.unconstrained_parts). Private,
// and apart from the parts themselves: clouds, their copies and the notes of a build ask for it by place.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include "parts.h"

namespace deformable_surface::simulation {

/// Which points (n, 1) lie in parts of which the scene holds a point at time 0: a pinned one, the nearest to an anchor, one
/// inside a tool that moves what it grips, one that touches a solid tool or falls onto it along gravity, or one within reach of
/// a tool that attracts. A robot's links are not known yet.
std::vector<char> markHeldParts(const SceneParams& params, const Parts& parts, const Points& points);

/// Of input.unconstrained_parts: drop, leaves out of the dense points the parts that nothing holds. Their points become holes of
/// the input. InputError if nothing holds any.
void dropUnconstrained(const SceneParams& params, const Parts& parts, RestSurface& s);

/// Of input.unconstrained_parts: freeze, pins the simulation points of parts that nothing holds. InputError if nothing holds any.
void freezeUnconstrained(const SceneParams& params, RestSurface& s);

/// Adds to the notes or warnings which parts of what is simulated nothing holds, and what becomes of them.
void noteUnconstrained(const SceneParams& params, RestSurface& s);

}  // namespace deformable_surface::simulation
