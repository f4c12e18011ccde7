#include "accuracy_runs.h"

#include "deformable_surface/base/timer.h"
#include "sections.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

constexpr double kTooLong = 60.0;  // s of processor time: a longer run is cut, with a message
constexpr double kTight = 1e-10;   // tolerance of the reference of statics

}  // namespace

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
  const double begin = processorSeconds();
  Simulation simulation(params, scene.cloud);
  const int steps = scene.duration > 0.0 ? static_cast<int>(std::lround(scene.duration / setting.time_step)) : 1;
  Run result;
  const double cpu = processorSeconds();
  result.setup = cpu - begin;
  const Timer timer;
  for (int i = 0; i < steps; ++i) {
    const simulation::StepOutcome outcome = simulation.step();
    if (!outcome.ok) {
      result.state = "refused at " + show(simulation.time()) + " s";
      break;
    }
    if (!outcome.has_converged) result.state = "not converged";
    if (processorSeconds() - cpu > kTooLong) {
      result.state = "cut at " + show(simulation.time()) + " s";
      break;
    }
  }
  result.cpu = processorSeconds() - cpu;
  result.wall = timer.seconds();
  result.substeps = static_cast<Index>(simulation.statistics().substeps);
  result.is_implicit = simulation.lastIntegrator() == IntegratorType::kImplicit;
  result.simulated = simulation.state().positions;
  result.dense = simulation.surface(false).positions;
  return result;
}

namespace {

Points extrapolate(const Points& coarse, const Points& fine) {
  Points result(fine.size());
  for (std::size_t i = 0; i < fine.size(); ++i) result[i] = (4.0 * fine[i] - coarse[i]) / 3.0;
  return result;
}

}  // namespace

Reference findReference(const AccuracyScene& scene, Index level) {
  Reference reference;
  if (scene.duration == 0.0) {
    const Run tight = run(scene, level, {"static", IntegratorType::kStatic, 0.01, kTight, 1000});
    const Run looser = run(scene, level, {"static", IntegratorType::kStatic, 0.01, 1e2 * kTight, 1000});
    return {tight.simulated, tight.dense, rmsDistance(tight.dense, looser.dense), 0.0};
  }
  // The number of sub-steps of one step over the whole duration gives the stable step.
  const Run probe = run(scene, level, {"verlet", IntegratorType::kVerlet, scene.duration});
  reference.substep = scene.duration / probe.substeps;
  Run runs[3];
  for (int i = 0; i < 3; ++i) runs[i] = run(scene, level, {"verlet", IntegratorType::kVerlet, reference.substep / (2 << i)});
  reference.simulated = extrapolate(runs[1].simulated, runs[2].simulated);
  reference.dense = extrapolate(runs[1].dense, runs[2].dense);
  reference.uncertainty = rmsDistance(reference.dense, extrapolate(runs[0].dense, runs[1].dense));
  return reference;
}

Points findTruth(const AccuracyScene& scene, const Reference& first) {
  if (!scene.exact) return first.dense;
  Points truth;
  for (const Vec3& p : scene.cloud.positions) truth.push_back(scene.exact(p));
  return truth;
}

}  // namespace deformable_surface::benchmark
