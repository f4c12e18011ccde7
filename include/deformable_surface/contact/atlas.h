// Overlapping charts of a surface, from the whole to small ones.
#pragma once

#include "deformable_surface/contact/chart.h"
#include "deformable_surface/contact/patches.h"

#include <optional>
#include <vector>

namespace deformable_surface::contact {

/// Two patches that share a triangle, or one and itself, are in a chart of each level together. A patch with a point without
/// triangles is in none. Charts are made when they are first asked for.
class Atlas {
 public:
  /// rest: (n) m. patches: of the same surface. distance: m, see Chart. All are kept by reference. Few patches have no chart.
  Atlas(const Points& rest, const std::vector<Triangle>& triangles, const Patches& patches, double distance);

  /// The charts, depth first: those behind a chart up to behind() are parts of it.
  Index size() const { return static_cast<Index>(nodes_.size()); }
  Index behind(Index chart) const { return nodes_[chart].behind; }
  const Chart& chart(Index chart);
  /// The patches in a chart, ascending.
  const std::vector<Index>& patchesIn(Index chart);

 private:
  struct Node {
    Index first, end;  // patches, without the margin
    Index behind;
    std::vector<Index> patches;  // with the margin
    std::optional<Chart> chart;
  };
  void split(Index first, Index end);
  void make(Node& node);

  const Points& rest_;
  const std::vector<Triangle>& triangles_;
  const Patches& patches_;
  const double distance_;
  std::vector<Index> patch_of_;                   // (n), -1: none
  std::vector<std::vector<Index>> neighbors_;     // (patches), ascending: the patch itself and later ones
  std::vector<std::vector<Index>> triangles_at_;  // (n), ascending
  std::vector<Node> nodes_;
};

}  // namespace deformable_surface::contact
