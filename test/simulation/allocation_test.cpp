// A step allocates nothing after the first, also while the surface changes so much that the stable step is measured again. The
// full surface allocates nothing after its first request.
#include "clouds.h"
#include "deformable_surface/io/shapes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<long> num_allocations{0};
}

void* operator new(std::size_t size) {
  ++num_allocations;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace deformable_surface::test {
namespace {

// Steps after which the loaded sheet has crumpled and dented. The error estimate reports both in words.
constexpr int kUntilDented = 30;

// Number of heap calls in the steps after the first, and of the surface with normals after each.
long countAllocations(simulation::Simulation& s, int steps) {
  run(s, 3);
  s.surface(true);
  const long before = num_allocations;
  bool sound = true;
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = s.step();
    sound = sound && outcome.ok && outcome.notice.empty();
    s.surface(true);
  }
  const long after = num_allocations;
  EXPECT_TRUE(sound);
  return after - before;
}

simulation::SceneParams loadedSheet(solve::IntegratorType type) {
  simulation::SceneParams p = hangingSheet();
  p.integrator.type = type;
  p.contact.self = false;  // parts of the crumpled sheet come near each other, and are listed
  p.pressure = 1.0;
  p.viscous_drag = 0.5;
  p.material.spring_damping = 1e-4;
  p.forces.push_back({"pull", Vec3(1.0, 0.0, 0.0), Vec3(30.0, 0.0, 0.0), 0.5, 0.0, 1e300});
  return p;
}

TEST(Allocation, NoStepWithToolsInMotionAllocatesAfterTheFirst) {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.material.damping = 20.0;  // keeps the sheet at the plate
  tool::ToolParams plate, knife;
  plate.id = "plate";
  plate.shape.kind = geometry::Solid::Kind::kBox;
  plate.shape.size = Vec3(0.4, 0.4, 0.01);
  plate.path = {{0.0, Vec3(0.5, 0.0, 0.05), Vec4(0.0, 0.0, 0.0, 1.0)}, {1.0, Vec3(0.5, 0.0, -0.15), Vec4(0.0, 0.0, 1.0, 0.0)}};
  knife.id = "knife";
  knife.mode = tool::Mode::kCut;
  knife.shape.radius = 0.01;
  knife.path = {{0.0, Vec3(5.0, 0.0, 0.0)}, {1.0, Vec3(5.0, 1.0, 0.0)}};  // moves past
  p.tools = {plate, knife};
  simulation::Simulation s(p, sheetCloud());
  run(s, 60);
  ASSERT_GT(s.toolReactions()[0].contacts, 0);
  EXPECT_EQ(countAllocations(s, 20), 0);
}

// What is cut is looked at once, not whenever a tool moves.
TEST(Allocation, AToolThatFollowsAllocatesNoMoreBesideACutSheet) {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.accuracy.estimate = false;
  tool::ToolParams ball, knife;
  ball.id = "ball";
  ball.shape.radius = 0.1;
  ball.path = {{0.0, Vec3(0.8, 0.0, -0.3)}};
  knife.id = "knife";
  knife.mode = tool::Mode::kCut;
  knife.shape.kind = geometry::Solid::Kind::kBox;
  knife.shape.size = Vec3(0.002, 0.1, 0.4);
  knife.path = {{0.0, Vec3(0.513, -0.7, 0.0)}, {0.05, Vec3(0.513, 0.7, 0.0)}};
  p.tools = {ball, knife};
  simulation::Simulation s(p, sheetCloud());
  const auto countInMoves = [&] {
    s.moveTool("ball", {{0.0, Vec3(0.8, 0.0, -0.31)}});
    const long before = num_allocations;
    for (int k = 0; k < 10; ++k) s.moveTool("ball", {{0.0, Vec3(0.8, 0.0, -0.3 - 0.001 * k)}});
    return num_allocations - before;
  };
  const std::size_t links = stretchLinksOf(s.model()).size();
  const long beside_whole = countInMoves();
  run(s, 10);
  ASSERT_LT(stretchLinksOf(s.model()).size(), links);
  EXPECT_LE(countInMoves(), beside_whole);
}

// The places where points stick are listed in the state. If more points touch than ever before, the list grows.
TEST(Allocation, NoStepWithFrictionAllocatesWhileNoMorePointsTouch) {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.material.damping = 20.0;
  p.sleep.mode = simulation::Sleep::kNever;
  tool::ToolParams plate;
  plate.id = "plate";
  plate.shape.kind = geometry::Solid::Kind::kBox;
  plate.shape.size = Vec3(0.4, 0.4, 0.01);
  plate.friction = 0.3;
  plate.path = {{0.0, Vec3(0.5, 0.0, 0.05), Vec4(0.0, 0.0, 0.0, 1.0)}, {0.5, Vec3(0.5, 0.0, -0.05), Vec4(0.0, 0.0, 0.0, 1.0)}};
  p.tools = {plate};
  simulation::Simulation s(p, sheetCloud());
  run(s, 200);
  ASSERT_GT(s.toolReactions()[0].contacts, 0);
  EXPECT_EQ(countAllocations(s, 20), 0);
}

TEST(Allocation, NoExplicitStepAllocatesAfterTheFirst) {
  using Type = solve::IntegratorType;
  for (Type type : {Type::kAuto, Type::kVerlet, Type::kSymplecticEuler}) {
    simulation::Simulation s(loadedSheet(type), sheetCloud());
    run(s, kUntilDented);
    EXPECT_EQ(countAllocations(s, 60), 0) << static_cast<int>(type);
    // The scene has stretched far enough for several new measurements of the stable step.
    EXPECT_GT(s.statistics().max_stretch, 0.2);
  }
}

TEST(Allocation, NoStepWithSelfContactAllocatesWhileNothingIsNear) {
  using Type = solve::IntegratorType;
  for (Type type : {Type::kAuto, Type::kVerlet, Type::kImplicit}) {
    simulation::SceneParams p = hangingSheet();
    p.integrator.type = type;
    p.contact.self = true;
    simulation::Simulation s(p, sheetCloud());
    // Few implicit steps, before it is told that they take longer than Verlet's.
    EXPECT_EQ(countAllocations(s, type == Type::kImplicit ? 8 : 30), 0) << static_cast<int>(type);
  }
}

TEST(Allocation, NoImplicitOrStaticStepAllocatesAfterTheFirst) {
  for (solve::IntegratorType type : {solve::IntegratorType::kImplicit, solve::IntegratorType::kStatic})
    for (model::Membrane membrane : {model::Membrane::kTriangles, model::Membrane::kSprings}) {
      simulation::SceneParams p = loadedSheet(type);
      p.mass_spring.membrane = membrane;
      p.anchors.push_back({Vec3(1.0, 0.5, 0.0), Vec3(1.0, 0.6, 0.1), 5.0});
      simulation::Simulation s(p, sheetCloud());
      run(s, kUntilDented);
      s.setGravity(Vec3(0.0, 2.0, -9.81));  // another equilibrium to find
      EXPECT_EQ(countAllocations(s, 5), 0) << static_cast<int>(type) << " " << static_cast<int>(membrane);
      EXPECT_GT(s.statistics().max_stretch, 0.05);
    }
}

TEST(Allocation, NoStepOfAClosedSurfaceWithAKeptVolumeAllocatesAfterTheFirst) {
  using Type = solve::IntegratorType;
  for (Type type : {Type::kVerlet, Type::kImplicit, Type::kStatic}) {
    simulation::SceneParams p;
    p.integrator.type = type;
    p.integrator.time_step = 1e-3;
    p.material.young_modulus = 2e5;
    p.material.thickness = 0.002;
    p.material.damping = 1.0;
    p.material.spring_damping = 1e-4;
    p.mass_spring.volume_stiffness = 1e5;
    p.gravity = Vec3(0.0, 0.0, -1.0);
    p.pressure = 5.0;
    p.viscous_drag = 0.5;
    p.simplification.target_points = 520;  // more than fit in one block of a sum
    simulation::PinParams pin;
    pin.region.min = Vec3(-1.0, -1.0, -1.0);
    pin.region.max = Vec3(1.0, 1.0, -0.08);
    p.pins.push_back(pin);
    simulation::Simulation s(p, asCloud(makeSphere(1200, 0.1).points));
    run(s, 1);
    s.setGravity(Vec3(0.1, 0.0, -1.0));  // another equilibrium to find
    EXPECT_EQ(countAllocations(s, 2), 0) << static_cast<int>(type);
  }
}

TEST(Allocation, NoStepWithAPinThatMovesAllocatesAfterTheFirst) {
  simulation::SceneParams p = hangingSheet();
  p.pins[0].path = {{0.0, Vec3::Zero()}, {10.0, Vec3(1.0, 0.0, 0.5)}};
  simulation::Simulation s(p, sheetCloud());
  run(s, 5);
  EXPECT_EQ(countAllocations(s, 20), 0);
}

TEST(Allocation, NoStepOfAnElasticSolidAllocatesAfterTheFirst) {
  using Type = solve::IntegratorType;
  for (Type type : {Type::kVerlet, Type::kImplicit, Type::kStatic}) {
    simulation::SceneParams p;
    p.model = "elastic_solid";
    p.integrator.type = type;
    p.cloud.shape = simulation::CloudParams::Shape::kBar;
    p.cloud.points = 400;
    p.cloud.size = Vec2(0.4, 0.1);
    p.cloud.height = 0.1;
    p.cloud.jitter = 0.2;
    p.anchors.push_back({Vec3(0.4, 0.0, 0.0), Vec3(0.4, 0.1, 0.1), 5.0});  // a load with a stiffness
    simulation::PinParams pin;
    pin.region.min = Vec3(-1.0, -1.0, -1.0);
    pin.region.max = Vec3(1e-6, 1.0, 1.0);
    p.pins.push_back(pin);
    simulation::Simulation s(p, io::makeShape(p.cloud));
    run(s, 1);
    s.setGravity(Vec3(0.0, 2.0, -9.81));  // another equilibrium to find
    EXPECT_EQ(countAllocations(s, 3), 0) << static_cast<int>(type);
  }
}

TEST(Allocation, NoStepOfOrientedParticlesAllocatesAfterTheFirst) {
  using Type = solve::IntegratorType;
  for (Type type : {Type::kVerlet, Type::kStatic})
    for (const double yield : {0.0, 0.5}) {
      simulation::SceneParams p = hangingSheet();
      p.model = "oriented_particles";
      p.integrator.type = type;
      p.simplification = {};
      p.simplification.method = cloud::SimplificationMethod::kNone;
      p.material.bending_rigidity = 0.05;
      p.material.damping = 2.0;
      if (type == Type::kVerlet) {
        p.pressure = 1.0;
        p.viscous_drag = 0.5;
      }
      p.oriented_particles.axis_alignment_rate = 10.0;
      p.oriented_particles.yield_curvature = yield;
      p.oriented_particles.delete_trapped = true;
      tool::ToolParams warm;
      warm.id = "warm";
      warm.mode = tool::Mode::kHeat;
      warm.strength = 100.0;
      warm.shape.radius = 0.2;
      warm.path = {{0.0, Vec3(0.5, 0.0, 0.0), Vec4(0.0, 0.0, 0.0, 1.0)}};
      tool::ToolParams ball = warm;
      ball.id = "ball";
      ball.mode = tool::Mode::kSolid;
      ball.strength = 0.0;
      ball.path[0].position = Vec3(0.5, 0.0, -0.25);
      if (type == Type::kVerlet) p.tools = {warm, ball};
      simulation::Simulation s(p, asCloud(makeSheet(12, 12, 1.0, 1.0).points));
      run(s, 10);  // the lists of neighbours grow when there are more neighbours than ever before
      EXPECT_EQ(countAllocations(s, 20), 0) << static_cast<int>(type) << " " << yield;
    }
}

TEST(Allocation, NoStepOfParticlesWithKeptBondsAllocatesAfterTheFirst) {
  using Type = solve::IntegratorType;
  for (Type type : {Type::kVerlet, Type::kStatic}) {
    simulation::SceneParams p = hangingSheet();
    p.model = "oriented_particles";
    p.oriented_particles.bonds = model::ParticleBonds::kKept;
    p.integrator.type = type;
    p.simplification = {};
    p.simplification.method = cloud::SimplificationMethod::kNone;
    p.material.damping = 2.0;
    simulation::Simulation s(p, asCloud(makeSheet(12, 12, 1.0, 1.0).points));
    run(s, 10);
    EXPECT_EQ(countAllocations(s, 20), 0) << static_cast<int>(type);
  }
}

TEST(Allocation, NoStepOfAPartAllocatesWhileTheSameTilesMove) {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  p.material.young_modulus = 500.0;
  p.material.damping = 20.0;
  p.simplification.target_points = 800;
  p.accuracy.estimate = false;
  p.sleep.quiet_time = 0.02;  // requested in every step
  p.sleep.tolerance = 1e-4;
  p.forces.push_back({"push", Vec3(0.8, 0.3, 0.0), Vec3(0.0, 0.0, 0.02), 0.1, 0.0, 1e300});
  simulation::Simulation s(p, sheetCloud(40));
  Index unchanged = 0;
  for (int k = 0; k < 60; ++k) {
    const std::uint32_t awake = s.statistics().awake;
    const long before = num_allocations;
    ASSERT_TRUE(s.step().ok);
    const long after = num_allocations;
    if (k < 5 || s.statistics().awake != awake) {
      unchanged = 0;
      continue;
    }
    // A part is made in the step after the one in which it changed.
    if (++unchanged < 3) continue;
    EXPECT_GT(awake, 0u);
    EXPECT_LT(awake, 500u);
    EXPECT_EQ(after - before, 0) << k;
  }
  EXPECT_GT(unchanged, 5);
}

TEST(Allocation, NoStepOfASurfaceThatSleepsAllocates) {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  simulation::Simulation s(p, sheetCloud());
  EXPECT_EQ(countAllocations(s, 60), 0);
  EXPECT_EQ(s.statistics().awake, 0u);
}

}  // namespace
}  // namespace deformable_surface::test
