// Kruskal's minimum spanning forest. It stores and sorts only few links: most are longer than those that join everything. The
// side of normals and the trust radii of geodesics use it.
#pragma once

#include "deformable_surface/base/parallel_sort.h"
#include "deformable_surface/base/types.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace deformable_surface::cloud {

/// Joins the ends of links in ascending order, unless they are joined already. Link: with ends i and j and a strict total
/// order. forLinks(i, visit): visits the links that point i offers, from several threads, always the same. findRoot(i): one
/// point for all points joined to i, from several threads. join(link): called for every link of the forest, and for some others
/// whose ends are joined by then. The result does not depend on the number of threads.
template <class Link, class ForLinks, class FindRoot, class Join>
void visitSpanningForest(Index n, const ForLinks& forLinks, const FindRoot& findRoot, const Join& join) {
  constexpr Index kBlock = 1024;  // points per task: about a millisecond of work
  constexpr Index kSampled = 16;  // one point in kSampled samples the distribution of the links
  std::vector<Index> root(n);
  std::vector<std::vector<Link>> parts((n + kBlock - 1) / kBlock);
  std::vector<Link> sample;
  std::optional<Link> last;  // of the links treated so far
  // The shortest links join nearly all points, so most others are dropped before they are sorted. Portions double, so that
  // there are few of them where the weights tie and little can be dropped.
  for (std::size_t portion = n;; portion *= 2) {
    parallelFor(n, kBlock, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) root[i] = findRoot(i);
    });
    const auto isLeft = [&](const Link& link) { return (!last || *last < link) && root[link.i] != root[link.j]; };
    sample.clear();
    for (Index i = 0; i < n; i += kSampled)
      forLinks(i, [&](const Link& link) {
        if (isLeft(link)) sample.push_back(link);
      });
    const std::size_t wanted = portion / kSampled;
    const bool are_all = sample.size() <= wanted;
    if (!are_all) std::nth_element(sample.begin(), sample.begin() + wanted, sample.end());
    const auto isTaken = [&](const Link& link) { return isLeft(link) && (are_all || !(sample[wanted] < link)); };
    parallelFor(n, kBlock, [&](Index begin, Index end) {
      std::vector<Link>& part = parts[begin / kBlock];
      part.clear();
      for (Index i = begin; i < end; ++i)
        forLinks(i, [&](const Link& link) {
          if (isTaken(link)) part.push_back(link);
        });
    });
    std::vector<Link> links;
    for (const std::vector<Link>& part : parts) links.insert(links.end(), part.begin(), part.end());
    parallelSort(links);
    for (const Link& link : links) join(link);
    if (are_all) return;
    last = sample[wanted];
  }
}

}  // namespace deformable_surface::cloud
