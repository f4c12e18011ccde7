#include "deformable_surface/base/interrupt.h"

namespace deformable_surface {
namespace {

thread_local const std::atomic<bool>* current = nullptr;
thread_local LookCounter* counter = nullptr;

}  // namespace

InterruptScope::InterruptScope(const std::atomic<bool>& flag) : before_(current) { current = &flag; }

InterruptScope::~InterruptScope() { current = before_; }

const std::atomic<bool>* currentInterrupt() { return current; }

LookCounter::LookCounter(std::atomic<bool>& flag, long at) : flag_(flag), at_(at) { counter = this; }

LookCounter::~LookCounter() { counter = nullptr; }

void endIfInterrupted() {
  if (!current) return;
  if (counter && ++counter->count_ == counter->at_) counter->flag_ = true;
  if (*current) throw Interrupted();
}

}  // namespace deformable_surface
