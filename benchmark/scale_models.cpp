#include "scale_models.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/model/oriented_particles/oriented_particles.h"
#include "deformable_surface/simulation/simulation.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::benchmark {
namespace {

using simulation::CloudParams;
using simulation::SceneParams;
using simulation::Simulation;

constexpr double kTimeStep = 1e-3;  // s: from one sub-step of few points to some dozens of many
constexpr int kSteps = 3;           // the first step allocates what later ones reuse

struct Model {
  const char* name;
  std::string kind;
  CloudParams::Shape shape;
  model::Membrane membrane = model::Membrane::kTriangles;
  model::Bending bending = model::Bending::kNone;
};
const Model kModels[] = {{"springs", "mass_spring", CloudParams::Shape::kLattice, model::Membrane::kSprings},
                         {"triangles", "mass_spring", CloudParams::Shape::kLattice},
                         {"triangles and curvature", "mass_spring", CloudParams::Shape::kLattice, model::Membrane::kTriangles,
                          model::Bending::kCurvature},
                         {"oriented particles", "oriented_particles", CloudParams::Shape::kLattice},
                         {"elastic solid", "elastic_solid", CloudParams::Shape::kBar}};

SceneParams makeScene(const Model& model, Index n) {
  SceneParams scene;
  scene.model = model.kind;
  scene.cloud.shape = model.shape;
  scene.cloud.points = n;
  scene.accuracy.estimate = false;
  scene.sleep.mode = simulation::Sleep::kNever;
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  scene.mass_spring.membrane = model.membrane;
  scene.mass_spring.bending = model.bending;
  scene.material.damping = 0.0;
  scene.gravity.setZero();
  scene.integrator.type = solve::IntegratorType::kVerlet;
  scene.integrator.time_step = kTimeStep;
  if (model.kind == "elastic_solid") scene.cloud.jitter = 0.1;
  if (model.kind == "oriented_particles") {
    // Stiff enough in bending to stay a surface at every spacing.
    const double spacing = std::sqrt(2.0 / std::sqrt(3.0) / n);
    scene.material.bending_rigidity = 0.1 * scene.material.young_modulus * scene.material.thickness * spacing * spacing;
  }
  return scene;
}

// Operations of the loops of src/model/mass_spring on a spring, a triangle and a curvature fit, and the bytes that they read and
// write, each array once: springs.cpp, triangle_forces.cpp, curvature_bending.cpp with 17 places in a fit.
struct Counts {
  double operations, bytes;
};
constexpr Counts kSpring{31.0, 56.0}, kTriangle{90.0, 264.0}, kFit{45.0 * 17.0 + 87.0, 68.0 * 17.0 + 96.0};
constexpr double kPointBytes = 32.0 + 2.0 * 24.0;  // of a point: its copy, its force read and written

double countOf(const Model& kind, const model::DeformableModel& model, double Counts::*what) {
  const double springs = static_cast<double>(stretchLinksOf(model).size()),
               triangles = static_cast<double>(trianglesOf(model).size());
  const double n = static_cast<double>(model.masses().size());
  double sum = kind.membrane == model::Membrane::kSprings ? springs * kSpring.*what : triangles * kTriangle.*what;
  if (kind.bending == model::Bending::kCurvature) sum += n * kFit.*what;
  return sum;
}

// Stretched along x by a hundredth and bent across, so that every force is non-zero.
model::State deform(model::State state) {
  constexpr double kStretch = 1.01, kHeight = 0.01, kWaveNumber = 6.0;  // m, 1/m
  for (Vec3& p : state.positions) p = Vec3(kStretch * p.x(), p.y(), p.z() + kHeight * std::sin(kWaveNumber * p.x()));
  return state;
}

double totalEnergy(const Simulation& simulation) {
  const simulation::Statistics s = simulation.statistics();
  return s.kinetic_energy + s.elastic_energy + s.potential_energy;
}

}  // namespace

double countTriangleOperations(const model::DeformableModel& model) {
  return kTriangle.operations * static_cast<double>(trianglesOf(model).size());
}

