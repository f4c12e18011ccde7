// How long work is ended from outside without every function on the way being told: the thread that does it knows, and the loops
// of base/parallel.h look.
#pragma once

#include <atomic>
#include <exception>

namespace deformable_surface {

/// The work was ended from outside.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "was interrupted"; }
};

/// While it lives, the work of the thread that made it ends with Interrupted soon after the flag has become true: before the next
/// loop of base/parallel.h, between two of its blocks, or where endIfInterrupted() is called. What the work has changed stays
/// changed: who catches Interrupted gives it back, as a step does (Dynamics::takeStep()).
class InterruptScope {
 public:
  explicit InterruptScope(const std::atomic<bool>& flag);
  ~InterruptScope();
  InterruptScope(const InterruptScope&) = delete;
  InterruptScope& operator=(const InterruptScope&) = delete;

 private:
  const std::atomic<bool>* before_;
};

/// The flag of the calling thread's innermost scope; null outside of all.
const std::atomic<bool>* currentInterrupt();
/// Throws Interrupted if that is true.
void endIfInterrupted();
/// The same in the first of so many rounds of a loop.
template <class Integer>
void endIfInterrupted(Integer round, Integer rounds) {
  if (round % rounds == 0) endIfInterrupted();
}

/// For tests: counts the looks at an interrupt in the thread that made it, and makes the flag true at one of them.
class LookCounter {
 public:
  /// at: the number of that look, from 1; 0: never.
  explicit LookCounter(std::atomic<bool>& flag, long at = 0);
  ~LookCounter();
  LookCounter(const LookCounter&) = delete;
  LookCounter& operator=(const LookCounter&) = delete;
  long count() const { return count_; }

 private:
  friend void endIfInterrupted();
  std::atomic<bool>& flag_;
  const long at_;
  long count_ = 0;
};

}  // namespace deformable_surface
