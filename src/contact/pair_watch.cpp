#include "deformable_surface/contact/pair_watch.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::contact {
namespace {

// Of the usual reach of the lists. Among the cheapest of 0.1, 0.25 and 0.5, and of 0.1 to 1, for 4096 points that drape over a
// ball. One run each on a busy machine: they differ by a quarter at most.
constexpr double kAllowance = 0.25;  // by which the points may leave the prediction
constexpr double kAhead = 1.0;       // relative way of any two points for which the motion is predicted
constexpr double kMostAhead = 64.0;  // of the way at the look: points that hardly move do not go on for long
constexpr Index kMostFailures = 4;   // after each look that serves once, it takes twice as many calls until the next one

}  // namespace

bool PairWatch::ensure(const Points& positions, double reach, const Points* next) {
  if (!(reach <= list_.usualReach())) return false;
  if (covers(positions, reach)) {
    ++num_served_;
    return true;
  }
  if (pause_ > 0) {
    --pause_;
    return false;
  }
  const bool has_served = num_served_ > 1 || watched_reach_ < 0.0;
  failures_ = has_served ? 0 : std::min(failures_ + 1, kMostFailures);
  pause_ = (Index{1} << failures_) - 1;
  num_served_ = 0;
  look(positions, next ? *next : positions, reach);
  return true;
}

bool PairWatch::covers(const Points& positions, double reach) {
  if (watched_reach_ < 0.0) return false;
  share_ = motion_.shareAt(positions[motion_.leader]);
  aside_ = motion_.boundAside(positions);
  return reach + aside_ <= watched_reach_;
}

void PairWatch::look(const Points& positions, const Points& next, double reach) {
  ++num_looks_;
  way_.resize(positions.size());
  for (std::size_t i = 0; i < way_.size(); ++i) way_[i] = next[i] - positions[i];
  const double way = &positions == &next ? 0.0 : findLargestRelativeWay(positions, next);
  motion_.predict(positions, way_, way > 0.0 ? std::min(kMostAhead, kAhead * list_.usualReach() / way) : 0.0);
  end_.resize(positions.size());
  for (std::size_t i = 0; i < end_.size(); ++i) end_[i] = positions[i] + motion_.way[i];
  watched_reach_ = reach + kAllowance * list_.usualReach();
  share_ = aside_ = 0.0;
  list_.update(positions, end_, {watched_reach_, 1.0});
  watched_.clear();
  list_.collectNear(watched_, watched_parts_, [&](const Pair& pair, double least, std::vector<Watched>& list) {
    double squared = 0.0;
    for (int v = 0; v < pair.numFirst(); ++v)
      for (int w = pair.numFirst(); w < 4; ++w)
        squared = std::max(squared, (motion_.way[pair.vertices[v]] - motion_.way[pair.vertices[w]]).squaredNorm());
    const double nearing = std::sqrt(squared);
    if (!(least - nearing < watched_reach_)) return;
    const double distance = std::sqrt(findClosest(pair, positions).squaredDistance());
    if (distance - nearing < watched_reach_) list.push_back({pair, distance, nearing});
  });
}

}  // namespace deformable_surface::contact
