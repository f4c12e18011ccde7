// Contact of the parts of a solid with each other.
#include "clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/simulation/model_kind.h"

#include <gtest/gtest.h>

#include <numeric>

#include "../../src/simulation/self_contact_load.h"
#include "../model/solids.h"
#include "../support/crossings.h"

namespace deformable_surface::test {
namespace {

using simulation::SceneParams;
using simulation::Simulation;
using Type = solve::IntegratorType;

constexpr double kSpacing = 0.01;

Points makeBlock(Index across, Index high, const Vec3& corner, double jitter, unsigned seed) {
  Points block = makeBox(across, across, high, kSpacing, jitter, seed);
  for (Vec3& p : block) p += corner;
  return block;
}

cloud::PointCloud join(const Points& one, const Points& other) {
  cloud::PointCloud cloud;
  cloud.positions = one;
  cloud.positions.insert(cloud.positions.end(), other.begin(), other.end());
  return cloud;
}

SceneParams makeScene(Type type = Type::kVerlet) {
  SceneParams scene;
  scene.model = "elastic_solid";
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  scene.material.young_modulus = 5e4;
  scene.material.poisson_ratio = 0.3;
  scene.material.density = 1000.0;
  scene.contact.self = true;
  scene.accuracy.estimate = false;
  scene.integrator.type = type;
  scene.integrator.time_step = 0.005;
  scene.gravity.setZero();
  return scene;
}

std::vector<contact::Triangle> findSkin(const SceneParams& scene, const cloud::PointCloud& cloud) {
  const simulation::RestSurface rest = simulation::buildRestSurface(scene, cloud);
  return simulation::ContactSkin(rest.points, simulation::findModel("elastic_solid").findSkin(rest, *rest.model)).triangles;
}

// A block falls on another one, which stands on a held layer, a little turned and aside.
struct Fall {
  SceneParams scene;
  cloud::PointCloud cloud;
  Index first = 0;  // point of the falling block
};
Fall makeFall(Type type, double jitter, unsigned seed) {
  Fall fall;
  fall.scene = makeScene(type);
  fall.scene.material.damping = 20.0;
  fall.scene.gravity = Vec3(0.0, 0.0, -9.81);
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(1.0, 1.0, 0.1 * kSpacing);
  fall.scene.pins.push_back(pin);
  Points falling = makeBlock(5, 4, Vec3::Zero(), jitter, seed + 1);
  const Mat3 turn = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
  for (Vec3& p : falling) p = turn * p + Vec3(0.021, 0.013, 0.03 + 0.028);
  const Points standing = makeBlock(7, 4, Vec3::Zero(), jitter, seed);
  fall.first = static_cast<Index>(standing.size());
  fall.cloud = join(standing, falling);
  return fall;
}

double weigh(const Fall& fall, const Simulation& s) {
  const std::vector<double>& masses = s.model().masses();
  return 9.81 * std::accumulate(masses.begin() + fall.first, masses.end(), 0.0);
}

// Upward, of the standing block on the falling one.
double sumContact(const Fall& fall, const Simulation& s) {
  double sum = 0.0;
  for (const simulation::SelfTouch& touch : s.selfTouches())
    sum += (touch.points[0] >= fall.first ? 1.0 : -1.0) * touch.force.z();
  return sum;
}

TEST(SolidContact, AFallingBlockComesToRestOnAnother) {
  for (const Type type : {Type::kVerlet, Type::kImplicit})
    for (const double jitter : {0.0, 0.2}) {
      Fall fall = makeFall(type, jitter, 3);
      const std::vector<contact::Triangle> skin = findSkin(fall.scene, fall.cloud);
      Simulation s(fall.scene, fall.cloud);
      for (int k = 0; k < 160; ++k) {
        const simulation::StepOutcome outcome = s.step();
        ASSERT_TRUE(outcome.ok) << outcome.problem;
        if (k % 4 == 0) ASSERT_TRUE(findCrossings(s.state().positions, skin).empty()) << k;
      }
      // It holds the weight, and parts are no nearer than half of the thickness, a tenth of the spacing.
      EXPECT_NEAR(sumContact(fall, s), weigh(fall, s), 0.02 * weigh(fall, s));
      EXPECT_GT(s.statistics().self_distance, 0.1 * kSpacing);
      fall.scene.contact.self = false;
      Simulation through(fall.scene, fall.cloud);
      for (int k = 0; k < 25; ++k) ASSERT_TRUE(through.step().ok);
      EXPECT_FALSE(findCrossings(through.state().positions, skin).empty());
    }
}

TEST(SolidContact, EquilibriaOfPartsThatOnlyRestOnOthersAreToldBeforeTheirSearch) {
  const auto isTold = [](const Fall& fall) {
    const std::vector<std::string> notes = Simulation(fall.scene, fall.cloud).buildNotes();
    return std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.find("1 of 2 parts, which can only rest on others") != std::string::npos;
    });
  };
  Fall fall = makeFall(Type::kStatic, 0.0, 3);
  EXPECT_TRUE(isTold(fall));
  fall.scene.contact.self = {};
  EXPECT_FALSE(isTold(fall));  // it is off
  fall.scene.contact.self = true;
  fall.scene.integrator.type = Type::kImplicit;
  EXPECT_FALSE(isTold(fall));
  fall.scene.integrator.type = Type::kStatic;
  fall.scene.pins.front().region.max = Vec3(1.0, 1.0, 1.0);  // all
  EXPECT_FALSE(isTold(fall));
}

