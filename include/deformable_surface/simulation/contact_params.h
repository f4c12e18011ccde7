// Parameters of contact with tools and of a surface with itself.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/params.h"

namespace deformable_surface::simulation {

struct ContactParams {
  Index cloud_points = 8;           // 0 .. 64: per cell, beside its simulation point, that touch tools
  OrAuto<bool> self;                // parts of the surface do not pass through each other; auto = where that costs little
  bool untangle = false;            // parts that pass through each other when a state begins are pushed apart
  double compliance = 0.0;          // m/Pa, >= 0: depth of contact per pressure; 0 = that of the penalty
  OrAuto<double> thickness;         // m, > 0; auto = that of the material; of solids a fifth of the spacing
  double friction = 0.0;            // Coulomb's coefficient, >= 0
  OrAuto<double> kinetic_friction;  // coefficient of kinetic friction, at most the static one; auto = friction
};

inline void visit(Fields& fields, ContactParams& p) {
  fields.integer("cloud_points", p.cloud_points, "", between(0, 64),
                 "points of the cloud around each simulation point that touch solid tools as well (mass_spring); 0 = simulation "
                 "points alone");
  fields.flag(
      "self", p.self,
      "parts of a mass-spring surface, or of an elastic solid in space, do not pass through each other; `auto` = on for "
      "surfaces and solids of which no parts are near each other at rest, but for equilibria; it acts where parts come near");
  fields.flag(
      "untangle", p.untangle,
      "parts that pass through each other at the beginning, or in a state that is set or restored, are pushed apart; with "
      "`self: true`");
  fields.number("compliance", p.compliance, "m/Pa", between(0.0, 1.0),
                "of soft pads between the surface and tools, and between its own parts: depth of contact over pressure; 0 = no "
                "pads");
  fields.number("thickness", p.thickness, "m", between(1e-9, kMaxLength),
                "distance at which parts of the surface begin to push each other apart; `auto` = material.thickness, of "
                "elastic solids a fifth of the spacing of the simulation points");
  fields.number("friction", p.friction, "", between(0.0, 1e3), "Coulomb coefficient between parts of the surface");
  fields.number("kinetic_friction", p.kinetic_friction, "", between(0.0, 1e3),
                "Coulomb coefficient between parts that slide over each other, at most `friction`; `auto` = friction");
  fields.require(p.self.valueOr(false) || !p.untangle, "untangle", "found true without self: true; accepted: true with it");
  fields.require(p.kinetic_friction.valueOr(p.friction) <= p.friction, "kinetic_friction",
                 "found " + formatReal(p.kinetic_friction.valueOr(0.0)) + ", more than friction, " + formatReal(p.friction) +
                     "; accepted: at most friction");
}

}  // namespace deformable_surface::simulation
