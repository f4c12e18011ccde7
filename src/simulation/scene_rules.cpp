// Rules for scenes that depend on the model: features that only some models have, and the models' own rules.
#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {
namespace {

// The model of a scene; null if its name is unknown, which is refused elsewhere.
const ModelKind* findKind(const std::string& name) {
  for (const ModelKind* kind : modelKinds())
    if (name == kind->name()) return kind;
  return nullptr;
}

void requireSides(Fields& fields, const SceneParams& p) {
  const std::string has_none = "found one, but the points of " + p.model + " have no sides; accepted: 0";
  fields.require(p.viscous_drag == 0.0, "viscous_drag", has_none);
  fields.require(p.pressure == 0.0, "pressure", has_none);
  fields.require(!p.output.resample, "output.resample", "found true, but points are inserted in surfaces only; accepted: false");
  fields.require(
      p.input.policy != InputPolicy::kTrack, "input.policy",
      "found track, but the points of " + p.model + " have no sides that a cloud could show; accepted: ignore, replace");
}

void requireOrientations(Fields& fields, const SceneParams& p) {
  const std::string only = ", but only " + listModels(&ModelTraits::is_oriented) + " have an orientation; accepted: ";
  for (std::size_t i = 0; i < p.pins.size(); ++i)
    fields.require(!p.pins[i].orientation, "pins[" + std::to_string(i) + "].orientation", "found true" + only + "false");
  fields.require(p.creases.empty(), "creases", "found some" + only + "none");
  fields.require(p.output.pieces_per_edge == 1, "output.pieces_per_edge",
                 "found " + std::to_string(p.output.pieces_per_edge) + only + "1");
}

}  // namespace

void visitModelName(Fields& fields, std::string& model) {
  std::vector<std::pair<const char*, std::string>> names;
  for (const ModelKind* kind : modelKinds()) names.emplace_back(kind->name(), kind->name());
  fields.required().choice("model", model, names, "the model");
}

void visitModelOptions(Fields& fields, SceneParams& p) {
  for (const ModelKind* kind : modelKinds()) kind->visitOptions(fields, p);
}

void requireModel(Fields& fields, const SceneParams& p) {
  const ModelKind* const kind = findKind(p.model);
  if (!kind) return;
  const ModelTraits traits = kind->traits();
  if (!traits.is_surface) requireSides(fields, p);
  if (!traits.is_oriented) requireOrientations(fields, p);
  const bool is_chosen = traits.is_tuned && p.simplification.method == cloud::SimplificationMethod::kDelaunay;
  fields.require(p.simplification.density == cloud::PointDensity::kUniform || is_chosen, "simplification.density",
                 "found adaptive where no points are chosen by it; accepted: uniform, or model: " +
                     listModels(&ModelTraits::is_tuned) + " with simplification.method: delaunay");
  fields.require(!p.output.error || p.accuracy.estimate, "output.error",
                 "found true without accuracy.estimate; accepted: false, or both true");
  fields.require(!p.output.error || !p.output.resample, "output.error",
                 "found true beside output.resample, whose points have no estimate; accepted: one of the two");
  fields.require(!p.output.error || traits.has_local_estimate, "output.error",
                 "found true with " + p.model + "; accepted: false, or model: " + listModels(&ModelTraits::has_local_estimate));
  fields.require(traits.has_springs || !(p.material.spring_damping > 0.0), "material.spring_damping",
                 "found " + formatReal(p.material.spring_damping) + " with a model that has no springs; accepted: 0");
  fields.require(traits.meets_itself || !p.contact.self.valueOr(false), "contact.self",
                 "found true with " + p.model +
                     ", whose parts do not meet; accepted: auto, false, or model: " + listModels(&ModelTraits::meets_itself));
  fields.require(
      !p.contact.untangle || p.integrator.type != solve::IntegratorType::kStatic, "contact.untangle",
      "found true with integrator.type: static, which has no time to push parts apart; accepted: false, or another type");
  fields.require(
      traits.is_tuned || !(p.accuracy.position_error > 0.0), "accuracy.position_error",
      "found a target, but only " + listModels(&ModelTraits::is_tuned) + " has its points chosen by the error; accepted: 0");
  fields.require(traits.is_timed || !(p.accuracy.step_budget > 0.0), "accuracy.step_budget",
                 "found a target, which is not built for " + p.model + "; accepted: 0");
  for (std::size_t i = 0; i < p.regions.size(); ++i) {
    const std::string problem = findMaterialProblem(p, p.regions[i].material);
    fields.require(problem.empty(), "regions[" + std::to_string(i) + "]", problem);
  }
  for (std::size_t i = 0; i < p.tools.size(); ++i)
    for (const ToolProblem& problem : findToolProblems(p.model, p.tools[i]))
      fields.require(false, "tools[" + std::to_string(i) + "]." + problem.field, problem.sentence);
  kind->checkScene(fields, p);
}

std::string findMaterialProblem(const SceneParams& p, const MaterialChangeParams& change) {
  const ModelKind& kind = findModel(p.model);
  if (kind.traits().has_regions) return kind.findMaterialProblem(p, change);
  return "found values of a material by region, but only " + listModels(&ModelTraits::has_regions) +
         " surfaces have them; accepted: none";
}

}  // namespace deformable_surface::simulation
