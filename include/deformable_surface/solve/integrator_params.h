// How time is stepped.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/base/types.h"

namespace deformable_surface::solve {

enum class IntegratorType { kAuto, kVerlet, kSymplecticEuler, kExplicitEuler, kImplicit, kStatic };

struct IntegratorParams {
  IntegratorType type = IntegratorType::kAuto;
  double time_step = 0.01;     // s, > 0; never changed silently
  Index max_substeps = 1000;   // >= 1: auto takes verlet while it needs no more sub-steps per step, else what is less work
  double tolerance = 1e-6;     // > 0: implicit and static stop when the residual force is below this share of the largest force
  Index max_iterations = 100;  // >= 1: Newton iterations of an implicit or static step
};

inline void visit(Fields& fields, IntegratorParams& p) {
  fields.choice(
      "type", p.type,
      {{"auto", IntegratorType::kAuto},
       {"verlet", IntegratorType::kVerlet},
       {"symplectic_euler", IntegratorType::kSymplecticEuler},
       {"explicit_euler", IntegratorType::kExplicitEuler},
       {"implicit", IntegratorType::kImplicit},
       {"static", IntegratorType::kStatic}},
      "`auto` = verlet within max_substeps, beyond it verlet or implicit, whichever turns out to be less work; with an accuracy "
      "target, the integrator that its trials choose. "
      "`explicit_euler` = as published. `static` = each step is the equilibrium under its loads");
  fields.number("time_step", p.time_step, "s", between(1e-9, 1e3), "length of a step. It is never changed; sub-steps divide it");
  fields.integer(
      "max_substeps", p.max_substeps, "", between(1, 1e9),
      "`auto` tries implicit steps if verlet needs more sub-steps than this. It returns to verlet where they turn out to be "
      "far more work, also to more sub-steps than this");
  fields.number("tolerance", p.tolerance, "", between(1e-15, 0.1),
                "implicit and static: relative residual force at which iterations stop. A stage of implicit with a relative "
                "residual above 1e-6 takes at least one iteration");
  fields.integer("max_iterations", p.max_iterations, "", between(1, 1e6),
                 "maximum number of Newton iterations of an implicit or static step");
}

}  // namespace deformable_surface::solve
