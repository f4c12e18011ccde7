// Which tools a model takes: the modes that it has, and the fields that each of them uses.
#include "deformable_surface/simulation/scene_params.h"

namespace deformable_surface::simulation {
namespace {

using tool::Mode;
using tool::ModeInfo;

constexpr const char* kModels[] = {"mass_spring", "oriented_particles", "elastic_solid"};  // in the order of ModelKind

const tool::ModeUse& useOf(ModelKind model, const ModeInfo& info) {
  switch (model) {
    case ModelKind::kMassSpring: return info.mass_spring;
    case ModelKind::kOrientedParticles: return info.oriented_particles;
    case ModelKind::kElasticSolid: break;
  }
  return info.elastic_solid;
}

std::string listKnown(ModelKind model) {
  std::string names;
  for (const ModeInfo& info : tool::kModes)
    if (useOf(model, info).is_known) names += (names.empty() ? "" : ", ") + std::string(info.name);
  return names;
}

}  // namespace

std::vector<ToolProblem> findToolProblems(ModelKind model, const tool::ToolParams& tool) {
  const ModeInfo& info = tool::infoOf(tool.mode);
  const tool::ModeUse& use = useOf(model, info);
  const std::string name = kModels[static_cast<int>(model)];
  if (!use.is_known)
    return {{"mode", "found " + std::string(info.name) + ", which " + name + " does not have; accepted: " + listKnown(model)}};
  std::vector<ToolProblem> problems;
  const auto refuseUnused = [&](const char* field, double value, bool is_used) {
    if (is_used || value == 0.0) return;
    problems.push_back({field, "found " + formatReal(value) + ", which mode " + info.name + " of " + name +
                                   " does not use; accepted: 0, or none"});
  };
  refuseUnused("friction", tool.friction, use.friction);
  refuseUnused("kinetic_friction", tool.kinetic_friction.valueOr(0.0), use.friction);
  refuseUnused("strength", tool.strength, use.strength);
  refuseUnused("reach", tool.reach, use.reach);
  if (model == ModelKind::kMassSpring && tool.mode == Mode::kCut && tool.shape.kind == geometry::Solid::Kind::kPlane)
    problems.push_back({"shape",
                        "found plane for mode cut, which has no other side to come out at; accepted: sphere, box, "
                        "cylinder, cone, mesh"});
  return problems;
}

}  // namespace deformable_surface::simulation
