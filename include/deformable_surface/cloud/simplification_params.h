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
  OrAuto<double> threshold;  // m, > 0: the ring diameter up to which points are removed; auto: see accuracy; without a target
                             // min(n, 1000) points are kept
  PointDensity density = PointDensity::kUniform;
};

inline void visit(Fields& fields, SimplificationParams& p) {
  fields.choice("method", p.method, {{"delaunay", SimplificationMethod::kDelaunay}, {"none", SimplificationMethod::kNone}},
                "how simulation points are chosen; `none` = every point is simulated");
  fields.integer("target_points", p.target_points, "", between(0, kMaxPoints), "number of simulation points; 0 = by threshold");
  fields.require(p.target_points == 0 || p.target_points >= 3, "target_points",
                 "found " + std::to_string(p.target_points) + "; accepted: 0 for the threshold, or at least 3, a triangle");
  fields.number(
      "threshold", p.threshold, "m", between(1e-9, kMaxLength),
      "points are removed up to this ring diameter; `auto` = by the accuracy target or step budget; without either, 1000 points "
      "or all if there are fewer");
  fields.choice("density", p.density, {{"uniform", PointDensity::kUniform}, {"adaptive", PointDensity::kAdaptive}},
                "`uniform` = even spacing, as published; `adaptive` = smaller spacing around small clamping pins and point "
                "loads, larger spacing elsewhere, same number of points. Only for mass_spring. When it pays: docs/accuracy.md");
}

}  // namespace deformable_surface::cloud
