// Part "statics": equilibria by the static solver, beside damped stepping to the same unbalanced force with the best of several dampings.
#include "accuracy_scenes.h"

#include "deformable_surface/base/parallel.h"
#include "sections.h"

#include <algorithm>

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

constexpr double kTolerance = 1e-6;  // unbalanced force over the largest load and internal force, as of the static solver
constexpr double kPatience = 30.0;   // s of processor time for one damping

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

Found stepUntil(const SceneParams& scene, const cloud::PointCloud& cloud, double damping, double wanted) {
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
    if (found.reached || found.cpu > kPatience) break;
  }
  found.positions = simulation.state().positions;
  return found;
}

}  // namespace

void runStaticsSection(const Options& options, Report& report) {
  report.begin("statics", "Equilibria: the static solver and damped stepping (velocity Verlet) to the same unbalanced force, one thread",
               {"scene", "points", "method", "damping_1/s", "cpu_s", "residual_N", "reached", "rms_to_static_m", "times_slower"});
  setNumThreads(1);
  for (const AccuracyScene& scene : makeAccuracyScenes(options.large)) {
    if (scene.duration > 0.0) continue;
    for (Index level : {scene.levels[0], scene.levels[1]}) {
      SceneParams params = atLevel(scene, level);
      params.integrator.tolerance = kTolerance;
      Simulation simulation(params, scene.cloud);
      const double start = processorSeconds();
      simulation.step();
      const double cpu = processorSeconds() - start;
      const Balance balance = findBalance(simulation, params.gravity);
      const Points equilibrium = simulation.state().positions;
      const std::string points = std::to_string(equilibrium.size());
      report.add({scene.name, points, "static", "-", show(cpu), show(balance.residual), "yes", "0", "1"});
      for (double damping : {1.0, 2.0, 4.0, 8.0, 16.0, 32.0}) {
        const Found found = stepUntil(params, scene.cloud, damping, std::max(balance.residual, kTolerance * balance.scale));
        report.add({scene.name, points, "verlet", show(damping), show(found.cpu), show(found.residual), found.reached ? "yes" : "cut",
                    show(rmsDistance(found.positions, equilibrium)), show(found.cpu / cpu)});
      }
    }
  }
  setNumThreads(0);
  report.end();
}

}  // namespace deformable_surface::benchmark
