// Tools that have changed since the last check, and the points that this can affect.
#include "../../src/simulation/tool_watch.h"

#include <gtest/gtest.h>

namespace deformable_surface::simulation {
namespace {

tool::ToolParams makeBall(const std::string& id, const Vec3& from, const Vec3& to) {
  tool::ToolParams ball;
  ball.id = id;
  ball.shape.kind = geometry::Solid::Kind::kSphere;
  ball.shape.radius = 0.1;
  const Vec4 upright(0.0, 0.0, 0.0, 1.0);
  ball.path = {{0.0, from, upright}, {1.0, to, upright}};
  return ball;
}

TEST(ToolWatch, SeesWhatIsNewMovesOrGoesAndNothingElse) {
  ToolWatch watch;
  const tool::ToolParams still = makeBall("still", Vec3(5.0, 0.0, 0.0), Vec3(5.0, 0.0, 0.0));
  const tool::ToolParams moving = makeBall("moving", Vec3::Zero(), Vec3(1.0, 0.0, 0.0));
  EXPECT_EQ(watch.look({still, moving}, 0.1, 0.1).size(), 2u) << "both are new";
  const auto& seen = watch.look({still, moving}, 0.2, 0.1);
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_TRUE(seen[0].contains(Vec3(0.29, 0.0, 0.0)));
  EXPECT_FALSE(seen[0].contains(Vec3(5.0, 0.0, 0.0)));
  watch.look({still, moving}, 1.0, 0.1);
  EXPECT_TRUE(watch.look({still, moving}, 1.1, 0.1).empty()) << "its path has ended";
  EXPECT_FALSE(watch.look({moving}, 1.2, 0.1).empty()) << "one is gone";
  EXPECT_TRUE(watch.look({moving}, 1.3, 0.1).empty());
}

TEST(ToolWatch, GoesOnFromItsMemory) {
  const tool::ToolParams still = makeBall("still", Vec3::Zero(), Vec3::Zero());
  ToolWatch watch, other;
  watch.look({still}, 0.1, 0.1);
  other.setMemory(watch.memory());
  EXPECT_TRUE(other.look({still}, 0.2, 0.1).empty());
  other.reset();
  EXPECT_EQ(other.look({still}, 0.3, 0.1).size(), 1u);
}

}  // namespace
}  // namespace deformable_surface::simulation
