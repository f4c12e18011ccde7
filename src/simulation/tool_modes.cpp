// Tools that a model accepts: its modes, and the fields that each of them uses.
#include "deformable_surface/simulation/model_kind.h"

namespace deformable_surface::simulation {
namespace {

std::string listKnown(const ModelKind& kind) {
  std::string names;
  for (const tool::ModeInfo& info : tool::kModes)
    if (kind.useOf(info).is_known) names += (names.empty() ? "" : ", ") + std::string(info.name);
  return names;
}

}  // namespace

std::vector<ToolProblem> findToolProblems(const std::string& model, const tool::ToolParams& tool) {
  const ModelKind& kind = findModel(model);
  if (!tool::isMode(tool.mode)) return {};  // which checkParams() refuses
  const tool::ModeInfo& info = tool::infoOf(tool.mode);
  const tool::ModeUse use = kind.useOf(info);
  if (!use.is_known)
    return {{"mode", "found " + std::string(info.name) + ", which " + model + " does not have; accepted: " + listKnown(kind)}};
  std::vector<ToolProblem> problems;
  const auto refuseUnused = [&](const char* field, double value, bool is_used) {
    if (is_used || value == 0.0) return;
    problems.push_back({field, "found " + formatReal(value) + ", which mode " + info.name + " of " + model +
                                   " does not use; accepted: 0, or none"});
  };
  refuseUnused("friction", tool.friction, use.friction);
  refuseUnused("kinetic_friction", tool.kinetic_friction.valueOr(0.0), use.friction);
  refuseUnused("strength", tool.strength, use.strength);
  refuseUnused("reach", tool.reach, use.reach);
  for (ToolProblem& problem : kind.findToolProblems(tool)) problems.push_back(std::move(problem));
  return problems;
}

}  // namespace deformable_surface::simulation
