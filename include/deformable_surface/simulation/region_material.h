// What regions of a surface are made of when they differ from the rest: values by point, and their shares of the material that
// the model was made with. Apart from the simulation, because the rest surface and its coarser copies need them, too.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/simulation/scene_params.h"

#include <limits>
#include <vector>

namespace deformable_surface::simulation {

/// The values of a point that differ from the material's; NaN: as everywhere.
struct PointValues {
  static constexpr double kAsEverywhere = std::numeric_limits<double>::quiet_NaN();
  double young_modulus = kAsEverywhere;     // Pa
  double bending_rigidity = kAsEverywhere;  // N m
  double density = kAsEverywhere;           // kg/m^3

  void take(const MaterialChangeParams& change);
  bool areOwn() const;
};

/// Those of the scene's regions, (n): a later region goes over an earlier one. rest (n x 3): where points lie at rest.
std::vector<PointValues> findRegionValues(const std::vector<RegionParams>& regions, const Points& rest);

/// made: what the model was made with; material: what holds everywhere now; values (n).
std::vector<model::PointMaterial> findShares(const model::MaterialParams& made, const model::MaterialParams& material,
                                             const std::vector<PointValues>& values);

}  // namespace deformable_surface::simulation
