// An error of the program in one command neither repeats nor loses the others: memory ends at each place in turn.
#include "../../../src/ros/node/pending_commands.h"

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

#include <cstdlib>
#include <new>
#include <utility>
#include <vector>

#include "../../support/surfaces.h"

namespace {
thread_local long allocations_left = -1;  // negative: as many as there is memory for
}

void* operator new(std::size_t size) {
  if (allocations_left >= 0 && allocations_left-- == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace deformable_surface::node {
namespace {

constexpr std::int64_t kStep = 10'000'000;  // ns

simulation::SceneParams makeScene() {
  simulation::SceneParams scene;
  scene.model = "mass_spring";
  scene.accuracy.estimate = false;
  return scene;
}

std::vector<Command> makeForces(const std::vector<std::string>& ids, const std::string& frame) {
  std::vector<Command> commands;
  for (const std::string& id : ids) {
    auto force = boost::make_shared<PointForce>();
    force->header.frame_id = frame;
    force->id = id;
    force->force.z = 1.0;
    Command command;
    command.force = force;
    commands.push_back(std::move(command));
  }
  return commands;
}

TEST(PendingCommands, AnErrorInOneNeitherRepeatsNorLosesTheOthers) {
  cloud::PointCloud cloud;
  cloud.positions = test::makeSheet(8, 8, 1.0, 1.0).points;
  const simulation::SceneParams scene = makeScene();
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "map";
  transform.child_frame_id = "camera";
  transform.transform.rotation.w = 1.0;
  WarningLog warnings("test");
  bool has_failed = true;
  int num_failed = 0;
  for (long allocations = 0; has_failed; ++allocations) {
    SCOPED_TRACE(allocations);
    simulation::Simulation simulation(scene, cloud);
    tf2::BufferCore transforms;
    PendingCommands commands(scene.force, scene.input, transforms, warnings);
    commands.setSurfaceFrame("map");
    commands.append(makeForces({"a", "b", "c"}, "camera"));
    commands.apply(0, kStep, simulation, "map");
    ASSERT_EQ(commands.numWaiting(), 3);  // for their transform
    transforms.setTransform(transform, "test", true);
    commands.append(makeForces({"d", "e", "f"}, "map"));

    has_failed = false;
    allocations_left = allocations;
    try {
      commands.apply(kStep, 2 * kStep, simulation, "map");
    } catch (const std::bad_alloc&) {
      has_failed = true;
    }
    allocations_left = -1;
    num_failed += has_failed;
    commands.apply(2 * kStep, 3 * kStep, simulation, "map");
    EXPECT_EQ(commands.numWaiting(), 0);
    EXPECT_LE(commands.numApplied(), 6u);
    EXPECT_GE(commands.numApplied(), has_failed ? 5u : 6u);
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(num_failed, 6);
}

}  // namespace
}  // namespace deformable_surface::node
