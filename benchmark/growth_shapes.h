// Shapes with a known surface for the part "growth": dense oriented points that stand for the true surface, its topology, and
// samples of it.
#pragma once

#include "deformable_surface/base/types.h"

#include <string>
#include <vector>

namespace deformable_surface::benchmark {

struct OrientedPoints {
  Points positions, normals;  // m; unit
};

/// What a surface is made of. Equal for two surfaces that can be deformed into each other.
struct SurfaceKind {
  Index pieces = 1, loops = 0, euler_characteristic = 2;
  bool operator==(const SurfaceKind& other) const {
    return pieces == other.pieces && loops == other.loops && euler_characteristic == other.euler_characteristic;
  }
};

struct GrowthShape {
  std::string name;
  OrientedPoints surface;  // dense, in random order, evenly distributed
  double area = 0.0;       // m^2
  SurfaceKind kind;
};

/// The shapes made by formulas, then those of files in the folder of real data (none if it has none).
std::vector<std::string> listGrowthShapes();
/// Empty surface: the file is missing or has no triangles.
GrowthShape makeGrowthShape(const std::string& name);

/// Samples of a shape: points of its surface at least some distance apart, as many as fit, chosen so that they are about
/// num_samples; each coordinate moved by normal noise of so many spacings. Normals: those of the surface, turned by noise as
/// well.
struct GrowthSamples {
  OrientedPoints points;
  double spacing = 0.0;  // m, of a hexagonal lattice of as many points on that area
};
GrowthSamples takeSamples(const GrowthShape& shape, Index num_samples, double noise, unsigned seed);

}  // namespace deformable_surface::benchmark
