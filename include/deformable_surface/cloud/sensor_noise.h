// Noise of a depth sensor, and the surface behind it. Neighbours over the surface take any step off it for a gap; what noise
// makes is none.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/cloud/clean.h"
#include "deformable_surface/cloud/pixel_links.h"

namespace deformable_surface::cloud {

struct SensorNoise {
  double deviation = 0.0;   // m, standard deviation along the line of sight, else across the surface: median over the points
  double spacing = 0.0;     // m, of neighbouring points: median
  bool is_image = false;    // measured in rows and columns, by depth
  bool is_seen = false;     // points are moved along their lines of sight, else along normals
  double window = 0.0;      // spacings across the windows in which the surface was looked for; 0: points stay where they are
  double least_gap = 0.0;   // m: parts that are nearer to each other in that direction are not told apart
  Index unexplained = 0;    // points that fit no window that noise explains, and go to the nearest, if there is one
  Index num_levels = 0;     // of depths that take too few to tell steps of the sensor from flat parts; else 0
  double level_step = 0.0;  // m, from one of these to the next
  bool is_thick = false;    // points fill their neighbourhoods: there is no telling what is surface and what is noise
  Points surface;           // (n) where the points lie on the surface; empty: where they are
  PixelLinks links;         // of an image on that surface; empty: there is none, or too many of its pixels are missing
};

/// Noise above kNoticed spacings moves points onto local planes (in inverse depth, where the points are an image of a pinhole
/// camera or seen from input.eye()) of the least windows that leave that much of it, as long as noise explains nearly all of
/// them. deviation: m, given in place of the measured median. cloud: clean(input). Parallel; O(n window^2) at most.
SensorNoise findSensorNoise(const PointCloud& input, const CleanCloud& cloud, const OrAuto<double>& deviation = {});

constexpr double kNoticed = 0.15;

}  // namespace deformable_surface::cloud
