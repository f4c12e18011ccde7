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

namespace internal {
/// join(join(0, body(first block)), body(second block)) ..., in the order of the blocks.
template <class Body, class Join>
double joinBlocks(Index n, Index block, const Body& body, const Join& join) {
  if (n <= block) return n > 0 ? body(Index{0}, n) : 0.0;
  const Index num_blocks = (n - 1) / block + 1;
  constexpr Index kAtOnce = 256;  // blocks whose results fit on the stack
  double part[kAtOnce], joined = 0.0;
  for (Index first = 0; first < num_blocks; first += kAtOnce) {
    const Index count = std::min(kAtOnce, num_blocks - first);
    runBlocks(count, [&](Index k) {
      const Index b = first + k;
      part[k] = body(b * block, b + 1 == num_blocks ? n : (b + 1) * block);
    });
    for (Index k = 0; k < count; ++k) joined = join(joined, part[k]);
  }
  return joined;
}
}  // namespace internal

/// Sum of body(begin, end) over the blocks, added in the order of the blocks.
template <class Body>
double parallelSum(Index n, Index block, const Body& body) {
  return internal::joinBlocks(n, block, body, [](double a, double b) { return a + b; });
}

/// The largest of zero and body(begin, end) over the blocks.
template <class Body>
double parallelMax(Index n, Index block, const Body& body) {
  return std::max(0.0, internal::joinBlocks(n, block, body, [](double a, double b) { return std::max(a, b); }));
}

}  // namespace deformable_surface
