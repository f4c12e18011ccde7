#include "swinging_sheet.h"

#include "deformable_surface/io/shapes.h"

namespace deformable_surface::benchmark {

simulation::SceneParams makeSwingingScene(solve::IntegratorType type, double time_step) {
  simulation::SceneParams scene;
  scene.accuracy.estimate = false;  // the integrators are compared, not what watches them
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

}  // namespace deformable_surface::benchmark
