// Union-find: which of n things are connected, when pairs are joined one after the other. Of each thing there is a parent in its
// set, in a vector that the caller owns, so that joining allocates nothing. The smallest index of a set is its root.
#pragma once

#include "deformable_surface/base/types.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace deformable_surface {

/// Each of n things alone.
inline void makeSingleSets(Index n, std::vector<Index>& parents) {
  parents.resize(n);
  std::iota(parents.begin(), parents.end(), Index{0});
}

/// The smallest index of the set of i. Shortens the way to it.
inline Index findRoot(std::vector<Index>& parents, Index i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

/// Joins the sets of i and j. Returns whether they were different.
inline bool joinSets(std::vector<Index>& parents, Index i, Index j) {
  const Index a = findRoot(parents, i), b = findRoot(parents, j);
  parents[std::max(a, b)] = std::min(a, b);
  return a != b;
}

/// (n) the number of each thing's set, from 0 in the order of the roots.
inline std::vector<Index> labelSets(std::vector<Index>& parents, Index& num_sets) {
  num_sets = 0;
  std::vector<Index> label(parents.size());
  for (Index i = 0; i < static_cast<Index>(parents.size()); ++i)
    label[i] = parents[i] == i ? num_sets++ : label[findRoot(parents, i)];
  return label;
}

}  // namespace deformable_surface
