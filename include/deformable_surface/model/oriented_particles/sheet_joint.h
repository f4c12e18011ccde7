// Where two sheets of oriented particles meet, both are opened and their rims are joined by a tube: a change of topology in one
// piece, as pure geometry. Apart from growth.h, whose rules add particles to a surface and never change its topology by intent.
#pragma once

#include "deformable_surface/model/oriented_particles/growth.h"

#include <functional>
#include <optional>
#include <vector>

namespace deformable_surface::model {

struct SheetJoint {
  std::vector<char> is_gone;      // (n): those that were, and those inside the rims
  std::vector<NewParticle> tube;  // parents: remaining particles, the nearest above and below its middle
  Vec3 middle;                    // m
  double apart;                   // m, of the nearest pair there
};

/// Joins two sheets where they come nearest to each other, of all places where two particles i < j
///   - are at most `meeting` apart, and face opposite ways (by 120 degrees or more) along the line between them,
///   - may be joined: may_join(i, j),
///   - and are not within eight steps from neighbour to neighbour of each other, nor any such pair beside them up to a spacing
///     farther apart: no narrow tube is pinched off, and sheets that stay pressed have one tube.
/// The sheets are back to back, like dents, or front to front, like a stem that lands. The axis of the tube is the mean of the
/// normals of all these pairs, its middle that of the pairs. The tube is rings of particles a spacing apart, along a half circle
/// from sheet to sheet; at its waist it is wider than the reach of bonds.
///
/// The tube is as long as the sheets are apart, at least `shortest`, m, and at most `meeting`.
///
/// positions (n x 3) m; orientations, is_gone (n): those that take no part; spacing, reach (of bonds), meeting: m, > 0;
/// candidates: particles that may_join() may accept, ascending. A function of the geometry and the indices alone. O(n log n) if
/// there are candidates.
std::optional<SheetJoint> joinSheets(const Points& positions, const Orientations& orientations, const std::vector<char>& is_gone,
                                     double spacing, double reach, double meeting, double shortest,
                                     const std::vector<Index>& candidates, const std::function<bool(Index, Index)>& may_join);

}  // namespace deformable_surface::model
