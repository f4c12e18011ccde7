#include "kind.h"

#include "deformable_surface/base/value.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../../points_between.h"
#include "cutting.h"
#include "rest.h"

namespace deformable_surface::simulation {
namespace {

bool isKnife(const tool::ToolParams& tool) { return tool.mode == tool::Mode::kCut; }

class MassSpringKind : public ModelKind {
 public:
  const char* name() const override { return "mass_spring"; }
  ModelTraits traits() const override {
    ModelTraits traits;
    traits.is_surface = traits.has_springs = traits.has_regions = true;
    traits.has_estimate = traits.has_local_estimate = true;
    traits.is_tuned = traits.is_timed = traits.can_snap = traits.meets_itself = traits.is_prepared = true;
    return traits;
  }

  void visitOptions(Fields& fields, SceneParams& p) const override;
  void checkScene(Fields& fields, const SceneParams& p) const override {
    const bool can_be_cut = p.mass_spring.tear_strain > 0.0 || std::any_of(p.tools.begin(), p.tools.end(), isKnife);
    fields.require(
        !p.output.resample || !can_be_cut, "output.resample",
        "found true on a surface that is to be cut or torn, whose inserted points would not know their side; accepted: false");
  }
  tool::ModeUse useOf(const tool::ModeInfo& mode) const override {
    return mode.mode == tool::Mode::kCut ? tool::kPlain : mode.everywhere;
  }
  std::vector<ToolProblem> findToolProblems(const tool::ToolParams& tool) const override {
    if (!isKnife(tool) || tool.shape.kind != geometry::Solid::Kind::kPlane) return {};
    return {{"shape",
             "found plane for mode cut, which has no other side to come out at; accepted: sphere, box, "
             "cylinder, cone, mesh"}};
  }
  std::string refuseTool(const SceneParams& p, const tool::ToolParams& tool) const override {
    if (!isKnife(tool)) return "";
    if (!(p.output.resample || p.mass_spring.volume_stiffness > 0.0)) return "";
    return std::string("mode: found cut on a surface that ") +
           (p.output.resample ? "inserts points, which would not know their side" : "keeps its volume") +
           "; accepted: cut without output.resample and mass_spring.volume_stiffness";
  }
  std::string findMaterialProblem(const SceneParams& p, const MaterialChangeParams& change) const override {
    if (!change.young_modulus.is_auto && p.mass_spring.stiffness == model::Stiffness::kUniform)
      return "young_modulus: found one with mass_spring.stiffness: uniform; accepted: material";
    if (!change.bending_rigidity.is_auto && !isPlate(p))
      return "bending_rigidity: found one where nothing bends by it; accepted: mass_spring.bending: curvature and a "
             "material.bending_rigidity above 0";
    return "";
  }
  bool isPlate(const SceneParams& p) const override { return mayDent(p) && p.material.bendingRigidity() > 0.0; }
  bool mayDent(const SceneParams& p) const override { return p.mass_spring.bending == model::Bending::kCurvature; }
  /// Surfaces that meet tools, or tear, must be as stiff as stated. An equilibrium costs the same for any stiffness.
  bool maySoften(const SceneParams& p) const override {
    return p.tools.empty() && p.mass_spring.tear_strain == 0.0 && p.integrator.type != solve::IntegratorType::kStatic &&
           p.mass_spring.stiffness == model::Stiffness::kMaterial;
  }

  RestSurface prepare(const SceneParams& params, const cloud::PointCloud& input, Index coarsest, bool to_choose) const override {
    return prepareMassSpring(params, input, coarsest, to_choose);
  }
  RestSurface finishRest(const SceneParams& params, RestSurface prepared, const Choose& choose) const override {
    return finishMassSpringRest(params, std::move(prepared), choose);
  }
  RestSurface makeTrial(const SceneParams& params, const RestSurface& full, Index points) const override {
    return makeMassSpringTrial(params, full, points);
  }
  RestSurface makeCoarser(const SceneParams& params, const RestSurface& of, Index target) const override {
    return makeCoarserMassSpring(params, of, target);
  }
  CoarserLevel makeCopies(const SceneParams& params, const RestSurface& level) const override {
    return makeMassSpringCopies(params, level);
  }
  RestSurface copyCoarser(const SceneParams& params, const RestSurface& of) const override {
    return copyCoarserMassSpring(params, of);
  }

  std::shared_ptr<const transfer::SampledPoints> makeBetween(const SceneParams& params, const RestSurface& rest,
                                                             const std::vector<model::WeightedTriangle>&) const override {
    if (rest.dense.positions.empty()) return rest.between;
    const bool is_whole = rest.dense.positions.size() <= rest.points.size();
    return is_whole ? choosePlacesOnTriangles(params, rest) : choosePointsBetween(params, rest.dense, rest, true);
  }
  std::shared_ptr<const LoadPoints> makeLoadPoints(const SceneParams& params, const RestSurface& rest) const override {
    return rest.dense.positions.empty() ? rest.load_points : chooseLoadPoints(params, rest.dense, rest, kMostLoadPoints);
  }

  std::unique_ptr<Evolution> makeEvolution(model::DeformableModel& model, const RestSurface&,
                                           const SceneParams& params) const override {
    return std::make_unique<Cutting>(static_cast<model::MassSpring&>(model), params.mass_spring.tear_strain);
  }
};

void MassSpringKind::visitOptions(Fields& fields, SceneParams& p) const {
  fields.section("mass_spring", p.mass_spring, "Options of the mass-spring model (docs/mass_spring.md).");
  const bool is_chosen = p.model == name();
  fields.require(is_chosen || p.mass_spring.tear_strain == 0.0, "mass_spring.tear_strain",
                 "found one, but the model is another; accepted: 0, or model: mass_spring");
  const bool pure_springs = p.mass_spring.membrane == model::Membrane::kSprings;
  // Rounding of 1/3 in a file.
  constexpr double kThirdTolerance = 1e-3;
  fields.require(!pure_springs || std::abs(p.material.poisson_ratio - 1.0 / 3.0) <= kThirdTolerance, "material.poisson_ratio",
                 "found " + formatReal(p.material.poisson_ratio) +
                     " with mass_spring.membrane: springs; accepted: 1/3, which pure springs have by construction");
  fields.require(p.material.bending_poisson_ratio.is_auto || (is_chosen && isPlate(p)), "material.bending_poisson_ratio",
                 "found one where nothing bends by it; accepted: auto, or model: mass_spring with mass_spring.bending: "
                 "curvature and a bending_rigidity above 0");
  fields.require(p.mass_spring.damping == model::Damping::kAlongSpring || p.material.spring_damping > 0.0, "mass_spring.damping",
                 "found relative_velocity with material.spring_damping: 0, which damps nothing; accepted: along_spring, or a "
                 "spring_damping above 0");
}

}  // namespace

const ModelKind& massSpringKind() {
  static const MassSpringKind kind;
  return kind;
}

}  // namespace deformable_surface::simulation
