// Whether lists of neighbours still hold every near pair, found by a tree of boxes without looking at all pairs.
#pragma once

#include "deformable_surface/base/types.h"

#include <vector>

namespace deformable_surface::model {

/// A binary tree over particles, halved along the longest edge of the box around each part, with up to eight in a leaf.
class ApproachTree {
 public:
  /// The lists are new. places: (n), finite. O(n log n) if the number has changed, or a few times after an answer took too long.
  /// Else the tree stays as it was: of other places it is slower, not wrong.
  void renew(const Points& places);
  Index size() const { return static_cast<Index>(order_.size()); }

  struct Lengths {
    double radius;               // m: pairs nearer than this now must be listed
    double reach;                // m: pairs nearer than this then are listed
    double skin;                 // m: pairs that have moved against each other by less hold in any case
    bool is_listed_by_distance;  // else only the skin counts
  };
  /// then, now: (n). Whether every pair nearer than the radius now was within reach then. False also once the calls since renew()
  /// have taken about as long as making new lists: it is fast only while the lists are new. Boxes in parallel; allocates nothing
  /// after the first call.
  ///
  /// Once displacements have made it slow, it looks whether every pair nearer than radius and half of the skin is listed. If so,
  /// displacements count from here, and half of the skin is left: a surface that has turned is as fast again as one that has not.
  bool holds(const Points& then, const Points& now, const Lengths& lengths);
  /// While all particles have moved by less than the slack against each other since these places, m, it holds. Null: since then.
  const Points* base() const { return has_base_ ? &base_ : nullptr; }
  double slack(double skin) const { return has_base_ ? kLeft * skin : skin; }

  std::size_t bytes() const;

 private:
  static constexpr Index kLeaf = 8;
  static constexpr double kLeft = 0.5;  // of the skin, from places later than then
  struct Box {
    double low[4], high[4], least_move[4], most_move[4];  // m; x, y, z, 0
  };
  struct Leaf {
    double x[kLeaf], y[kLeaf], z[kLeaf];  // m, now; x is NaN where there is no particle
    Index particle[kLeaf], count;
  };
  class Search;
  void build(const Points& places);
  static bool runWide(Search& search, Index most);
  void join();
  Index beginOf(Index leaf) const;
  void fill(const Points& then, const Points& now, Index leaf);

  std::vector<Index> order_;  // (n)
  Index num_leaves_ = 0;      // a power of two
  std::vector<Box> boxes_;    // 1: the root; 2 k and 2 k + 1: the halves of k; the last num_leaves_: the leaves
  std::vector<Leaf> leaves_;
  Index visited_ = 0;  // pairs of boxes since the lists are new, or since the base
  Points base_;
  bool has_base_ = false, may_have_base_ = true;
  bool is_slow_ = false;
  Index age_ = 0;  // calls of renew() since the tree was built
};

}  // namespace deformable_surface::model
