// A program of another catkin package: run_scene SCENE.yaml RESULT.ply runs a scene and writes its last surface. It can also use
// the messages of the package.
#include <deformable_surface/Statistics.h>
#include <deformable_surface/base/error.h>
#include <deformable_surface/io/cloud_filters.h>
#include <deformable_surface/io/load_scene.h>
#include <deformable_surface/io/point_files.h>
#include <deformable_surface/simulation/commands.h>
#include <deformable_surface/simulation/simulation.h>

#include <iostream>

using namespace deformable_surface;

int main(int argc, char** argv) try {
  if (argc != 3) throw InputError("found " + std::to_string(argc - 1) + " arguments; accepted: SCENE.yaml RESULT.ply");
  const simulation::SceneParams scene = io::loadScene(argv[1]);
  cloud::PointCloud cloud = io::loadCloud(scene);
  const io::FilterReport filtered = io::filterCloud(scene.input.filter, cloud);
  if (!filtered.problem.empty()) throw InputError(filtered.problem);

  simulation::Simulation surface(scene, cloud);
  surface.apply(simulation::command::SetDamping{8.0});  // the same as surface.setDamping(8.0)
  while (surface.time() < scene.duration) {
    const simulation::StepOutcome outcome = surface.step();
    if (!outcome.ok) throw InputError(outcome.problem);
    if (!outcome.notice.empty()) std::cout << outcome.notice << "\n";
  }

  const simulation::Surface& last = surface.surface(false);
  cloud.positions = last.positions;
  io::writePointFile(argv[2], cloud, last.displacement);

  Statistics message;
  message.error_estimate = surface.statistics().error_estimate;
  std::cout << last.positions.size() << " points, estimated error " << message.error_estimate << " m\n";
} catch (const InputError& error) {
  std::cerr << error.what() << "\n";
  return 1;
}
