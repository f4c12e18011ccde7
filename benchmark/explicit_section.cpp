// Part 4b: explicit methods on the sheet of a published comparison of methods: equilateral, soft and stiff, with springs and
// triangles, with and without bending. A part of its own because here the discretisation changes, not the integrator.
#include "deformable_surface/base/parallel.h"
#include "sections.h"
#include "swinging_sheet.h"

#include <cmath>

namespace deformable_surface::benchmark {
namespace {

using simulation::Simulation;

constexpr double kDuration = 0.4;   // s
constexpr double kTimeStep = 0.01;  // s

struct Sheet {
  Index across, along;  // points of a row along the pinned edge, rows
  double membrane_stiffness;
  const char* printed;  // the fastest published one with an error of a millimetre or less, and its method
  bool large;
};

// Published values for one core of an AMD EPYC, with a membrane of springs without bending.
constexpr Sheet kSheets[] = {{17, 19, 1e3, "0.016 to 0.05 (Verlet, 4e-6 m)", false},
                             {33, 38, 1e3, "0.06 to 0.15 (Verlet, 1e-6 m)", false},
                             {17, 19, 1e5, "-", false},
                             {33, 38, 1e5, "0.62 (XPBD, 6e-4 m); 0.9 to 1.7 (Verlet, 3e-7 m)", true}};

struct Material {
  const char* name;
  model::Membrane membrane;
  model::Bending bending;
};
constexpr Material kMaterials[] = {{"springs", model::Membrane::kSprings, model::Bending::kNone},
                                   {"triangles", model::Membrane::kTriangles, model::Bending::kNone},
                                   {"triangles + curvature", model::Membrane::kTriangles, model::Bending::kCurvature}};

simulation::SceneParams makeScene(const Sheet& sheet, const Material& material, double time_step) {
  simulation::SceneParams scene = makeEquilateralScene(sheet.membrane_stiffness, time_step);
  scene.mass_spring.membrane = material.membrane;
  scene.mass_spring.bending = material.bending;
  return scene;
}

// Sub-steps taken in all, or -1 if a step failed.
long runToEnd(Simulation& sheet, long steps) {
  sheet.reset();
  long substeps = 0;
  for (long i = 0; i < steps; ++i) {
    if (!sheet.step().ok) return -1;
    substeps += sheet.statistics().substeps;
  }
  return substeps;
}

// Positions at the end with steps so short that each is one sub-step.
Points findPositions(const Sheet& sheet, const Material& material, long steps) {
  Simulation fine(makeScene(sheet, material, kDuration / steps), makeEquilateralSheet(sheet.across, sheet.along));
  fine.reset();
  for (long i = 0; i < steps; ++i) fine.step();
  return fine.state().positions;
}

}  // namespace

void runExplicitSection(const Options& options, Report& report) {
  report.begin(
      "explicit",
      "4b. Verlet on equilateral sheets (1 m, pinned on one edge, 0.2 kg/m^2, no damping), steps of " +
          showMilliseconds(kTimeStep) + " ms, one thread",
      {"points", "E h, N/m", "model", "substep_ms", "wall_s_per_simulated_s", "cpu_s_per_simulated_s", "spread_%", "rms_error_m",
       "error_uncertain_by_m", "pass_us", "ns_per_point", "ns_per_link", "runs", "hash", "printed elsewhere"});
  setNumThreads(1);
  for (const Sheet& sheet : kSheets) {
    if (sheet.large && !options.large) continue;
    for (const Material& material : kMaterials) {
      const long steps = std::lround(kDuration / kTimeStep);
      Simulation timed(makeScene(sheet, material, kTimeStep), makeEquilateralSheet(sheet.across, sheet.along));
      const long substeps = runToEnd(timed, steps);
      const Timing run = measure(
          [&] {
            timed.reset();
            for (long i = 0; i < steps; ++i) timed.step();
          },
          options.budget, 1);
      const Points& end = timed.state().positions;
      Points forces(end.size(), Vec3::Zero());
      const Timing pass = measure([&] { timed.model().addForces(timed.state(), forces); }, options.budget);

      const Points at_2 = findPositions(sheet, material, 2 * substeps), at_4 = findPositions(sheet, material, 4 * substeps);
      Points reference(end.size());
      for (std::size_t i = 0; i < end.size(); ++i) reference[i] = (4.0 * at_4[i] - at_2[i]) / 3.0;

      report.add({std::to_string(end.size()), show(sheet.membrane_stiffness), material.name,
                  showMilliseconds(kDuration / static_cast<double>(substeps)), show(run.wall / kDuration),
                  show(run.cpu / kDuration), showPercent(run.spread), show(rmsDistance(end, reference)),
                  show(rmsDistance(at_4, reference)), show(1e6 * pass.cpu),
                  show(1e9 * pass.cpu / static_cast<double>(end.size())),
                  show(1e9 * pass.cpu / static_cast<double>(stretchLinksOf(timed.model()).size())),
                  std::to_string(run.repetitions), showHash(timed.stateHash()), sheet.printed});
    }
  }
  report.end();
  report.note(
      "error: rms of the positions at " + show(kDuration) +
      " s against Richardson's extrapolation of runs with a half and a quarter of the sub-step; uncertain by less than the "
      "distance of the finer run from it");
  report.note(
      "the pass is that of the model at the end of the run; per link: of the "
      "edges between neighbours, whatever the model makes of them");
  if (!options.large) report.note("--large adds the stiff sheet of 1254 points");
}

}  // namespace deformable_surface::benchmark
