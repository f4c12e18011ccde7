// How long a link counts when normals say which way the surface goes, and up to which length it is trusted: what the costs of the
// geodesic graph are made of.
#pragma once

#include "deformable_surface/cloud/geodesics.h"

namespace deformable_surface::cloud {

/// Cosine of 107 degrees. Points whose oriented normals turn towards each other by more lie on both sides of a gap, as legs do
/// beside where they are nearest; concave edges of bodies turn by less.
constexpr double kFacingCosine = -0.3;

/// The squared anisotropic length of a link (m^2), symmetric in its ends. See GeodesicGraph.
double measureSquaredLength(const Points& positions, const SurfaceSides& sides, Index i, Index j);

struct TrustRadii {
  std::vector<double> radius;   // (n) m
  bool is_directional = false;  // of a body that is sampled more densely in one direction
};

/// The larger of two lengths around each point. A little more than the ninth decile of the minimum spanning tree's links
/// there, or than the point's own second link, whichever is longer; and, with normals, the first decile of the lengths at which
/// points are surrounded by neighbours, at most twice the first: a sampling that is denser in one direction is held together
/// across it. of_body: the same without normals, if a quarter of the points is surrounded by neighbours in space that far away
/// only. Parallel; O(n k).
TrustRadii findTrustRadii(const Points& positions, const SurfaceSides& sides, const Lists& neighbors, bool of_body);

}  // namespace deformable_surface::cloud
