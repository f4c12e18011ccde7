// Loops over fixed blocks: results, and the order of sums, do not depend on the number of threads.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>

namespace deformable_surface {

/// Number of threads of loops that the calling thread starts; 0 = all cores, as before the first call. The setting belongs to
/// the thread: two surfaces in one process, each stepped by its own thread, keep their own settings.
void setNumThreads(int num_threads);
int numThreads();

namespace internal {
/// Calls run(context, block) for block = 0 .. num_blocks - 1 on the pool's threads and the caller's; returns when all are done.
/// An exception in a block is rethrown here (that of the lowest block). Nested calls run in the calling thread. Nothing is
/// allocated.
void runBlocks(Index num_blocks, void (*run)(const void* context, Index block), const void* context);

template <class Run>
void runBlocks(Index num_blocks, const Run& run) {
  runBlocks(
      num_blocks, [](const void* context, Index block) { (*static_cast<const Run*>(context))(block); }, &run);
}
}  // namespace internal

/// Calls body(begin, end) on the blocks [0, block), [block, 2 block), ... of [0, n). The body writes only to elements of its
/// own indices. A single block runs in the calling thread, so small loops cost nothing.
template <class Body>
void parallelFor(Index n, Index block, const Body& body) {
  if (n <= block) {
    if (n > 0) body(Index{0}, n);
    return;
  }
  const Index num_blocks = (n - 1) / block + 1;
  internal::runBlocks(num_blocks, [&](Index b) { body(b * block, b + 1 == num_blocks ? n : (b + 1) * block); });
}

/// Sum of body(begin, end) over the blocks, added in the order of the blocks.
template <class Body>
double parallelSum(Index n, Index block, const Body& body) {
  if (n <= block) return n > 0 ? body(Index{0}, n) : 0.0;
  const Index num_blocks = (n - 1) / block + 1;
  constexpr Index kAtOnce = 256;  // blocks whose sums fit on the stack
  double part[kAtOnce], sum = 0.0;
  for (Index first = 0; first < num_blocks; first += kAtOnce) {
    const Index count = std::min(kAtOnce, num_blocks - first);
    internal::runBlocks(count, [&](Index k) {
      const Index b = first + k;
      part[k] = body(b * block, b + 1 == num_blocks ? n : (b + 1) * block);
    });
    for (Index k = 0; k < count; ++k) sum += part[k];
  }
  return sum;
}

}  // namespace deformable_surface
