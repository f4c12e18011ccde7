// A first equilibrium that is searched from that of fewer points equals the one found from rest, without Newton's method where a
// surface swings far.
#include "clouds.h"
#include "deformable_surface/io/shapes.h"

#include <gtest/gtest.h>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;

// A jittered sheet of about n points held on two edges, or hanging from one, sagging under its weight.
struct Sag {
  explicit Sag(Index n, bool hangs = false) {
    shape.shape = simulation::CloudParams::Shape::kSheet;
    shape.points = n;
    shape.jitter = 0.2;
    scene.accuracy.estimate = false;
    scene.simplification.method = cloud::SimplificationMethod::kNone;
    scene.material.young_modulus = 1e6;
    scene.integrator.type = solve::IntegratorType::kStatic;
    for (double side : {-1.0, 1.0}) {
      if (hangs && side > 0.0) break;
      simulation::PinParams pin;
      pin.region.min = Vec3(side * 0.5 - 0.001, -1.0, -1.0);
      pin.region.max = Vec3(side * 0.5 + 0.001, 1.0, 1.0);
      scene.pins.push_back(pin);
    }
  }
  Simulation make() const { return Simulation(scene, io::makeShape(shape)); }

  simulation::SceneParams scene;
  simulation::CloudParams shape;
};

// If it is not quite at rest, the search starts where it is.
void moveALittle(Simulation& s) {
  model::State state = s.state();
  state.positions[200].z() += 1e-12;
  s.setState(state);
}

double findLargestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

TEST(NestedStart, LeadsToTheEquilibriumThatNewtonsMethodFindsFromRest) {
  Sag sag(400, true);
  sag.scene.material.young_modulus = 1e8;
  Simulation nested = sag.make(), direct = sag.make();
  moveALittle(direct);
  ASSERT_TRUE(nested.step().ok);
  ASSERT_TRUE(direct.step().ok);
  // Both are in balance to a millionth of the forces, and move by less than a metre per newton.
  EXPECT_LT(findLargestDistance(nested.state().positions, direct.state().positions), 1e-4);
  EXPECT_TRUE(nested.statistics().is_quasi_newton);
  EXPECT_FALSE(direct.statistics().is_quasi_newton);
  EXPECT_GT(findLargestDistance(nested.state().positions, nested.input().positions), 0.5);
}

TEST(NestedStart, IsNotNeededBetweenPins) {
  const Sag sag(400);
  Simulation s = sag.make(), direct = sag.make();
  moveALittle(direct);
  ASSERT_TRUE(s.step().ok);
  ASSERT_TRUE(direct.step().ok);
  EXPECT_TRUE(s.statistics().is_quasi_newton);
  // From 25 points it would take 42 iterations instead of 35.
  EXPECT_NEAR(s.statistics().solver_iterations, direct.statistics().solver_iterations, 2);
  EXPECT_GT(findLargestDistance(s.state().positions, s.input().positions), 0.01);
}

TEST(NestedStart, IsTakenAgainAfterAResetWithTheSameBits) {
  const Sag sag(300, true);
  Simulation s = sag.make();
  s.step();
  const std::uint64_t first = s.stateHash();
  s.reset();
  s.step();
  EXPECT_EQ(s.stateHash(), first);
}

TEST(NestedStart, LeavesAlonePinsThatTheSceneDoesNotHave) {
  const Sag sag(400);
  Simulation s = sag.make();
  geometry::Region middle;
  middle.min = Vec3(-0.1, -0.1, -0.1);
  middle.max = Vec3(0.1, 0.1, 0.1);
  ASSERT_GT(s.pin(middle), 0);
  const Points rest = s.state().positions;
  ASSERT_TRUE(s.step().ok);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (s.pinned()[i]) {
      EXPECT_EQ(s.state().positions[i], rest[i]) << i;
    }
  }
}

}  // namespace
}  // namespace deformable_surface::test
