// Part "accuracy": run time against error, for every method with every setting on every scene. The errors of time steps, of
// simplification and of the transfer are measured separately and together.
#include "accuracy_runs.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "machine_limits.h"
#include "scale_models.h"
#include "sections.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using solve::IntegratorType;

constexpr double kUnstable = 1.0;  // m, rms: larger than any scene

std::vector<Setting> chooseSettings(const AccuracyScene& scene, double substep) {
  std::vector<Setting> settings;
  if (scene.duration == 0.0) {
    settings.push_back({"default", IntegratorType::kStatic, 0.01});
    for (double tolerance : {1e-2, 1e-4, 1e-8}) settings.push_back({"static", IntegratorType::kStatic, 0.01, tolerance});
    for (Index iterations : {3, 10}) settings.push_back({"static", IntegratorType::kStatic, 0.01, 1e-6, iterations});
    return settings;
  }
  settings.push_back({"default", IntegratorType::kAuto, 0.01});
  if (scene.params.model == "elastic_solid") {
    for (double part : {1.0, 0.5, 0.25}) settings.push_back({"verlet", IntegratorType::kVerlet, part * substep});
    // For a body of thousands of points a solution to six digits is most of the work.
    for (double step : {1.0 / 30.0, 1.0 / 60.0, 1.0 / 120.0})
      for (double tolerance : {1e-2, 1e-3, 1e-6}) settings.push_back({"implicit", IntegratorType::kImplicit, step, tolerance});
    for (Setting& setting : settings)
      setting.time_step = scene.duration / std::max(1.0, std::round(scene.duration / setting.time_step));
    return settings;
  }
  for (double part : {1.0, 0.5, 0.25}) settings.push_back({"verlet", IntegratorType::kVerlet, part * substep});
  for (double part : {1.0, 0.5, 0.25, 0.125})
    settings.push_back({"symplectic_euler", IntegratorType::kSymplecticEuler, part * substep});
  for (double part : {1.0, 0.1}) settings.push_back({"explicit_euler", IntegratorType::kExplicitEuler, part * substep});
  for (double step : {0.02, 0.0067, 0.0022}) settings.push_back({"implicit", IntegratorType::kImplicit, step});
  settings.push_back({"implicit", IntegratorType::kImplicit, 0.02, 1e-2});
  for (Index iterations : {1, 3}) settings.push_back({"implicit", IntegratorType::kImplicit, 0.02, 1e-6, iterations});
  for (Setting& setting : settings)  // whole steps
    setting.time_step = scene.duration / std::max(1.0, std::round(scene.duration / setting.time_step));
  return settings;
}

struct Row {
  std::string scene, method;
  Index points;
  Setting setting;
  Run run;
  Error time, space, transfer, total;
  bool on_front = false;
  double limit = std::numeric_limits<double>::quiet_NaN();  // s, below which the machine cannot be; NaN: not known
};

// The force passes over the triangles alone, at the machine's limit of arithmetic. Not of models and methods whose operations are
// not counted.
double findLimit(const AccuracyScene& scene, const Setting& setting, const Run& run, double pass_operations, double arithmetic) {
  const bool is_explicit = setting.type == IntegratorType::kVerlet || setting.type == IntegratorType::kAuto;
  if (scene.duration == 0.0 || scene.params.model != "mass_spring" || !is_explicit || run.is_implicit)
    return std::numeric_limits<double>::quiet_NaN();
  return scene.duration / setting.time_step * run.substeps * pass_operations / arithmetic;
}

// No other sound row of the scene is both cheaper and better.
void markFront(std::vector<Row>& rows) {
  for (Row& row : rows)
    row.on_front = row.run.state == "sound" && std::none_of(rows.begin(), rows.end(), [&](const Row& other) {
                     return other.run.state == "sound" && other.run.cpu < row.run.cpu && other.total.rms < row.total.rms;
                   });
}

}  // namespace

