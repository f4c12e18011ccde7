// States are handed to the publishing thread without waiting for it. The newest state is shown, states that must be kept are all
// shown, and the others are counted as dropped.
#include "../../../src/ros/node/frame_thread.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <vector>

namespace deformable_surface::node {
namespace {

/// Shows a state, identified by its stamp, when it is allowed to.
class Screen {
 public:
  void show(Moment& moment) {
    std::unique_lock<std::mutex> lock(mutex_);
    ++num_begun_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return num_let_ > 0; });
    --num_let_;
    shown_.push_back(moment.stamp);
    changed_.notify_all();
  }
  void let(int count) {
    const std::lock_guard<std::mutex> lock(mutex_);
    num_let_ += count;
    changed_.notify_all();
  }
  void waitUntilBegun(int count) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [&] { return num_begun_ >= count; });
  }
  std::vector<std::int64_t> waitFor(std::size_t count) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [&] { return shown_.size() >= count; });
    return shown_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int num_begun_ = 0, num_let_ = 0;
  std::vector<std::int64_t> shown_;
};

Moment makeMoment(std::int64_t stamp, bool is_kept = false) {
  Moment moment;
  moment.stamp = stamp;
  moment.is_kept = is_kept;
  return moment;
}

TEST(FrameThread, ShowsTheNewestAndNeverHoldsUpWhoHandsOver) {
  Screen screen;
  FrameThread frames([&](Moment& moment) { screen.show(moment); }, 1);
  frames.show(makeMoment(1));
  screen.waitUntilBegun(1);
  // The publishing thread is blocked: whoever waited for it would wait for ever.
  for (std::int64_t stamp = 2; stamp <= 100; ++stamp) frames.show(makeMoment(stamp));
  EXPECT_EQ(frames.numDropped(), 98);
  screen.let(2);
  EXPECT_EQ(screen.waitFor(2), (std::vector<std::int64_t>{1, 100}));
  EXPECT_EQ(frames.numDropped(), 98);
}

TEST(FrameThread, KeepsWhatIsToBeKept) {
  Screen screen;
  FrameThread frames([&](Moment& moment) { screen.show(moment); }, 1);
  frames.show(makeMoment(1));
  screen.waitUntilBegun(1);
  frames.show(makeMoment(2));
  frames.show(makeMoment(3, true));
  frames.show(makeMoment(4));
  frames.show(makeMoment(5));
  screen.let(3);
  EXPECT_EQ(screen.waitFor(3), (std::vector<std::int64_t>{1, 3, 5}));
  EXPECT_EQ(frames.numDropped(), 2);
}

TEST(FrameThread, AsManyAsAreToBeKeptWaitAndOneMore) {
  Screen screen;
  FrameThread frames([&](Moment& moment) { screen.show(moment); }, 1);
  frames.show(makeMoment(1));
  screen.waitUntilBegun(1);
  for (std::int64_t stamp = 2; stamp <= 5; ++stamp) frames.show(makeMoment(stamp, true));
  // These would wait for ever.
  frames.show(makeMoment(6));
  frames.show(makeMoment(7));
  screen.let(6);
  EXPECT_EQ(screen.waitFor(6), (std::vector<std::int64_t>{1, 2, 3, 4, 5, 7}));
  EXPECT_EQ(frames.numDropped(), 1);
}

TEST(FrameThread, EndsWhileMomentsWait) {
  Screen screen;
  {
    FrameThread frames([&](Moment& moment) { screen.show(moment); }, 1);
    frames.show(makeMoment(1, true));
    screen.waitUntilBegun(1);
    frames.show(makeMoment(2, true));
    screen.let(2);
  }
  EXPECT_EQ(screen.waitFor(1).front(), 1);
}

}  // namespace
}  // namespace deformable_surface::node
