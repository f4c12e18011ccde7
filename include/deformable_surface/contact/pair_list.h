// The pairs of a surface's parts that may touch: vertices and triangles, edges and edges, that share no vertex.
#pragma once

#include "deformable_surface/contact/box_tree.h"
#include "deformable_surface/contact/closest_points.h"

#include <array>
#include <utility>
#include <vector>

namespace deformable_surface::contact {

using Triangle = std::array<Index, 3>;

struct Pair {
  std::array<Index, 4> vertices;  // of a triangle: the vertex first; of edges: two and two
  bool is_edges;
  double thickness;  // m: nearer than that they push each other apart; that of the surface, but below their distance at rest

  Index numFirst() const { return is_edges ? 2 : 1; }  // vertices of the first primitive
};

inline Closest findClosest(const Pair& pair, const Points& positions) {
  const Vec3 &a = positions[pair.vertices[0]], &b = positions[pair.vertices[1]], &c = positions[pair.vertices[2]],
             &d = positions[pair.vertices[3]];
  return pair.is_edges ? findClosestOfEdges(a, b, c, d) : findClosestToTriangle(a, b, c, d);
}

/// Lists the pairs that are near, and says how long the list holds.
class PairList {
 public:
  /// rest: (n) m. thickness: m. Left out are pairs that touch at rest, and all of triangles that cross others there.
  PairList(Points rest, const std::vector<Triangle>& triangles, double thickness);

  /// Makes sure that every pair nearer than reach (m) is listed; the list is made anew if points have moved too far, all less
  /// their mean, since it was made.
  void update(const Points& positions, double reach);

  /// In an order that is the same whenever the list was made. Calls visit(pair) for those that may be nearer than reach (m), at
  /// most that of the last update().
  template <class Visit>
  void visitNear(double reach, const Visit& visit) const {
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const double room = distance_[p] - reach;
      if (room > 2.0 * largest_way_) continue;
      const Pair& pair = pairs_[p];
      const double second = std::max(way_[pair.vertices[2]], way_[pair.vertices[3]]);
      const double first = pair.is_edges ? way_[pair.vertices[0]] : 0.0;
      const double other = way_[pair.vertices[pair.is_edges ? 1 : 0]];
      if (room > (pair.is_edges ? std::max(first, other) + second : other + std::max(way_[pair.vertices[1]], second))) continue;
      visit(pair);
    }
  }
  double thickness() const { return thickness_; }
  /// Triangles that edges of others go through at rest.
  Index numCrossed() const { return num_crossed_; }
  const Vec3& firstCrossing() const { return first_crossing_; }  // m, at rest; only if there is one
  /// m: a search for pairs that are nearer costs no more than one for those that touch.
  double usualReach() const { return kUsualReach * usual_radius_; }
  Index numSearches() const { return num_searches_; }

 private:
  static constexpr double kUsualReach = 0.5;  // the rest is what points may move until the next search

  void findCrossed();
  void measureWays(const Points& positions);
  void search(const Points& positions, double radius);
  void offer(const Points& positions, double radius, Pair pair, std::vector<std::pair<Pair, double>>& found) const;

  const Points rest_;
  const std::vector<Triangle> triangles_;
  const double thickness_;
  std::vector<std::array<Index, 2>> edges_;
  std::vector<Box> triangle_boxes_, edge_boxes_;
  BoxTree triangle_tree_, edge_tree_;
  double usual_radius_ = 0.0;     // m, of a search
  std::vector<char> is_crossed_;  // (n) of a triangle that crosses another one at rest
  Index num_crossed_ = 0;
  Vec3 first_crossing_ = Vec3::Zero();

  Points reference_;          // m, where the points were when the list was made; empty: there is none
  double radius_ = 0.0;       // m: nearer pairs were listed
  std::vector<double> way_;   // (n) m, of the points since then, less their mean
  double largest_way_ = 0.0;  // m
  std::vector<Pair> pairs_;
  std::vector<double> distance_;  // m, of the pairs then
  Index num_searches_ = 0;
};

}  // namespace deformable_surface::contact
