// The model kind of the tethered points: every point of the cloud is a simulation point, and follows it.
#pragma once

#include "deformable_surface/simulation/evolution.h"
#include "deformable_surface/simulation/model_kind.h"

#include <numeric>

#include "../../../src/simulation/cloud_follower.h"
#include "../../../src/simulation/rest_parts.h"
#include "tethered_points.h"

namespace deformable_surface::test {

class PointsAsTheyAre : public simulation::CloudFollower {
 public:
  void follow(const model::State& state, Points& dense, std::vector<Eigen::Vector3f>* normals) override {
    dense = state.positions;
    if (normals) normals->assign(dense.size(), Eigen::Vector3f::UnitZ());
  }
};

class TetheredPointsKind : public simulation::ModelKind {
 public:
  const char* name() const override { return "tethered_points"; }
  simulation::ModelTraits traits() const override { return {}; }
  void checkScene(Fields& fields, const simulation::SceneParams& scene) const override {
    fields.require(scene.material.young_modulus <= kStiffest, "material.young_modulus",
                   "found one that no tether has; accepted: up to " + formatReal(kStiffest));
  }

  simulation::RestSurface makeRest(const simulation::SceneParams& params, const cloud::PointCloud& input, Index,
                                   const Choose&) const override {
    simulation::RestSurface s = simulation::cleanInput(input);
    const Index n = static_cast<Index>(s.dense.positions.size());
    s.dense.normals.assign(n, Vec3::UnitZ());
    s.points = s.dense.positions;
    s.normals = s.dense.normals;
    s.dense_index.resize(n);
    std::iota(s.dense_index.begin(), s.dense_index.end(), Index{0});
    s.area = 1.0;
    const double share = s.area / n, thickness = params.material.thickness;
    s.model = std::make_unique<TetheredPoints>(s.points, params.material.density * thickness * share,
                                               params.material.young_modulus * thickness * share);
    simulation::applyPins(params, s);
    return s;
  }
  std::unique_ptr<simulation::CloudFollower> makeFollower(const simulation::RestSurface&, const simulation::SceneParams&,
                                                          const model::DeformableModel&) const override {
    return std::make_unique<PointsAsTheyAre>();
  }

  static constexpr double kStiffest = 1e7;  // Pa
};

}  // namespace deformable_surface::test
