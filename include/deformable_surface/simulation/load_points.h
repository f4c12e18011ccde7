// The points of a cloud that carry forces with a radius.
#pragma once

#include "deformable_surface/transfer/sampled_points.h"

#include <memory>
#include <vector>

namespace deformable_surface::simulation {

/// Points of the cloud between the simulation points, and how much of the mass of a cell each point stands for. The simulation
/// points stand for the rest, so that the shares of a cell sum to 1.
struct LoadPoints {
  std::shared_ptr<const transfer::SampledPoints> between;  // at least one point
  std::vector<double> share;                               // (points between) of the mass of the cell
  std::vector<double> own_share;                           // (m) of the simulation points
};

}  // namespace deformable_surface::simulation
