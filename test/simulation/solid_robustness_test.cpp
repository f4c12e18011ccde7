// Elastic solids of very few points, random points, extreme materials and absurd loads: refused with a sentence, or a sound
// result.
#include "clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/io/scene.h"
#include "deformable_surface/io/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;

SceneParams makeScene() {
  SceneParams scene;
  scene.model = "elastic_solid";
  scene.material.poisson_ratio = 0.3;
  scene.accuracy.estimate = false;
  return scene;
}

// A bar of some 240 points, clamped at x = 0.
SceneParams makeBarScene() {
  SceneParams scene = makeScene();
  scene.cloud.shape = simulation::CloudParams::Shape::kBar;
  scene.cloud.points = 300;
  scene.cloud.size = Vec2(0.4, 0.1);
  scene.cloud.height = 0.1;
  scene.cloud.jitter = 0.2;
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(1e-6, 1.0, 1.0);
  scene.pins.push_back(pin);
  return scene;
}

Points makeRandomPoints(Index n, double height, unsigned seed) {
  std::mt19937 generator(seed);
  Points points(n);
  for (Vec3& p : points) {
    p = randomVector(generator);
    p.z() *= height;
  }
  return points;
}

bool areFinite(const Points& points) {
  return std::all_of(points.begin(), points.end(), [](const Vec3& p) { return p.allFinite(); });
}

// Nothing holds it and only its weight acts: it falls as a whole, and stores almost no energy.
void expectFreeFall(const SceneParams& scene, const Points& points, const Vec3& way, double rounding) {
  Simulation s(scene, asCloud(points));
  run(s, 10);
  for (Index i = 0; i < s.input().size(); ++i)
    EXPECT_LT((s.surface(false).positions[i] - s.input().positions[i] - way).norm(), rounding)
        << points.size() << " points, " << i;
}

TEST(SolidRobustness, RefusesFewerPointsThanMakeABody) {
  for (const Index n : {0, 1, 2})
    EXPECT_NE(problemOf(makeScene(), asCloud(makeRandomPoints(n, 1.0, 1))).find("accepted: at least 3"), std::string::npos) << n;
  EXPECT_NE(problemOf(makeScene(), asCloud(Points(20, Vec3(1.0, 2.0, 3.0)))).find("found 1 finite distinct points"),
            std::string::npos);
  Points line;
  for (int k = 0; k < 20; ++k) line.push_back(k * Vec3(1.0, 2.0, 3.0));
  EXPECT_NE(problemOf(makeScene(), asCloud(line)).find("lie on a line"), std::string::npos);
  SceneParams filled = makeScene();
  filled.elastic_solid.fill = true;
  for (const Index n : {3, 4})
    EXPECT_NE(problemOf(filled, asCloud(makeRandomPoints(n, 1.0, 1))).find("no place inside"), std::string::npos) << n;
}

// A triangle is a planar solid, and so is a cloud in a plane that is parallel to no axis. Random points leave some with one
// neighbour.
TEST(SolidRobustness, AHandfulOfPointsAndPointsAtRandomFallFreely) {
  SceneParams scene = makeScene();
  const Vec3 way = 0.5 * 0.01 * scene.gravity;
  for (const Index n : {6, 12}) expectFreeFall(scene, makeRandomPoints(n, 1.0, 1), way, 1e-9);
  // Among forty of them some have steep gradients. Rounding then leaves forces: some micrometres were found.
  expectFreeFall(scene, makeRandomPoints(40, 1.0, 1), way, 1e-5);
  scene.gravity = Vec3(1.0, 0.0, 0.0);
  for (const Index n : {3, 4, 5, 12, 100}) expectFreeFall(scene, makeRandomPoints(n, 0.0, 1), Vec3(0.005, 0.0, 0.0), 1e-9);
  expectFreeFall(scene, makeRandomPoints(100, 1e-9, 1), Vec3(0.005, 0.0, 0.0), 1e-9);
}

// Within a fiftieth of the spacing a cloud counts as flat. The offset from the plane is no strain.
TEST(SolidRobustness, APlanarCloudThatIsNotQuiteFlatRestsInItsPlane) {
  SceneParams scene = makeScene();
  scene.gravity.setZero();
  Simulation s(scene, asCloud(makeRandomPoints(100, 1e-3, 1)));
  run(s, 10);
  for (Index i = 0; i < s.state().size(); ++i) EXPECT_LT((s.state().positions[i] - s.input().positions[i]).norm(), 1e-3) << i;
}

