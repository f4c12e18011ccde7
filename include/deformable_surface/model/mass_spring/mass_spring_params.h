// The choices within the mass-spring model.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/base/types.h"

namespace deformable_surface::model {

enum class Membrane { kAuto, kSprings, kTriangles };  // auto = triangles
enum class Bending { kSprings, kCurvature, kNone };

/// Where the springs' constants come from. [Su 2007] has a k_ij for each spring and no rule for it; uniform is the simplest
/// reading. The stiffness of the surface then depends on the pattern of its points: a grid that is finer in one direction is
/// softer along it. `material`, calibrated by the triangles at each spring, removes most of that.
enum class Stiffness { kMaterial, kUniform };

/// The damping force between linked points. Along the spring: by the rate of its length only; angular momentum is kept.
/// Relative velocity: k_d (v_j - v_i) [Su 2007, eq. 3], with k_d = spring_damping * k; it also damps rigid rotation: a
/// surface that spins freely stops and its angular momentum is lost.
enum class Damping { kAlongSpring, kRelativeVelocity };

struct MassSpringParams {
  Membrane membrane = Membrane::kAuto;
  Bending bending = Bending::kCurvature;
  Stiffness stiffness = Stiffness::kMaterial;
  double spring_constant = 0.0;  // N/m, > 0 with uniform stiffness, else 0: of every stretching spring
  Damping damping = Damping::kAlongSpring;
  double volume_stiffness = 0.0;      // Pa, >= 0: keeps the volume of a closed surface
  double bending_spring_ratio = 0.1;  // > 0: stiffness of the published bending springs over that of the stretching springs
  double tear_strain = 0.0;           // > 0: l / l0 - 1 at which a link is cut, permanently; 0: never
};

inline void visit(Fields& fields, MassSpringParams& p) {
  fields.choice("membrane", p.membrane,
                {{"auto", Membrane::kAuto}, {"springs", Membrane::kSprings}, {"triangles", Membrane::kTriangles}},
                "`triangles` = co-rotated triangles, any Poisson's ratio; `springs` = the published scheme; `auto` = triangles");
  fields.choice("bending", p.bending,
                {{"springs", Bending::kSprings}, {"curvature", Bending::kCurvature}, {"none", Bending::kNone}},
                "`curvature` = energy that converges to the bending rigidity; `springs` = the published scheme");
  fields.choice("stiffness", p.stiffness, {{"material", Stiffness::kMaterial}, {"uniform", Stiffness::kUniform}},
                "spring stiffness: `material` = from Young's modulus and the triangles at each spring; `uniform` = "
                "spring_constant for all springs, so that the surface depends on the pattern of its points");
  fields.number("spring_constant", p.spring_constant, "N/m", between(0.0, 1e15),
                "stiffness of every stretching spring with `stiffness: uniform`; replaces Young's modulus; else 0");
  const bool uniform = p.stiffness == Stiffness::kUniform;
  fields.require(!uniform || p.membrane == Membrane::kSprings, "stiffness",
                 "found uniform with a membrane of triangles, which takes Young's modulus; accepted: material, or membrane: "
                 "springs");
  fields.require(!uniform || p.spring_constant > 0.0, "spring_constant",
                 "found 0 with stiffness: uniform; accepted: a constant above 0 (N/m)");
  fields.require(uniform || p.spring_constant == 0.0, "spring_constant",
                 "found " + formatReal(p.spring_constant) + " with stiffness: material; accepted: 0, or stiffness: uniform");
  fields.choice("damping", p.damping,
                {{"along_spring", Damping::kAlongSpring}, {"relative_velocity", Damping::kRelativeVelocity}},
                "velocity that material.spring_damping acts on: `along_spring` = rate of the length; `relative_velocity` = full "
                "relative velocity, as published; it also damps rotation");
  fields.number("volume_stiffness", p.volume_stiffness, "Pa", between(0.0, 1e15), "volume stiffness of a closed surface");
  fields.number("bending_spring_ratio", p.bending_spring_ratio, "", between(1e-9, 1e6),
                "for `bending: springs`: stiffness of bending springs over that of stretching springs");
  fields.number("tear_strain", p.tear_strain, "", between(0.0, 1e6),
                "links with l / l0 - 1 above this after a sub-step are cut permanently; 0 = never");
  fields.require(!(p.tear_strain > 0.0) || p.volume_stiffness == 0.0, "tear_strain",
                 "found one beside a volume_stiffness, which a torn surface cannot have; accepted: one of them, the other 0");
}

}  // namespace deformable_surface::model
