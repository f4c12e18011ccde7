// Pins with a path: the points move rigidly, and everything that uses pins uses their motion.
#include "clouds.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/rest_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

const Vec4 kUpright(0.0, 0.0, 0.0, 1.0);

geometry::Region boxOf(const Vec3& min, const Vec3& max) {
  geometry::Region box;
  box.min = min;
  box.max = max;
  return box;
}

/// The sheet of one metre, held along x = 0; its edge x = 1 goes along a path.
simulation::SceneParams pulledSheet(const std::vector<tool::WaypointParams>& path) {
  simulation::SceneParams p = hangingSheet();
  p.gravity.setZero();
  simulation::PinParams moving;
  moving.region = boxOf(Vec3(0.999, -1.0, -1.0), Vec3(1.001, 1.0, 1.0));
  moving.path = path;
  p.pins.push_back(moving);
  return p;
}

std::vector<Index> pointsIn(const Simulation& s, const geometry::Region& region) {
  std::vector<Index> points;
  for (Index i = 0; i < s.state().size(); ++i)
    if (region.contains(s.state().positions[i])) points.push_back(i);
  return points;
}

TEST(MovingPins, CarryTheirPointsRigidlyWithEveryMethod) {
  const double half = 0.5;
  const std::vector<tool::WaypointParams> path = {
      {0.0, Vec3(1.0, 0.5, 0.0), kUpright},
      {0.2, Vec3(1.05, 0.5, 0.1), Vec4(std::sin(half * 0.3), 0.0, 0.0, std::cos(half * 0.3))}};
  using Type = solve::IntegratorType;
  for (const Type type : {Type::kVerlet, Type::kSymplecticEuler, Type::kImplicit, Type::kAuto}) {
    simulation::SceneParams p = pulledSheet(path);
    p.integrator.type = type;
    Simulation s(p, sheetCloud());
    const Points rest = s.state().positions;
    const std::vector<Index> moving = pointsIn(s, p.pins[1].region), fixed = pointsIn(s, p.pins[0].region);
    ASSERT_GT(moving.size(), 2u);
    for (int k = 0; k < 30; ++k) {
      run(s, 1);
      const tool::Pose first = tool::interpolate(path, 0.0), now = tool::interpolate(path, s.time());
      for (const Index i : moving) {
        const Vec3 place = now.position + now.orientation * (first.orientation.conjugate() * (rest[i] - first.position));
        ASSERT_LT((s.state().positions[i] - place).norm(), 1e-12) << static_cast<int>(type) << " " << k;
      }
      for (const Index i : fixed) ASSERT_EQ(s.state().positions[i], rest[i]);
    }
    // And the rest of the sheet follows.
    double highest = 0.0;
    for (Index i = 0; i < s.state().size(); ++i)
      if (!s.pinned()[i]) highest = std::max(highest, s.state().positions[i].z());
    EXPECT_GT(highest, 0.03);
  }
}

// Pins start at their full speed. The force on them rises and falls within such a step, so that its values at both ends do not
// tell their work.
TEST(MovingPins, MayBeginAtFullSpeedInImplicitSteps) {
  for (const double step : {0.0005, 0.0015, 0.005, 0.015})
    for (const double speed : {0.3, 3.0}) {  // m/s
      simulation::SceneParams p;
      p.gravity.setZero();
      p.material.young_modulus = 5e5;
      p.material.thickness = 0.005;
      p.material.density = 50.0;
      p.simplification.method = cloud::SimplificationMethod::kNone;
      p.accuracy.estimate = false;
      p.integrator.type = solve::IntegratorType::kImplicit;
      p.integrator.time_step = step;
      p.pins.resize(1);
      p.pins[0].region = boxOf(Vec3(-1.0, -1.0, -1.0), Vec3(0.04, 1.0, 1.0));
      p.pins[0].path = {{0.0, Vec3::Zero(), kUpright},
                        {0.35 / speed, Vec3(0.15, -0.15, 0.25), Vec4(0.0, std::sin(0.5), 0.0, std::cos(0.5))}};
      Simulation s(p, asCloud(makeSheet(13, 13, 0.3, 0.3, 0.2).points));
      double stored = 0.0;  // J
      for (int k = 0; k < 10; ++k) {
        const simulation::StepOutcome outcome = s.step();
        ASSERT_TRUE(outcome.ok) << step << " s, " << speed << " m/s: " << outcome.problem;
        stored = std::max(stored, s.statistics().kinetic_energy + s.statistics().elastic_energy);
      }
      EXPECT_LT(s.energyExcess(), 1e-6 * stored) << step << " s, " << speed << " m/s";
    }
}

