#include "deformable_surface/simulation/region_material.h"

#include <cmath>

namespace deformable_surface::simulation {

void PointValues::take(const MaterialChangeParams& change) {
  young_modulus = change.young_modulus.valueOr(young_modulus);
  bending_rigidity = change.bending_rigidity.valueOr(bending_rigidity);
  density = change.density.valueOr(density);
}

bool PointValues::areOwn() const { return !(std::isnan(young_modulus) && std::isnan(bending_rigidity) && std::isnan(density)); }

std::vector<PointValues> findRegionValues(const std::vector<RegionParams>& regions, const Points& rest) {
  std::vector<PointValues> values(rest.size());
  for (const RegionParams& region : regions)
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (region.region.contains(rest[i])) values[i].take(region.material);
  return values;
}

std::vector<model::PointMaterial> findShares(const model::MaterialParams& made, const model::MaterialParams& material,
                                             const std::vector<PointValues>& values) {
  const double rigidity = made.bendingRigidity();
  std::vector<model::PointMaterial> shares;
  for (const PointValues& own : values) {
    model::MaterialParams here = material;
    if (!std::isnan(own.young_modulus)) here.young_modulus = own.young_modulus;
    if (!std::isnan(own.bending_rigidity)) here.bending_rigidity = own.bending_rigidity;
    if (!std::isnan(own.density)) here.density = own.density;
    shares.push_back({here.young_modulus / made.young_modulus, rigidity > 0.0 ? here.bendingRigidity() / rigidity : 1.0,
                      here.density / made.density});
  }
  return shares;
}

}  // namespace deformable_surface::simulation
