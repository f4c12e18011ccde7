// The pairs of primitives of a surface that may touch and share no vertex: vertex and triangle, edge and edge.
#pragma once

#include "deformable_surface/base/parallel_append.h"
#include "deformable_surface/contact/box_tree.h"
#include "deformable_surface/contact/closest_points.h"
#include "deformable_surface/contact/cover.h"
#include "deformable_surface/contact/crossings.h"
#include "deformable_surface/contact/patches.h"
#include "deformable_surface/contact/primitives.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace deformable_surface::contact {

struct Pair {
  std::array<Index, 4> vertices;  // vertex and triangle: the vertex first; edges: two and two
  bool is_edges;
  double thickness;  // m: nearer parts repel each other; that of the surface, but below their distance at rest

  // Of the thickness: parts that move come no nearer.
  static constexpr double kLeast = 0.5;

  Index numFirst() const { return is_edges ? 2 : 1; }  // vertices of the first primitive
  /// m: a pair that is farther apart does not touch, nor would it come too near on a relative way, m.
  double reachFor(double way) const { return reachFor(thickness, way); }
  static double reachFor(double thickness, double way) { return std::max(thickness, kLeast * thickness + way); }
  /// m: how far a vertex of one primitive moves against one of the other, at most. wayOf(k): m, of the pair's k-th vertex.
  template <class WayOf>
  double findRelativeWay(const WayOf& wayOf) const {
    double squared = 0.0;
    for (int v = 0; v < numFirst(); ++v)
      for (int w = numFirst(); w < 4; ++w) squared = std::max(squared, (wayOf(v) - wayOf(w)).squaredNorm());
    return std::sqrt(squared);
  }
};

inline Closest findClosest(const Pair& pair, const Points& positions) {
  const Vec3 &a = positions[pair.vertices[0]], &b = positions[pair.vertices[1]], &c = positions[pair.vertices[2]],
             &d = positions[pair.vertices[3]];
  return pair.is_edges ? findClosestOfEdges(a, b, c, d) : findClosestToTriangle(a, b, c, d);
}

/// Lists the near pairs, and determines how long the list is valid.
///
/// The surface is divided into patches. Each couple of near patches has a list of its own. The list remains valid until the two
/// patches have moved far enough relative to each other. Only then the couple is searched again. So the cost depends on how
/// fast the surface deforms, and only where it does.
class PairList {
 public:
  /// How near pairs must be to be listed: nearer than `least` and `of_way` times their relative way, but at most `most`.
  struct Reach {
    double least;                                           // m
    double of_way = 0.0;                                    // of a bound of the relative way of the pair's patches
    double most = std::numeric_limits<double>::infinity();  // m
    double spare = 0.0;                                     // m, by which patches that are no couple shall be farther apart

    double of(double way) const { return std::min(most, least + of_way * way); }
  };

  /// rest: (n) m. thickness: m. Pairs that touch at rest are omitted. So is what passes through each other at rest: all pairs
  /// that have an end of an edge and a corner of a triangle which that edge crosses. takes_lone_points: points without
  /// triangles touch those of others.
  PairList(Points rest, const std::vector<Triangle>& triangles, double thickness, bool takes_lone_points = true);

  /// Leaves out the triangles that are cut or torn, and the edges that are left without any: (triangles) 1 = whole. Points
  /// without triangles stay. The pairs that remain are those of before, so none begins in contact.
  void keepWhole(const std::vector<char>& is_whole);

  /// From now on, what passes through each other at these positions is omitted in place of what does so at rest. Pairs that have
  /// been set free push each other at the whole thickness. Returns whether anything has changed. O(n log n).
  bool findCrossed(const Points& positions);

