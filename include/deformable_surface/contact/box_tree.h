// Finds which of many moving boxes are near a given box: a bounding volume hierarchy that keeps its topology while they move.
#pragma once

#include "deformable_surface/base/types.h"

#include <utility>
#include <vector>

namespace deformable_surface::contact {

using Box = Eigen::AlignedBox3d;  // m

/// Larger by a length (m) on every side.
inline Box grow(const Box& box, double by) { return Box(box.min() - Vec3::Constant(by), box.max() + Vec3::Constant(by)); }

/// Sorts the points begin to end such that those of the lower half along the widest axis come first. Returns the first of the
/// upper half. The indices decide between equal points, so the result is always the same.
Index splitAtMedian(std::vector<std::pair<Vec3, Index>>& points, Index begin, Index end);

class BoxTree {
 public:
  /// Splits the boxes recursively at the median along the widest axis. Deterministic.
  explicit BoxTree(const std::vector<Box>& boxes);

  /// Updates the tree for the same boxes at other places. O(n).
  void refit(const std::vector<Box>& boxes);

  /// Calls visit(i) for the boxes that overlap the given one, always in the same order. Thread-safe.
  template <class Visit>
  void visitMeeting(const Box& box, const Visit& visit) const {
    for (Index node = 0; node < static_cast<Index>(nodes_.size());) {
      if (!nodes_[node].box.intersects(box)) {
        node = nodes_[node].behind;
      } else {
        if (nodes_[node].item >= 0) visit(nodes_[node].item);
        ++node;
      }
    }
  }

 private:
  struct Node {
    Box box;
    Index behind;  // the next node that is not below this one
    Index item;    // of a leaf; else -1
  };
  void build(std::vector<std::pair<Vec3, Index>>& middles, Index begin, Index end);

  std::vector<Node> nodes_;  // depth first
};

}  // namespace deformable_surface::contact
