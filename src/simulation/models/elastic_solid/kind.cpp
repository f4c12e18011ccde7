#include "kind.h"

#include "deformable_surface/model/elastic_solid/elastic_solid.h"
#include "deformable_surface/simulation/evolution.h"

#include <utility>

#include "../../cloud_follower.h"
#include "../../points_between.h"
#include "rest.h"

namespace deformable_surface::simulation {
namespace {

using model::ElasticSolid;

// A point of the surface is held by the body below it. Contact as stiff as that of a sheet is as soft as the body: a ball of 15
// mm felt a third less than in equilibrium, with this factor at most 4 % less.
constexpr double kContactStiffening = 16.0;
// The skin also bears the weight of what lies behind it. Its pairs are many: more costs too many sub-steps.
constexpr double kSelfContactStiffening = 4.0;

/// Points of the body: moved by the transfer of solids, or the simulation points themselves if all are simulated.
class SolidFollower : public CloudFollower {
 public:
  SolidFollower(const RestSurface& rest, const ElasticSolid& solid) : rest_(rest), solid_(solid) {}
  void follow(const model::State& state, Points& dense, std::vector<Eigen::Vector3f>* normals) override {
    if (!rest_.solid_transfer.isEmpty()) return rest_.solid_transfer.apply(state.positions, dense, normals);
    dense = state.positions;
    if (normals) solid_.turnNormals(state, rest_.dense.normals, *normals);
  }

 private:
  const RestSurface& rest_;
  const ElasticSolid& solid_;
};

class Flow : public Evolution {
 public:
  explicit Flow(ElasticSolid& solid) : solid_(solid) {}
  AfterStep endStep(double, double step, const std::vector<tool::ToolParams>&, model::State& state, CutFollower*) override {
    AfterStep after;
    after.has_flowed = solid_.flow(step, state);
    return after;
  }

 private:
  ElasticSolid& solid_;
};

class ElasticSolidKind : public ModelKind {
 public:
  const char* name() const override { return "elastic_solid"; }
  ModelTraits traits() const override {
    ModelTraits traits;
    traits.has_estimate = traits.is_prepared = traits.meets_itself = true;
    traits.contact_stiffening = kContactStiffening;
    traits.self_contact_stiffening = kSelfContactStiffening;
    return traits;
  }
  void visitOptions(Fields& fields, SceneParams& p) const override {
    fields.section("elastic_solid", p.elastic_solid, "Options of elastic solids (docs/elastic_solid.md).");
  }

  RestSurface prepare(const SceneParams& params, const cloud::PointCloud& input, Index, bool) const override {
    return prepareSolid(params, input);
  }
  RestSurface finishRest(const SceneParams& params, RestSurface prepared, const Choose&) const override {
    return finishSolidRest(params, std::move(prepared));
  }
  CoarserLevel makeCopies(const SceneParams& params, const RestSurface& level) const override {
    return makeSolidCopies(params, level);
  }

  std::shared_ptr<const transfer::SampledPoints> makeBetween(const SceneParams& params, const RestSurface& rest,
                                                             const std::vector<model::WeightedTriangle>& skin) const override {
    return choosePlacesOnTriangles(params, skin, rest.points);
  }

  std::vector<model::WeightedTriangle> findSkin(const RestSurface& rest, const model::DeformableModel& model) const override {
    return findSolidSkin(rest, static_cast<const ElasticSolid&>(model));
  }
  std::unique_ptr<CloudFollower> makeFollower(const RestSurface& rest, const SceneParams&,
                                              const model::DeformableModel& model) const override {
    return std::make_unique<SolidFollower>(rest, static_cast<const ElasticSolid&>(model));
  }
  std::unique_ptr<Evolution> makeEvolution(model::DeformableModel& model, const RestSurface&, const SceneParams&) const override {
    return std::make_unique<Flow>(static_cast<ElasticSolid&>(model));
  }
};

}  // namespace

const ModelKind& elasticSolidKind() {
  static const ElasticSolidKind kind;
  return kind;
}

}  // namespace deformable_surface::simulation
