// Ends work from outside without a parameter in every function on the way: the interrupt belongs to the thread that works,
// and the loops of base/parallel.h check it.
#pragma once

#include <atomic>
#include <exception>

namespace deformable_surface {

/// The work was ended from outside.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "was interrupted"; }
};

/// While this object lives, work of the thread that made it ends with Interrupted soon after the flag has become true: before the
/// next loop of base/parallel.h, between two of its blocks, or at endIfInterrupted(). Changes that the work has made stay:
/// the code that catches Interrupted undoes them, as a step does (Dynamics::takeStep()).
class InterruptScope {
 public:
  explicit InterruptScope(const std::atomic<bool>& flag);
  ~InterruptScope();
  InterruptScope(const InterruptScope&) = delete;
  InterruptScope& operator=(const InterruptScope&) = delete;

 private:
  const std::atomic<bool>* before_;
};

/// The flag of the calling thread's innermost scope; null without a scope.
const std::atomic<bool>* currentInterrupt();
/// Throws Interrupted if that flag is true.
void endIfInterrupted();
/// The same in every `rounds`-th round of a loop, from the first.
template <class Integer>
void endIfInterrupted(Integer round, Integer rounds) {
  if (round % rounds == 0) endIfInterrupted();
}

/// For tests: counts the checks of an interrupt in the thread that made it, and sets the flag at one of them.
class LookCounter {
 public:
  /// at: the number of that check, from 1; 0: never.
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
