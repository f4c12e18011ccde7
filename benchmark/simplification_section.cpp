// Part "simplification": cost and error of fewer simulation points, on the scenes of run time against error with the default
// settings. It is short, so that two versions can alternate.
#include "accuracy_runs.h"
#include "deformable_surface/base/parallel.h"
#include "sections.h"

#include <algorithm>

namespace deformable_surface::benchmark {
namespace {

constexpr int kRuns = 3;  // of which the least processor time counts

}  // namespace

void runSimplificationSection(const Options& options, Report& report) {
  report.begin("simplification", "Error of simplification against processor time, one thread, least of three runs",
               {"scene", "points", "setup_s", "run_s", "rms_m", "largest_m", "moved_m", "state"});
  setNumThreads(1);
  std::vector<std::string> notes;
  for (const AccuracyScene& scene : makeAccuracyScenes(options.large)) {
    if (scene.name.compare(0, options.scene.size(), options.scene) != 0) continue;
    Reference reference;
    if (!scene.exact) reference = findReference(scene, scene.levels.front());
    const Points truth = findTruth(scene, reference);
    notes.push_back(scene.name + (scene.exact ? ": against a closed form"
                                              : ": against the full cloud in fine steps, uncertain by " +
                                                    show(reference.uncertainty) + " m rms"));
    for (const Index level : scene.levels) {
      Run best;
      for (int k = 0; k < kRuns; ++k) {
        Run one = run(scene, level, {"default", scene.params.integrator.type, 0.01});
        if (k > 0) {
          one.setup = std::min(one.setup, best.setup);
          one.cpu = std::min(one.cpu, best.cpu);
        }
        best = std::move(one);
      }
      const Error error = measureError(best.dense, truth), moved = measureError(scene.cloud.positions, truth);
      report.add({scene.name, std::to_string(best.simulated.size()), show(best.setup), show(best.cpu), show(error.rms),
                  show(error.largest), show(moved.largest), best.state});
    }
  }
  setNumThreads(0);
  report.end();
  for (const std::string& note : notes) report.note(note);
}

}  // namespace deformable_surface::benchmark
