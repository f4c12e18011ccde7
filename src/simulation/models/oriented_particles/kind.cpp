#include "kind.h"

#include "deformable_surface/model/oriented_particles/oriented_particles.h"
#include "deformable_surface/model/oriented_particles/tear_strain.h"

#include <utility>

#include "follower.h"
#include "particle_life.h"
#include "quantities.h"
#include "rest.h"

namespace deformable_surface::simulation {
namespace {

using model::OrientedParticles;

class OrientedParticlesKind : public ModelKind {
 public:
  const char* name() const override { return "oriented_particles"; }
  ModelTraits traits() const override {
    ModelTraits traits;
    traits.is_surface = traits.is_oriented = traits.has_population = traits.is_timed = traits.is_prepared = true;
    traits.has_estimate = true;
    return traits;
  }

  void visitOptions(Fields& fields, SceneParams& p) const override {
    fields.section("oriented_particles", p.oriented_particles, "Options of oriented particles (docs/oriented_particles.md).");
  }
  void checkScene(Fields& fields, const SceneParams& p) const override {
    using solve::IntegratorType;
    const IntegratorType type = p.integrator.type;
    const bool has_method = type == IntegratorType::kAuto || type == IntegratorType::kVerlet || type == IntegratorType::kStatic;
    fields.require(has_method, "integrator.type", "found one that oriented_particles has not; accepted: auto, verlet, static");
    const std::string tear_problem = model::findTearStrainProblem(p.oriented_particles);
    fields.require(tear_problem.empty(), "oriented_particles.tear_strain", tear_problem);
  }
  tool::ModeUse useOf(const tool::ModeInfo& mode) const override {
    switch (mode.mode) {
      case tool::Mode::kErase: return tool::kPlain;
      case tool::Mode::kCut: return tool::kRubsHot;
      case tool::Mode::kHeat: return tool::kStrong;
      default: return mode.everywhere;
    }
  }
  std::vector<ToolProblem> findToolProblems(const tool::ToolParams& tool) const override {
    std::vector<ToolProblem> problems;
    if (tool.mode != tool::Mode::kCut || tool.strength > 0.0) return problems;
    if (tool.shape.kind == geometry::Solid::Kind::kPlane)
      problems.push_back(
          {"shape",
           "found plane for mode cut without strength, which has no other side to come out at; accepted: sphere, box, "
           "cylinder, cone, mesh"});
    const auto refuseFriction = [&](const char* field, double value) {
      if (value == 0.0) return;
      problems.push_back(
          {field, "found " + formatReal(value) +
                      ", which mode cut without strength does not use: it cuts without resistance; accepted: 0, or none"});
    };
    refuseFriction("friction", tool.friction);
    refuseFriction("kinetic_friction", tool.kinetic_friction.valueOr(0.0));
    return problems;
  }

  RestSurface prepare(const SceneParams& params, const cloud::PointCloud& input, Index coarsest, bool to_choose) const override {
    return prepareParticles(params, input, coarsest, to_choose);
  }
  RestSurface finishRest(const SceneParams& params, RestSurface prepared, const Choose& choose) const override {
    return finishParticlesRest(params, std::move(prepared), choose);
  }
  RestSurface makeTrial(const SceneParams& params, const RestSurface& full, Index points) const override {
    return makeParticlesTrial(params, full, points);
  }

  std::string refuseEstimate(const SceneParams& scene) const override {
    if (scene.oriented_particles.bonds == model::ParticleBonds::kFree)
      return "has one with oriented_particles.bonds: kept only; runs with other numbers of simulation points show how far "
             "results depend on it";
    if (!scene.creases.empty()) return "has none with creases, which are as wide as the particles are apart";
    return "";
  }
  bool mayDent(const SceneParams& scene) const override { return scene.oriented_particles.bonds == model::ParticleBonds::kKept; }
  CoarserLevel makeCopies(const SceneParams& params, const RestSurface& level) const override {
    return makeParticleCopies(params, level);
  }
  RestSurface copyCoarser(const SceneParams& params, const RestSurface& of) const override {
    return copyCoarserParticles(params, of);
  }

  std::vector<std::pair<Index, Index>> linkPartners(const model::DeformableModel& model, const Points& rest) const override {
    OrientedParticles begun = static_cast<const OrientedParticles&>(model);
    model::State state;
    state.positions = rest;
    model::beginAtRest(begun, state);
    begun.followPartners(state);
    return begun.linkPartners();
  }

  std::unique_ptr<CloudFollower> makeFollower(const RestSurface& rest, const SceneParams& params,
                                              const model::DeformableModel& model) const override {
    return std::make_unique<ParticleFollower>(rest, params.transfer, static_cast<const OrientedParticles&>(model));
  }
  std::unique_ptr<Evolution> makeEvolution(model::DeformableModel& model, const RestSurface& rest,
                                           const SceneParams& params) const override {
    return std::make_unique<ParticleLife>(static_cast<OrientedParticles&>(model), rest.creased, params);
  }
  std::optional<double> findQuantity(const std::string& name, const Simulation& simulation) const override {
    return findParticleQuantity(name, static_cast<const OrientedParticles&>(simulation.model()), simulation);
  }
};

}  // namespace

const ModelKind& orientedParticlesKind() {
  static const OrientedParticlesKind kind;
  return kind;
}

}  // namespace deformable_surface::simulation
