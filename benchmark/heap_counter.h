// Counts what the whole process asks of the heap, Eigen's own allocations included: it stands in for malloc, so it is linked into
// the benchmark only.
#pragma once

#include <cstdint>

namespace deformable_surface::benchmark {

/// Counts from its construction to stop(); one at a time. Blocks of before that are freed meanwhile count as negative.
class HeapCounter {
 public:
  HeapCounter();
  ~HeapCounter() { stop(); }
  HeapCounter(const HeapCounter&) = delete;
  HeapCounter& operator=(const HeapCounter&) = delete;

  void stop();
  std::int64_t allocations() const;  // calls that asked for a block
  std::int64_t liveBytes() const;    // asked for and not given back, as the allocator rounds them
  std::int64_t peakBytes() const;    // the most that were live at once
  void resetPeak();                  // to what is live now
};

/// Bytes of this process that are in memory now, after the heap gave back what it does not use.
std::int64_t residentBytes();

}  // namespace deformable_surface::benchmark
