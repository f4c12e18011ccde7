// Counts the heap calls of the whole process, including Eigen's. It replaces malloc, so it is linked into the benchmark only.
#pragma once

#include <cstdint>

namespace deformable_surface::benchmark {

/// Counts from its construction to stop(); one at a time. Older blocks that are freed meanwhile count as negative.
class HeapCounter {
 public:
  HeapCounter();
  ~HeapCounter() { stop(); }
  HeapCounter(const HeapCounter&) = delete;
  HeapCounter& operator=(const HeapCounter&) = delete;

  void stop();
  std::int64_t allocations() const;  // calls that asked for a block
  std::int64_t liveBytes() const;    // requested and not freed, as rounded by the allocator
  std::int64_t peakBytes() const;    // the most that were live at once
  void resetPeak();                  // to the blocks that are live now
};

/// Bytes of this process in memory, after the heap has returned its unused memory.
std::int64_t residentBytes();

}  // namespace deformable_surface::benchmark
