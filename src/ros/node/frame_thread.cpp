#include "frame_thread.h"

#include "deformable_surface/base/parallel.h"

#include <utility>

namespace deformable_surface::node {
namespace {

// Resets, single steps, new surfaces and subscribers come one by one; a burst of them must not fill the memory.
constexpr std::size_t kMostKept = 4;

}  // namespace

FrameThread::FrameThread(std::function<void(Moment&)> show, int num_threads)
    : show_(std::move(show)), thread_([this, num_threads] {
        setNumThreads(num_threads);
        run();
      }) {}

FrameThread::~FrameThread() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ended_ = true;
  }
  came_.notify_all();
  left_.notify_all();
  shown_.notify_all();
  thread_.join();
}

void FrameThread::show(Moment&& moment) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (!waiting_.empty() && !waiting_.back().is_kept) {
    waiting_.pop_back();
    ++num_dropped_;
  }
  if (moment.is_kept) left_.wait(lock, [this] { return is_ended_ || waiting_.size() < kMostKept; });
  if (moment.is_result) ++num_results_;
  waiting_.push_back(std::move(moment));
  came_.notify_one();
}

void FrameThread::waitForResult() {
  std::unique_lock<std::mutex> lock(mutex_);
  shown_.wait(lock, [this, given = num_results_] { return is_ended_ || num_results_shown_ >= given; });
}

int FrameThread::numDropped() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return num_dropped_;
}

void FrameThread::run() {
  for (;;) {
    Moment moment;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      came_.wait(lock, [this] { return is_ended_ || !waiting_.empty(); });
      if (is_ended_) return;
      moment = std::move(waiting_.front());
      waiting_.pop_front();
    }
    left_.notify_one();
    show_(moment);
    if (!moment.is_result) continue;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++num_results_shown_;
    }
    shown_.notify_all();
  }
}

}  // namespace deformable_surface::node