  /// Whether no pair is within reach at `positions`, for paths from there to `next`: true only if that is found quickly. Those
  /// that the cover holds do not count; it must be that of the last update().
  bool areFar(const Points& positions, const Points& next, const Reach& reach, const Cover* cover = nullptr) const;
  /// Upper bound of the difference of the displacements, m, of any two points of a patch.
  double findLargestLocalWay(const Points& from, const Points& to);
  /// Ensures that every pair is listed that is within reach at `positions`, for paths from there to `next`. cover: what is known
  /// to have no such pairs, and is left out; null: nothing.
  void update(const Points& positions, const Points& next, const Reach& reach, const Cover* cover = nullptr);
  /// The same for points that rest: every pair nearer than reach (m).
  void update(const Points& positions, double reach, const Cover* cover = nullptr) {
    update(positions, positions, {reach}, cover);
  }
  /// The same for ways in any direction, from their greatest lengths: ways: (n) m.
  void update(const Points& positions, const std::vector<double>& ways, const Reach& reach);
  /// Calls visit(pair, least) for the pairs that may be within reach at the positions of the last update(). least: m, a lower
  /// bound of their distance there. The order does not depend on when the lists were built.
  template <class Visit>
  void visitNear(const Visit& visit) {
    if (are_far_) return;
    num_visits_ +=
        visitNear(0, static_cast<Index>(open_.size()), [&](Index, const Pair& pair, double least) { visit(pair, least); });
  }
  /// Calls visit(pair, least, list) for the same pairs, by all threads, and appends to `to` what it appends to the list. In the
  /// order of visitNear().
  template <class Item, class Visit>
  void collectNear(std::vector<Item>& to, AppendedParts<Item>& parts, const Visit& visit) {
    collectByCouple(to, parts, [&](Index, const Pair& pair, double least, auto& list) { visit(pair, least, list); });
  }
  /// The same with the number of the pair's couple, as visitCouples() tells it: visit(couple, pair, least, list).
  template <class Item, class Visit>
  void collectByCouple(std::vector<Item>& to, AppendedParts<Item>& parts, const Visit& visit) {
    if (are_far_) return;
    std::atomic<std::size_t> num_visits{0};
    parallelAppend(static_cast<Index>(open_.size()), kCouplesAtOnce, to, parts, [&](Index begin, Index end, auto& list) {
      num_visits +=
          visitNear(begin, end, [&](Index couple, const Pair& pair, double least) { visit(couple, pair, least, list); });
    });
    num_visits_ += num_visits;
  }
  /// Whether test(pair, least) holds for any of these pairs, by all threads.
  template <class Test>
  bool isAnyNear(const Test& test) {
    if (are_far_) return false;
    std::atomic<bool> is_any{false};
    std::atomic<std::size_t> num_visits{0};
    parallelFor(static_cast<Index>(open_.size()), kCouplesAtOnce, [&](Index begin, Index end) {
      num_visits += visitNear(begin, end, [&](Index, const Pair& pair, double least) {
        if (!is_any && test(pair, least)) is_any = true;
      });
    });
    num_visits_ += num_visits;
    return is_any;
  }
  /// Calls visit(number, one, other, nearest, way) for the couples of near patches: nearest: m, a lower bound of the distance of
  /// their pairs at the positions of the last update(); way: m, a bound of their relative way from there on. In the order of
  /// visitNear().
  template <class Visit>
  void visitCouples(const Visit& visit) const {
    if (are_far_) return;
    for (const Index k : open_) {
      const Couple& couple = couples_[k];
      visit(k, couple.one, couple.other, couple.nearest - couple.gone,
            next_ways_[couple.one].findRelative(next_ways_[couple.other]));
    }
  }
  /// m: patches that are no such couple are farther apart at the positions of the last update(). Without a cover.
  double apart() const { return apart_now_; }
  /// Calls visit(pair) for pairs that were near at some time, without a search; not for those that the cover holds. Any may be
  /// missing.
  template <class Visit>
  void visitKnown(const Cover* cover, const Visit& visit) {
    findOpen(cover);
    for (const Index open : open_) {
      if (couples_[open].radius < 0.0) continue;  // may list what has no contact any longer
      for (const Listed& listed : couples_[open].listed) visit(listed.pair);
    }
  }
  /// m, of a pair in contact: see Pair; not positive: it has none.
  double thicknessOf(const Pair& pair) const;
  const Patches& patches() const { return patches_; }
  double thickness() const { return thickness_; }
  /// m, of all pairs: see Pair::reachFor().
  double largestReachFor(double way) const { return Pair::reachFor(thickness_, way); }
  double medianEdge() const { return median_edge_; }  // m, at rest
  /// Number of triangles that are crossed by edges of others, at rest or at the last findCrossed().
  Index numCrossed() const { return num_crossed_; }
  const Vec3& firstCrossing() const { return first_crossing_; }          // m; only if there is one
  const std::vector<Crossing>& crossings() const { return crossings_; }  // ascending by edge
  const std::vector<Edge>& edges() const { return edges_; }              // ascending
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /// (edges), 0: all triangles at it are cut; empty: none is.
  const std::vector<char>& areEdgesWhole() const { return is_edge_whole_; }
  /// m: a search up to this distance costs no more than one for touching pairs.
  double usualReach() const { return kUsualReach * usual_radius_; }
  /// Number of searches of couples of patches.
  Index numSearches() const { return num_searches_; }

 private:
  static constexpr Index kCouplesAtOnce = 128;  // a task: some microseconds if nothing is near
  static constexpr double kUsualReach = 0.5;    // the remainder is the allowed motion until the next search

