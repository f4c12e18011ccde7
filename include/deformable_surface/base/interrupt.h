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
/// loop of base/parallel.h, between two of its blocks, or where endIfInterrupted() is called. For work that is worth nothing
/// unless it is finished, as building a surface; a step, which leaves a state behind, is ended by Simulation::setInterrupt().
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

}  // namespace deformable_surface
