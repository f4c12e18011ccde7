// Of a large depth image the surface that every second pixel of every second row shows. Where simulation points are to be many
// pixels apart it is looked for there, in a quarter of the time. Private.
#pragma once

#include "deformable_surface/cloud/pixel_lattice.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <optional>

namespace deformable_surface::simulation {

struct HalfFrame {
  RestSurface surface;  // its dense points are those pixels', their neighbours among themselves
  cloud::PixelLattice lattice;
};

/// Where that suffices: links between pixels are known, and simulation points asked for by a number that is small for the image.
/// s: with its dense points on the surface.
std::optional<HalfFrame> halveFrame(const SceneParams& params, const RestSurface& s);

/// Completes normals, neighbours and order of the full surface from those of the half one, with its notes. kept: indices of
/// points of the half one, which become those of the full one. Pixels that no link leads to ride along with what is near.
void takeHalf(const Vec3& eye, HalfFrame half, std::vector<Index>& kept, RestSurface& s);

}  // namespace deformable_surface::simulation
