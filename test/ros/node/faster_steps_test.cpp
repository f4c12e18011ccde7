// What the node names to a user whose steps are slower than real time: only what applies to the last step.
#include "../../../src/ros/node/faster_steps.h"

#include "simulation/clouds.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using simulation::Statistics;

const SceneParams kSurface;

Statistics makeStep() {
  Statistics step;
  step.time_total = 0.1;
  return step;
}

TEST(FasterSteps, FewerPointsAlwaysHelp) {
  EXPECT_EQ(nameFaster(kSurface, makeStep(), false), "fewer simulation points");
  SceneParams particles;
  particles.model = "oriented_particles";
  EXPECT_EQ(nameFaster(particles, makeStep(), false), "a larger oriented_particles.spacing");
}

TEST(FasterSteps, OnlyWhatTakesAGoodShareIsNamed) {
  Statistics step = makeStep();
  step.time_estimate = step.time_contact = 0.002;
  EXPECT_EQ(nameFaster(kSurface, step, true), "fewer simulation points");
  step.time_estimate = 0.042;
  EXPECT_EQ(nameFaster(kSurface, step, true), "accuracy.estimate: false (it is 42 % of the last step), fewer simulation points");
  step.time_contact = 0.03;
  EXPECT_EQ(nameFaster(kSurface, step, false), "accuracy.estimate: false (it is 42 % of the last step), fewer simulation points");
  EXPECT_EQ(nameFaster(kSurface, step, true),
            "accuracy.estimate: false (it is 42 % of the last step), contact.cloud_points: 0, fewer simulation points");
}

TEST(FasterSteps, TheToleranceIsNamedForIterationsAndSelfContactWherePartsTouch) {
  Statistics step = makeStep();
  step.solver_iterations = 12;
  EXPECT_EQ(nameFaster(kSurface, step, false), "a larger integrator.tolerance, fewer simulation points");
  EXPECT_EQ(nameFaster(kSurface, step, true), "contact.cloud_points: 0, a larger integrator.tolerance, fewer simulation points");
  step = makeStep();
  step.self_contacts = 3;
  EXPECT_EQ(nameFaster(kSurface, step, false),
            "fewer simulation points, contact.self: false (parts then pass through each other)");
}

// A sheet falls on a ball.
TEST(FasterSteps, CloudPointsAreSeenToTouch) {
  SceneParams params;
  params.simplification.target_points = 60;
  params.tools.resize(1);
  params.tools[0].id = "ball";
  params.tools[0].shape.kind = geometry::Solid::Kind::kSphere;
  params.tools[0].shape.radius = 0.2;
  params.tools[0].path.push_back({0.0, Vec3(0.5, 0.0, -0.21), Vec4(0.0, 0.0, 0.0, 1.0)});
  for (const Index cloud_points : {0, 8}) {
    params.contact.cloud_points = cloud_points;
    Simulation simulation(params, test::sheetCloud(20));
    EXPECT_FALSE(touchesCloudPoints(simulation));
    for (int k = 0; k < 20; ++k) ASSERT_TRUE(simulation.step().ok);
    EXPECT_FALSE(simulation.contacts().empty());
    EXPECT_EQ(touchesCloudPoints(simulation), cloud_points > 0);
  }
}

}  // namespace
}  // namespace deformable_surface::node
