// Part 15: cost and error of an accuracy target. The sheets are those with published times at a millimetre. They run with the
// choices of accuracy.position_error, and without a target. A part of its own because here the scene states a target, not a
// method.
#include "../src/simulation/dynamics.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/timer.h"
#include "sections.h"
#include "swinging_sheet.h"
#include "varied_targets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

constexpr double kTargets[] = {0.0, 1e-3, 2e-3, 5e-3};  // m; 0: none
constexpr int kRuns = 3;                                // of which the fastest counts, those of a scene in turn
constexpr Index kFineness = 2;  // of the truth: its error is then a quarter of that of a run without a target

struct Sheet {
  const char* name;
  SceneParams scene;
  cloud::PointCloud cloud;
};

std::vector<Sheet> makeSheets(bool large) {
  std::vector<Sheet> sheets{{"swings from an edge, E h 1e5 N/m", makeEquilateralScene(1e5, 0.01), makeEquilateralSheet(17, 19)}};
  if (large) sheets.push_back({sheets[0].name, makeEquilateralScene(1e5, 0.01), makeEquilateralSheet(33, 38)});
  for (Sheet& sheet : sheets) sheet.scene.duration = 0.4;
  if (large) sheets.push_back({"hangs from two corners, E h 1e3 N/m", makeHangingScene(1.0 / 60.0), makeHangingSheet(64)});
  sheets.back().scene.duration = large ? 0.5 : 0.4;
  return sheets;
}

struct Choice {
  double target;
  bool estimate;  // also in the run
  double set_up = 0.0;
  std::unique_ptr<Simulation> simulation;
  double wall = std::numeric_limits<double>::infinity(), cpu = wall;  // s per simulated second
};

int countSteps(const SceneParams& scene) { return static_cast<int>(std::lround(scene.duration / scene.integrator.time_step)); }

void run(Simulation& simulation, int steps) {
  for (int k = 0; k < steps; ++k) simulation.step();
}

void addSheet(const Sheet& sheet, Report& report) {
  const int steps = countSteps(sheet.scene);
  Simulation truth(sheet.scene, sheet.cloud);
  truth.dynamics().setFineness(kFineness);
  run(truth, steps);
  const Points exact = truth.surface(false).positions;

  std::vector<Choice> choices;
  for (const double target : kTargets)
    for (const bool estimate : {false, true}) {
      SceneParams scene = sheet.scene;
      scene.accuracy.position_error = target;
      scene.accuracy.estimate = estimate;
      if (target > 0.0) scene.simplification = cloud::SimplificationParams();
      Choice choice{target, estimate};
      const double before = processorSeconds();
      choice.simulation = std::make_unique<Simulation>(scene, sheet.cloud);
      choice.set_up = processorSeconds() - before;
      choices.push_back(std::move(choice));
    }
  for (int repetition = 0; repetition < kRuns; ++repetition)
    for (Choice& choice : choices) {
      choice.simulation->reset();
      const Timer timer;
      const double before = processorSeconds();
      run(*choice.simulation, steps);
      choice.cpu = std::min(choice.cpu, (processorSeconds() - before) / sheet.scene.duration);
      choice.wall = std::min(choice.wall, timer.seconds() / sheet.scene.duration);
    }
  for (Choice& choice : choices) {
    Simulation& simulation = *choice.simulation;
    const Points& found = simulation.surface(false).positions;
    double largest = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) largest = std::max(largest, (found[i] - exact[i]).norm());
    const simulation::AccuracyChoice& chosen = simulation.accuracyChoice();
    report.add({sheet.name, std::to_string(sheet.cloud.size()), choice.target > 0.0 ? show(choice.target) : "-",
                choice.estimate ? "yes" : "no", std::to_string(simulation.state().size()), show(simulation.membraneShare()),
                chosen.is_asked ? (chosen.is_met ? "yes" : "no") : "-", show(choice.set_up), show(choice.wall), show(choice.cpu),
                show(rmsDistance(found, exact)), show(largest),
                show(choice.estimate ? simulation.statistics().error_estimate : chosen.error)});
  }
}

}  // namespace

void runTargetsSection(const Options& options, Report& report) {
  if (options.varied) return reportVariedTargets(options, report);
  report.begin("targets", "15. Sheets with what accuracy.position_error chooses for them, one thread",
               {"sheet", "points", "target_m", "estimate_in_run", "simulated", "membrane_share", "met", "set_up_cpu_s",
                "wall_s_per_simulated_s", "cpu_s_per_simulated_s", "rms_error_m", "largest_error_m", "estimate_m"});
  setNumThreads(1);
  for (const Sheet& sheet : makeSheets(options.large)) addSheet(sheet, report);
  setNumThreads(0);
  report.end();
  report.note(
      "errors at the end, against all points with the stated stiffness in half of the sub-steps; estimate_m: that of the run, "
      "or of the "
      "trial where the run has none");
  if (!options.large) report.note("--large adds the stiff sheet of 1254 points and the hanging one of 4096");
}

}  // namespace deformable_surface::benchmark
