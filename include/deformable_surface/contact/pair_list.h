// The pairs of primitives of a surface that may touch and share no vertex: vertex and triangle, edge and edge.
#pragma once

#include "deformable_surface/contact/box_tree.h"
#include "deformable_surface/contact/closest_points.h"

#include <array>
#include <utility>
#include <vector>

namespace deformable_surface::contact {

using Triangle = std::array<Index, 3>;

struct Pair {
  std::array<Index, 4> vertices;  // vertex and triangle: the vertex first; edges: two and two
  bool is_edges;
  double thickness;  // m: nearer parts repel each other; that of the surface, but below their distance at rest

  Index numFirst() const { return is_edges ? 2 : 1; }  // vertices of the first primitive
};

inline Closest findClosest(const Pair& pair, const Points& positions) {
  const Vec3 &a = positions[pair.vertices[0]], &b = positions[pair.vertices[1]], &c = positions[pair.vertices[2]],
             &d = positions[pair.vertices[3]];
  return pair.is_edges ? findClosestOfEdges(a, b, c, d) : findClosestToTriangle(a, b, c, d);
}

/// Lists the near pairs, and determines how long the list is valid.
class PairList {
 public:
  /// rest: (n) m. thickness: m. Pairs that touch at rest are omitted. So is what passes through each other at rest: all pairs
  /// that have an end of an edge and a corner of a triangle which that edge crosses.
  PairList(Points rest, const std::vector<Triangle>& triangles, double thickness);

  /// Leaves out the triangles that are cut or torn, and the edges that are left without any: (triangles) 1 = whole. Points
  /// without triangles stay. The pairs that remain are those of before, so none begins in contact.
  void keepWhole(const std::vector<char>& is_whole);
  /// Ensures that every pair nearer than reach (m) is listed. Rebuilds the list if points have moved too far since the last
  /// search, relative to their mean motion.
  void update(const Points& positions, double reach);

  /// Calls visit(pair) for the pairs that may be nearer than reach (m), which must not exceed that of the last update(). The
  /// order does not depend on when the list was built.
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
  /// Number of triangles that are crossed by edges of others at rest.
  Index numCrossed() const { return num_crossed_; }
  const Vec3& firstCrossing() const { return first_crossing_; }  // m, at rest; only if there is one
  /// m: a search up to this distance costs no more than one for touching pairs.
  double usualReach() const { return kUsualReach * usual_radius_; }
  Index numSearches() const { return num_searches_; }

 private:
  static constexpr double kUsualReach = 0.5;  // the remainder is the allowed motion until the next search

  void findCrossed();
  /// Whether a vertex of each primitive are one of the couples, which are ascending, the lower vertex first.
  static bool isAnyIn(const std::vector<std::array<Index, 2>>& couples, const Pair& pair);
  void measureWays(const Points& positions);
  void search(const Points& positions, double radius);
  void offer(const Points& positions, double radius, Pair pair, std::vector<std::pair<Pair, double>>& found) const;

  const Points rest_;
  const std::vector<Triangle> triangles_;
  const double thickness_;
  std::vector<std::array<Index, 2>> edges_;
  std::vector<char> is_whole_, is_edge_whole_;  // (triangles), (edges); empty: all are
  std::vector<Box> triangle_boxes_, edge_boxes_;
  BoxTree triangle_tree_, edge_tree_;
  double usual_radius_ = 0.0;                  // m, of a search
  std::vector<std::array<Index, 2>> crossed_;  // an end of an edge and a corner of a triangle that it crosses at rest
  Index num_crossed_ = 0;
  Vec3 first_crossing_ = Vec3::Zero();

  Points reference_;          // m, positions at the last search; empty: no search yet
  double radius_ = 0.0;       // m: nearer pairs were listed
  std::vector<double> way_;   // (n) m, motion of the points since the search, less their mean
  double largest_way_ = 0.0;  // m
  std::vector<Pair> pairs_;
  std::vector<double> distance_;  // m, of the pairs at the search
  Index num_searches_ = 0;
};

}  // namespace deformable_surface::contact
