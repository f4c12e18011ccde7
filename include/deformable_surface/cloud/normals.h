// Normals by covariance analysis, and one consistent side for all of them.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"

namespace deformable_surface::cloud {

/// Unit normals of least variance among each point and its neighbours [Su 2007, sec. 3; Pauly 2002]: (n x 3), sign arbitrary.
/// Where the neighbourhood has no plane (collinear, coincident) the normal is some unit vector perpendicular to its line.
Points estimateNormals(const Points& positions, const Lists& neighbors);
/// The same for the marked points alone: the others keep theirs. is_marked: (n).
void estimateNormals(const Points& positions, const Lists& neighbors, const std::vector<char>& is_marked, Points& normals);

/// Unit normals of a surface beside which may be others, and which may have creases. Signs are arbitrary.
struct NormalsInSpace {
  Points normals;            // (n x 3)
  std::vector<char> is_own;  // (n) from a part of the neighbours alone; else as estimateNormals() has it
  Points at_creases;         // (n x 3) the same, but that of one side where a crease is near; empty: the same everywhere
};

/// Of least variance for lists of neighbours in space, which may hold points of other layers. In a thick neighbourhood only those
/// neighbours count that no gap parts from the point, if these are flatter. Where that does not help, the side of a crease is the
/// plane of the nearest twelve, or of a neighbour on whose plane the point lies, if it is flat.
NormalsInSpace estimateNormalsInSpace(const Points& positions, const Lists& neighbors);

/// Normals at the points of the quadratic surfaces that fit their neighbours on the same side: those whose normals are less than
/// 78 degrees and whose lines are at most 44 degrees off. normals: (n x 3) unit, of a common side. Where a point has fewer than
/// six of these, its normal stays. Few neighbours tell the sides of a thin body apart, more of one side give better normals.
Points fitNormals(const Points& positions, const Lists& neighbors, const Points& normals);

/// Turns the normals of points towards the eye, each for itself, without regard to neighbours.
void faceEye(const Points& positions, const Vec3& eye, Points& normals);

/// How a surface's outward side was decided, for the log.
enum class OrientationRule { kInputNormals, kOutward, kViewpoint, kUp };

/// How neighbours agree on a side. kFlat: by their normals, for clouds denser than the features of the surface. kMirrored: by the
/// normals mirrored at the plane halfway between the two, for sparse samples of sharp bends and thin bodies.
enum class SideLinks { kFlat, kMirrored };

/// Flips normals in place so that neighbours agree (minimum spanning tree over 1 - |n_i . n_j| of the neighbour graph), then
/// decides the side of each connected component. If there are reference normals, their majority decides (zero rows do
/// not vote); else outward if the component is closed (no boundary points: signed volume positive); else towards the
/// viewpoint if there is one; else +z (area-weighted mean; a tie is broken by +y, then +x).
/// Returns the rule used for the largest component. O(n k log n).
OrientationRule orientNormals(const Points& positions, const Lists& neighbors, const std::vector<char>& is_boundary,
                              const Points& reference_normals, const std::optional<Vec3>& viewpoint, Points& normals,
                              SideLinks links = SideLinks::kFlat);

}  // namespace deformable_surface::cloud
