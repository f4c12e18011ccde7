// Drives a surface to an iso-surface of a volume: the inflation of [Miller et al. 1991], which [Szeliski and Tonnesen 1991, sec.
// 9] plan for oriented particles.
#pragma once

#include "deformable_surface/model/oriented_particles/guide_params.h"
#include "deformable_surface/solve/external_load.h"

#include <utility>

namespace deformable_surface::simulation {

/// F = p max(-1, min(1, d / (reach a))) A n: a point with the area vector A n is pushed outwards inside of the iso-surface and
/// inwards outside of it. d: its distance (geometry/volume.h), a: the spacing of a hexagonal lattice with its area. There is no
/// potential.
class GuideLoad : public solve::ExternalLoad {
 public:
  /// model is kept by reference. Without a grid there is no load.
  GuideLoad(const model::DeformableModel& model, model::GuideParams params) : model_(model), params_(std::move(params)) {}
  bool isEmpty() const { return !params_.grid; }

  void addForces(double time, const model::State& state, Points& forces) const override;
  void addRowBounds(double time, const model::State& state, std::vector<double>& stiffness,
                    std::vector<double>& damping) const override;

 private:
  const model::DeformableModel& model_;
  model::GuideParams params_;
  mutable Points area_;
};

}  // namespace deformable_surface::simulation
