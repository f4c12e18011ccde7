// The quantities of `expect`, on motions with known numbers.
#include "deformable_surface/simulation/expectations.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/io/shapes.h"

#include "particles.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <memory>
#include <vector>

namespace deformable_surface::simulation {
namespace {

constexpr double kFall = 9.81 * 0.1 * 0.1 / 2.0;  // distance that a free body falls in a tenth of a second

SceneParams makeFallingSheet() {
  SceneParams params;
  params.cloud.shape = CloudParams::Shape::kSheet;
  params.cloud.points = 100;
  params.simplification.target_points = 40;
  params.integrator.time_step = 0.01;
  return params;
}

Simulation runSteps(const SceneParams& params, int steps) {
  Simulation simulation(params, io::makeShape(params.cloud));
  for (int i = 0; i < steps; ++i) EXPECT_TRUE(simulation.step().ok);
  return simulation;
}

// With a radius of 0.3 m, at this height above the origin.
tool::ToolParams makeBall(double height) {
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = 0.3;
  ball.path.resize(1);
  ball.path[0].position = Vec3(0.0, 0.0, height);
  return ball;
}

TEST(Expectations, ComputeDisplacementsAndBoundsOfAFreeFall) {
  Simulation simulation = runSteps(makeFallingSheet(), 10);
  // Displacements are float.
  for (const char* name : {"max_displacement", "mean_displacement", "rms_displacement"})
    EXPECT_NEAR(computeQuantity(name, simulation), kFall, 1e-7) << name;
  EXPECT_NEAR(computeQuantity("min_z", simulation), -kFall, 1e-9);
  EXPECT_NEAR(computeQuantity("max_z", simulation), -kFall, 1e-9);
  EXPECT_NEAR(computeQuantity("min_x", simulation), -0.5, 1e-9);
  EXPECT_NEAR(computeQuantity("max_x", simulation), 0.5, 1e-9);
  EXPECT_NEAR(computeQuantity("min_y", simulation), -0.5, 1e-9);
  EXPECT_NEAR(computeQuantity("max_y", simulation), 0.5, 1e-9);
}

TEST(Expectations, ReadTheStatistics) {
  Simulation simulation = runSteps(makeFallingSheet(), 10);
  EXPECT_EQ(computeQuantity("points", simulation), 100.0);
  EXPECT_EQ(computeQuantity("simulation_points", simulation), 40.0);
  EXPECT_EQ(computeQuantity("step", simulation), 10.0);
  EXPECT_NEAR(computeQuantity("max_speed", simulation), 9.81 * 0.1, 1e-9);
}

TEST(Expectations, KnowNothingOfBucklingWithoutAnEstimate) {
  SceneParams params = makeFallingSheet();
  for (const bool estimate : {true, false}) {
    params.accuracy.estimate = estimate;
    params.expect = {{"may_buckle", 0.0, 0.0}};
    Simulation sheet = runSteps(params, 1);
    EXPECT_EQ(checkExpectations(sheet).empty(), estimate);
  }
}

TEST(Expectations, KnowEveryNameThatTheSchemaKnows) {
  SceneParams params = makeFallingSheet();
  params.cloud.shape = CloudParams::Shape::kSphere;
  Simulation simulation = runSteps(params, 1);
  params.model = "oriented_particles";
  params.tools.push_back(makeBall(10.0));
  model::GuideParams& guide = params.oriented_particles.guide;
  guide.volume = "given";
  guide.pressure = guide.iso_value = 0.5;
  guide.grid =
      std::make_shared<const geometry::Volume>(std::array<Index, 3>{2, 2, 2}, Vec3::Constant(-9.0), Mat3(18.0 * Mat3::Identity()),
                                               std::vector<float>{0, 1, 1, 1, 1, 1, 1, 1});
  Simulation particles = runSteps(params, 1);
  for (const std::string& name : expectQuantities()) {
    // Each is one of the sphere or of its particles.
    bool is_known = true;
    try {
      computeQuantity(name, simulation);
    } catch (const InputError&) {
      is_known = false;
    }
    if (!is_known) {
      EXPECT_NO_THROW(computeQuantity(name, particles)) << name;
    }
  }
  EXPECT_THROW(computeQuantity("max_displacment", simulation), InputError);
  EXPECT_THROW(computeQuantity("state_hash", simulation), InputError);
}

TEST(Expectations, MeasureWhatKindOfSurfaceParticlesAre) {
  SceneParams params = makeFallingSheet();
  params.cloud.shape = CloudParams::Shape::kSphere;
  params.cloud.points = 400;
  params.simplification = {};
  params.simplification.method = cloud::SimplificationMethod::kNone;
  params.model = "oriented_particles";
  params.oriented_particles.rest_shape = model::RestShape::kFlat;
  params.gravity.setZero();
  Simulation sphere = runSteps(params, 1);
  EXPECT_EQ(computeQuantity("components", sphere), 1.0);
  EXPECT_EQ(computeQuantity("boundary_loops", sphere), 0.0);
  EXPECT_EQ(computeQuantity("euler_characteristic", sphere), 2.0);
  EXPECT_EQ(computeQuantity("isolated", sphere), 0.0);
  EXPECT_EQ(computeQuantity("added", sphere), 0.0);
  EXPECT_EQ(computeQuantity("removed", sphere), 0.0);
  EXPECT_GE(computeQuantity("spacing_max", sphere), computeQuantity("spacing_mean", sphere));
}

TEST(Expectations, MeasureDistancesToTheShapeAndToTheInput) {
  SceneParams params = makeFallingSheet();
  params.accuracy.estimate = false;
  // All fall alike: from the plane of the shape, and from the tangent planes of the points as they were.
  Simulation sheet = runSteps(params, 10);
  for (const char* name : {"distance_to_shape_max", "distance_to_shape_rms", "distance_to_input_max", "distance_to_input_rms"})
    EXPECT_NEAR(computeQuantity(name, sheet), kFall, 1e-9) << name;
  // A sphere that has moved by d along z is at most d from its first place, and d / sqrt(3) in the mean square.
  params.cloud.shape = CloudParams::Shape::kSphere;
  params.cloud.points = 2000;
  params.simplification.target_points = 500;
  Simulation sphere = runSteps(params, 10);
  EXPECT_NEAR(computeQuantity("distance_to_shape_max", sphere), kFall, 0.01 * kFall);
  EXPECT_NEAR(computeQuantity("distance_to_shape_rms", sphere), kFall / std::sqrt(3.0), 0.1 * kFall);
  params.cloud.shape = CloudParams::Shape::kSine;
  Simulation sine = runSteps(params, 1);
  EXPECT_THROW(computeQuantity("distance_to_shape_max", sine), InputError);
}

TEST(Expectations, MeasureDistancesToTheNearestSphereAndTorus) {
  SceneParams params = makeFallingSheet();
  params.accuracy.estimate = false;
  params.cloud.shape = CloudParams::Shape::kSphere;
  params.cloud.points = 2000;
  params.cloud.radius = 0.3;
  params.simplification.target_points = 500;
  // It falls as a whole: away from its first place, and still round.
  Simulation sphere = runSteps(params, 10);
  EXPECT_NEAR(computeQuantity("sphere_radius", sphere), 0.3, 1e-9);
  EXPECT_LT(computeQuantity("distance_to_sphere_max", sphere), 1e-9);
  EXPECT_LT(computeQuantity("distance_to_sphere_rms", sphere), computeQuantity("distance_to_shape_rms", sphere));
  EXPECT_GE(computeQuantity("distance_to_torus_max", sphere), computeQuantity("distance_to_torus_rms", sphere));
  EXPECT_THROW(computeQuantity("sphere_colour", sphere), InputError);
}

TEST(Expectations, MeasureWhatLiesOnASolidTool) {
  SceneParams params;
  params.model = "oriented_particles";
  params.cloud.shape = CloudParams::Shape::kLattice;
  params.cloud.points = 300;
  params.simplification.method = cloud::SimplificationMethod::kNone;
  params.gravity.setZero();
  Simulation bare = runSteps(params, 1);
  EXPECT_THROW(computeQuantity("distance_to_tools_min", bare), InputError);
  EXPECT_THROW(computeQuantity("touching", bare), InputError);
  const double spacing = test::latticeOf(bare).spacing;
  // The middle of the sheet is below the ball. A tool that only carries does not count as support.
  params.tools = {makeBall(0.3 + 0.2 * spacing), makeBall(0.0)};
  params.tools[1].id = "hand";
  params.tools[1].mode = tool::Mode::kMove;
  Simulation below = runSteps(params, 1);
  EXPECT_GT(computeQuantity("distance_to_tools_min", below), 0.2 * spacing - 1e-9);
  EXPECT_LT(computeQuantity("distance_to_tools_min", below), 0.5 * spacing);
  EXPECT_EQ(computeQuantity("touching", below), 0.0);
  // The whole sheet lies on a table.
  params.tools[0].shape = {};
  params.tools[0].shape.kind = geometry::Solid::Kind::kBox;
  params.tools[0].shape.size = Vec3(10.0, 10.0, 1.0);
  params.tools[0].path[0].position = Vec3(0.0, 0.0, -0.5);
  Simulation table = runSteps(params, 1);
  EXPECT_NEAR(computeQuantity("distance_to_tools_min", table), 0.0, 1e-9);
  EXPECT_EQ(computeQuantity("touching", table), static_cast<double>(table.state().size()));
}

TEST(Expectations, MeasureHowFarAxesAreFromThePrincipalDirections) {
  SceneParams params = makeFallingSheet();
  params.cloud.shape = CloudParams::Shape::kSine;
  params.cloud.points = 900;
  params.cloud.size = Vec2(1.0, 1.0);
  params.cloud.wavelength = 2.0;
  params.simplification = {};
  params.simplification.method = cloud::SimplificationMethod::kNone;
  params.model = "oriented_particles";
  params.oriented_particles.rest_shape = model::RestShape::kFlat;
  params.oriented_particles.freeze_below = 1.0;  // no particle is warm: the surface does not change
  params.oriented_particles.axis_alignment_rate = 1e-9;
  params.oriented_particles.principal = model::PrincipalDirection::kAbsolute;
  Simulation still = runSteps(params, 1);
  // In all directions: evenly spread angles are off by a quarter of a half turn in the mean.
  EXPECT_NEAR(computeQuantity("principal_angle_mean", still), 3.14159265 / 4.0, 0.05);
  params.oriented_particles.axis_alignment_rate = 1e6;
  Simulation turned = runSteps(params, 10);
  // The points are no lattice, and uneven neighbours pull the direction of the potential by a few degrees.
  EXPECT_LT(computeQuantity("principal_angle_mean", turned), 0.08);
}

TEST(Expectations, MeasureTheVolumeOfClosedSurfacesOnly) {
  SceneParams params = makeFallingSheet();
  Simulation sheet = runSteps(params, 1);
  EXPECT_THROW(computeQuantity("volume_ratio", sheet), InputError);
  params.cloud.shape = CloudParams::Shape::kSphere;
  Simulation falling = runSteps(params, 10);
  EXPECT_NEAR(computeQuantity("volume_ratio", falling), 1.0, 1e-9);
  params.pressure = 100.0;
  Simulation blown = runSteps(params, 10);
  EXPECT_GT(computeQuantity("volume_ratio", blown), 1.01);
}

TEST(Expectations, OfAnErrorNeedABoundAndNotOnlyANumber) {
  SceneParams params = makeFallingSheet();
  PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(-0.3, 1.0, 1.0);
  params.pins.push_back(pin);
  params.integrator.type = solve::IntegratorType::kStatic;
  params.integrator.max_iterations = 1;  // which ends out of balance
  params.expect = {{"error_estimate", 0.0, 1e6}, {"error_bounded", 0.0, 0.0}};
  Simulation sheet = runSteps(params, 1);
  EXPECT_TRUE(std::isfinite(sheet.statistics().error_estimate));
  const std::vector<std::string> violations = checkExpectations(sheet);
  ASSERT_EQ(violations.size(), 1u);
  EXPECT_NE(violations[0].find("expect.error_estimate: found .inf (error_bounded is false: "), std::string::npos)
      << violations[0];
  params.accuracy.estimate = false;
  EXPECT_TRUE(std::isnan(computeQuantity("error_bounded", sheet = runSteps(params, 1))));
}

TEST(Expectations, SkipHolesInTheCloud) {
  const SceneParams params = makeFallingSheet();
  cloud::PointCloud cloud = io::makeShape(params.cloud);
  cloud.positions.insert(cloud.positions.begin(), Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  ++cloud.width;
  Simulation simulation(params, cloud);
  EXPECT_TRUE(simulation.step().ok);
  EXPECT_NEAR(computeQuantity("max_x", simulation), 0.5, 1e-9);
  EXPECT_GT(computeQuantity("mean_displacement", simulation), 0.0);
}

TEST(Expectations, NameEachBoundThatDoesNotHold) {
  SceneParams params = makeFallingSheet();
  params.accuracy.estimate = false;
  const double inf = std::numeric_limits<double>::infinity();
  params.expect = {{"min_z", -0.06, -0.04}, {"step", 11.0, inf}, {"error_estimate", -inf, inf}, {"max_speed", 0.0, 1.0}};
  Simulation simulation = runSteps(params, 10);
  const std::vector<std::string> violations = checkExpectations(simulation);
  ASSERT_EQ(violations.size(), 2u);  // the estimate is NaN, which no bound accepts
  EXPECT_EQ(violations[0], "expect.step: found 10.0 at 0.1 s; accepted: 11.0 to .inf");
  EXPECT_EQ(violations[1].substr(0, 22), "expect.error_estimate:");
}

}  // namespace
}  // namespace deformable_surface::simulation
