#include "deformable_surface/base/parallel.h"

#include "deformable_surface/base/interrupt.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace deformable_surface {
namespace {

// Threads that wait for a job and take its blocks one by one from a shared counter. As many as the largest job so far needed.
class Pool {
 public:
  ~Pool() {
    {
      std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& worker : workers_) worker.join();
  }

  void run(int num_helpers, Index num_blocks, void (*block)(const void*, Index), const void* context) {
    while (static_cast<int>(workers_.size()) < num_helpers) {
      workers_.emplace_back([this, rank = static_cast<int>(workers_.size()), seen = job_] { work(rank, seen); });
    }
    {
      std::lock_guard<std::mutex> lock(mutex_);
      block_ = block;
      context_ = context;
      interrupt_ = currentInterrupt();
      num_blocks_ = num_blocks;
      next_ = 0;
      failed_block_ = num_blocks;
      helpers_ = busy_ = num_helpers;
      ++job_;
    }
    wake_.notify_all();
    takeBlocks();
    std::unique_lock<std::mutex> lock(mutex_);
    done_.wait(lock, [this] { return busy_ == 0; });
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    endIfInterrupted();
  }

 private:
  void work(int rank, long seen) {
    for (;;) {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        // A job ends only when all its helpers are done, so that none of them can miss it.
        wake_.wait(lock, [&] { return stop_ || (job_ != seen && rank < helpers_); });
        if (stop_) return;
        seen = job_;
      }
      takeBlocks();
      {
        std::lock_guard<std::mutex> lock(mutex_);
        --busy_;
      }
      done_.notify_one();
    }
  }

  void takeBlocks();

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  void (*block_)(const void*, Index) = nullptr;
  const void* context_ = nullptr;
  const std::atomic<bool>* interrupt_ = nullptr;  // of the thread that began the job: no more blocks once it is true
  Index num_blocks_ = 0;
  std::atomic<Index> next_{0};
  int helpers_ = 0;  // of the job: the number of workers that take part
  int busy_ = 0;
  long job_ = 0;
  bool stop_ = false;
  std::exception_ptr failure_;
  Index failed_block_ = 0;
};

thread_local bool inside_block = false;

void Pool::takeBlocks() {
  inside_block = true;
  for (Index b = next_++; b < num_blocks_ && !(interrupt_ && *interrupt_); b = next_++) {
    try {
      block_(context_, b);
    } catch (...) {
      std::lock_guard<std::mutex> lock(mutex_);
      if (b < failed_block_) {
        failed_block_ = b;
        failure_ = std::current_exception();
      }
    }
  }
  inside_block = false;
}

std::mutex pool_mutex;  // one job at a time: if the pool is busy, the caller runs its own blocks instead of waiting
Pool pool;
thread_local int num_threads = 0;

}  // namespace

void setNumThreads(int n) { num_threads = std::max(0, n); }

int numThreads() {
  static const int num_cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return num_threads > 0 ? num_threads : num_cores;
}

void internal::runBlocks(Index num_blocks, void (*run)(const void* context, Index block), const void* context) {
  const int num_helpers = inside_block ? 0 : numThreads() - 1;
  if (num_helpers > 0) {
    const std::unique_lock<std::mutex> lock(pool_mutex, std::try_to_lock);
    if (lock.owns_lock()) return pool.run(num_helpers, num_blocks, run, context);
  }
  for (Index b = 0; b < num_blocks; ++b) {
    endIfInterrupted();
    run(context, b);
  }
}

}  // namespace deformable_surface
