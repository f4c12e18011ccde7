// Nearest neighbours of points. Ties are broken by index, so that equal input gives equal output. Points can be removed one by
// one, for the simplification.
#pragma once

#include "deformable_surface/base/types.h"

#include <limits>

namespace deformable_surface::cloud {

/// A neighbour: squared distance (m^2), then index; the order of results.
struct Neighbor {
  double squared_distance;
  Index index;

  bool operator<(const Neighbor& other) const {
    return squared_distance != other.squared_distance ? squared_distance < other.squared_distance : index < other.index;
  }
};

class KdTree {
 public:
  /// points (n x 3), finite. Copies them in the tree's own order. O(n log n).
  explicit KdTree(const Points& points);

  /// The k nearest alive points to query within reach (m; closed ball), nearest first; fewer if there are not as many. If the
  /// query is a point, it is among them. out is overwritten. O(log n + k log k).
  void nearest(const Vec3& query, Index k, std::vector<Neighbor>& out,
               double reach = std::numeric_limits<double>::infinity()) const;

  /// All alive points within radius (closed ball), nearest first.
  void withinRadius(const Vec3& query, double radius, std::vector<Neighbor>& out) const;

  /// Removes a point from later answers. O(log n) on average: the tree is rebuilt whenever half of its points are removed.
  void remove(Index point);

  /// Whether these are its points, in their places, with none removed. O(n).
  bool holds(const Points& points) const;

  /// All points, removed ones included, in the first order of the tree: near in the list means near in space. Loops over
  /// queries run in this order.
  const std::vector<Index>& order() const;

  Index size() const;

 private:
  struct Node {
    double lo[3], hi[3];  // the tight box of all points below, removed ones included
    Index begin, end;     // slots
    Index right;          // the second child; the first follows its parent; 0 = leaf
  };
  struct Slot {
    double x, y, z;  // m; of a removed point x is not a number
    Index point;
  };

  void rebuild();
  Index makeNode(Index node, Index begin, Index end);
  Index build(Index node, Index begin, Index end);
  template <class Results>
  void search(const Vec3& query, Results& results) const;

  std::vector<Node> nodes_;     // depth first
  std::vector<Slot> slots_;     // in tree order, at least half of them alive
  std::vector<Index> slot_of_;  // (n) by point
  std::vector<Index> order_;    // (n)
  Index num_alive_ = 0;
};

/// The k nearest other points of every point (fewer if there are not as many), nearest first. Parallel. O(n (log n + k log k)).
Lists nearestNeighbors(const Points& points, Index k);

/// The same with a tree that holds the points.
Lists nearestNeighbors(const Points& points, const KdTree& tree, Index k);

}  // namespace deformable_surface::cloud
