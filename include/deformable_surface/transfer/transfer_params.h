// How the displacement of the simulation points reaches the dense ones.
#pragma once

#include "deformable_surface/base/params.h"

namespace deformable_surface::transfer {

/// Weight of a simulation point by its distance r: published is exp(-r^2 / h^2) without cut-off [Su 2007, eq. 8]; compact is the
/// C2 Wendland kernel, which uses few neighbours.
enum class Weighting { kCompact, kGaussian };

/// Normals of the deformed surface: from the transferred gradient, or by a new covariance analysis, as published.
enum class NormalMethod { kGradient, kCovariance };

struct TransferParams {
  Index k = 8;  // 3 .. 64: simulation points per dense point
  Weighting weighting = Weighting::kCompact;
  double gaussian_width = 0.0;  // m, h of eq. 8; 0 = mean distance of the k neighbours
  NormalMethod normals = NormalMethod::kGradient;
};

inline void visit(Fields& fields, TransferParams& p) {
  fields.integer("k", p.k, "", between(3, 64), "number of simulation points that each point follows");
  fields.choice("weighting", p.weighting, {{"compact", Weighting::kCompact}, {"gaussian", Weighting::kGaussian}},
                "weights by distance: `compact` = compact support; `gaussian` = exp(-r^2 / h^2), as published");
  fields.number("gaussian_width", p.gaussian_width, "m", between(0.0, kMaxLength),
                "h of `gaussian`; 0 = mean distance of the k points");
  fields.choice("normals", p.normals, {{"gradient", NormalMethod::kGradient}, {"covariance", NormalMethod::kCovariance}},
                "normals of the deformed surface: `gradient` = from the interpolated deformation gradient; `covariance` = "
                "covariance analysis in every frame, as published");
}

}  // namespace deformable_surface::transfer
