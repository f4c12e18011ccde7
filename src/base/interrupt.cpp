#include "deformable_surface/base/interrupt.h"

namespace deformable_surface {
namespace {

thread_local const std::atomic<bool>* current = nullptr;

}  // namespace

InterruptScope::InterruptScope(const std::atomic<bool>& flag) : before_(current) { current = &flag; }

InterruptScope::~InterruptScope() { current = before_; }

const std::atomic<bool>* currentInterrupt() { return current; }

void endIfInterrupted() {
  if (current && *current) throw Interrupted();
}

}  // namespace deformable_surface
