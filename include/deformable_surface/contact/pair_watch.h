// The pairs that may come near within the next sub-steps: one look at the lists serves many.
#pragma once

#include "deformable_surface/contact/clear_motion.h"
#include "deformable_surface/contact/pair_list.h"

#include <atomic>
#include <vector>

namespace deformable_surface::contact {

/// A look at the lists predicts that the points keep their velocities. It finds the pairs that may come near while they do,
/// within an allowance. Until two near patches leave the prediction by more than that against each other, only these pairs are
/// measured. Results do not depend on when looks are taken: all pairs within reach are found, in the order of the lists.
class PairWatch {
 public:
  /// list: kept by reference.
  explicit PairWatch(PairList& list) : list_(list) {}

  /// After a change of what the lists hold.
  void forget() { is_watching_ = false; }
  /// Ensures that all pairs within Pair::reachFor(way) at these positions are watched. from, to: (n) m, the motion of a sub-step,
  /// which is predicted to go on. False if lists cost less: for a long reach, or motion that no prediction serves.
  bool ensure(const Points& positions, double way, const Points& from, const Points& to);
  /// Calls visit(pair, closest, list), by all threads, for pairs that may be within Pair::reachFor(way) at the positions of the
  /// last ensure(), and for all that are. Appends to `to` what it appends to the list. In the order of PairList::visitNear().
  template <class Item, class Visit>
  void collectNear(const Points& positions, double way, std::vector<Item>& to, AppendedParts<Item>& parts, const Visit& visit) {
    parallelAppend(static_cast<Index>(couples_.size()), kBlock, to, parts, [&](Index begin, Index end, auto& list) {
      visitNear(begin, end, way, [&](Watched& watched, double) {
        if (isApart(watched, positions, way)) return;
        const Closest closest = findClosest(watched.pair, positions);
        watched.normal = closest.gap.normalized();
        visit(watched.pair, closest, list);
      });
    });
  }
  /// Whether test(pair, least) holds for any of these pairs, by all threads. least: m, a lower bound of their distance.
  template <class Test>
  bool isAnyNear(double way, const Test& test) {
    std::atomic<bool> is_any{false};
    parallelFor(static_cast<Index>(couples_.size()), kBlock, [&](Index begin, Index end) {
      visitNear(begin, end, way, [&](const Watched& watched, double least) {
        if (!is_any && test(watched.pair, least)) is_any = true;
      });
    });
    return is_any;
  }
  Index numLooks() const { return num_looks_; }

 private:
  static constexpr Index kBlock = 128;  // couples per task
  // Bounds are compared with distances that are larger by this share: more than rounding makes of them.
  static constexpr double kRounding = 1e-9;

  struct Watched {
    Pair pair;
    Index couple;              // in the list
    double distance, nearing;  // m: at the look; by at most that much in the predicted motion
    Vec3 normal;               // from the second primitive to the first, when the pair was measured last
  };
  // Two patches that are near each other.
  struct Couple {
    Index one, other;
    std::size_t begin, end;  // of its watched pairs
    double least;            // m: these come no nearer in the predicted motion
    double thickness;        // m, the largest of theirs
    double spare;            // m: the other pairs are farther than within reach by at least that much
    double aside;            // m, beside the prediction, at the last ensure()
  };

  /// A plane across the last normal separates two convex primitives, mostly the parts of two layers.
  static bool isApart(const Watched& watched, const Points& positions, double way) {
    const auto& v = watched.pair.vertices;
    const auto along = [&](int k) { return watched.normal.dot(positions[v[k]]); };
    const double a = along(0), b = along(1), c = along(2), d = along(3);
    const double gap = watched.pair.is_edges ? std::min(a, b) - std::max(c, d) : a - std::max(b, std::max(c, d));
    return gap > (1.0 + kRounding) * watched.pair.reachFor(way);
  }
  template <class Visit>
  void visitNear(Index begin, Index end, double way, const Visit& visit) {
    for (Index c = begin; c < end; ++c) {
      const Couple& couple = couples_[c];
      if (!(couple.least - couple.aside < (1.0 + kRounding) * Pair::reachFor(couple.thickness, way))) continue;
      for (std::size_t k = couple.begin; k < couple.end; ++k) {
        Watched& watched = watched_[k];
        const double least = watched.distance - share_ * watched.nearing - couple.aside;
        if (least < (1.0 + kRounding) * watched.pair.reachFor(way)) visit(watched, least);
      }
    }
  }
  bool covers(const Points& positions, double way);
  void look(const Points& positions, double way, const Points& from, const Points& to);
  void groupByCouple();

  PairList& list_;
  ClearMotion motion_;
  Points way_, end_, predicted_;  // m, scratch
  bool is_watching_ = false;
  double watched_way_ = 0.0;  // m, of the last look
  double spare_ = 0.0;        // m: as of a couple, of patches that are none
  double share_ = 0.0;        // of the predicted motion that is done, at the last ensure()
  std::vector<Watched> watched_;
  AppendedParts<Watched> watched_parts_;
  std::vector<Couple> couples_;
  std::vector<Index> patches_;            // of the couples, ascending
  std::vector<Patches::Ways> aside_;      // (patches), of these: beside the prediction
  Index num_looks_ = 0, num_served_ = 0;  // calls that the last look has served
  Index failures_ = 0, pause_ = 0;        // looks that served once, and calls until the next one
};

}  // namespace deformable_surface::contact
