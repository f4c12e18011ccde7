// Part 2: the case of Table 1 of [Su 2007], a sphere of 3203 points pulled and pushed, with 85, 273 and 327 simulation points.
// The table has the times and the distance of the simplified surface at rest from the unsimplified one.
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/simulation.h"
#include "sections.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace deformable_surface::benchmark {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using solve::IntegratorType;

constexpr Index kPoints = 3203;
constexpr double kRadius = 0.5;   // m
constexpr double kFrame = 0.01;   // s, the default step
constexpr double kDamping = 2.5;  // 1/s: critical for the slowest mode of this scene, so that it comes to rest soonest
constexpr double kSettled = 8.0;  // s: after this time the remaining motion shows in the last speed
constexpr int kTransferSamples = 300;

struct PublishedRow {
  Index simulation_points;
  double seconds;  // per step, on a Pentium IV of 2 GHz
};
constexpr PublishedRow kPublished[] = {{85, 0.13}, {273, 0.25}, {327, 0.32}};

// A rubber ball that stands on its lowest cap, is pulled up at the top and pushed in from the side: it moves by a tenth of its
// size.
SceneParams makeScene(Index simulation_points) {
  SceneParams scene;
  scene.accuracy.estimate = false;
  scene.material.thickness = 0.005;
  scene.material.damping = kDamping;
  scene.gravity.setZero();
  scene.simplification.target_points = simulation_points;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(1.0, 1.0, -0.9 * kRadius);
  scene.pins.push_back(pin);
  simulation::ForceParams pull, push;
  pull.id = "pull";
  pull.point = Vec3(0.0, 0.0, kRadius);
  pull.force = Vec3(0.0, 0.0, 1.0);
  push.id = "push";
  push.point = Vec3(kRadius, 0.0, 0.0);
  push.force = Vec3(-0.5, 0.0, 0.0);
  pull.radius = push.radius = 0.5 * kRadius;
  scene.forces = {pull, push};
  return scene;
}

cloud::PointCloud makeSphere() {
  simulation::CloudParams params;
  params.shape = simulation::CloudParams::Shape::kSphere;
  params.points = kPoints;
  params.radius = kRadius;
  return io::makeShape(params);
}

// The surface at rest under its loads, by damped motion, which takes less time here than Newton steps on all points.
Points findStaticShape(SceneParams scene, const cloud::PointCloud& cloud, model::State& state, double& last_speed) {
  scene.integrator.type = IntegratorType::kVerlet;
  scene.integrator.time_step = kFrame;
  Simulation ball(scene, cloud);
  while (ball.time() < kSettled) {
    const simulation::StepOutcome outcome = ball.step();
    if (!outcome.ok) throw std::runtime_error("table 1: " + outcome.problem);
  }
  state = ball.state();
  last_speed = std::max(last_speed, ball.statistics().max_speed);
  return ball.surface(false).positions;
}

}  // namespace

void runTable1Section(const Options& options, Report& report) {
  report.begin("table_1",
               "2. Table 1 of Su 2007: a sphere of " + std::to_string(kPoints) + " points pulled and pushed, one thread",
               {"simulation_points", "springs", "force_pass_ms", "step_ms", "transfer_normals_ms", "step_and_transfer_ms",
                "spread_%", "cpu_ms", "frame_ms", "substeps", "real_time_factor", "rms_to_unsimplified_mm", "max_displacement_mm",
                "published_s_per_step", "runs", "hash"});
  setNumThreads(1);
  const cloud::PointCloud sphere = makeSphere();
  model::State deformed;
  double last_speed = 0.0;
  const Points unsimplified = findStaticShape(makeScene(sphere.size()), sphere, deformed, last_speed);
  double max_displacement = 0.0;
  for (std::size_t i = 0; i < unsimplified.size(); ++i)
    max_displacement = std::max(max_displacement, (unsimplified[i] - sphere.positions[i]).norm());

  for (const PublishedRow& row : kPublished) {
    SceneParams scene = makeScene(row.simulation_points);
    const Points simplified = findStaticShape(scene, sphere, deformed, last_speed);

    // A step of the default length, in sub-steps.
    scene.integrator.type = IntegratorType::kVerlet;
    scene.integrator.time_step = kFrame;
    Simulation framed(scene, sphere);
    const Timing frame = measure([&] { framed.step(); }, options.budget);
    const Index substeps = static_cast<Index>(framed.statistics().substeps);

    // A step of one sub-step, as published: the time step is as long as stability allows.
    scene.integrator.time_step = kFrame / substeps;
    Simulation ball(scene, sphere);
    Points forces(deformed.positions.size(), Vec3::Zero());
    const Timing force_pass = measure([&] { ball.model().addForces(deformed, forces); }, options.budget);
    const Timing step = measure([&] { ball.step(); }, options.budget);
    const Timing all = measure(
        [&] {
          ball.step();
          ball.surface(true);
        },
        options.budget);
    std::vector<double> transfers;
    for (int i = 0; i < kTransferSamples; ++i) {
      ball.step();
      ball.surface(true);
      transfers.push_back(ball.statistics().time_normals);
    }

    // What is compared between versions starts from rest and takes a fixed number of steps.
    framed.reset();
    for (int i = 0; i < 20; ++i) framed.step();
    report.add({std::to_string(ball.state().size()), std::to_string(ball.statistics().links), showMilliseconds(force_pass.wall),
                showMilliseconds(step.wall), showMilliseconds(findQuartiles(transfers).median), showMilliseconds(all.wall),
                showPercent(all.spread), showMilliseconds(all.cpu), showMilliseconds(frame.wall), std::to_string(substeps),
                show(kFrame / frame.wall), show(1e3 * rmsDistance(simplified, unsimplified)), show(1e3 * max_displacement),
                show(row.seconds), std::to_string(all.repetitions), showHash(framed.stateHash())});
  }
  report.end();
  report.note(
      "step: one velocity-Verlet sub-step, which evaluates the forces once; frame: a step of 10 ms in sub-steps; published:");
  report.note(
      "Pentium IV, 2 GHz, for orientation only; targets for 327: force pass below 0.1 ms, with transfer and normals below 0.2");
  report.note("rms: between the shapes at rest; largest speed left in them " + show(last_speed) + " m/s");
}

}  // namespace deformable_surface::benchmark