TEST(MovingPins, APathThatRestsIsAPinThatRests) {
  simulation::SceneParams p = pulledSheet({});
  p.gravity = Vec3(0.0, 0.0, -9.81);
  Simulation fixed(p, sheetCloud());
  p.pins[1].path = {{0.0, Vec3::Zero(), kUpright}, {1.0, Vec3::Zero(), kUpright}};
  Simulation resting(p, sheetCloud());
  run(fixed, 30);
  run(resting, 30);
  EXPECT_EQ(resting.stateHash(), fixed.stateHash());
}

TEST(MovingPins, FeelWhatPullsAtThem) {
  simulation::SceneParams p = pulledSheet({{0.0, Vec3::Zero(), kUpright}, {0.2, Vec3(0.02, 0.0, 0.0), kUpright}});
  p.material.damping = 20.0;
  Simulation s(p, sheetCloud());
  run(s, 150);
  const std::vector<simulation::PinReaction> pins = s.pinReactions();
  ASSERT_EQ(pins.size(), 2u);
  EXPECT_GT(pins[0].force.x(), 0.0);
  EXPECT_NEAR(pins[0].force.x(), -pins[1].force.x(), 1e-2 * pins[0].force.x());
  // E h b stretched by two per cent, between without and with its sides held.
  const double narrow = p.material.young_modulus * p.material.thickness * 0.02;
  EXPECT_GT(pins[0].force.x(), 0.95 * narrow);
  EXPECT_LT(pins[0].force.x(), 1.3 * narrow);
}

TEST(MovingPins, SnapshotsAndForksGoOnBitForBit) {
  simulation::SceneParams p = pulledSheet({{0.0, Vec3::Zero(), kUpright}, {0.3, Vec3(0.05, 0.02, 0.1), kUpright}});
  Simulation s(p, sheetCloud());
  run(s, 5);
  s.pinAlong("lift", boxOf(Vec3(0.4, -0.1, -1.0), Vec3(0.6, 0.1, 1.0)),
             {{s.time(), Vec3::Zero(), kUpright}, {s.time() + 0.2, Vec3(0.0, 0.0, 0.1), kUpright}});
  ASSERT_NE(s.findPinPath("lift"), nullptr);
  run(s, 5);
  const simulation::Snapshot saved = s.snapshot();
  Simulation fork = s.fork();
  run(s, 20);
  run(fork, 20);
  EXPECT_EQ(fork.stateHash(), s.stateHash());
  Simulation other(p, sheetCloud());
  other.restore(saved);
  run(other, 20);
  EXPECT_EQ(other.stateHash(), s.stateHash());
  s.reset();
  EXPECT_EQ(s.findPinPath("lift"), nullptr);
  ASSERT_NE(s.findPinPath("pins[1]"), nullptr);
  Simulation fresh(p, sheetCloud());
  run(s, 10);
  run(fresh, 10);
  EXPECT_EQ(s.stateHash(), fresh.stateHash());
}

