// Part 10: time of a step in which a share of a sheet moves and the rest sleeps, over that of a step of the whole sheet, and the
// error of sleeping. A part of its own because it compares a simulation with itself.
#include "deformable_surface/base/parallel.h"
#include "sections.h"
#include "swinging_sheet.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::benchmark {
namespace {

using simulation::Simulation;

constexpr Index kPoints = 100000;
constexpr double kTimeStep = 0.01;  // s
constexpr int kWarmUp = 3;          // steps after which the front has left its origin
constexpr int kTimed = 3;           // steps, whose sum counts: in each of them more moves
constexpr double kPush = 0.5;       // m/s^2, normal to the sheet
constexpr double kHoop = 0.1;       // m, inner side of a square of pins that no wave leaves: a hundredth of the sheet moves in it
constexpr double kHoopWidth = 0.013;  // m, four spacings: wider than elements
constexpr int kHoopWarmUp = 15;       // steps, after which all of it moves and nothing is made anew

// A square metre without weight, so soft that a disturbance travels about three spacings in a step, in several sub-steps.
simulation::SceneParams makeScene() {
  simulation::SceneParams scene = makeSwingingScene(solve::IntegratorType::kVerlet, kTimeStep);
  scene.gravity.setZero();
  scene.material.young_modulus = 200.0;
  scene.material.damping = 20.0;
  return scene;
}

// Pins along the sides of the hoop.
void addHoop(simulation::SceneParams& scene) {
  const double inner = 0.5 * kHoop, outer = inner + kHoopWidth;
  const double sides[4][4] = {{-outer, -outer, -inner, outer},
                              {inner, -outer, outer, outer},
                              {-outer, -outer, outer, -inner},
                              {-outer, inner, outer, outer}};
  for (const auto& side : sides) {
    simulation::PinParams pin;
    pin.region.min = Vec3(side[0], side[1], -1.0);
    pin.region.max = Vec3(side[2], side[3], 1.0);
    scene.pins.push_back(pin);
  }
  scene.material.damping = 0.5;  // so that it goes on moving
}

// On a disc with a share of the area.
simulation::ForceParams makePush(const simulation::SceneParams& scene, double share) {
  simulation::ForceParams push;
  push.id = "push";
  push.radius = std::sqrt(share / M_PI);
  push.force = Vec3(0.0, 0.0, kPush * share * scene.material.thickness * scene.material.density);
  return push;
}

double largestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

double timeStep(Simulation& simulation) {
  const double before = processorSeconds();
  simulation.step();
  return processorSeconds() - before;
}

// Share of the points that move faster than points that may sleep.
double findMoving(const Simulation& simulation, double speed) {
  const Points& velocities = simulation.state().velocities;
  const auto moving = std::count_if(velocities.begin(), velocities.end(), [&](const Vec3& v) { return v.norm() > speed; });
  return static_cast<double>(moving) / velocities.size();
}

}  // namespace

void runActivitySection(const Options&, Report& report) {
  report.begin("activity", "10. A step of " + std::to_string(kPoints) + " simulation points of which few move, one thread",
               {"pushed_%", "moving_%", "awake_%", "substeps", "all_substeps", "step_ms", "all_step_ms", "share_of_step_%",
                "least_share_%", "moved_m", "error_m", "tolerance_m"});
  setNumThreads(1);
  const cloud::PointCloud sheet = makeSwingingSheet(kPoints);
  const double tolerance = 1e-4 / std::sqrt(static_cast<double>(sheet.size()));  // the default
  const double speed = tolerance / simulation::SleepParams().quiet_time;
  for (const bool has_hoop : {false, true}) {
    simulation::SceneParams scene = makeScene();
    if (has_hoop) addHoop(scene);
    scene.sleep.mode = simulation::Sleep::kNever;
    Simulation awake(scene, sheet);
    scene.sleep.mode = simulation::Sleep::kAuto;
    Simulation sleeping(scene, sheet);
    const int warm_up = has_hoop ? kHoopWarmUp : kWarmUp;
    for (const double share : has_hoop ? std::vector<double>{1e-3} : std::vector<double>{0.0, 1e-5, 1e-3, 0.01, 0.1, 1.0}) {
      for (Simulation* simulation : {&sleeping, &awake}) {
        simulation->reset();
        simulation->setForce(makePush(scene, share));
      }
      double part = 0.0, all = 0.0, moving = 0.0, least = 1e300;
      for (int k = 0; k < warm_up + kTimed; ++k) {
        const double a = timeStep(sleeping), b = timeStep(awake);
        if (k == warm_up) moving = findMoving(awake, speed);
        if (k < warm_up) continue;
        part += a / kTimed;
        least = std::min(least, a / b);
        all += b / kTimed;
      }
      const simulation::Statistics statistics = sleeping.statistics();
      report.add({has_hoop ? "hoop" : showPercent(share), showPercent(moving) + " to " + showPercent(findMoving(awake, speed)),
                  showPercent(static_cast<double>(statistics.awake) / statistics.simulation_points),
                  std::to_string(statistics.substeps), std::to_string(awake.statistics().substeps), showMilliseconds(part),
                  showMilliseconds(all), showPercent(part / all), showPercent(least),
                  show(largestDistance(awake.state().positions, sheet.positions)),
                  show(largestDistance(sleeping.state().positions, awake.state().positions)), show(tolerance)});
    }
  }
  report.end();
  report.note("step: processor time, mean of " + std::to_string(kTimed) +
              " steps, both runs step by step in turn; error: the largest distance "
              "between them at the end");
  report.note(
      "least share: of the step of these that is the cheapest beside the whole one, as where the part stays as it is; the "
      "others make it anew");
  report.note("hoop: pushed within a square of pins that no wave leaves, steps " + std::to_string(kHoopWarmUp + 1) + " on");
  report.note(
      "moving: faster than a tolerance in the quiet time, after the first and the last of these steps; awake: those, and the "
      "tiles "
      "around them, at the end");
}

}  // namespace deformable_surface::benchmark
