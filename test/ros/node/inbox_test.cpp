// Work for the simulation thread: when it ends a running step, and who hears what it throws.
#include "../../../src/ros/node/inbox.h"

#include "deformable_surface/base/error.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <thread>

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
  EXPECT_THROW(inbox_.perform(nothing, true), InputError);
  EXPECT_TRUE(*inbox_.endingStep());
  EXPECT_THROW(inbox_.perform(nothing), InputError);
  EXPECT_TRUE(*inbox_.endingStep());
  inbox_.doJobs();  // the step has ended
  EXPECT_FALSE(*inbox_.endingStep());
}

TEST_F(InboxTest, OtherWorkEndsNoStep) {
  EXPECT_THROW(inbox_.perform([] {}), InputError);
  EXPECT_FALSE(*inbox_.endingStep());
}

TEST_F(InboxTest, WhatWorkThrowsIsThrownToItsCallerAndLaterWorkIsDone) {
  Inbox inbox(true, transforms_);
  std::string heard;
  std::thread caller([&] {
    try {
      inbox.perform([] { throw std::runtime_error("no memory"); });
    } catch (const std::runtime_error& error) {
      heard = error.what();
    }
    inbox.perform([&] { heard += ", done"; });
    inbox.close();
  });
  while (!inbox.isClosed()) {
    inbox.take(std::chrono::steady_clock::now() + std::chrono::seconds(1));
    inbox.doJobs();
  }
  caller.join();
  EXPECT_EQ(heard, "no memory, done");
}

TEST_F(InboxTest, WorkIsRefusedOnceItIsClosed) {
  inbox_.close();
  EXPECT_THROW(inbox_.perform([] {}), InputError);
}

}  // namespace
}  // namespace deformable_surface::node
