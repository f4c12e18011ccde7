// Steps from a cloud to simulation points that several models share, in their order. Private.
#pragma once

#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <functional>
#include <optional>

namespace deformable_surface::simulation {

/// What is known of the neighbours of the dense points, RestSurface::dense_neighbors.
struct FoundNeighbors {
  Points normals;                 // (dense) that these give; empty: not estimated yet
  std::vector<char> are_nearest;  // (dense) lists that hold the nearest in space; empty: not known
};
/// Finds s.dense_neighbors.
using FindNeighbors = std::function<FoundNeighbors(const SceneParams& params, RestSurface& s)>;
/// The 2k neighbours of the dense points: in space, or along the surface. The normals used are the given ones, else those of the
/// neighbours in space.
FoundNeighbors findNeighbors(const SceneParams& params, RestSurface& s);
/// The same in space, or over a body. The normals are zero; every link counts as flat to them.
FoundNeighbors findBodyNeighbors(const SceneParams& params, RestSurface& s);

/// Removes the parts that input.largest_parts and input.unconstrained_parts do not keep from the dense points.
void leaveOutParts(const SceneParams& params, const FindNeighbors& find, RestSurface& s);

/// Normals of the dense points: the given ones, estimated ones (if not done yet) where none is given, all on one consistent
/// side. Returns the boundary.
cloud::Boundary completeNormals(const std::optional<Vec3>& viewpoint, Index k, Points normals, RestSurface& s,
                                cloud::SideLinks links = cloud::SideLinks::kFlat);

/// How many simulation points are asked for of n points; 0: as many as the threshold leaves.
Index countWanted(const SceneParams& params, Index n);

/// Records the order of removal as far as it is needed and returns the simulation points. coarsest: see buildRestSurface().
/// one_by_one: see cloud::simplify().
std::vector<Index> chooseSimulationPoints(const SceneParams& params, const std::vector<Index>& protected_points,
                                          cloud::Boundary& boundary, Index coarsest, RestSurface& s,
                                          Index one_by_one = cloud::kOneByOne);
/// Tells of parts of the cloud that are left out of that order.
void noteLeftOut(RestSurface& s);
/// Makes these dense points the simulation points.
void takePoints(const cloud::CleanCloud& dense, const std::vector<Index>& kept, RestSurface& s);

/// The transfer from the simulation points to the dense ones.
void followSimulationPoints(const SceneParams& params, RestSurface& s);
/// The notes on it, and that counts what there is. will_grow: there are no links yet.
void noteFollowing(RestSurface& s, bool will_grow = false);

}  // namespace deformable_surface::simulation
