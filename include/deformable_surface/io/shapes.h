// Generated clouds, so that scenes, tests and benchmarks need no files.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/scene_params.h"

namespace deformable_surface::io {

/// The cloud of params.shape, without normals:
/// - sheet: a grid in z = 0 centred at the origin; strip: the same from x = 0 on; both nearly square, with points on all edges;
/// - lattice: points about the origin in z = 0, each equally far from its six first neighbours;
/// - chain: points in line along x about the origin;
/// - sine: a sheet with z = amplitude cos(2 pi x / wavelength);
/// - sphere: a Fibonacci sphere about the origin; cap: its lower part, with a ring of points on the rim;
/// - two_bars: a plate in the x-z plane from x = 0 on with a slit, the gap, about z = 0, which is open at the larger x; the bars
///   are joined over a length of one bar's height;
/// - bar: a box filled with points, from x = 0 on and about the x axis.
/// The count made is near params.points. Jitter moves points within the surface, and those on an edge along it. The same
/// parameters give the same cloud everywhere. Throws InputError if there is no shape.
cloud::PointCloud makeShape(const simulation::CloudParams& params);

}  // namespace deformable_surface::io