void measureModels(const Options& options, Report& report, std::vector<CountedStage>& counted) {
  struct Growth {
    std::string name;
    std::vector<double> sizes, passes, steps;
  };
  std::vector<Growth> growths;
  setNumThreads(1);
  report.begin("scale_models",
               "13d. Models, every point simulated, one thread, steps of " + showMilliseconds(kTimeStep) +
                   " ms, Verlet, undamped, from a stretched and bent state",
               {"model", "points", "pass_ms", "ns_per_point", "imbalance", "substeps", "step_ms", "ns_per_point_and_substep",
                "energy_error"});
  for (const Model& kind : kModels) {
    Growth growth{kind.name, {}, {}, {}};
    for (const Index wanted : {100, 1000, 10000, 100000}) {
      const SceneParams scene = makeScene(kind, wanted);
      Simulation simulation(scene, io::makeShape(scene.cloud));
      const Index n = simulation.state().size();
      simulation.setState(deform(simulation.state()));
      const double before = totalEnergy(simulation), stored = simulation.statistics().elastic_energy;
      double least = 1e300;
      for (int k = 0; k < kSteps; ++k) {
        const double start = processorSeconds();
        simulation.step();
        if (k > 0) least = std::min(least, processorSeconds() - start);
      }
      const simulation::Statistics statistics = simulation.statistics();
      const double energy_error = std::abs(totalEnergy(simulation) - before) / stored;

      Points forces(n), torques(n);
      const bool is_oriented = isOriented(simulation.model());
      const Timing pass = measure(
          [&] {
            std::fill(forces.begin(), forces.end(), Vec3::Zero());
            if (is_oriented) {
              simulation.model().orientedPoints()->addForcesAndTorques(simulation.state(), forces, torques);
            } else {
              simulation.model().addForces(simulation.state(), forces);
            }
          },
          options.budget);
      // Internal forces sum to nothing.
      Vec3 sum = Vec3::Zero();
      double size = 0.0;
      for (const Vec3& f : forces) {
        sum += f;
        size += f.norm();
      }
      report.add({kind.name, std::to_string(n), showMilliseconds(pass.cpu), show(1e9 * pass.cpu / n),
                  show(size > 0.0 ? sum.norm() / size : 0.0), std::to_string(statistics.substeps), showMilliseconds(least),
                  show(1e9 * least / n / statistics.substeps), show(energy_error)});
      growth.sizes.push_back(n);
      growth.passes.push_back(pass.cpu);
      growth.steps.push_back(least / statistics.substeps);
      if (kind.kind == "mass_spring")
        counted.push_back({std::string("force pass, ") + kind.name, n, countOf(kind, simulation.model(), &Counts::operations),
                           countOf(kind, simulation.model(), &Counts::bytes) + kPointBytes * n, pass.cpu});
    }
    growths.push_back(std::move(growth));
  }
  report.end();
  report.note("imbalance: length of the sum of all internal forces over the sum of their lengths");
  report.note("energy error: change of all energy over the elastic one at the beginning");

  report.begin("scale_model_exponents", "13e. Processor time of models over the simulation points",
               {"model", "pass_exponent", "substep_exponent"});
  for (const Growth& growth : growths)
    report.add({growth.name, show(fitExponent(growth.sizes, growth.passes)), show(fitExponent(growth.sizes, growth.steps))});
  report.end();
}

void reportRoofline(const std::vector<CountedStage>& counted, const MachineLimits& limits, Report& report) {
  report.begin("scale_roofline", "13f. What share of the machine stages reach on one thread",
               {"stage", "points", "operations_per_byte", "Gop_per_s", "GB_per_s", "share_of_arithmetic_%", "share_of_memory_%",
                "share_of_near_cache_%", "peak_Gop_per_s", "memory_GB_per_s", "near_GB_per_s"});
  for (const CountedStage& s : counted) {
    const double speed = s.operations / s.seconds, bandwidth = s.bytes / s.seconds;
    report.add({s.name, std::to_string(s.points), show(s.operations / s.bytes), show(1e-9 * speed), show(1e-9 * bandwidth),
                showPercent(speed / limits.arithmetic), showPercent(bandwidth / limits.bandwidth),
                showPercent(bandwidth / limits.near_bandwidth), show(1e-9 * limits.arithmetic), show(1e-9 * limits.bandwidth),
                show(1e-9 * limits.near_bandwidth)});
  }
  report.end();
  report.note(
      "operations: sums, products, quotients and roots counted in the source; bytes: every array once, written results of "
      "frames twice");
  report.note("what fits in caches is faster than memory: then the near cache is the limit, or neither");
}

}  // namespace deformable_surface::benchmark
