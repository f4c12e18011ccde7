// The choices within the model of oriented particles.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/params.h"
#include "deformable_surface/base/types.h"
#include "deformable_surface/model/oriented_particles/growth_params.h"
#include "deformable_surface/model/oriented_particles/guide_params.h"

#include <cmath>

namespace deformable_surface::model {

/// space: a surface. plane: a curve, as a section of a surface; particles stay in y = 0 and their normals in that plane.
enum class ParticleMode { kSpace, kPlane };

/// Range of the forces between orientations: isotropic = by distance alone; anisotropic = [Szeliski 1991, eq. 10], with
/// more weight near a particle's tangent plane.
enum class ParticleWeighting { kIsotropic, kAnisotropic };

/// The principal direction that the x axes turn to: that of the least signed curvature [Szeliski 1991, eq. 14] or of
/// the least absolute one [eq. 15].
enum class PrincipalDirection { kSigned, kAbsolute };

/// Where particles are added automatically: nowhere, in gaps that face another side, or at open edges as well.
enum class Growing { kNone, kGaps, kEdges };

/// The rest shape: the flat lattice, as published, so that other clouds move from the beginning; or the cloud as given.
/// auto: the cloud if particles can remember a shape.
enum class RestShape { kAuto, kFlat, kCloud };

/// free: particles bind whatever is near, as published. kept: neighbours at rest stay bound, each pair with its rest shape, until
/// the bond breaks; others only repel (kept_bonds.h).
enum class ParticleBonds { kFree, kKept };

struct OrientedParticlesParams {
  ParticleMode mode = ParticleMode::kSpace;
  ParticleBonds bonds = ParticleBonds::kFree;
  OrAuto<double> spacing;  // m, > 0: between neighbours on the flat surface at rest; auto = that of the cloud
  // Each multiplies a value derived from the material.
  double lennard_jones = 1.0;         // >= 0: 1 = the surface has Young's modulus
  double co_planarity = 1.0;          // >= 0: the bending rigidity is (co_planarity + co_normality) / 2 times the material's
  double co_normality = 1.0;          // >= 0
  double co_circularity = 0.0;        // >= 0, on the scale of co-planarity
  double axis_alignment_rate = 0.0;   // 1/s, >= 0: how fast x axes turn to a principal direction
  OrAuto<double> rotational_damping;  // 1/s, >= 0: torque = -rotational_damping * inertia * spin; auto = as motion is damped
  PrincipalDirection principal = PrincipalDirection::kSigned;
  Vec2 exponents{8.0, 4.0};  // of repulsion and attraction, whole, the first the larger
  double cutoff = 1.6;       // of the pair's distance of least energy, > 1: no interaction beyond
  // >= 0: stretch at which a bond carries most, by a shorter cutoff; 0 = as given by exponents and cutoff.
  double tear_strain = 0.0;
  ParticleWeighting weighting = ParticleWeighting::kIsotropic;
  double weighting_width = 1.0;   // > 0, spacings: a of eq. 10
  double weighting_height = 0.5;  // > 0, at most the width, spacings: b of eq. 10
  RestShape rest_shape = RestShape::kAuto;
  double melting = 1000.0;       // K above ambient, > 0: bonds weaken linearly until there
  OrAuto<double> welding;        // K above ambient, > 0: from there on both sides, cut bonds form again; auto = half of melting
  double cooling = 0.0;          // 1/s, >= 0: rate at which temperatures fall to the ambient one
  double freeze_below = 0.0;     // K above ambient, >= 0: cooler particles neither move nor turn; 0 = all may
  double yield_curvature = 0.0;  // 1/m, >= 0: bending beyond it stays; 0 = no plasticity
  bool delete_trapped = false;   // particles inside two solid tools at once go
  bool stretching = false;       // particles are added between those that were drawn apart
  Growing growing = Growing::kNone;
  double growth_interval = 0.02;  // s, > 0: between two looks for room
  bool grow_surface = false;      // before time 0 a surface is grown through the particles
  GrowthParams growth;
  GuideParams guide;

