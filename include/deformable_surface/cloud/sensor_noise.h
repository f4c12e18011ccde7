// Noise of a depth sensor, and the surface behind it. Neighbour search over the surface takes any step for a gap; steps of noise
// are none.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/cloud/clean.h"
#include "deformable_surface/cloud/pixel_links.h"

namespace deformable_surface::cloud {

struct SensorNoise {
  double deviation = 0.0;      // m, standard deviation along the line of sight, else across the surface: median over the points
  double spacing = 0.0;        // m, of neighbouring points: median
  bool is_image = false;       // measured in rows and columns, by depth
  bool is_seen = false;        // points are moved along their lines of sight, else along normals
  Vec3 eye = Vec3::Zero();     // m, where these meet
  bool is_eye_found = false;   // in rows and columns, because input.eye() does not fit them
  bool is_grid_found = false;  // rows and columns were found in the directions of a list of points
  double window = 0.0;         // width of the fitted windows in spacings; 0: points stay in place
  double least_gap = 0.0;      // m: nearer parts cannot be separated in that direction
  Index unexplained = 0;       // points that fit no window explained by noise; they move to the nearest window, if any
  Index num_levels = 0;        // number of depths, if too few to separate sensor steps from flat parts; else 0
  double level_step = 0.0;     // m, from one of these depths to the next
  bool is_thick = false;       // points fill their neighbourhoods: surface and noise cannot be separated
  Points surface;              // (n) points moved onto the surface; empty: not moved
  PixelLinks links;            // of an image on that surface; empty: no image, or too many missing pixels
};

/// Noise above kNoticed spacings moves points onto local planes. These are planes in inverse depth if the points are an image of
/// a pinhole camera anywhere, or seen from input.eye(). The windows are the smallest that leave only that fraction of the noise,
/// as long as noise explains nearly all of them. deviation: m, replaces the measured median. cloud: clean(input). Parallel; O(n
/// window^2) at most.
SensorNoise findSensorNoise(const PointCloud& input, const CleanCloud& cloud, const OrAuto<double>& deviation = {});

constexpr double kNoticed = 0.15;

}  // namespace deformable_surface::cloud
