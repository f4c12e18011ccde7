// Work for the simulation thread: when it ends a running step.
#include "../../../src/ros/node/inbox.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

class InboxTest : public ::testing::Test {
 protected:
  tf2::BufferCore transforms_;
  // Nobody waits: work that is not done at once is given up.
  Inbox inbox_{true, transforms_, std::chrono::milliseconds(0)};
};

TEST_F(InboxTest, AStepThatHasBegunToEndEndsThoughTheCallHasGivenUp) {
  const auto nothing = [] {};
  EXPECT_FALSE(*inbox_.endingStep());
  EXPECT_NE(inbox_.perform(nothing, true).find("busy"), std::string::npos);
  EXPECT_TRUE(*inbox_.endingStep());
  EXPECT_NE(inbox_.perform(nothing).find("busy"), std::string::npos);
  EXPECT_TRUE(*inbox_.endingStep());
  inbox_.doJobs();  // the step has ended
  EXPECT_FALSE(*inbox_.endingStep());
}

TEST_F(InboxTest, OtherWorkEndsNoStep) {
  EXPECT_NE(inbox_.perform([] {}).find("busy"), std::string::npos);
  EXPECT_FALSE(*inbox_.endingStep());
}

}  // namespace
}  // namespace deformable_surface::node