TEST(MovingPins, WakeASurfaceThatSleeps) {
  simulation::SceneParams p = pulledSheet({{3.0, Vec3::Zero(), kUpright}, {3.2, Vec3(0.0, 0.0, 0.2), kUpright}});
  p.sleep.mode = simulation::Sleep::kAlways;
  Simulation s(p, sheetCloud());
  while (s.time() < 2.99) run(s, 1);
  EXPECT_TRUE(s.isAsleep());
  while (s.time() < 3.1) run(s, 1);
  EXPECT_FALSE(s.isAsleep());
  while (s.time() < 3.25) run(s, 1);
  int lifted = 0;
  for (Index i = 0; i < s.state().size(); ++i) {
    if (!s.pinned()[i] || s.state().positions[i].x() < 0.5) continue;
    EXPECT_NEAR(s.state().positions[i].z(), 0.2, 1e-9);
    ++lifted;
  }
  EXPECT_GT(lifted, 2);
}

TEST(MovingPins, PointsThatAreFreedOrPinnedAgainLeaveThem) {
  const simulation::SceneParams p = pulledSheet({{0.0, Vec3::Zero(), kUpright}, {1.0, Vec3(0.0, 0.0, 0.3), kUpright}});
  Simulation s(p, sheetCloud());
  const std::vector<Index> moving = pointsIn(s, p.pins[1].region);
  run(s, 10);
  const geometry::Region half = boxOf(Vec3(0.9, -1.0, -1.0), Vec3(1.1, 0.0, 1.0));
  const std::vector<Index> stopped = pointsIn(s, half);
  s.pin(half);
  const Points then = s.state().positions;
  run(s, 10);
  int still = 0;
  for (const Index i : moving) {
    const bool is_stopped = std::count(stopped.begin(), stopped.end(), i) > 0;
    still += is_stopped;
    EXPECT_EQ(s.state().positions[i] == then[i], is_stopped);
  }
  EXPECT_GT(still, 0);
  EXPECT_LT(still, static_cast<int>(moving.size()));
  s.unpin(boxOf(Vec3(0.5, -1.0, -1.0), Vec3(1.5, 2.0, 1.0)));
  EXPECT_EQ(s.findPinPath("pins[1]"), nullptr);
  for (const Index i : moving) EXPECT_FALSE(s.pinned()[i]);
  run(s, 10);
}

TEST(MovingPins, HaveAnErrorEstimate) {
  const simulation::SceneParams p = pulledSheet({{0.0, Vec3::Zero(), kUpright}, {0.3, Vec3(0.0, 0.0, 0.1), kUpright}});
  Simulation s(p, sheetCloud());
  run(s, 40);
  EXPECT_GT(s.statistics().error_estimate, 0.0);
  EXPECT_LT(s.statistics().error_estimate, 0.05);
}

TEST(MovingPins, CarryParticlesAndSolids) {
  for (const std::string model : {"oriented_particles", "elastic_solid"}) {
    simulation::SceneParams p = pulledSheet({{0.0, Vec3::Zero(), kUpright}, {0.5, Vec3(0.02, 0.0, 0.0), kUpright}});
    // A planar solid stays in its plane.
    SCOPED_TRACE(model);
    p.model = model;
    p.accuracy.estimate = false;
    const cloud::PointCloud cloud = sheetCloud(12);
    Simulation s(p, cloud);
    // Where the cloud is: particles settle before time 0.
    std::vector<Index> moving;
    for (Index i = 0; i < s.state().size(); ++i)
      if (p.pins[1].region.contains(cloud.positions[i])) moving.push_back(i);
    const Points rest = s.state().positions;
    ASSERT_EQ(s.state().size(), static_cast<Index>(cloud.positions.size()));
    ASSERT_FALSE(moving.empty());
    run(s, 10);
    for (const Index i : moving) EXPECT_LT((s.state().positions[i] - rest[i] - Vec3(0.04 * s.time(), 0.0, 0.0)).norm(), 1e-12);
  }
}

