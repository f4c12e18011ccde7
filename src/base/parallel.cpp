#include "deformable_surface/base/parallel.h"

#include "deformable_surface/base/interrupt.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace deformable_surface {
namespace {

constexpr std::chrono::microseconds kSpin{50};  // longer than most work between two loops of a step
constexpr int kLooks = 64;                      // between two looks at the clock

int numCores() {
  static const int num_cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return num_cores;
}

// Tells the core that the thread only waits for another.
void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Threads that share the blocks of a job; as many as the largest job so far needed. Each has its own share, the same in every
// loop of as many blocks: so the data of a block stay in the cache of one core. A thread without blocks left helps the others.
//
// To wake a thread takes longer than a loop of a small surface does. So a worker looks for the next job for a while before it
// sleeps, and nobody waits for a worker that wakes late: it finds the job closed.
class Pool {
 public:
  ~Pool() {
    stop_ = true;
    for (const std::unique_ptr<Worker>& worker : workers_) wake(*worker);
    for (const std::unique_ptr<Worker>& worker : workers_) worker->thread.join();
  }

  void run(int num_helpers, Index num_blocks, void (*block)(const void*, Index), const void* context) {
    while (static_cast<int>(workers_.size()) < num_helpers) {
      auto worker = std::make_unique<Worker>(static_cast<int>(workers_.size()) + 1);
      workers_.reserve(workers_.size() + 1);  // a thread that runs must be joined in the end
      worker->thread = std::thread([this, worker = worker.get()] { work(*worker); });
      workers_.push_back(std::move(worker));
    }
    block_ = block;
    context_ = context;
    interrupt_ = currentInterrupt();
    while (static_cast<int>(shares_.size()) <= num_helpers) shares_.emplace_back();
    for (int rank = 0; rank <= num_helpers; ++rank) {
      shares_[rank].next = findBegin(num_blocks, rank, num_helpers + 1);
      shares_[rank].end = findBegin(num_blocks, rank + 1, num_helpers + 1);
    }
    failed_block_ = num_blocks;
    num_helpers_ = num_helpers;
    open_ = ++job_;
    for (int k = 0; k < num_helpers; ++k)
      if (workers_[k]->sleeps) wake(*workers_[k]);
    takeBlocks(0);
    open_ = 0;
    awaitWorkers();
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    endIfInterrupted();
  }

 private:
  struct Worker {
    explicit Worker(int number) : rank(number) {}
    const int rank;  // from 1; the caller has 0
    std::thread thread;
    std::mutex mutex;
    std::condition_variable wake;
    std::atomic<bool> sleeps{false};
  };

  struct alignas(64) Share {
    std::atomic<Index> next{0};
    Index end = 0;
  };

  static Index findBegin(Index num_blocks, int rank, int num_ranks) {
    return static_cast<Index>(static_cast<long>(num_blocks) * rank / num_ranks);
  }

  static void wake(Worker& worker) {
    { const std::lock_guard<std::mutex> lock(worker.mutex); }  // else it could fall asleep between its last look and the call
    worker.wake.notify_one();
  }

  // The order of operations on inside_, open_ and those that tell who sleeps is what makes this safe. The caller opens a job,
  // then looks who sleeps; it closes the job, then waits until nobody is inside. A worker goes to sleep, then looks at the job
  // once more; it goes inside, then looks whether the job is open. So they are sequentially consistent.
  void work(Worker& worker) {
    for (long seen = 0; awaitJob(worker, seen);) {
      ++inside_;
      const long job = open_;
      if (job != 0 && worker.rank <= num_helpers_) {
        takeBlocks(worker.rank);
        seen = job;
      }
      if (--inside_ == 0 && caller_sleeps_) {
        { const std::lock_guard<std::mutex> lock(caller_mutex_); }
        caller_wake_.notify_one();
      }
    }
  }

  // Until all have left the job. One that another program has driven off its core may get that of the caller, if this sleeps.
  void awaitWorkers() {
    for (int looks = 0; looks < kLooks * kLooks; ++looks) {
      if (inside_ == 0) return;
      relax();
    }
    std::unique_lock<std::mutex> lock(caller_mutex_);
    caller_sleeps_ = true;
    caller_wake_.wait(lock, [this] { return inside_ == 0; });
    caller_sleeps_ = false;
  }

  // A job other than the one that was seen last; false: the end.
  bool awaitJob(Worker& worker, long seen) {
    const auto isWanted = [&] {
      const long job = open_;
      return stop_ || (job != 0 && job != seen && worker.rank <= num_helpers_);
    };
    if (worker.rank < numCores()) {  // else it would take a core from one that works
      const auto end = std::chrono::steady_clock::now() + kSpin;
      do {
        for (int look = 0; look < kLooks; ++look) {
          if (isWanted()) return !stop_;
          relax();
        }
      } while (std::chrono::steady_clock::now() < end);
    }
    std::unique_lock<std::mutex> lock(worker.mutex);
    worker.sleeps = true;
    worker.wake.wait(lock, isWanted);
    worker.sleeps = false;
    return !stop_;
  }

  void takeBlocks(int rank);

  std::vector<std::unique_ptr<Worker>> workers_;
  void (*block_)(const void*, Index) = nullptr;
  const void* context_ = nullptr;
  const std::atomic<bool>* interrupt_ = nullptr;  // of the thread that began the job: no more blocks once it is true
  std::deque<Share> shares_;                      // of the caller and the workers
  long job_ = 0;
  std::mutex failure_mutex_;
  std::exception_ptr failure_;
  std::mutex caller_mutex_;
  std::condition_variable caller_wake_;
  std::atomic<bool> caller_sleeps_{false};
  Index failed_block_ = 0;
  // Each on a cache line of its own: the workers read the first while the blocks change the others.
  alignas(64) std::atomic<long> open_{0};  // the number of the job that workers may join; 0: none
  std::atomic<int> num_helpers_{0};        // workers up to this rank may join
  std::atomic<bool> stop_{false};
  alignas(64) std::atomic<int> inside_{0};  // workers that may read the job
};

thread_local bool inside_block = false;

void Pool::takeBlocks(int rank) {
  inside_block = true;
  const int num_ranks = num_helpers_ + 1;
  for (int k = 0; k < num_ranks; ++k) {
    Share& share = shares_[(rank + k) % num_ranks];
    for (Index b = share.next++; b < share.end && !(interrupt_ && *interrupt_); b = share.next++) {
      try {
        block_(context_, b);
      } catch (...) {
        std::lock_guard<std::mutex> lock(failure_mutex_);
        if (b < failed_block_) {
          failed_block_ = b;
          failure_ = std::current_exception();
        }
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

int numThreads() { return num_threads > 0 ? num_threads : numCores(); }

void internal::runBlocks(Index num_blocks, void (*run)(const void* context, Index block), const void* context) {
  const int num_helpers = inside_block ? 0 : static_cast<int>(std::min<Index>(numThreads(), num_blocks)) - 1;
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
