// A program of another package: a rubber sheet hangs from one edge and is pulled by a force.
#include <deformable_surface/base/error.h>
#include <deformable_surface/base/version.h>
#include <deformable_surface/io/scene.h>
#include <deformable_surface/io/shapes.h>
#include <deformable_surface/simulation/simulation.h>

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

  while (sheet.time() < 0.5) {
    const simulation::StepOutcome outcome = sheet.step();
    if (!outcome.ok) throw InputError(outcome.problem);
  }

  const Points& points = sheet.surface(false).positions;  // one per point of the cloud, in its order
  const simulation::PinReaction held = sheet.pinReactions().front();
  const simulation::Statistics statistics = sheet.statistics();
  std::cout << "deformable_surface " << version() << "\n"
            << "points: " << points.size() << ", the first at " << points.front().transpose() << " m\n"
            << "force on the pins: " << held.force.transpose() << " N\n"
            << "estimated error: " << statistics.error_estimate << " m\n";
} catch (const InputError& error) {
  std::cerr << error.what() << "\n";
  return 1;
}
