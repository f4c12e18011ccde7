// Part "solids": speed of an elastic solid with its error: the bar of 5,000 points with explicit and implicit steps, with one and
// two threads. And the time of a force pass against the number of neighbours.
#include "accuracy_scenes.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/timer.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/elastic_solid/elastic_solid.h"
#include "sections.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

namespace deformable_surface::benchmark {
namespace {

using solve::IntegratorType;

constexpr int kRuns = 3;  // of every row, in turn, of which the fastest counts

constexpr int kPasses = 300;

struct Setting {
  const char* method;
  IntegratorType type;
  int steps;  // of the whole motion
  double tolerance;
};

struct Row {
  Setting setting;
  int threads;
  double wall = std::numeric_limits<double>::infinity(), cpu = wall, error = 0.0;  // s, s, m
  double iterations = 0.0;                                                         // a step
};

const AccuracyScene& findBar(const std::vector<AccuracyScene>& scenes) {
  return *std::find_if(scenes.begin(), scenes.end(), [](const AccuracyScene& scene) { return scene.name == "solid_bar"; });
}

Points runOnce(const AccuracyScene& bar, const Setting& setting, Row* row) {
  simulation::SceneParams params = atLevel(bar, bar.cloud.size());
  params.integrator.type = setting.type;
  params.integrator.time_step = bar.duration / setting.steps;
  params.integrator.tolerance = setting.tolerance;
  simulation::Simulation simulation(params, bar.cloud);
  double iterations = 0.0;
  const double cpu = processorSeconds();
  const Timer timer;
  for (int k = 0; k < setting.steps; ++k) {
    simulation.step();
    iterations += simulation.statistics().solver_iterations;
  }
  if (row) {
    row->wall = std::min(row->wall, timer.seconds());
    row->cpu = std::min(row->cpu, processorSeconds() - cpu);
    row->iterations = iterations / setting.steps;
  }
  return simulation.state().positions;
}

void reportBar(bool large, Report& report) {
  const std::vector<AccuracyScene> scenes = makeAccuracyScenes(large);
  const AccuracyScene& bar = findBar(scenes);
  report.begin("solids",
               "A bar of 1 x 0.1 x 0.1 m, 1e5 Pa, 1000 kg/m^3, falls from rest, all " + std::to_string(bar.cloud.size()) +
                   " points simulated; real_time: simulated seconds a second",
               {"method", "step_ms", "tolerance", "threads", "iterations", "real_time", "cpu_per_s", "error_rms_m"});
  // Verlet's steps halved twice.
  const int steps = 640;
  Points runs[3], truth;
  for (int k = 0; k < 3; ++k) runs[k] = runOnce(bar, {"verlet", IntegratorType::kVerlet, steps << k, 1e-6}, nullptr);
  double uncertainty = 0.0;
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    truth.push_back((4.0 * runs[2][i] - runs[1][i]) / 3.0);
    uncertainty += (truth[i] - (4.0 * runs[1][i] - runs[0][i]) / 3.0).squaredNorm() / static_cast<double>(runs[0].size());
  }

  std::vector<Row> rows;
  for (const Setting& setting :
       {Setting{"auto", IntegratorType::kAuto, 40, 1e-6}, Setting{"implicit", IntegratorType::kImplicit, 12, 1e-2},
        Setting{"implicit", IntegratorType::kImplicit, 12, 1e-3}, Setting{"implicit", IntegratorType::kImplicit, 24, 1e-2},
        Setting{"implicit", IntegratorType::kImplicit, 24, 1e-3}})
    for (const int threads : {1, 2}) rows.push_back({setting, threads});
  for (int run = 0; run < kRuns; ++run)
    for (Row& row : rows) {
      setNumThreads(row.threads);
      row.error = rmsDistance(runOnce(bar, row.setting, &row), truth);
    }
  setNumThreads(0);
  for (const Row& row : rows)
    report.add({row.setting.method, showMilliseconds(bar.duration / row.setting.steps), show(row.setting.tolerance),
                std::to_string(row.threads), show(row.iterations), show(bar.duration / row.wall), show(row.cpu / bar.duration),
                show(row.error)});
  report.end();
  report.note("errors against Richardson's extrapolation of Verlet's finer steps, uncertain by " + show(std::sqrt(uncertainty)) +
              " m rms");
}

// A cube of points; jitter: the share of the spacing by which each is moved in every direction.
Points makeCube(Index side, double jitter) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> shift(-jitter, jitter);
  Points points;
  for (Index x = 0; x < side; ++x)
    for (Index y = 0; y < side; ++y)
      for (Index z = 0; z < side; ++z)
        points.push_back(0.01 * Vec3(x + shift(generator), y + shift(generator), z + shift(generator)));
  return points;
}

// Lattices of four points per cell, in which each point has twelve nearest ones: denser neighbourhoods than a cubic lattice.
Points makeDensePacking(Index side, double jitter) {
  Points points;
  for (const Vec3& p : makeCube(2 * side, jitter)) {
    const Eigen::Vector3i cell = (p / 0.01).array().round().cast<int>();
    if (cell.sum() % 2 == 0) points.push_back(p);
  }
  return points;
}

struct PassRow {
  std::string cloud;
  std::unique_ptr<model::ElasticSolid> solid;
  model::State state;
  Index pairs = 0;
  double least = std::numeric_limits<double>::infinity();  // s
};

PassRow makePassRow(const std::string& name, const Points& points) {
  PassRow row;
  row.cloud = name;
  const Lists neighbors = cloud::nearestNeighbors(points, 32);
  model::MaterialParams material;
  material.poisson_ratio = 0.3;
  row.solid = std::make_unique<model::ElasticSolid>(points, neighbors, std::vector<double>(), Vec3::Zero(), material,
                                                    model::ElasticSolidParams());
  row.pairs = row.solid->numPairs();
  row.state.positions = points;
  for (Vec3& p : row.state.positions) p = Vec3(p.x() + 0.3 * p.z() * p.z(), 1.05 * p.y(), p.z());
  row.state.velocities.assign(points.size(), Vec3::Zero());
  return row;
}

void reportPasses(Report& report) {
  report.begin(
      "solid_passes",
      "Forces of elastic solids at strains of some hundredths, one thread; the least of " + std::to_string(kPasses) + " passes",
      {"cloud", "points", "neighbours", "ns_per_point", "ns_per_neighbour"});
  setNumThreads(1);
  std::vector<PassRow> rows;
  rows.push_back(makePassRow("cube, jitter 0.2", makeCube(17, 0.2)));
  rows.push_back(makePassRow("cube, regular", makeCube(17, 0.0)));
  rows.push_back(makePassRow("densest packing, jitter 0.1", makeDensePacking(11, 0.1)));
  rows.push_back(makePassRow("densest packing, jitter 0.2", makeDensePacking(11, 0.2)));
  Points forces;
  for (PassRow& row : rows)  // not in turn: together they are more than caches hold
    for (int pass = 0; pass < kPasses; ++pass) {
      forces.assign(row.state.positions.size(), Vec3::Zero());
      const Timer timer;
      row.solid->addForces(row.state, forces);
      row.least = std::min(row.least, timer.seconds());
    }
  setNumThreads(0);
  for (const PassRow& row : rows) {
    const double n = static_cast<double>(row.state.size()), each = 1e9 * row.least;
    report.add({row.cloud, std::to_string(row.state.size()), show(row.pairs / n), show(each / n), show(each / row.pairs)});
  }
  report.end();
}

}  // namespace

void runSolidsSection(const Options& options, Report& report) {
  reportPasses(report);
  reportBar(options.large, report);
}

}  // namespace deformable_surface::benchmark