// The elastic energy after a disc within a sheet has moved, in so many static steps.
double moveDisc(const Vec3& motion, int steps) {
  constexpr double kRadius = 2.0 / 15.0;
  simulation::CloudParams cloud;
  cloud.shape = simulation::CloudParams::Shape::kSheet;
  cloud.points = 225;
  cloud.size = Vec2(1.0, 1.0);
  cloud.jitter = 0.3;
  simulation::SceneParams p;
  p.material.thickness = 0.003;
  p.gravity.setZero();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.integrator.type = solve::IntegratorType::kStatic;
  p.integrator.time_step = 1.0;
  p.accuracy.estimate = false;
  p.pins.resize(2);
  p.pins[0].region = boxOf(Vec3(-1.0, -1.0, -1.0), Vec3(-0.4, 1.0, 1.0));
  geometry::Region& disc = p.pins[1].region;
  disc.kind = geometry::Region::Kind::kSphere;
  disc.center = Vec3(0.1, 0.05, 0.0);
  disc.radius = kRadius;
  for (int k = 0; k <= steps; ++k) p.pins[1].path.push_back({k + 1.0, disc.center + motion * k / steps, kUpright});
  Simulation s(p, io::makeShape(cloud));
  run(s, steps + 1);
  return s.statistics().elastic_energy;
}

// The sheet buckles where it is pushed together. Moved all at once, the disc crumpled it into another equilibrium.
TEST(MovingPins, AStaticStepOverSpacingsEndsWhereShortStepsDo) {
  constexpr double kSpacing = 1.0 / 15.0;
  for (const Vec3& direction : {Vec3(-1.0, 0.0, 0.0), Vec3(0.6, 0.7, 0.3), Vec3(0.0, 0.0, 1.0)})
    for (const double spacings : {1.0, 3.0}) {
      const Vec3 motion = spacings * kSpacing * direction;
      const double energy = moveDisc(motion, static_cast<int>(2.0 * spacings));
      EXPECT_NEAR(moveDisc(motion, 1), energy, 0.03 * energy) << direction.transpose() << ", " << spacings;
    }
}

TEST(MovingPins, TurnsAreRefusedWithAHeldOrientation) {
  simulation::SceneParams p = pulledSheet({{0.0, Vec3::Zero(), kUpright}, {1.0, Vec3::Zero(), Vec4(1.0, 0.0, 0.0, 0.0)}});
  p.model = "oriented_particles";
  EXPECT_TRUE(checkParams(p).empty());
  p.pins[1].orientation = true;
  ASSERT_EQ(checkParams(p).size(), 1u);
  EXPECT_NE(checkParams(p)[0].find("pins[1].orientation: found true with a path that turns"), std::string::npos);
}

TEST(Region, OutsideIsAllButTheClosedShape) {
  geometry::Region box = boxOf(Vec3::Zero(), Vec3::Ones());
  geometry::Region ball;
  ball.kind = geometry::Region::Kind::kSphere;
  ball.radius = 1.0;
  for (geometry::Region region : {box, ball})
    for (const Vec3& p :
         {Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), Vec3(0.5, 0.5, 0.5), Vec3(1.1, 0.0, 0.0), Vec3(-2.0, 3.0, 0.0)}) {
      region.outside = false;
      const bool is_inside = region.contains(p);
      region.outside = true;
      EXPECT_NE(region.contains(p), is_inside);
    }
}

TEST(Region, APinOutsideOfABoxHoldsTheRim) {
  simulation::SceneParams p = hangingSheet();
  p.pins[0].region = boxOf(Vec3(0.1, -0.4, -1.0), Vec3(0.9, 0.4, 1.0));
  p.pins[0].region.outside = true;
  const Simulation s(p, sheetCloud());
  int held = 0;
  for (Index i = 0; i < s.state().size(); ++i) {
    const Vec3& x = s.state().positions[i];
    const bool is_inside = x.x() >= 0.1 && x.x() <= 0.9 && x.y() >= -0.4 && x.y() <= 0.4;
    EXPECT_EQ(s.pinned()[i] == simulation::kInPin, !is_inside);  // others are carried by it
    held += !is_inside;
  }
  EXPECT_GT(held, 10);
}

}  // namespace
}  // namespace deformable_surface::test
