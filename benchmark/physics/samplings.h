// The points of flat pieces and spheres in the three samplings. A scanned piece is cut from the pattern of a real depth scan of a
// plane (PCL's sac_plane_test.pcd), repeated by reflection, and left to the product to simplify.
#pragma once

#include "problem.h"

namespace deformable_surface::physics {

struct Sampled {
  Points points;   // m
  Index keep = 0;  // how many of them the simulation keeps; 0 = all
};

/// The rectangle from low to high in z = 0. spacing: of the points that are simulated, m; rounded so that columns and rows end on
/// the edges.
Sampled sampleRectangle(const Vec2& low, const Vec2& high, double spacing, Sampling sampling);

/// The disc about the origin in z = 0.
Sampled sampleDisc(double radius, double spacing, Sampling sampling);

/// The sphere about the origin. There is no scan of a sphere: kScanned is a dense jittered one, simplified.
Sampled sampleSphere(double radius, double spacing, Sampling sampling);

/// The folder of real data that DEFORMABLE_SURFACE_DATA names; empty if there is none.
std::string dataFolder();
/// Whether the scan is there.
bool hasScan();

/// A rotation that has nothing to do with the axes.
Mat3 someRotation();

}  // namespace deformable_surface::physics