TEST(SolidContact, IsOnByDefault) {
  for (const Type type : {Type::kVerlet, Type::kImplicit}) {
    Fall fall = makeFall(type, 0.2, 3);
    Simulation chosen(fall.scene, fall.cloud);
    fall.scene.contact.self = {};
    Simulation by_default(fall.scene, fall.cloud);
    const std::vector<contact::Triangle> skin = findSkin(fall.scene, fall.cloud);
    std::size_t most = 0;
    for (int k = 0; k < 25; ++k) {
      ASSERT_TRUE(chosen.step().ok);
      ASSERT_TRUE(by_default.step().ok);
      ASSERT_TRUE(findCrossings(by_default.state().positions, skin).empty()) << k;
      most = std::max<std::size_t>(most, by_default.statistics().self_contacts);
    }
    EXPECT_EQ(by_default.stateHash(), chosen.stateHash());
    EXPECT_GT(most, 10u);
  }
}

// What is stopped short, and what then loses energy, is the whole body.
TEST(SolidContact, PointsWithinABodyBelongToThePartThatIsStopped) {
  const Points lower = makeBlock(4, 4, Vec3::Zero(), 0.1, 1), upper = makeBlock(4, 4, Vec3(0.0, 0.0, 0.1), 0.1, 2);
  const simulation::RestSurface rest = simulation::buildRestSurface(makeScene(), join(lower, upper));
  const auto skin = std::make_shared<const simulation::ContactSkin>(
      rest.points, simulation::findModel("elastic_solid").findSkin(rest, *rest.model));
  contact::SelfContactParams params;
  params.thickness = 0.2 * kSpacing;
  const simulation::SelfContactLoads loads(rest.points, skin, *rest.model, params);
  const std::vector<Index>& parts = loads.limit.parts();
  for (std::size_t i = 0; i < parts.size(); ++i) EXPECT_EQ(parts[i], parts[i < lower.size() ? 0 : lower.size()]) << i;
  EXPECT_NE(parts.front(), parts.back());
}

