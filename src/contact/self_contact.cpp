#include "deformable_surface/contact/self_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::contact {
namespace {

// Factor on a pair's thickness: parts as near as that may touch soon, at any speed.
constexpr double kWatched = 1.5;
constexpr double kLongest = 4.0;        // of the usual reach: a longer piece of a way would need too many pairs
constexpr double kShortest = 1.0 / 64;  // of a way: pieces that are not needed shorter where nothing is near
constexpr double kStepsAhead = 8.0;     // for which a motion is predicted
constexpr Index kFewPatches = 48;       // of surfaces whose parts have no proofs: their lists cost less
// Of the usual reach: the way of a patch's points against each other in a step up to which lists cost less than proofs of parts.
// On closed surfaces they always do: balls that are pulled or dropped, and a torus and a tube that sag (1000 and 4000 points).
constexpr double kCalm = 1.0;
// Of the median edge: the motion until a quick look is taken again. Longer ways look farther, and find the next ring of points
// near.
constexpr double kSlack = 0.6;

}  // namespace

SelfContact::SelfContact(Points rest, const std::vector<Triangle>& triangles, std::vector<double> masses,
                         const SelfContactParams& params)
    : motion_(rest.size()),
      list_(rest, triangles, params.thickness, !params.is_body),
      clearance_(std::move(rest), triangles, kWatched * params.thickness,
                 list_.patches().size() < kFewPatches ? nullptr : &list_.patches()),
      masses_(std::move(masses)),
      params_(params) {
  if (params_.looks_first) clearance_.lookInstead(list_.patches(), kSlack * list_.medianEdge(), params_.is_body);
}

void SelfContact::keepWhole(const std::vector<char>& is_whole) {
  list_.keepWhole(is_whole);
  // A look knows nothing of cuts: the sides of one are neighbours.
  if (params_.looks_first) clearance_.setLooks(std::count(is_whole.begin(), is_whole.end(), char{0}) == 0);
  forgetNear();
}

void SelfContact::setMasses(const std::vector<double>& masses) {
  if (masses == masses_) return;
  masses_ = masses;
  forgetNear();
}

void SelfContact::setRate(double rate) {
  if (rate == params_.rate) return;
  params_.rate = rate;
  forgetNear();
}

void SelfContact::forgetNear() {
  near_.clear();
  measured_at_.clear();
  measured_way_ = -1.0;
  watch_.forget();
}

bool SelfContact::findCrossed(const Points& positions) {
  const bool has_changed = list_.findCrossed(positions);
  if (has_changed) forgetNear();
  return has_changed;
}

std::vector<SelfContact::Near>& SelfContact::measure(const Points& positions, double way) {
  if (way <= measured_way_ && positions == measured_at_) return near_;
  way = std::max(way, usual_way_);
  near_.clear();
  const double reach = list_.largestReachFor(way);
  const bool is_near = reach <= clearance_.distance();
  if (!is_near || !clearance_.isApartAt(positions)) {
    const auto add = [&](const Pair& pair, const Closest& closest, std::vector<Near>& near) {
      const double distance = std::sqrt(closest.squaredDistance());
      if (distance < pair.reachFor(way)) near.push_back({pair, closest, distance, weigh(pair, positions)});
    };
    if (watch_.ensure(positions, way, measured_at_.empty() ? positions : measured_at_, positions)) {
      watch_.collectNear(positions, way, near_, near_parts_, add);
    } else {
      list_.update(positions, reach, is_near ? clearance_.partsApart(positions) : nullptr);
      list_.collectNear(near_, near_parts_, [&](const Pair& pair, double least, std::vector<Near>& near) {
        if (least < pair.reachFor(way)) add(pair, findClosest(pair, positions), near);
      });
    }
  }
  findRates();
  measured_at_ = positions;
  measured_way_ = way;
  return near_;
}

void SelfContact::forgetMotion() {
  clearance_.forget();
  beginMotion();
}

void SelfContact::beginMotion() {
  clearance_.forgetParts();
  clearance_.tryAllParts();
  is_calm_ = was_uncrossed_ = has_proof_failed_ = false;
}

bool SelfContact::foresee(const Points& positions, const Points& velocities, double time) {
  return clearance_.prove(positions, velocities, kStepsAhead * time);
}

bool SelfContact::isClear(const Points& rest) {
  const bool is_clear = clearance_.prove(rest, Points(rest.size(), Vec3::Zero()), 1.0) && clearance_.isApart();
  clearance_.forget();
  return is_clear;
}

