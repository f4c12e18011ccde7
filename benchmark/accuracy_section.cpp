// Part "accuracy": run time against error. Every method with every setting on every scene; the errors of time, of simplification
// and of the transfer are measured apart from each other, and together.
#include "accuracy_scenes.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/simulation/rest_surface.h"
#include "sections.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnstable = 1.0;     // m, rms: larger than any scene
constexpr double kTooLong = 60.0;     // s of processor time: a run is cut, and says so
constexpr double kTight = 1e-10;      // tolerance of the reference of statics

struct Setting {
  std::string method;
  IntegratorType type;
  double time_step;                   // s
  double tolerance = 1e-6;
  Index max_iterations = 100;
};

// Where a run ended, in the order of the cloud.
struct Run {
  Points simulated, dense;            // m
  double cpu = 0.0, wall = 0.0;       // s
  Index substeps = 0;                 // of the last step
  std::string state = "sound";
};

struct Error {
  double rms = kInfinity, largest = kInfinity;
};

Error measureError(const Points& a, const Points& b) {
  Error error{rmsDistance(a, b), 0.0};
  for (std::size_t i = 0; i < a.size(); ++i) error.largest = std::max(error.largest, (a[i] - b[i]).norm());
  return error;
}

Run run(const AccuracyScene& scene, Index level, const Setting& setting) {
  SceneParams params = atLevel(scene, level);
  params.integrator.type = setting.type;
  params.integrator.time_step = setting.time_step;
  params.integrator.tolerance = setting.tolerance;
  params.integrator.max_iterations = setting.max_iterations;
  Simulation simulation(params, scene.cloud);
  const int steps = scene.duration > 0.0 ? static_cast<int>(std::lround(scene.duration / setting.time_step)) : 1;
  Run result;
  const double cpu = processorSeconds();
  const Timer timer;
  for (int i = 0; i < steps; ++i) {
    const simulation::StepOutcome outcome = simulation.step();
    if (!outcome.ok) {
      result.state = "refused at " + show(simulation.time()) + " s";
      break;
    }
    if (outcome.notice.find("the solver stopped") != std::string::npos) result.state = "not converged";
    if (processorSeconds() - cpu > kTooLong) {
      result.state = "cut at " + show(simulation.time()) + " s";
      break;
    }
  }
  result.cpu = processorSeconds() - cpu;
  result.wall = timer.seconds();
  result.substeps = static_cast<Index>(simulation.statistics().substeps);
  result.simulated = simulation.state().positions;
  result.dense = simulation.surface(false).positions;
  return result;
}

Points extrapolate(const Points& coarse, const Points& fine) {
  Points result(fine.size());
  for (std::size_t i = 0; i < fine.size(); ++i) result[i] = (4.0 * fine[i] - coarse[i]) / 3.0;
  return result;
}

// What one number of simulation points converges to as the time step goes to zero.
struct Reference {
  Points simulated, dense;
  double uncertainty = 0.0;           // m, rms
  double substep = 0.0;               // s, that velocity Verlet takes by itself
};

Reference findReference(const AccuracyScene& scene, Index level) {
  Reference reference;
  if (scene.duration == 0.0) {
    const Run tight = run(scene, level, {"static", IntegratorType::kStatic, 0.01, kTight, 1000});
    const Run looser = run(scene, level, {"static", IntegratorType::kStatic, 0.01, 1e2 * kTight, 1000});
    return {tight.simulated, tight.dense, rmsDistance(tight.dense, looser.dense), 0.0};
  }
  // One step of the whole duration tells into how many stability cuts it.
  const Run probe = run(scene, level, {"verlet", IntegratorType::kVerlet, scene.duration});
  reference.substep = scene.duration / probe.substeps;
  Run runs[3];
  for (int i = 0; i < 3; ++i) runs[i] = run(scene, level, {"verlet", IntegratorType::kVerlet, reference.substep / (2 << i)});
  reference.simulated = extrapolate(runs[1].simulated, runs[2].simulated);
  reference.dense = extrapolate(runs[1].dense, runs[2].dense);
  reference.uncertainty = rmsDistance(reference.dense, extrapolate(runs[0].dense, runs[1].dense));
  return reference;
}

std::vector<Setting> chooseSettings(const AccuracyScene& scene, double substep) {
  std::vector<Setting> settings;
  if (scene.duration == 0.0) {
    settings.push_back({"default", IntegratorType::kStatic, 0.01});
    for (double tolerance : {1e-2, 1e-4, 1e-8}) settings.push_back({"static", IntegratorType::kStatic, 0.01, tolerance});
    for (Index iterations : {3, 10}) settings.push_back({"static", IntegratorType::kStatic, 0.01, 1e-6, iterations});
    return settings;
  }
  settings.push_back({"default", IntegratorType::kAuto, 0.01});
  if (scene.params.model == simulation::ModelKind::kElasticSolid) {
    for (double part : {1.0, 0.5, 0.25}) settings.push_back({"verlet", IntegratorType::kVerlet, part * substep});
    // Of a body of thousands of points a solution to six digits is most of the work.
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
};

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
               {"scene", "method", "points", "time_step_ms", "substeps", "tolerance", "max_iterations", "cpu_s", "wall_s",
                "time_rms", "time_max", "space_rms", "space_max", "transfer_rms", "transfer_max", "total_rms", "total_max",
                "front", "state"});
  setNumThreads(1);
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
        notes.push_back(scene.name + ": the truth, all " + std::to_string(rest.points.size()) +
                        " points simulated, is uncertain by " + show(truth.uncertainty) + " m rms");
      }
      // The truth at the simulation points, and what the transfer makes of it.
      Points there(rest.points.size()), carried;
      for (std::size_t i = 0; i < there.size(); ++i) there[i] = truth.dense[rest.dense_index[i]];
      if (scene.params.model != simulation::ModelKind::kElasticSolid) {
        rest.transfer.apply(there, carried);
      } else if (rest.points.size() == rest.dense.positions.size()) {
        carried = there;
      } else {
        rest.solid_transfer.apply(there, carried, nullptr);
      }
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
      report.add({row.scene, row.method, std::to_string(row.points), showMilliseconds(row.setting.time_step),
                  std::to_string(row.run.substeps), show(row.setting.tolerance), std::to_string(row.setting.max_iterations),
                  show(row.run.cpu), show(row.run.wall), show(row.time.rms), show(row.time.largest), show(row.space.rms),
                  show(row.space.largest), show(row.transfer.rms), show(row.transfer.largest), show(row.total.rms),
                  show(row.total.largest), row.on_front ? "yes" : "no", row.run.state});
  }
  setNumThreads(0);
  report.end();
  for (const std::string& note : notes) report.note(note);
  report.note(
      "time: against the same points with the step going to zero; space: that against the truth, at the simulation points;");
  report.note(
      "transfer: the truth at the simulation points carried to the cloud, against the truth; total: the run against the truth");
}

}  // namespace deformable_surface::benchmark
