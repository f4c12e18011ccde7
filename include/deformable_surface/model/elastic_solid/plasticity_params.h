// Parameters of the plasticity of elastic solids. The flow needs only these
// of the model's parameters.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/params.h"

namespace deformable_surface::model {

struct PlasticityParams {
  double yield_stress = 0.0;  // Pa, >= 0; 0 = nothing flows
  OrAuto<double> creep;       // 1/s, > 0; auto = at once
  double max_strain = 1.0;    // > 0

  bool isOn() const { return yield_stress > 0.0; }
};

inline void visit(Fields& fields, PlasticityParams& p) {
  fields.number("yield_stress", p.yield_stress, "Pa", between(0.0, 1e15),
                "equivalent stress at which plastic flow starts: von Mises; for planar solids Tresca in the plane; 0 = elastic");
  fields.number("creep", p.creep, "1/s", between(1e-9, 1e12),
                "rate of plastic flow beyond the yield surface; `auto` = complete in every step");
  fields.number("max_strain", p.max_strain, "", between(1e-6, 10.0),
                "equivalent plastic strain (logarithmic) at which flow stops");
}

}  // namespace deformable_surface::model
