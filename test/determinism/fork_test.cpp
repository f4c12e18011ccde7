// A fork continues as the original simulation would, bit for bit, whatever happens to either of them.
#include "../simulation/clouds.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>

namespace deformable_surface::test {
namespace {

using simulation::Simulation;
using solve::IntegratorType;

constexpr int kSteps = 5;

simulation::SceneParams sceneFor(IntegratorType type) {
  simulation::SceneParams p = hangingSheet();
  p.integrator.type = type;
  p.forces.push_back({"begins later", Vec3(1.0, 0.2, 0.0), Vec3(0.3, 0.0, 0.4), 0.3, 0.04, 0.2});
  return p;
}

tool::ToolParams makeBall() {
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = 0.2;
  ball.path = {{0.0, Vec3(0.5, 0.0, -0.25), Vec4(0, 0, 0, 1)}, {0.2, Vec3(0.5, 0.0, -0.15), Vec4(0, 0, 0, 1)}};
  return ball;
}

// The bits of everything that a planner reads: state, estimate, energy, full surface.
std::vector<std::uint64_t> listBits(Simulation& s) {
  std::vector<std::uint64_t> bits;
  const auto add = [&](double value) {
    bits.push_back(0);
    std::memcpy(&bits.back(), &value, sizeof value);
  };
  for (int k = 0; k < kSteps; ++k) {
    run(s, 1);
    const simulation::Statistics now = s.statistics();
    bits.push_back(now.state_hash);
    add(now.error_estimate);
    add(now.elastic_energy);
    for (const simulation::ToolReaction& reaction : s.toolReactions()) add(reaction.force.norm());
  }
  for (const Vec3& p : s.surface(true).positions) add(p.sum());
  return bits;
}

void checkFork(const simulation::SceneParams& p) {
  Simulation original(p, sheetCloud());
  original.setTool(makeBall());
  run(original, 2);
  original.setForce({"pull", Vec3(1.0, 0.0, 0.0), Vec3(0.5, 0.0, 0.2), 0.2, 0.0, 0.08});
  run(original, 2);
  const simulation::Snapshot before = original.snapshot();
  const std::uint64_t hash = original.stateHash();

  Simulation fork = original.fork(), disturbed = original.fork();
  EXPECT_EQ(fork.stateHash(), hash);
  disturbed.setGravity(Vec3(0.0, 30.0, 0.0));
  disturbed.removeTool("ball");
  disturbed.pin({geometry::Region::Kind::kSphere, {}, {}, Vec3(1.0, 0.5, 0.0), 0.5});
  run(disturbed, 2);
  EXPECT_EQ(original.stateHash(), hash);
  const std::vector<std::uint64_t> expected = listBits(original);
  EXPECT_EQ(listBits(fork), expected);
  EXPECT_NE(listBits(disturbed), expected);

  // Snapshots are interchangeable between the two.
  fork.restore(before);
  EXPECT_EQ(listBits(fork), expected);
  original.restore(fork.fork().snapshot());
  EXPECT_EQ(original.stateHash(), fork.stateHash());
}

TEST(Fork, GoesOnBitForBitWithEveryMethod) {
  for (IntegratorType type :
       {IntegratorType::kAuto, IntegratorType::kVerlet, IntegratorType::kImplicit, IntegratorType::kStatic}) {
    SCOPED_TRACE(static_cast<int>(type));
    checkFork(sceneFor(type));
  }
}

TEST(Fork, OfOrientedParticlesGoesOnBitForBit) {
  simulation::SceneParams p = sceneFor(IntegratorType::kAuto);
  p.model = "oriented_particles";
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.material.bending_rigidity = 0.05;
  p.material.damping = 5.0;
  checkFork(p);
}

TEST(Fork, InsertedPointsGoAlong) {
  simulation::SceneParams p = sceneFor(IntegratorType::kAuto);
  p.output.resample = true;
  p.forces.push_back({"stretch", Vec3(1.0, 0.0, 0.0), Vec3(300.0, 0.0, 0.0), 0.3, 0.0, 1e300});
  Simulation s(p, sheetCloud());
  const std::size_t input = s.surface(false).positions.size();
  for (int k = 0; k < 60 && s.surface(false).positions.size() == input; ++k) run(s, 1);
  ASSERT_GT(s.surface(false).positions.size(), input) << "nothing was inserted";
  Simulation fork = s.fork();
  EXPECT_EQ(fork.surface(false).positions, s.surface(false).positions);
  EXPECT_EQ(listBits(fork), listBits(s));
}

TEST(Fork, SeveralMayRunAtOnceInThreadsOfTheirOwn) {
  setNumThreads(1);
  Simulation original(sceneFor(IntegratorType::kAuto), sheetCloud());
  run(original, 3);
  std::vector<Simulation> forks;
  for (int k = 0; k < 4; ++k) forks.push_back(original.fork());
  std::vector<std::vector<std::uint64_t>> bits(forks.size());
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < forks.size(); ++k)
    threads.emplace_back([&, k] {
      setNumThreads(1 + static_cast<int>(k) % 2);
      bits[k] = listBits(forks[k]);
    });
  const std::vector<std::uint64_t> expected = listBits(original);
  for (std::thread& thread : threads) thread.join();
  for (const auto& of_one : bits) EXPECT_EQ(of_one, expected);
  setNumThreads(0);
}

TEST(Fork, OutlivesTheSimulationThatItWasMadeOf) {
  auto original = std::make_unique<Simulation>(sceneFor(IntegratorType::kAuto), sheetCloud());
  run(*original, 2);
  Simulation fork = original->fork();
  const std::vector<std::uint64_t> expected = listBits(*original);
  original.reset();
  EXPECT_EQ(listBits(fork), expected);
}

TEST(Fork, SnapshotsSayHowLargeTheyAre) {
  Simulation s(sceneFor(IntegratorType::kAuto), sheetCloud());
  run(s, 2);
  const simulation::Snapshot snapshot = s.snapshot();
  EXPECT_DOUBLE_EQ(snapshot.time(), s.time());
  // Positions and velocities at least, and the copies of the estimate, but not the cloud.
  EXPECT_GE(snapshot.bytes(), 48u * s.state().positions.size());
  EXPECT_EQ(simulation::Snapshot().bytes(), 0u);
}

TEST(Fork, OfAClosedSurfaceWhosePressureCameWhileItRanGoesOnBitForBit) {
  simulation::SceneParams p;
  p.gravity.setZero();
  p.material.damping = 5.0;
  p.simplification.target_points = 100;
  Simulation s(p, asCloud(makeSphere(600, 0.5).points));
  run(s, 3);
  p.pressure = 20.0;
  s.setParams(p);
  Simulation blown = s.fork();
  EXPECT_EQ(listBits(blown), listBits(s));
  p.pressure = 0.0;
  s.setParams(p);
  Simulation let_out = s.fork();
  EXPECT_EQ(listBits(let_out), listBits(s));
}

}  // namespace
}  // namespace deformable_surface::test
