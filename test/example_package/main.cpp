// A program of another package: a rubber sheet hangs from one edge and is pulled by a force.
#include <deformable_surface/base/error.h>
#include <deformable_surface/base/version.h>
#include <deformable_surface/io/scene.h>
#include <deformable_surface/io/shapes.h>
#include <deformable_surface/simulation/simulation.h>

#include <cstdint>
#include <iostream>

using namespace deformable_surface;

int main() try {
  // A scene as in a file; or fill simulation::SceneParams directly.
  const simulation::SceneParams scene = io::readScene(io::parseYaml(R"(
    model: mass_spring
    cloud: {shape: sheet, points: 900, size: [0.3, 0.3]}
    material: {young_modulus: 2.0e5, thickness: 0.001, density: 1000.0, damping: 4.0}
    simplification: {target_points: 200}
    integrator: {time_step: 0.01}
    pins: [{box: {min: [-0.2, 0.149, -0.1], max: [0.2, 0.2, 0.1]}}])",
                                                                    "the scene of this example"));
  simulation::Simulation sheet(scene, io::makeShape(scene.cloud));
  for (const std::string& note : sheet.buildNotes()) std::cout << "note: " << note << "\n";

  simulation::ForceParams pull;
  pull.id = "pull";
  pull.point = {0.0, -0.15, 0.0};
  pull.force = {0.0, 0.0, 0.02};
  sheet.setForce(pull);

  const auto runUntil = [](simulation::Simulation& simulation, double time) {
    while (simulation.time() < time) {
      const simulation::StepOutcome outcome = simulation.step();
      if (!outcome.ok) throw InputError(outcome.problem);
    }
  };
  runUntil(sheet, 0.25);

  // What would a ball feel in the way of the sheet? A fork answers, and the sheet itself goes on without it.
  const simulation::Snapshot before = sheet.snapshot();
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = 0.04;
  ball.path.resize(1);
  ball.path[0].position = {0.0, 0.25, -0.15};
  simulation::Simulation copy = sheet.fork();
  copy.setTool(ball);
  runUntil(copy, 0.5);
  runUntil(sheet, 0.5);
  const std::uint64_t hash = sheet.stateHash();
  sheet.restore(before);  // and once more, with the same bits
  runUntil(sheet, 0.5);
  if (sheet.stateHash() != hash) throw InputError("the second run differs from the first");

  const Points& points = sheet.surface(false).positions;  // one per point of the cloud, in its order
  const simulation::PinReaction held = sheet.pinReactions().front();
  const simulation::Statistics statistics = sheet.statistics();
  std::cout << "deformable_surface " << version() << "\n"
            << "points: " << points.size() << ", the first at " << points.front().transpose() << " m\n"
            << "force on the ball: " << copy.toolReactions().front().force.transpose() << " N\n"
            << "force on the pins: " << held.force.transpose() << " N\n"
            << "estimated error: " << statistics.error_estimate << " m\n";
} catch (const InputError& error) {
  std::cerr << error.what() << "\n";
  return 1;
}
