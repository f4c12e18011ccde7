// The choices within the model of elastic solids.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/model/elastic_solid/plasticity_params.h"

namespace deformable_surface::model {

/// What a cloud fills: a part of a plane, or of space. auto: decided from the cloud.
enum class SolidDimension { kAuto, kPlanar, kVolume };

/// What holds across a planar solid: no stress (a thin plate) or no strain (a slice of a long body).
enum class PlaneKind { kStress, kStrain };

/// corotated: strain is measured against the local rotation. linear: small strain [as published]; rotations count as strain.
/// neo_hookean: as soft rubber and tissue, which stiffen as they are pressed together.
enum class SolidLaw { kCorotated, kLinear, kNeoHookean };

struct ElasticSolidParams {
  SolidDimension dimension = SolidDimension::kAuto;
  PlaneKind plane = PlaneKind::kStress;
  SolidLaw law = SolidLaw::kCorotated;
  double stabilization = 0.05;  // >= 0: stiffness, over Young's modulus, against motions that no fitted gradient shows
  bool fill = false;            // the cloud is the surface of a body, inside which points are made
  PlasticityParams plasticity;
};

inline void visit(Fields& fields, ElasticSolidParams& p) {
  fields.choice(
      "dimension", p.dimension,
      {{"auto", SolidDimension::kAuto}, {"planar", SolidDimension::kPlanar}, {"volume", SolidDimension::kVolume}},
      "dimension of the body; `auto` = planar if the cloud lies in a plane, else volume. A planar solid moves only in its plane");
  fields.choice("plane", p.plane, {{"stress", PlaneKind::kStress}, {"strain", PlaneKind::kStrain}},
                "of a planar solid: plane `stress` (a plate with the material's thickness) or plane `strain`");
  fields.choice("law", p.law,
                {{"corotated", SolidLaw::kCorotated}, {"linear", SolidLaw::kLinear}, {"neo_hookean", SolidLaw::kNeoHookean}},
                "stress of a strain; all agree for small ones. `neo_hookean`: as rubber and tissue, for strains above a tenth; "
                "not for plates. "
                "`linear`, as published, mistakes rotation for strain: 0.5 % at 6 degrees, 13 % at 30 degrees");
  fields.number(
      "stabilization", p.stabilization, "", between(0.0, 10.0),
      "stabilisation stiffness over Young's modulus. It acts on point-to-point motions that the fitted strain does not include; "
      "0 = off");
  fields.flag("fill", p.fill,
              "the cloud is the closed surface of a body: points are generated inside. They are simulated but not published");
  fields.require(!p.fill || p.dimension != SolidDimension::kPlanar, "fill",
                 "found true for a planar solid; accepted: false, or dimension auto or volume");
  fields.section("plasticity", p.plasticity, "Plasticity.");
  fields.require(!p.plasticity.isOn() || p.law == SolidLaw::kCorotated, "plasticity.yield_stress",
                 std::string("found one with law: ") +
                     (p.law == SolidLaw::kLinear ? "linear, which would take rotations for yield" : "neo_hookean") +
                     "; accepted: 0, or law: corotated");
}

}  // namespace deformable_surface::model
