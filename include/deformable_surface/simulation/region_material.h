// Materials of regions that differ from the rest: values by point, relative to the model's material. The rest surface and its
// coarser copies need them as well as the simulation.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/simulation/scene_params.h"

#include <limits>
#include <vector>

namespace deformable_surface::simulation {

/// The values of a point that differ from the material's; NaN: no difference.
struct PointValues {
  static constexpr double kAsEverywhere = std::numeric_limits<double>::quiet_NaN();
  double young_modulus = kAsEverywhere;     // Pa
  double bending_rigidity = kAsEverywhere;  // N m
  double density = kAsEverywhere;           // kg/m^3

  void take(const MaterialChangeParams& change);
  bool areOwn() const;
};

/// The values of the scene's regions, (n): a later region overrides an earlier one. rest (n x 3): the points at rest.
std::vector<PointValues> findRegionValues(const std::vector<RegionParams>& regions, const Points& rest);

/// made: the material of the model when it was made; material: the general one now; values (n).
std::vector<model::PointMaterial> findShares(const model::MaterialParams& made, const model::MaterialParams& material,
                                             const std::vector<PointValues>& values);

}  // namespace deformable_surface::simulation
