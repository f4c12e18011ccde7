// The pairs that may come near within the next sub-steps: one look at the lists serves many.
#pragma once

#include "deformable_surface/contact/clear_motion.h"
#include "deformable_surface/contact/pair_list.h"

#include <atomic>
#include <vector>

namespace deformable_surface::contact {

/// A look at the lists predicts that the points keep their velocities. It finds the pairs that may come near while they do,
/// within an allowance. Until the points leave the prediction, only these pairs are measured. Results do not depend on when looks
/// are taken: all pairs within reach are found, in the order of the lists.
class PairWatch {
 public:
  /// list: kept by reference.
  explicit PairWatch(PairList& list) : list_(list) {}

  /// After a change of what the lists hold.
  void forget() { watched_reach_ = -1.0; }
  /// Ensures that all pairs nearer than reach (m) at these positions are watched. next: (n) m, where the points are on their way
  /// to; null: unknown. False if lists cost less: for a long reach, or motion that no prediction serves.
  bool ensure(const Points& positions, double reach, const Points* next = nullptr);
  /// As in PairList, for the positions of the last ensure() and pairs nearer than reach (m).
  template <class Item, class Visit>
  void collectNear(double reach, std::vector<Item>& to, AppendedParts<Item>& parts, const Visit& visit) const {
    parallelAppend(static_cast<Index>(watched_.size()), kBlock, to, parts, [&](Index begin, Index end, auto& list) {
      visitNear(begin, end, reach, [&](const Pair& pair, double least) { visit(pair, least, list); });
    });
  }
  template <class Test>
  bool isAnyNear(double reach, const Test& test) const {
    std::atomic<bool> is_any{false};
    parallelFor(static_cast<Index>(watched_.size()), kBlock, [&](Index begin, Index end) {
      visitNear(begin, end, reach, [&](const Pair& pair, double least) {
        if (!is_any && test(pair, least)) is_any = true;
      });
    });
    return is_any;
  }
  Index numLooks() const { return num_looks_; }

 private:
  static constexpr Index kBlock = 1024;  // pairs per task

  struct Watched {
    Pair pair;
    double distance, nearing;  // m: at the look; by at most that much in the predicted motion
  };

  template <class Visit>
  void visitNear(Index begin, Index end, double reach, const Visit& visit) const {
    for (Index k = begin; k < end; ++k) {
      const double least = watched_[k].distance - share_ * watched_[k].nearing - aside_;
      if (least < reach) visit(watched_[k].pair, least);
    }
  }
  bool covers(const Points& positions, double reach);
  void look(const Points& positions, const Points& next, double reach);

  PairList& list_;
  ClearMotion motion_;
  Points way_, end_;                  // m, scratch
  double watched_reach_ = -1.0;       // m; negative: nothing is watched
  double share_ = 0.0, aside_ = 0.0;  // of the prediction that is done, and beside it (m), at the last ensure()
  std::vector<Watched> watched_;
  AppendedParts<Watched> watched_parts_;
  Index num_looks_ = 0, num_served_ = 0;  // calls that the last look has served
  Index failures_ = 0, pause_ = 0;        // looks that served once, and calls until the next one
};

}  // namespace deformable_surface::contact
