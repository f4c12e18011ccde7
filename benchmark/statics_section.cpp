// Part "statics": equilibria by the static solver, and damped stepping to the same unbalanced force with the best of several
// dampings.
#include "accuracy_scenes.h"

#include "deformable_surface/base/parallel.h"
#include "sections.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

constexpr double kTolerance = 1e-6;  // unbalanced force over the largest load and internal force, as of the static solver
constexpr double kPatience = 12.0;   // times the static solver's time: for one damping, more than the best needs

constexpr int kRuns = 3;  // of the static solver, of which the fastest counts
constexpr double kDampings[] = {1, 2, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44, 48, 64, 128};  // 1/s

// With everything at rest under gravity: the largest force on a free point, and the largest internal force on any, N.
struct Balance {
  double residual = 0.0, scale = 0.0;
};

Balance findBalance(const Simulation& simulation, const Vec3& gravity) {
  model::State at_rest = simulation.state();
  std::fill(at_rest.velocities.begin(), at_rest.velocities.end(), Vec3::Zero());
  Points forces(at_rest.positions.size(), Vec3::Zero());
  simulation.model().addForces(at_rest, forces);
  Balance balance;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    balance.scale = std::max(balance.scale, forces[i].norm());
    if (!simulation.pinned()[i])
      balance.residual = std::max(balance.residual, (forces[i] + simulation.model().masses()[i] * gravity).norm());
  }
  return balance;
}

struct Found {
  double cpu = 0.0, residual = 0.0;
  bool reached = false;
  Points positions;
};

Found stepUntil(const SceneParams& scene, const cloud::PointCloud& cloud, double damping, double wanted, double patience) {
  SceneParams params = scene;
  params.integrator.type = IntegratorType::kVerlet;
  params.material.damping = damping;
  Simulation simulation(params, cloud);
  Found found;
  const double start = processorSeconds();
  for (;;) {
    for (int i = 0; i < 10; ++i) simulation.step();
    found.cpu = processorSeconds() - start;
    found.residual = findBalance(simulation, params.gravity).residual;
    found.reached = found.residual <= wanted;
    if (found.reached || found.cpu > patience) break;
  }
  found.positions = simulation.state().positions;
  return found;
}

}  // namespace

void runStaticsSection(const Options& options, Report& report) {
  report.begin(
      "statics", "Equilibria: the static solver and damped stepping (velocity Verlet) to the same unbalanced force, one thread",
      {"scene", "E_Pa", "points", "method", "damping_1/s", "cpu_s", "residual_N", "reached", "rms_to_static_m", "times_slower"});
  setNumThreads(1);
  std::vector<std::string> summary;
  for (const AccuracyScene& scene : makeStaticScenes(options.large)) {
    SceneParams params = atLevel(scene, scene.levels[0]);
    params.integrator.tolerance = kTolerance;
    double cpu = std::numeric_limits<double>::infinity();
    Balance balance;
    Points equilibrium;
    for (int run = 0; run < kRuns; ++run) {
      Simulation simulation(params, scene.cloud);
      const double start = processorSeconds();
      simulation.step();
      cpu = std::min(cpu, processorSeconds() - start);
      balance = findBalance(simulation, params.gravity);
      equilibrium = simulation.state().positions;
    }
    const std::string stiffness = show(params.material.young_modulus), points = std::to_string(equilibrium.size());
    report.add({scene.name, stiffness, points, "static", "-", show(cpu), show(balance.residual), "yes", "0", "1"});
    double best = std::numeric_limits<double>::infinity();
    for (const double damping : kDampings) {
      const Found found =
          stepUntil(params, scene.cloud, damping, std::max(balance.residual, kTolerance * balance.scale), kPatience * cpu);
      if (found.reached) best = std::min(best, found.cpu / cpu);
      report.add({scene.name, stiffness, points, "verlet", show(damping), show(found.cpu), show(found.residual),
                  found.reached ? "yes" : "cut", show(rmsDistance(found.positions, equilibrium)), show(found.cpu / cpu)});
    }
    summary.push_back(scene.name + ", E " + stiffness + " Pa, " + points + " points: the best damping takes " +
                      (std::isfinite(best) ? show(best) : "more than " + show(kPatience)) + " times as long");
  }
  setNumThreads(0);
  report.end();
  for (const std::string& line : summary) report.note(line);
}

}  // namespace deformable_surface::benchmark