bool SelfContact::mayTouch(const Points& positions, const Points& velocities, double time) {
  beginMotion();
  if (clearance_.staysApart(positions, velocities, time)) return false;
  for (const double steps : {kStepsAhead, 1.0})
    if (clearance_.prove(positions, velocities, steps * time) && clearance_.isApart()) return false;
  for (std::size_t i = 0; i < motion_.size(); ++i) motion_[i] = positions[i] + time * velocities[i];
  is_calm_ = list_.findLargestLocalWay(positions, motion_) <= kCalm * list_.usualReach();
  const double watched_by_all = kWatched * list_.thickness();
  const PairList::Reach reach{watched_by_all, 1.0, watched_by_all + kLongest * list_.usualReach()};
  if (!is_calm_) {
    if (list_.areFar(positions, motion_, reach)) return false;
    is_calm_ = clearance_.looks() || !clearance_.hasOutline();
  }
  if (!is_calm_) {
    clearance_.proveParts(positions, velocities, time);
    clearance_.tryAllParts();
  }
  const Cover* const apart = clearance_.partsApart(positions);
  const bool has_come_near = may_touch_;
  may_touch_ = false;
  const auto test = [&](const Pair& pair, double = 0.0) { return comesNear(pair, positions, velocities, time, reach.most); };
  // Where some came near in the last step, one of the known pairs mostly does. Lists of all within the reach are long.
  if (has_come_near) list_.visitKnown(apart, [&](const Pair& pair) { may_touch_ = may_touch_ || test(pair); });
  if (may_touch_) return true;
  list_.update(positions, motion_, reach, apart);
  may_touch_ = list_.isAnyNear(test);
  return may_touch_;
}

// most: m, of the distance now. See mayTouch().
bool SelfContact::comesNear(const Pair& pair, const Points& positions, const Points& velocities, double time, double most) const {
  const Closest closest = findClosest(pair, positions);
  const double distance = std::sqrt(closest.squaredDistance()), watched = kWatched * pair.thickness;
  if (!(distance < most)) return false;
  // The rate of the distance: a common rotation brings no parts nearer.
  double rate = 0.0;
  for (int v = 0; v < 4; ++v) rate += closest.weight[v] * closest.gap.dot(velocities[pair.vertices[v]]) / distance;
  return distance < watched || distance + time * rate < watched;
}

// Looks at the way in pieces: limit() is the more cautious, the longer a piece is.
bool SelfContact::staysApart(const Points& before, const Points& after) {
  forgetMotion();
  way_.resize(before.size());
  double farthest = 0.0;
  for (std::size_t i = 0; i < way_.size(); ++i) {
    way_[i] = after[i] - before[i];
    farthest = std::max(farthest, way_[i].norm());
  }
  if (clearance_.prove(before, way_, 1.0) && clearance_.isApart()) return true;
  forgetMotion();
  piece_begin_ = piece_end_ = before;
  double done = 0.0, piece = 1.0;
  while (done < 1.0) {
    const double end = std::min(1.0, done + piece);
    for (std::size_t i = 0; i < way_.size(); ++i) piece_end_[i] = before[i] + end * way_[i];
    reached_ = piece_end_;
    if (piece * farthest < kLongest * list_.usualReach() && limit(piece_begin_, reached_).empty()) {
      piece_begin_.swap(piece_end_);
      done = end;
      piece *= 2.0;
    } else {
      piece *= 0.5;
      if (piece < kShortest) return false;
    }
  }
  const std::vector<Near>& all = measure(after);
  return std::none_of(all.begin(), all.end(), touches);
}

Index SelfContact::countTouching(const Points& positions) {
  const std::vector<Near>& all = measure(positions);
  return static_cast<Index>(std::count_if(all.begin(), all.end(), touches));
}

std::vector<SelfContactForce> SelfContact::listForces(const Points& positions, const Points& velocities,
                                                      const std::vector<PairAnchor>& anchors) {
  std::vector<SelfContactForce> list;
  for (Near& near : measure(positions)) {
    if (!touches(near)) continue;
    const double depth = near.pair.thickness - near.distance;
    Vec3 force = findSpring(near).force / near.distance * near.closest.gap;
    if (params_.friction > 0.0) {
      const Rub rub = findRub(near, positions, findAnchor(near, anchors, 0));
      force += rub.law.findForce(rub.stretch, findSliding(near, velocities), rub.slid);
    }
    list.push_back({near.pair, near.closest, depth, force});
  }
  return list;
}

double SelfContact::leastDistance(const Points& positions) {
  double least = std::numeric_limits<double>::infinity();
  for (const Near& near : measure(positions))
    if (near.distance < near.pair.thickness) least = std::min(least, near.distance);
  return least;
}

}  // namespace deformable_surface::contact