  /// Rest curvatures are for the isotropic weighting of a surface only.
  bool remembersShape() const { return weighting == ParticleWeighting::kIsotropic && mode == ParticleMode::kSpace; }
  double weldingTemperature() const { return welding.valueOr(0.5 * melting); }
  bool restsAsCloud() const { return rest_shape == RestShape::kCloud || (rest_shape == RestShape::kAuto && remembersShape()); }
};

inline void visit(Fields& fields, OrientedParticlesParams& p) {
  fields.choice("mode", p.mode, {{"space", ParticleMode::kSpace}, {"plane", ParticleMode::kPlane}},
                "`space` = a surface; `plane` = a curve of particles in the plane y = 0");
  fields.choice(
      "bonds", p.bonds, {{"free", ParticleBonds::kFree}, {"kept", ParticleBonds::kKept}},
      "`free` = particles bind all others in reach, as published. `kept` = neighbours at rest stay bound, with the shape "
      "that they have at rest, until the bond is torn, cut or melted; for thin surfaces");
  fields.number("spacing", p.spacing, "m", between(1e-9, kMaxLength),
                "rest distance between neighbours on a flat surface; `auto` = spacing of the cloud");
  fields.number("lennard_jones", p.lennard_jones, "", between(0.0, 1e6),
                "weight of attraction and repulsion; 1 = the surface has Young's modulus");
  fields.number("co_planarity", p.co_planarity, "", between(0.0, 1e6),
                "weight of the co-planarity potential: neighbours stay in each other's tangent planes. The bending rigidity is "
                "multiplied by (co_planarity + co_normality) / 2");
  fields.number("co_normality", p.co_normality, "", between(0.0, 1e6),
                "weight of the co-normality potential: neighbouring normals stay parallel");
  fields.number("co_circularity", p.co_circularity, "", between(0.0, 1e6),
                "weight of the co-circularity potential: the curvature stays constant; same scale as co_planarity");
  fields.number("axis_alignment_rate", p.axis_alignment_rate, "1/s", between(0.0, 1e9),
                "rate at which x axes align with the principal curvature direction, per unit of curvature difference times "
                "spacing. Display only");
  fields.number("rotational_damping", p.rotational_damping, "1/s", between(0.0, 1e9),
                "damping of rotation: torque = -rotational_damping * inertia * spin; `auto` = material.damping");
  fields.choice("principal", p.principal, {{"signed", PrincipalDirection::kSigned}, {"absolute", PrincipalDirection::kAbsolute}},
                "x axes align with the direction of the least `signed` or `absolute` curvature");
  fields.vector("exponents", p.exponents, "", between(1.0, 24.0),
                "exponents of repulsion and attraction: integers, the first is larger");
  const auto isWhole = [](double x) { return x == std::floor(x); };
  fields.require(isWhole(p.exponents[0]) && isWhole(p.exponents[1]) && p.exponents[0] > p.exponents[1], "exponents",
                 "found " + formatReal(p.exponents[0]) + " and " + formatReal(p.exponents[1]) +
                     "; accepted: whole numbers, the first the larger");
  fields.number("cutoff", p.cutoff, "", between(1.05, 4.0),
                "interaction cutoff, as a multiple of the equilibrium distance. Longer bonds break");
  fields.number("tear_strain", p.tear_strain, "", between(0.0, 4.0),
                "strain l / l0 - 1 of the largest bond force. Beyond it the bond breaks. 0 = the maximum; else from 0.1 up to "
                "it. With bonds: "
                "free a value above 0 shortens the cutoff, and the maximum follows from exponents and cutoff (0.4198 by "
                "default). With bonds: "
                "kept it is cutoff - 1 (0.6 by default)");
  fields.require(
      !(p.tear_strain > 0.0) || p.tear_strain >= 0.1, "tear_strain",
      "found " + formatReal(p.tear_strain) + "; accepted: 0, or from 0.1, below which sheets were not seen to part cleanly");
  fields.choice("weighting", p.weighting,
                {{"isotropic", ParticleWeighting::kIsotropic}, {"anisotropic", ParticleWeighting::kAnisotropic}},
                "weights of the orientation forces: `isotropic` = by distance; `anisotropic` = larger near the tangent plane, as "
                "published");
  fields.number("weighting_width", p.weighting_width, "", between(0.1, 10.0),
                "width of the anisotropic weights in the tangent plane, in spacings");
  fields.number("weighting_height", p.weighting_height, "", between(0.05, 10.0),
                "width of the anisotropic weights along the normal, in spacings; at most weighting_width");
  fields.require(p.weighting_height <= p.weighting_width, "weighting_height",
                 "found " + formatReal(p.weighting_height) + " above weighting_width: " + formatReal(p.weighting_width) +
                     "; accepted: at most the width");
  fields.choice(
      "rest_shape", p.rest_shape, {{"auto", RestShape::kAuto}, {"flat", RestShape::kFlat}, {"cloud", RestShape::kCloud}},
      "rest shape: `flat` = an even, flat sheet, as published; other clouds move from the start. `cloud` = the cloud: particles "
      "slide over it before time 0 until they are even, and keep its curvature. `auto` = `flat` for weighting: anisotropic and "
      "mode: plane, else `cloud`");
  fields.require(p.rest_shape != RestShape::kCloud || p.remembersShape(), "rest_shape",
                 "found cloud with weighting: anisotropic or mode: plane, which remember no shape; accepted: flat, auto");
  fields.number("melting", p.melting, "K", between(1e-6, 1e9),
                "melting temperature above ambient: bonds weaken linearly and vanish there");
  fields.number(
      "welding", p.welding, "K", between(1e-6, 1e9),
      "temperature above ambient from which particles weld: bonds that a knife has cut form again where both are as hot; "
      "`auto` = half of melting");
  fields.number("cooling", p.cooling, "1/s", between(0.0, 1e6), "rate at which temperatures decay to ambient");
  fields.number("freeze_below", p.freeze_below, "K", between(0.0, 1e9),
                "above ambient: cooler particles neither move nor rotate, so only heated particles can be shaped; 0 = off");
  fields.number("yield_curvature", p.yield_curvature, "1/m", between(0.0, 1e9),
                "plasticity: curvature change beyond this becomes part of the rest shape; 0 = no plasticity");
  fields.require(!(p.yield_curvature > 0.0) || p.remembersShape(), "yield_curvature",
                 "found " + formatReal(p.yield_curvature) +
                     " with weighting: anisotropic or mode: plane, which remember no "
                     "shape; accepted: 0");
  fields.flag("delete_trapped", p.delete_trapped,
              "delete particles that are inside two solid tools at once. Two sheets that two solid tools press together are then "
              "joined by a tube");
  fields.flag("stretching", p.stretching, "stretching rule: insert particles between neighbours that were pulled apart");
  fields.choice(
      "growing", p.growing, {{"none", Growing::kNone}, {"gaps", Growing::kGaps}, {"edges", Growing::kEdges}},
      "growing rule: insert particles around particles with few neighbours: `gaps` = in gaps with an opposite side; `edges` = "
      "also at open edges");
  fields.number("growth_interval", p.growth_interval, "s", between(1e-9, 1e9),
                "time between two searches for places of new particles");
  fields.flag("grow_surface", p.grow_surface, "grow a surface through the particles before time 0, like `~grow_surface`");
  if (p.bonds == ParticleBonds::kKept) {
    const std::string found = p.rest_shape == RestShape::kFlat ? "rest_shape flat"
                              : p.mode == ParticleMode::kPlane ? "mode plane"
                                                               : "weighting anisotropic";
    fields.require(
        p.restsAsCloud(), "bonds",
        "found kept with " + found + "; accepted: kept with rest_shape cloud or auto, mode space and weighting isotropic");
    fields.require(
        !(p.co_circularity > 0.0), "co_circularity",
        "found " + formatReal(p.co_circularity) + " with bonds: kept, which are circular at rest by themselves; accepted: 0");
    fields.require(!(p.yield_curvature > 0.0), "yield_curvature",
                   "found " + formatReal(p.yield_curvature) + " with bonds: kept, which keep their shape; accepted: 0");
    fields.require(!p.stretching && p.growing == Growing::kNone && !p.grow_surface, "bonds",
                   "found kept with added particles, which have no rest shape; accepted: stretching false, growing none, "
                   "grow_surface false");
  }
  fields.section("growth", p.growth, "The stretching and growing rules. Lengths are in particle spacings.");
  fields.section("guide", p.guide, "A volume whose iso-surface a seed inside of it is blown up to (docs/oriented_particles.md).");
  fields.require(p.guide.volume.empty() || (p.mode == ParticleMode::kSpace && p.bonds == ParticleBonds::kFree), "guide.volume",
                 "found one with mode: plane or bonds: kept; accepted: mode space and bonds free, or none");
}

}  // namespace deformable_surface::model
