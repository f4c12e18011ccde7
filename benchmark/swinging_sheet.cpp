#include "swinging_sheet.h"

#include "deformable_surface/io/shapes.h"

#include <cmath>

namespace deformable_surface::benchmark {

simulation::SceneParams makeSwingingScene(solve::IntegratorType type, double time_step) {
  simulation::SceneParams scene;
  scene.accuracy.estimate = false;  // the integrators are compared, not the error estimate
  scene.contact.self = false;       // nor contact, which the programs beside it do not have here
  scene.material.young_modulus = 1e6;
  scene.material.thickness = 0.001;
  scene.material.density = 200.0;
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  scene.integrator.type = type;
  scene.integrator.time_step = time_step;
  simulation::PinParams pin;
  pin.region.min = Vec3(-0.501, -1.0, -1.0);
  pin.region.max = Vec3(-0.499, 1.0, 1.0);
  scene.pins.push_back(pin);
  return scene;
}

cloud::PointCloud makeSwingingSheet(Index n) {
  simulation::CloudParams params;
  params.shape = simulation::CloudParams::Shape::kSheet;
  params.points = n;
  return io::makeShape(params);
}

simulation::SceneParams makeEquilateralScene(double membrane_stiffness, double time_step) {
  simulation::SceneParams scene = makeSwingingScene(solve::IntegratorType::kVerlet, time_step);
  scene.material.young_modulus = membrane_stiffness / scene.material.thickness;
  scene.pins[0].region.min = Vec3(-0.001, -1.0, -1.0);
  scene.pins[0].region.max = Vec3(0.001, 2.0, 1.0);
  return scene;
}

cloud::PointCloud makeEquilateralSheet(Index across, Index along) {
  cloud::PointCloud cloud;
  const double spacing = 1.0 / (across - 1);
  for (Index row = 0; row < along; ++row)
    for (Index k = 0; k < across; ++k)
      cloud.positions.emplace_back(row * spacing * std::sqrt(0.75), spacing * (k + 0.5 * (row % 2)), 0.0);
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  return cloud;
}

simulation::SceneParams makeHangingScene(double time_step) {
  simulation::SceneParams scene = makeSwingingScene(solve::IntegratorType::kVerlet, time_step);
  scene.pins.clear();
  for (const double y : {-0.5, 0.5}) {
    simulation::PinParams pin;
    pin.region.min = Vec3(-0.501, y - 0.001, -0.001);
    pin.region.max = Vec3(-0.499, y + 0.001, 0.001);
    scene.pins.push_back(pin);
  }
  return scene;
}

cloud::PointCloud makeHangingSheet(Index side) {
  cloud::PointCloud sheet;
  for (Index i = 0; i < side; ++i)
    for (Index j = 0; j < side; ++j) sheet.positions.emplace_back(-0.5 + i / (side - 1.0), -0.5 + j / (side - 1.0), 0.0);
  sheet.width = static_cast<std::uint32_t>(sheet.positions.size());
  return sheet;
}

}  // namespace deformable_surface::benchmark
