#include "accuracy.h"

#include "deformable_surface/base/value.h"
#include "deformable_surface/simulation/model_kind.h"

#include <algorithm>
#include <functional>

#include "accuracy_memory.h"
#include "accuracy_probe.h"
#include "choice_by_error.h"
#include "choice_by_time.h"
#include "rest_steps.h"

namespace deformable_surface::simulation {
namespace {

// build: makes the surface with the function that chooses, or with none.
RestSurface buildChosenBy(const std::function<RestSurface(const ModelKind::Choose&)>& build, const SceneParams& params,
                          AccuracyChoice& choice) {
  choice = AccuracyChoice{};
  choice.is_asked = hasTarget(params.accuracy);
  if (!choice.is_asked) return build(nullptr);
  std::string kept;  // about the memory, for the user
  RestSurface rest = build([&](const RestSurface& full) {
    if (params.accuracy.position_error > 0.0) {
      const ChoiceMemory memory(params, full);
      if (memory.recall(choice)) {
        kept = "no trials: what an earlier run of this scene chose was kept (accuracy.remember)";
        return choice.points;
      }
      chooseByError(params, full, choice);
      if (memory.isOn())
        kept = (memory.keep(choice) ? "what trials chose is kept for later runs in " : "what trials chose cannot be kept in ") +
               findCacheFolder() + " (accuracy.remember)";
      return choice.points;
    }
    chooseByBudget(params, full, choice);
    return choice.points;
  });
  if (!kept.empty()) rest.notes.push_back(kept);
  rest.notes.push_back(choice.sentence);
  return rest;
}

}  // namespace

RestSurface buildChosen(const SceneParams& params, const cloud::PointCloud& input, AccuracyChoice& choice) {
  const auto build = [&](const ModelKind::Choose& choose) {
    return buildRestSurface(params, input, findCoarsest(params), choose);
  };
  return buildChosenBy(build, params, choice);
}

RestSurface buildChosen(const SceneParams& params, RestSurface prepared, AccuracyChoice& choice) {
  const auto build = [&](const ModelKind::Choose& choose) { return buildRestSurface(params, std::move(prepared), choose); };
  return buildChosenBy(build, params, choice);
}

RestSurface buildUntried(const SceneParams& params, const cloud::PointCloud& input, AccuracyChoice& choice) {
  choice = AccuracyChoice{};
  choice.is_asked = true;
  RestSurface rest = buildRestSurface(params, input, findCoarsest(params), [&](const RestSurface& full) {
    const Index n = static_cast<Index>(full.dense.positions.size());
    choice.points = std::min(n, countWanted(params, n));
    choice.sentence = "accuracy.position_error " + formatReal(params.accuracy.position_error) + " m: begins with " +
                      sayPoints(choice.points, n) + ", as many as without a target; whether they meet it is not known";
    return choice.points;
  });
  rest.notes.push_back(choice.sentence);
  return rest;
}

}  // namespace deformable_surface::simulation
