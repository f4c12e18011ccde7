// Part 4: cost against error of the integrators on a swinging sheet. All share one discretisation in space, so only the time
// steps cause the error. The reference is velocity Verlet at a thirty-second of the stable step with Richardson's extrapolation.
#include "deformable_surface/base/parallel.h"
#include "sections.h"
#include "swinging_sheet.h"

#include <algorithm>

namespace deformable_surface::benchmark {
namespace {

using simulation::Simulation;
using solve::IntegratorType;

constexpr Index kPoints = 324;
constexpr double kDuration = 0.4;  // s: the sheet has swung by most of its length and has not yet buckled
constexpr double kUnstable = 1.0;  // m, rms: the sheet's own size

double totalEnergy(const Simulation& sheet) {
  const simulation::Statistics s = sheet.statistics();
  return s.kinetic_energy + s.elastic_energy + s.potential_energy;
}

// Steps from rest to the end; false if a step could not be taken.
bool runToEnd(Simulation& sheet, int steps) {
  sheet.reset();
  for (int i = 0; i < steps; ++i)
    if (!sheet.step().ok) return false;
  return true;
}

Simulation makeSheet(IntegratorType type, int steps) {
  return Simulation(makeSwingingScene(type, kDuration / steps), makeSwingingSheet(kPoints));
}

Points findPositions(IntegratorType type, int steps) {
  Simulation sheet = makeSheet(type, steps);
  runToEnd(sheet, steps);
  return sheet.state().positions;
}

// The error of Verlet falls with the square of the step.
Points extrapolate(const Points& coarse, const Points& fine) {
  Points result(fine.size());
  for (std::size_t i = 0; i < fine.size(); ++i) result[i] = (4.0 * fine[i] - coarse[i]) / 3.0;
  return result;
}

}  // namespace

void runIntegratorsSection(const Options& options, Report& report) {
  report.begin("integrators",
               "4. Integrators on the swinging sheet (1 m, pinned on one edge, 0.2 kg/m^2, E h = 1000 N/m), one thread",
               {"integrator", "time_step_ms", "substeps", "cpu_s_per_simulated_s", "wall_s_per_simulated_s", "spread_%",
                "rms_error_m", "energy_error_%", "state", "runs", "hash"});
  setNumThreads(1);

  // The number of sub-steps of one step over the whole duration gives the stable step.
  Simulation probe = makeSheet(IntegratorType::kVerlet, 1);
  probe.step();
  const int stable = static_cast<int>(probe.statistics().substeps);
  const Points at_8 = findPositions(IntegratorType::kVerlet, 8 * stable);
  const Points at_16 = findPositions(IntegratorType::kVerlet, 16 * stable);
  const Points at_32 = findPositions(IntegratorType::kVerlet, 32 * stable);
  const Points reference = extrapolate(at_16, at_32);
  const double uncertainty = rmsDistance(reference, extrapolate(at_8, at_16));

  struct Row {
    const char* name;
    IntegratorType type;
    int steps;
  };
  std::vector<Row> rows{{"verlet", IntegratorType::kVerlet, 40},
                        {"verlet", IntegratorType::kVerlet, stable},
                        {"verlet", IntegratorType::kVerlet, 2 * stable},
                        {"verlet", IntegratorType::kVerlet, 4 * stable},
                        {"symplectic_euler", IntegratorType::kSymplecticEuler, 40},
                        {"symplectic_euler", IntegratorType::kSymplecticEuler, stable},
                        {"symplectic_euler", IntegratorType::kSymplecticEuler, 4 * stable},
                        {"implicit", IntegratorType::kImplicit, 24},
                        {"implicit", IntegratorType::kImplicit, 96},
                        {"explicit_euler", IntegratorType::kExplicitEuler, 400},
                        {"explicit_euler", IntegratorType::kExplicitEuler, stable}};
  if (options.large) {
    rows.push_back({"implicit", IntegratorType::kImplicit, 400});
    rows.push_back({"explicit_euler", IntegratorType::kExplicitEuler, 4 * stable});
  }
  for (const Row& row : rows) {
    Simulation sheet = makeSheet(row.type, row.steps);
    const double energy_before = totalEnergy(sheet);
    const double potential_before = sheet.statistics().potential_energy;
    bool ok = true;
    const Timing timing = measure([&] { ok = runToEnd(sheet, row.steps); }, options.budget, 1);
    const double error = rmsDistance(sheet.state().positions, reference);
    const simulation::Statistics end = sheet.statistics();
    const double energy_error = (totalEnergy(sheet) - energy_before) / (potential_before - end.potential_energy);
    const bool stable_run = ok && error < kUnstable;
    report.add({row.name, showMilliseconds(kDuration / row.steps), std::to_string(end.substeps), show(timing.cpu / kDuration),
                show(timing.wall / kDuration), showPercent(timing.spread), stable_run ? show(error) : "-",
                stable_run ? show(100.0 * energy_error) : "-",
                stable_run ? "sound" : "UNSTABLE by " + show(std::max(end.simulation_time, kDuration / row.steps)) + " s",
                std::to_string(timing.repetitions), showHash(sheet.stateHash())});
  }
  report.end();
  report.note("error: rms of the positions at " + show(kDuration) + " s; the reference itself is uncertain by " +
              show(uncertainty) + " m; energy error: of the potential energy given up");
  report.note("explicit_euler is the published scheme; without damping it is unstable at any step, only later at smaller ones");
}

}  // namespace deformable_surface::benchmark
