// A large depth image at half resolution: every second pixel of every second row. If simulation points are many pixels apart,
// they are chosen there, in a quarter of the time. Private.
#pragma once

#include "deformable_surface/cloud/pixel_lattice.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <optional>

namespace deformable_surface::simulation {

struct HalfFrame {
  RestSurface surface;  // its dense points are the pixels of the lattice, its neighbours are among these
  cloud::PixelLattice lattice;
};

/// The half frame, where it suffices: links between pixels are known, and the requested number of simulation points is small for
/// the image. s: with its dense points on the surface.
std::optional<HalfFrame> halveFrame(const SceneParams& params, const RestSurface& s);

/// Completes normals, neighbours and order of the full surface from those of the half frame, with its notes. kept: indices of
/// points of the half frame, changed to those of the full one. Pixels without a link to others move with the nearest points.
void takeHalf(const Vec3& eye, HalfFrame half, std::vector<Index>& kept, RestSurface& s);

}  // namespace deformable_surface::simulation
