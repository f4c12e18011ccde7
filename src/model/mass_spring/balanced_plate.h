// The rows of the curvature energy of a plate, and those of the same plate with cuts, which differ only near the cuts.
#pragma once

#include "curvature_fits.h"
#include "moment_balance.h"

namespace deformable_surface::model {

/// n: the points of the clamped plate.
struct BalancedPlate {
  ClampedPlate clamped;
  CurvatureFits fits;              // as they were fitted; without bases where there are cuts
  std::vector<double> areas;       // (n) m^2, thirds of those triangles whose corners all have fits
  Multipliers multipliers;         // (n) of the balance
  std::vector<CurvatureRow> rows;  // (items of the fits' points) in balance
};

BalancedPlate balancePlate(ClampedPlate clamped);

/// cut: the plate of whole with fewer links and triangles. Fits are found anew where their points or links have changed, and
/// multipliers within some rings of these; the others are those of the whole plate. So the work is that near cuts, but for
/// comparisons, O(n), and the result depends on the two plates only, not on the order of the cuts.
BalancedPlate balanceNearCuts(const BalancedPlate& whole, ClampedPlate cut);

}  // namespace deformable_surface::model
