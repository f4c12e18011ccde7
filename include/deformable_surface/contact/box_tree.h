// Which of many boxes that move are near a given one: a tree over the boxes that keeps its shape while they move.
#pragma once

#include "deformable_surface/base/types.h"

#include <utility>
#include <vector>

namespace deformable_surface::contact {

using Box = Eigen::AlignedBox3d;  // m

class BoxTree {
 public:
  /// Halves the boxes by the middles along the widest axis, again and again. Deterministic.
  explicit BoxTree(const std::vector<Box>& boxes);

  /// The same boxes at other places. O(n).
  void refit(const std::vector<Box>& boxes);

  /// Calls visit(i) for the boxes that meet the given one, always in the same order. Parallel calls are fine.
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
    Index behind;  // the node that follows all below this one
    Index item;    // of a leaf; else -1
  };
  void build(std::vector<std::pair<Vec3, Index>>& middles, Index begin, Index end);

  std::vector<Node> nodes_;  // depth first
};

}  // namespace deformable_surface::contact