  struct Listed {
    Pair pair;
    double distance;  // m, when the couple was measured
  };
  // Two patches, or one and itself.
  struct Couple {
    Index one, other;
    double radius;   // m: pairs that are not listed were farther apart when the couple was measured; negative: not searched
    double nearest;  // m: no pair was nearer then
    double used;     // m, bound of the relative way from then to at_
    double gone;     // m, the same to the positions of the last update()
    double reach;    // m, of the last update()
    std::vector<Listed> listed;
  };

  // Of a patch.
  struct Parts {
    Primitives vertices{1}, edges{2}, triangles{3};
  };

  /// Of open couples. Returns the number of visits.
  template <class Visit>
  std::size_t visitNear(Index begin, Index end, const Visit& visit) const {
    std::size_t num_visits = 0;
    for (Index k = begin; k < end; ++k) {
      const Couple& couple = couples_[open_[k]];
      if (couple.nearest - couple.gone >= couple.reach) continue;
      for (const Listed& listed : couple.listed) {
        const double least = listed.distance - couple.gone;
        if (!(least < couple.reach)) continue;
        ++num_visits;
        visit(open_[k], listed.pair, least);
      }
    }
    return num_visits;
  }
  /// Whether a vertex of each primitive are one of the couples, which are ascending, the lower vertex first.
  static bool isAnyIn(const std::vector<std::array<Index, 2>>& couples, const Pair& pair);
  /// measureWays(): sets next_ways_ of the open patches. largest: m, a bound of the relative ways of all patches.
  template <class MeasureWays>
  void update(const Points& positions, const Reach& reach, const Cover* cover, double largest, const MeasureWays& measureWays);
  void findCouples(const Points& positions, double reach);
  void findOpen(const Cover* cover);
  double findNearestAt(const Points& positions) const;
  void rememberNearest(const Points& positions, double apart);
  void markExpired(const Reach& reach);
  void measureAgain(const Points& positions);
  void searchExpired(const Points& positions);
  void enclose(Index patch, const Points& positions);
  bool areBoxesApart(Couple& couple) const;
  void search(const Points& positions, Couple& couple) const;
  void offer(const Points& positions, Pair pair, Couple& couple) const;

  const Points rest_;
  const std::vector<Triangle> triangles_;
  const double thickness_;
  std::vector<Edge> edges_;
  Patches patches_;
  double median_edge_ = 0.0;                    // m, at rest
  std::vector<char> is_whole_, is_edge_whole_;  // (triangles), (edges); empty: all are
  double usual_radius_ = 0.0;                   // m, of a search
  std::vector<Crossing> crossings_;
  std::vector<std::array<Index, 2>> crossed_;  // an end of an edge and a corner of a triangle that it crosses
  std::vector<std::array<Index, 2>> at_rest_;  // the same at rest
  Index num_crossed_ = 0;
  Vec3 first_crossing_ = Vec3::Zero();

  Points at_;                                    // m, where the ways of all couples are counted from; empty: nowhere yet
  std::vector<Patches::Ways> ways_, next_ways_;  // from at_ to the positions of the last update(), and on to `next`
  std::vector<Box> boxes_;                       // of the patches
  BoxTree tree_;                                 // of these
  std::vector<Couple> couples_, kept_;           // ascending
  std::vector<Index> open_, open_patches_;       // couples that the cover does not hold, and their patches; ascending
  const Cover* cover_ = nullptr;                 // of these; and its revision
  Index revision_ = -1;
  Points seen_at_;                   // m, of the last update() that looked at couples
  double nearest_ = -1.0;            // m: no pair that the cover does not hold was nearer there
  bool are_far_ = false;             // no pair is within the reach of the last update()
  std::vector<char> is_open_;        // (patches), scratch
  std::vector<Index> near_patches_;  // scratch
  double apart_ = -1.0;              // m: patches that are no couple are farther apart at at_
  double apart_now_ = -1.0;          // m: see apart()
  std::vector<Couple*> expired_;     // to be searched
  AppendedParts<Index> open_parts_;  // scratch
  AppendedParts<Couple*> expired_parts_;
  std::vector<Index> patches_of_expired_;
  std::vector<Parts> parts_;                 // (patches), of the patches of expired couples
  std::vector<char> is_enclosed_, has_box_;  // (patches): these, and boxes_, are of at_
  Index num_searches_ = 0;
  std::size_t num_listed_ = 0, num_visits_ = 0, measured_after_ = 0;  // visits, when all were measured last
};

}  // namespace deformable_surface::contact
