// Part 1: time from a cloud to a simulation, stage by stage, on a surface whose normals and area are known.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/simulation/simulation.h"
#include "sections.h"
#include "wavy_sheet.h"

namespace deformable_surface::benchmark {
namespace {

void measureStages(Index n, PointOrder order, int threads, const Options& options, Report& report) {
  setNumThreads(threads);
  Preparation p;
  p.cloud = makeWavySheet(n, order);
  p.target = countKept(p.cloud.size());
  const double per_point = 1.0 / p.cloud.size();
  const auto addRow = [&](const std::string& name, const Timing& t, double error, const std::string& error_name,
                          std::uint64_t hash) {
    report.add({name, std::to_string(p.cloud.size()), order == PointOrder::kScan ? "scan" : "shuffled",
                std::to_string(numThreads()), showMilliseconds(t.wall), showPercent(t.spread), showMilliseconds(t.cpu),
                show(t.cpu / t.wall), show(1e9 * t.cpu * per_point), std::to_string(t.repetitions), show(error), error_name,
                showHash(hash)});
  };
  for (const Stage& stage : listStages()) {
    const Timing timing = measure([&] { stage.run(p); }, options.budget, 2);
    addRow(stage.name, timing, stage.error(p), stage.error_name, stage.hash(p));
  }

  // The whole set-up, as in a node that receives a cloud.
  simulation::SceneParams scene;
  scene.simplification.target_points = p.target;
  std::unique_ptr<simulation::Simulation> built;
  const Timing timing = measure([&] { built = std::make_unique<simulation::Simulation>(scene, p.cloud); }, options.budget, 2);
  double mass = 0.0;
  for (double m : built->model().masses()) mass += m;
  addRow("all (Simulation)", timing, std::abs(mass / (scene.material.arealDensity() * findWavyArea()) - 1.0),
         "relative error of mass", built->stateHash());
}

}  // namespace

void runSetupSection(const Options& options, Report& report) {
  report.begin("setup", "1. Set-up of a wavy sheet, 50 points to one simulation point",
               {"stage", "points", "order", "threads", "wall_ms", "spread_%", "cpu_ms", "cores", "cpu_ns_per_point", "runs",
                "error", "error_is", "hash"});
  measureStages(10000, PointOrder::kScan, 1, options, report);
  measureStages(100000, PointOrder::kScan, 1, options, report);
  measureStages(100000, PointOrder::kScan, 0, options, report);
  if (options.large) {
    measureStages(100000, PointOrder::kShuffled, 1, options, report);
    measureStages(1000000, PointOrder::kScan, 1, options, report);
    measureStages(1000000, PointOrder::kScan, 0, options, report);
  }
  report.end();
  report.note("target: 100000 points simplified in about a second or less on one core");
  report.note("errors: normals and area against the surface's formula, neighbours against all pairs, boundary against the edges");
}

}  // namespace deformable_surface::benchmark
