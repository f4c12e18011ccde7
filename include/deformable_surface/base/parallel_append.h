// Lists whose items all threads find. Few files need it, while parallel.h is included everywhere.
#pragma once

#include "deformable_surface/base/parallel.h"

#include <cstddef>
#include <vector>

namespace deformable_surface {

/// Memory of parallelAppend(), kept from call to call so that nothing is allocated in most.
template <class Item>
using AppendedParts = std::vector<std::vector<Item>>;

/// Appends to `to`, in the order of the blocks, what body(begin, end, list) appends to list for each block of [0, n). What it
/// appends for an index must not depend on the block. A single block runs in the calling thread.
template <class Item, class Body>
void parallelAppend(Index n, Index block, std::vector<Item>& to, AppendedParts<Item>& parts, const Body& body) {
  if (n <= block || numThreads() == 1) {
    if (n > 0) body(Index{0}, n, to);
    return;
  }
  const auto num_blocks = static_cast<std::size_t>((n - 1) / block + 1);
  if (parts.size() < num_blocks) parts.resize(num_blocks);
  parallelFor(n, block, [&](Index begin, Index end) {
    std::vector<Item>& part = parts[begin / block];
    part.clear();
    body(begin, end, part);
  });
  for (std::size_t b = 0; b < num_blocks; ++b) to.insert(to.end(), parts[b].begin(), parts[b].end());
}

}  // namespace deformable_surface
