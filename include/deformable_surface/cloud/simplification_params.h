// How many simulation points a cloud is simplified to.
#pragma once

#include "deformable_surface/base/or_auto.h"
#include "deformable_surface/base/params.h"
#include "deformable_surface/base/types.h"

namespace deformable_surface::cloud {

enum class SimplificationMethod { kDelaunay, kNone };
enum class PointDensity { kUniform, kAdaptive };

struct SimplificationParams {
  SimplificationMethod method = SimplificationMethod::kDelaunay;
  Index target_points = 0;   // >= 0; 0 = by threshold
  OrAuto<double> threshold;  // m, > 0: the ring diameter up to which points are removed; auto: see accuracy; without a wish
                             // min(n, 1000) points are kept
  PointDensity density = PointDensity::kUniform;
};

inline void visit(Fields& fields, SimplificationParams& p) {
  fields.choice("method", p.method, {{"delaunay", SimplificationMethod::kDelaunay}, {"none", SimplificationMethod::kNone}},
                "how the simulation points are chosen; `none` simulates every point");
  fields.integer("target_points", p.target_points, "", between(0, kMaxPoints), "simulation points to keep; 0 = by threshold");
  fields.require(p.target_points == 0 || p.target_points >= 3, "target_points",
                 "found " + std::to_string(p.target_points) + "; accepted: 0 for the threshold, or at least 3, a triangle");
  fields.number(
      "threshold", p.threshold, "m", between(1e-9, kMaxLength),
      "ring diameter up to which points are removed; `auto` keeps what `accuracy` leads to; without a wish a thousand points, "
      "or all if "
      "there are fewer");
  fields.choice("density", p.density, {{"uniform", PointDensity::kUniform}, {"adaptive", PointDensity::kAdaptive}},
                "where the simulation points are: `uniform` everywhere alike, as published; `adaptive` nearer to each other "
                "around small pins that clamp and where a force or an anchor acts on a point, and farther apart elsewhere, as "
                "many in all; mass_spring only; where it pays: docs/accuracy.md");
}

}  // namespace deformable_surface::cloud
