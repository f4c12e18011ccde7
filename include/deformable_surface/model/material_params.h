// The material of a surface, in SI units.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/params.h"

namespace deformable_surface::model {

struct MaterialParams {
  double young_modulus = 1.0e5;          // Pa, > 0
  double poisson_ratio = 0.3333;         // > -1, < 0.5 (plane stress; pure springs have 1/3 by construction)
  double thickness = 0.001;              // m, > 0
  OrAuto<double> bending_rigidity;       // N m, >= 0; auto = E h^3 / (12 (1 - nu^2))
  OrAuto<double> bending_poisson_ratio;  // > -1, < 0.5; auto = poisson_ratio where bending_rigidity is auto, else 0
  double density = 1000.0;               // kg/m^3, > 0
  double damping = 0.0;                  // 1/s, >= 0: force = -damping * mass * velocity
  double spring_damping = 0.0;           // s, >= 0: damping constant of a link over its stiffness k

  /// D, N m.
  double bendingRigidity() const {
    return bending_rigidity.valueOr(young_modulus * thickness * thickness * thickness /
                                    (12.0 * (1.0 - poisson_ratio * poisson_ratio)));
  }
  /// Coupling of the curvatures along and across. A stated rigidity is mostly measured on strips, which are free to curve across.
  /// Without coupling, strips of any width have that rigidity.
  double bendingPoissonRatio() const { return bending_poisson_ratio.valueOr(bending_rigidity.is_auto ? poisson_ratio : 0.0); }
  /// kg/m^2.
  double arealDensity() const { return density * thickness; }
};

// The ranges exceed any real material by some powers of ten on either side. They are narrow enough that products of these
// values neither overflow nor become denormal.
inline void visit(Fields& fields, MaterialParams& p) {
  fields.number("young_modulus", p.young_modulus, "Pa", between(1e-6, 1e15), "Young's modulus E; the membrane stiffness is E h");
  fields.number("poisson_ratio", p.poisson_ratio, "", strictlyBetween(-1.0, 0.5),
                "Poisson's ratio nu in plane stress. Springs have 1/3 by construction. Oriented particles use it only for "
                "`bending_rigidity: auto`");
  fields.number("thickness", p.thickness, "m", between(1e-10, 1e3), "thickness h of the surface");
  fields.number("bending_rigidity", p.bending_rigidity, "N m", between(0.0, 1e20),
                "bending rigidity D; `auto` = E h^3 / (12 (1 - nu^2))");
  fields.number("bending_poisson_ratio", p.bending_poisson_ratio, "", strictlyBetween(-1.0, 0.5),
                "Poisson's ratio of bending, for `mass_spring.bending: curvature`. `auto` = poisson_ratio with "
                "`bending_rigidity: auto` (a plate of one material). With a stated bending_rigidity `auto` = 0: strips of any "
                "width then have that rigidity");
  fields.number("density", p.density, "kg/m^3", between(1e-6, 1e9), "mass density; the areal density is density times h");
  fields.number("damping", p.damping, "1/s", between(0.0, 1e9), "mass-proportional damping: force = -damping * mass * velocity");
  fields.number("spring_damping", p.spring_damping, "s", between(0.0, 1e3),
                "stiffness-proportional damping of links: damping constant over stiffness. `mass_spring.damping` selects the "
                "velocity that it acts on");
}

}  // namespace deformable_surface::model