// Without gravity and damping, and so slowly that no point is stopped.
TEST(SolidContact, BlocksThatCollideKeepTheirMomentumAndGainNoEnergy) {
  SceneParams scene = makeScene();
  const cloud::PointCloud cloud = join(makeBlock(5, 5, Vec3::Zero(), 0.2, 1), makeBlock(5, 4, Vec3(0.012, 0.009, 0.07), 0.2, 2));
  Simulation s(scene, cloud);
  model::State state = s.state();
  for (std::size_t i = 125; i < cloud.positions.size(); ++i) state.velocities[i] = Vec3(0.02, 0.0, -0.2);
  s.setState(state);
  const auto momentum = [&] {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) sum += s.model().masses()[i] * s.state().velocities[i];
    return sum;
  };
  const auto energy = [&] { return s.statistics().kinetic_energy + s.statistics().elastic_energy; };
  const Vec3 before = momentum();
  const double begun = energy();
  Index most = 0;
  for (int k = 0; k < 80; ++k) {
    ASSERT_TRUE(s.step().ok);
    EXPECT_EQ(s.statistics().stopped_points, 0u);
    most = std::max(most, static_cast<Index>(s.statistics().self_contacts));
    if (s.statistics().self_contacts == 0) EXPECT_LT(energy(), 1.01 * begun) << k;
  }
  EXPECT_GT(most, 20);
  EXPECT_EQ(s.statistics().self_contacts, 0u);
  EXPECT_LT((momentum() - before).norm(), 1e-9 * before.norm());
}

TEST(SolidContact, HasTheSameBitsOnAnyNumberOfThreadsAndFromASnapshot) {
  const Fall fall = makeFall(Type::kVerlet, 0.2, 5);
  const auto run = [&](int threads) {
    setNumThreads(threads);
    Simulation s(fall.scene, fall.cloud);
    for (int k = 0; k < 40; ++k) EXPECT_TRUE(s.step().ok);
    return s.state().positions;
  };
  const Points one = run(1);
  EXPECT_EQ(one, run(3));
  setNumThreads(0);
  Simulation first(fall.scene, fall.cloud), second(fall.scene, fall.cloud);
  for (int k = 0; k < 25; ++k) first.step();
  second.restore(first.snapshot());
  for (int k = 0; k < 15; ++k) {
    first.step();
    second.step();
  }
  EXPECT_EQ(first.state().positions, one);
  EXPECT_EQ(second.state().positions, one);
}

// Two balls in one cloud: only their surfaces are given.
TEST(SolidContact, FilledSurfacesTouchToo) {
  SceneParams scene = makeScene();
  scene.elastic_solid.fill = true;
  Points one = makeSphere(300, 0.05).points, other = one;
  for (Vec3& p : other) p += Vec3(0.01, 0.02, 0.125);
  const cloud::PointCloud cloud = join(one, other);
  const std::vector<contact::Triangle> skin = findSkin(scene, cloud);
  Simulation s(scene, cloud);
  model::State state = s.state();
  for (std::size_t i = 0; i < state.positions.size(); ++i)
    if (state.positions[i].z() > 0.06) state.velocities[i].z() = -1.0;
  s.setState(state);
  Index most = 0;
  for (int k = 0; k < 30; ++k) {
    ASSERT_TRUE(s.step().ok);
    ASSERT_TRUE(findCrossings(s.state().positions, skin).empty()) << k;
    most = std::max(most, static_cast<Index>(s.statistics().self_contacts));
  }
  EXPECT_GT(most, 3);
}

TEST(SolidContact, PlanarSolidsAreRefused) {
  SceneParams scene = makeScene();
  cloud::PointCloud plate;
  plate.positions = makeBox(8, 8, 1, kSpacing, 0.0);
  try {
    Simulation s(scene, plate);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("contact.self: found true with a planar solid"), std::string::npos);
  }
}

TEST(SolidContact, ThatTheEstimateIsNoUseOncePartsHaveMetIsToldOnce) {
  Fall fall = makeFall(Type::kVerlet, 0.1, 5);
  fall.scene.accuracy.estimate = true;
  Simulation s(fall.scene, fall.cloud);
  Index touched = 0;
  int num_told = 0;
  for (int k = 0; k < 40; ++k) {
    const simulation::StepOutcome outcome = s.step();
    ASSERT_TRUE(outcome.ok) << outcome.problem;
    touched = std::max(touched, static_cast<Index>(s.statistics().self_contacts));
    num_told += outcome.notice.find("parts of the body have met") != std::string::npos;
    EXPECT_EQ(num_told, touched > 0 ? 1 : 0) << k;
  }
  EXPECT_EQ(num_told, 1);
}

}  // namespace
}  // namespace deformable_surface::test
