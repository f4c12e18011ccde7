// The status of the last command to each tool, as published for its sender.
#include "../../../src/ros/node/tool_statuses.h"

#include "deformable_surface/ros/convert/tool_decoder.h"

#include <gtest/gtest.h>

namespace deformable_surface::node {
namespace {

Tool makeCommand(const std::string& id, std::uint8_t action = Tool::ADD, std::uint32_t sequence = 0) {
  Tool tool;
  tool.id = id;
  tool.action = action;
  tool.header.seq = sequence;
  return tool;
}

TEST(ToolStatuses, AreNewsOnceAndTellTheLastCommandOfEachTool) {
  ToolStatuses statuses;
  ToolStatusArray told;
  EXPECT_TRUE(statuses.takeChanged(told));  // the first message, without tools
  EXPECT_TRUE(told.tools.empty());
  EXPECT_FALSE(statuses.takeChanged(told));

  statuses.reportWaiting(makeCommand("ball", Tool::ADD, 6), "its step has not come yet");
  statuses.reportAccepted(makeCommand("ball", Tool::ADD, 7), 12);
  statuses.reportRefused(makeCommand("anvil", Tool::DELETE), "there is no such tool");
  ASSERT_TRUE(statuses.takeChanged(told));
  ASSERT_EQ(told.tools.size(), 2u);
  EXPECT_EQ(told.tools[0].id, "anvil");
  EXPECT_EQ(told.tools[0].status, int{ToolStatus::REFUSED});
  EXPECT_EQ(told.tools[0].action, int{Tool::DELETE});
  EXPECT_EQ(told.tools[0].message, "there is no such tool");
  EXPECT_EQ(told.tools[1].id, "ball");
  EXPECT_EQ(told.tools[1].status, int{ToolStatus::ACCEPTED});
  EXPECT_EQ(told.tools[1].header.seq, 7u);
  EXPECT_EQ(told.tools[1].message, "");
  EXPECT_EQ(told.tools[1].step, 12u);
  EXPECT_FALSE(statuses.takeChanged(told));
}

TEST(ToolStatuses, AreGoneWithTheTools) {
  ToolStatuses statuses;
  ToolStatusArray told;
  statuses.reportAccepted(makeCommand("ball"), 0);
  statuses.reportAccepted(makeCommand("", Tool::DELETEALL), 3);
  ASSERT_TRUE(statuses.takeChanged(told));
  ASSERT_EQ(told.tools.size(), 1u);
  EXPECT_EQ(told.tools[0].id, "");
  EXPECT_EQ(told.tools[0].action, int{Tool::DELETEALL});
  statuses.clear();
  ASSERT_TRUE(statuses.takeChanged(told));
  EXPECT_TRUE(told.tools.empty());
  statuses.clear();
  EXPECT_FALSE(statuses.takeChanged(told));
}

TEST(ToolStatuses, AreNoMoreThanToolsCanBeWhateverIsSent) {
  ToolStatuses statuses;
  ToolStatusArray told;
  for (int k = 0; k < 1000; ++k) statuses.reportRefused(makeCommand("tool " + std::string(k, 'x')), "no name");
  statuses.reportAccepted(makeCommand("ball"), 0);
  ASSERT_TRUE(statuses.takeChanged(told));
  EXPECT_LE(told.tools.size(), kMaxTools);
  for (const ToolStatus& status : told.tools) EXPECT_LE(status.id.size(), 64u);
  EXPECT_EQ(told.tools[0].id, "ball");  // the newest is kept
}

}  // namespace
}  // namespace deformable_surface::node
