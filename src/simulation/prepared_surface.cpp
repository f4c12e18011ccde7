#include "deformable_surface/simulation/prepared_surface.h"

#include "deformable_surface/simulation/model_kind.h"

#include "rest_parts.h"
#include "wanted_spacing.h"

namespace deformable_surface::simulation {

bool hasTarget(const AccuracyParams& accuracy) { return accuracy.position_error > 0.0 || accuracy.step_budget > 0.0; }

SceneParams keepWhatPrepares(const SceneParams& params) {
  // Parts that nothing holds are left out: by pins, anchors, tools and gravity.
  if (params.input.unconstrained_parts == UnconstrainedParts::kDrop) return params;
  SceneParams kept;
  kept.model = params.model;
  kept.neighbors = params.neighbors;
  kept.simplification = params.simplification;
  kept.transfer = params.transfer;
  kept.oriented_particles.mode = params.oriented_particles.mode;
  kept.oriented_particles.grow_surface = params.oriented_particles.grow_surface;  // normals of sparse samples
  kept.elastic_solid.dimension = params.elastic_solid.dimension;
  kept.elastic_solid.fill = params.elastic_solid.fill;
  kept.input.largest_parts = params.input.largest_parts;
  kept.input.noise = params.input.noise;
  kept.input.min_gap = params.input.min_gap;
  kept.output.resample = params.output.resample;
  // Where pins, grips and loads are, and not what they do.
  for (const PinParams& pin : params.pins) {
    kept.pins.emplace_back();
    kept.pins.back().region = pin.region;
  }
  kept.tools = findGripsAtRest(params);
  for (const Vec3& place : findLoadedPlaces(params)) {
    kept.anchors.emplace_back();
    kept.anchors.back().point = place;
    kept.anchors.back().stiffness = 1.0;
  }
  kept.accuracy.position_error = hasTarget(params.accuracy) ? 1.0 : 0.0;
  // Whether it bends decides where points are to be dense.
  if (params.simplification.density == cloud::PointDensity::kAdaptive) {
    kept.mass_spring = params.mass_spring;
    kept.material = params.material;
  }
  return kept;
}

bool canShare(const SceneParams& params) {
  return params.input.unconstrained_parts != UnconstrainedParts::kDrop && findModel(params.model).traits().is_prepared;
}

Index findCoarsest(const SceneParams& params) {
  const bool is_needed =
      hasTarget(params.accuracy) || params.accuracy.estimate || params.integrator.type == solve::IntegratorType::kStatic;
  return is_needed ? kCoarsestPoints : kMaxIndex;
}

RestSurface prepareSurface(const SceneParams& params, const cloud::PointCloud& input, Index coarsest, bool to_choose) {
  RestSurface s = findModel(params.model).prepare(keepWhatPrepares(params), input, coarsest, to_choose);
  s.dense.tree.reset();
  return s;
}

}  // namespace deformable_surface::simulation
