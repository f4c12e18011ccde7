// What a scene holds from the beginning, and the treatment of parts that nothing holds (input.unconstrained_parts). The
// cleaning of clouds, copies and the notes of a build use it. Private.
#pragma once

#include "deformable_surface/simulation/rest_surface.h"

#include "parts.h"

namespace deformable_surface::simulation {

/// Marks points (n, 1) in parts with a point that the scene holds at time 0: a pinned one, the nearest to an anchor, one
/// inside a tool that moves what it grips, one that touches a solid tool or falls onto it along gravity, or one within reach of
/// a tool that attracts. A robot's links are not known yet.
std::vector<char> markHeldParts(const SceneParams& params, const Parts& parts, const Points& points);

/// For input.unconstrained_parts: drop. Removes the parts that nothing holds from the dense points. Their points become holes of
/// the input. InputError if nothing holds any part.
void dropUnconstrained(const SceneParams& params, const Parts& parts, RestSurface& s);

/// For input.unconstrained_parts: freeze. Pins the simulation points of parts that nothing holds. InputError if all are so.
void freezeUnconstrained(const SceneParams& params, RestSurface& s);

/// Adds to the notes or warnings which simulated parts nothing holds, and what happens to them.
void noteUnconstrained(const SceneParams& params, RestSurface& s);

/// Adds a note where equilibria are searched in which parts rest on others, which may not exist.
void noteStaticContact(const SceneParams& params, RestSurface& s);

}  // namespace deformable_surface::simulation