TEST(SolidRobustness, TwoBodiesOfOneCloudMoveAsTwo) {
  Points points = makeRandomPoints(0, 1.0, 1);
  std::mt19937 generator(2);
  for (const double offset : {0.0, 5.0})
    for (int x = 0; x < 6; ++x)
      for (int y = 0; y < 5; ++y)
        for (int z = 0; z < 5; ++z)
          points.push_back(0.1 * (Vec3(x, y, z) + 0.2 * randomVector(generator)) + Vec3(offset, 0.0, 0.0));
  const SceneParams scene = makeScene();
  expectFreeFall(scene, points, 0.5 * 0.01 * scene.gravity, 1e-9);
}

TEST(SolidRobustness, TakesTheSoftestAndTheStiffestMaterialAndRefusesWhatIsNone) {
  for (const double young_modulus : {1e-3, 1e12})
    for (const double poisson_ratio : {0.0, 0.499}) {
      SceneParams scene = makeBarScene();
      scene.material.young_modulus = young_modulus;
      scene.material.poisson_ratio = poisson_ratio;
      Simulation s(scene, io::makeShape(scene.cloud));
      for (int k = 0; k < 5; ++k) EXPECT_TRUE(s.step().ok) << young_modulus << " " << poisson_ratio;
      // Almost no stiffness: it falls. Almost no weight: it stays.
      const double fallen = s.input().positions.back().z() - s.surface(false).positions.back().z();
      EXPECT_NEAR(fallen, young_modulus < 1.0 ? 0.5 * 9.81 * 0.05 * 0.05 : 0.0, 1e-5) << young_modulus << " " << poisson_ratio;
    }
  for (const char* material : {"{young_modulus: 0.0}", "{young_modulus: -1.0}", "{young_modulus: 1.0e+16}",
                               "{poisson_ratio: 0.5}", "{poisson_ratio: -1.0}", "{poisson_ratio: .nan}"})
    EXPECT_THROW(io::readScene(io::parseYaml("model: elastic_solid\nmaterial: " + std::string(material) + "\n", "scene")),
                 InputError)
        << material;
}

// However large a load of a scene is, the state stays finite. A step either carries it or is refused, with everything unchanged.
// Contact of the body with itself stops such motion, and says so.
TEST(SolidRobustness, StaysFiniteUnderAbsurdForces) {
  for (const auto& [force, touches] : {std::pair(1e3, false), std::pair(1e12, false), std::pair(1e12, true)}) {
    SceneParams scene = makeBarScene();
    scene.contact.self = touches;
    scene.integrator.type = solve::IntegratorType::kVerlet;
    simulation::ForceParams push;
    push.id = "push";
    push.point = Vec3(0.4, 0.0, 0.0);
    push.force = Vec3(-force, 0.1 * force, 0.0);
    push.radius = 0.05;
    scene.forces = {push};
    Simulation s(scene, io::makeShape(scene.cloud));
    const Points before = s.state().positions;
    const simulation::StepOutcome outcome = s.step();
    EXPECT_TRUE(areFinite(s.state().positions)) << force;
    EXPECT_EQ(outcome.ok, force < 1e6 || touches) << outcome.problem;
    EXPECT_EQ(force < 1e6, s.state().positions != before) << force;
    EXPECT_EQ(touches, outcome.notice.find("contact limits the motion of points") != std::string::npos) << outcome.notice;
  }
}

TEST(SolidRobustness, AYieldOfZeroIsNoneAndOneOfNextToNothingFlowsLikeClay) {
  SceneParams scene = makeBarScene();
  const auto runWith = [&](double yield_stress) {
    scene.elastic_solid.plasticity.yield_stress = yield_stress;
    Simulation s(scene, io::makeShape(scene.cloud));
    for (int k = 0; k < 10; ++k) EXPECT_TRUE(s.step().ok);
    EXPECT_TRUE(areFinite(s.state().positions));
    return s.state();
  };
  const model::State none = runWith(0.0), never = runWith(1e15), clay = runWith(1e-9);
  EXPECT_TRUE(none.plastic.empty());
  EXPECT_EQ(none.positions, never.positions);
  EXPECT_GT(clay.dissipated, 0.0);
}

}  // namespace
}  // namespace deformable_surface::test
