// Plasticity of elastic solids: the part of the deformation that stays. Between steps it changes the reference of strain; forces
// do not depend on it otherwise.
#pragma once

#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/elastic_solid/plasticity_params.h"
#include "deformable_surface/model/elastic_solid/solid_passes.h"

namespace deformable_surface::model {

/// Plasticity by yield, creep and a largest strain [Mueller et al. 2004], with three departures. The split is F = F_e F_p instead
/// of a split of strains, so that co-rotated bodies keep an energy: F_e = F F_p^-1 comes out of the fit with rows
/// F_p^-T g_ij, and the loops over pairs do not change. Only stress beyond the yield flows: the published rule takes all, and
/// then depends on the step. Flow is by the logarithmic deviator, so that det F_p = 1: volume is kept.
///   F_p^-1 <- F_p^-1 exp(-f dev log U),  f = (1 - yield / stress) (1 - exp(-creep dt)),  U^2 = F_e^T F_e,
/// with the stress sqrt(3/2) |dev 2 mu (U - I)|; in a planar solid, which flows in its plane, sqrt(2) times that of its plane.
/// Points that are turned inside out, and points with too few neighbours, do not flow.
class PlasticFlow {
 public:
  PlasticFlow(const SolidRest& rest, const PlasticityParams& params);

  /// Sets the reference of strain in `passes` from plastic (n) of a state.
  void apply(const std::vector<Mat3>& plastic, SolidPasses& passes) const;
  /// One step dt (s) of flow at positions (4 x n padded), in passes and in the state. state.dissipated grows by the lost elastic
  /// energy. Returns whether anything flowed. Parallel.
  bool flow(double dt, const double* positions, SolidPasses& passes, State& state) const;

 private:
  bool flowAt(Index i, double share, const Mat3& F, const SolidRest& rest, Mat3& plastic) const;

  PlasticityParams params_;
  ConsistentGradients at_rest_;
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> axes_;  // (3 x d) in which it flows: of space, or of the plane
  double stress_of_deviator_;                               // Pa
};

}  // namespace deformable_surface::model
