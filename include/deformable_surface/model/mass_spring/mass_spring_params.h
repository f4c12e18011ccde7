// The choices within the mass-spring model.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/base/types.h"

namespace deformable_surface::model {

enum class Membrane { kAuto, kSprings, kTriangles };  // auto = triangles
enum class Bending { kSprings, kCurvature, kNone };

struct MassSpringParams {
  Membrane membrane = Membrane::kAuto;
  Bending bending = Bending::kCurvature;
  double volume_stiffness = 0.0;      // Pa, >= 0: keeps the volume of a closed surface
  double bending_spring_ratio = 0.1;  // > 0: stiffness of the published bending springs over that of the stretching springs
};

inline void visit(Fields& fields, MassSpringParams& p) {
  fields.choice("membrane", p.membrane,
                {{"auto", Membrane::kAuto}, {"springs", Membrane::kSprings}, {"triangles", Membrane::kTriangles}},
                "`springs` = the published scheme, `triangles` = co-rotated, any Poisson's ratio; `auto` = triangles");
  fields.choice("bending", p.bending,
                {{"springs", Bending::kSprings}, {"curvature", Bending::kCurvature}, {"none", Bending::kNone}},
                "`springs` = the published scheme, `curvature` = converges to the bending rigidity");
  fields.number("volume_stiffness", p.volume_stiffness, "Pa", between(0.0, 1e15), "keeps the volume of a closed surface");
  fields.number("bending_spring_ratio", p.bending_spring_ratio, "", between(1e-9, 1e6),
                "stiffness of the published bending springs over that of the stretching springs");
}

}  // namespace deformable_surface::model