void runAccuracySection(const Options& options, Report& report) {
  report.begin("accuracy", "Run time against error, one thread; errors in metres, rms / largest over the cloud",
               {"scene",        "method",       "points",    "time_step_ms", "substeps", "tolerance", "max_iterations",
                "setup_s",      "cpu_s",        "wall_s",    "time_rms",     "time_max", "space_rms", "space_max",
                "transfer_rms", "transfer_max", "total_rms", "total_max",    "front",    "state",     "limit_s"});
  setNumThreads(1);
  const double arithmetic = measureArithmetic(options.budget);
  std::vector<std::string> notes;
  for (const AccuracyScene& scene : makeAccuracyScenes(options.large)) {
    if (scene.name.compare(0, options.scene.size(), options.scene) != 0) continue;
    std::vector<Row> rows;
    Reference truth;
    for (Index level : scene.levels) {
      const Reference reference = findReference(scene, level);
      const simulation::RestSurface rest = simulation::buildRestSurface(atLevel(scene, level), scene.cloud);
      if (level == scene.levels.front()) {
        truth = reference;
        truth.dense = findTruth(scene, reference);
        if (scene.exact) {
          notes.push_back(scene.name + ": the truth is a closed form");
        } else {
          notes.push_back(scene.name + ": the truth, all " + std::to_string(rest.points.size()) +
                          " points simulated, is uncertain by " + show(truth.uncertainty) + " m rms");
        }
      }
      // The reference at the simulation points, and its transfer to all points.
      Points there(rest.points.size()), carried;
      for (std::size_t i = 0; i < there.size(); ++i) there[i] = truth.dense[rest.dense_index[i]];
      if (scene.params.model != "elastic_solid") {
        rest.transfer.apply(there, carried);
      } else if (rest.points.size() == rest.dense.positions.size()) {
        carried = there;
      } else {
        rest.solid_transfer.apply(there, carried, nullptr);
      }
      const double pass_operations = countTriangleOperations(*rest.model);
      const Error space = measureError(reference.simulated, there), transfer = measureError(carried, truth.dense);
      for (const Setting& setting : chooseSettings(scene, reference.substep)) {
        Row row{scene.name,
                setting.method,
                static_cast<Index>(rest.points.size()),
                setting,
                run(scene, level, setting),
                {},
                space,
                transfer,
                {}};
        row.limit = findLimit(scene, setting, row.run, pass_operations, arithmetic);
        if (row.run.state == "sound" || row.run.state == "not converged") {
          row.time = measureError(row.run.dense, reference.dense);
          row.total = measureError(row.run.dense, truth.dense);
          if (!(row.time.rms < kUnstable)) row.run.state = "unstable";
        }
        rows.push_back(std::move(row));
      }
    }
    markFront(rows);
    for (const Row& row : rows)
      report.add({row.scene,
                  row.method,
                  std::to_string(row.points),
                  showMilliseconds(row.setting.time_step),
                  std::to_string(row.run.substeps),
                  show(row.setting.tolerance),
                  std::to_string(row.setting.max_iterations),
                  show(row.run.setup),
                  show(row.run.cpu),
                  show(row.run.wall),
                  show(row.time.rms),
                  show(row.time.largest),
                  show(row.space.rms),
                  show(row.space.largest),
                  show(row.transfer.rms),
                  show(row.transfer.largest),
                  show(row.total.rms),
                  show(row.total.largest),
                  row.on_front ? "yes" : "no",
                  row.run.state,
                  show(row.limit)});
  }
  setNumThreads(0);
  report.end();
  for (const std::string& note : notes) report.note(note);
  report.note(
      "time: against the same points with the step going to zero; space: that against the truth, at the simulation points;");
  report.note("limit: processor time of the force passes over triangles alone at " + show(1e-9 * arithmetic) +
              " Gop/s, the limit of this machine's arithmetic on one thread; explicit steps of surfaces");
  report.note(
      "transfer: the truth at the simulation points carried to the cloud, against the truth; total: the run against the truth");
}

}  // namespace deformable_surface::benchmark
