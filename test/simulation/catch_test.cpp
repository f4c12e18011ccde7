// Pads that close on a falling sheet hold it by friction.
#include "support/figures.h"

namespace deformable_surface::test {
namespace {

// With friction: the tests of scenes.
TEST(Catch, WithoutFrictionTheSheetFallsThrough) {
  simulation::SceneParams scene = loadScene("catch_sheet");
  for (tool::ToolParams& tool : scene.tools) tool.friction = 0.0;
  simulation::Simulation s = makeSimulation(scene);
  runScene(s);
  const Vec3 far = Vec3::Constant(100.0);
  EXPECT_GT(findLargestMotion(s, -far, far), 2.0);
}

}  // namespace
}  // namespace deformable_surface::test
