#include "deformable_surface/contact/pair_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::contact {
namespace {

// Of the usual reach of the lists. The numbers were tried on a towel of 1000 points that is folded, on a busy machine: with an
// allowance of 0.25 to 0.5, and a motion predicted for 1 or 2, the times differ by less than their scatter of a tenth.
constexpr double kAllowance = 0.35;  // by which patches may leave the prediction
constexpr double kSpare = 4.0;       // couples whose pairs are farther away are not looked at one by one
constexpr double kAhead = 1.0;       // relative way of any two points for which the motion is predicted

constexpr double kMostAhead = 64.0;  // of the way at the look: points that hardly move do not go on for long
constexpr Index kMostFailures = 4;   // after each look that serves once, it takes twice as many calls until the next one

}  // namespace

bool PairWatch::ensure(const Points& positions, double way, const Points& from, const Points& to) {
  if (!(list_.largestReachFor(way) <= list_.usualReach())) return false;
  if (covers(positions, way)) {
    ++num_served_;
    return true;
  }
  if (pause_ > 0) {
    --pause_;
    return false;
  }
  const bool has_served = num_served_ > 1 || !is_watching_;
  failures_ = has_served ? 0 : std::min(failures_ + 1, kMostFailures);
  pause_ = (Index{1} << failures_) - 1;
  num_served_ = 0;
  look(positions, way, from, to);
  return true;
}

bool PairWatch::covers(const Points& positions, double way) {
  if (!is_watching_) return false;
  const double rise = std::max(0.0, way - watched_way_);
  share_ = motion_.shareAt(positions[motion_.leader]);
  if (!(motion_.boundAside(positions) + rise <= spare_)) return false;
  if (couples_.empty()) return true;
  predicted_.resize(positions.size());
  for (std::size_t i = 0; i < predicted_.size(); ++i) predicted_[i] = motion_.from[i] + share_ * motion_.way[i];
  list_.patches().measureWays(predicted_, positions, patches_, aside_);
  for (Couple& couple : couples_) {
    couple.aside = aside_[couple.one].findRelative(aside_[couple.other]);
    if (!(couple.aside + rise <= couple.spare)) return false;
  }
  return true;
}

void PairWatch::look(const Points& positions, double way, const Points& from, const Points& to) {
  ++num_looks_;
  way_.resize(positions.size());
  for (std::size_t i = 0; i < way_.size(); ++i) way_[i] = to[i] - from[i];
  const double most = findLargestRelativeWay(from, to);
  motion_.predict(positions, way_, most > 0.0 ? std::min(kMostAhead, kAhead * list_.usualReach() / most) : 0.0);
  end_.resize(positions.size());
  for (std::size_t i = 0; i < end_.size(); ++i) end_[i] = positions[i] + motion_.way[i];
  is_watching_ = true;
  watched_way_ = way;
  share_ = 0.0;
  const double allowance = kAllowance * list_.usualReach(), spare = kSpare * list_.usualReach();
  list_.update(positions, end_, {list_.largestReachFor(way) + allowance, 1.0, std::numeric_limits<double>::infinity(), spare});
  watched_.clear();
  list_.collectByCouple(watched_, watched_parts_, [&](Index couple, const Pair& pair, double least, std::vector<Watched>& list) {
    const double nearing = pair.findRelativeWay([&](int v) -> const Vec3& { return motion_.way[pair.vertices[v]]; });
    const double within = pair.reachFor(way) + allowance + nearing;
    if (!(least < within)) return;
    const Closest closest = findClosest(pair, positions);
    const double distance = std::sqrt(closest.squaredDistance());
    if (distance < within) list.push_back({pair, couple, distance, nearing, closest.gap / distance});
  });
  groupByCouple();
}

void PairWatch::groupByCouple() {
  const double allowance = kAllowance * list_.usualReach(), reach = list_.largestReachFor(watched_way_);
  spare_ = list_.apart() - findLargestRelativeWay(motion_.from, end_) - reach;
  couples_.clear();
  patches_.clear();
  std::size_t end = 0;
  list_.visitCouples([&](Index number, Index one, Index other, double nearest, double nearing) {
    Couple couple{one, other, end, end, std::numeric_limits<double>::infinity(), 0.0, allowance, 0.0};
    for (; end < watched_.size() && watched_[end].couple == number; ++end) {
      couple.least = std::min(couple.least, watched_[end].distance - watched_[end].nearing);
      couple.thickness = std::max(couple.thickness, watched_[end].pair.thickness);
    }
    couple.end = end;
    if (couple.begin == couple.end) couple.spare = std::max(allowance, nearest - nearing - reach);
    if (couple.spare > kSpare * list_.usualReach()) {
      spare_ = std::min(spare_, couple.spare);
      return;
    }
    couples_.push_back(couple);
    patches_.push_back(one);
    patches_.push_back(other);
  });
  std::sort(patches_.begin(), patches_.end());
  patches_.erase(std::unique(patches_.begin(), patches_.end()), patches_.end());
}

}  // namespace deformable_surface::contact
