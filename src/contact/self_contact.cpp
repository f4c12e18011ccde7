#include "deformable_surface/contact/self_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deformable_surface::contact {
namespace {

// Fraction of a pair's thickness: limit() lets parts that move come no nearer.
constexpr double kLeast = 0.5;
// A spring that hardens does so from this share of the depth at kLeast on. From this share of the remainder on, where it is some
// hundred times as strong, it goes on linearly.
constexpr double kSoft = 0.5, kHardest = 0.98;
// Of the thickness: the depth from which on a spring that hardens is damped in full. A force that sets in at once has no balance.
constexpr double kDamped = 0.1;
// Squared sine of the angle below which edges count as nearly parallel: 12 degrees.
constexpr double kParallel = 0.04;
// Fraction of the room of a pair that its points may use in one step: below 1, so that rounding causes no crossing.
constexpr double kOfRoom = 0.9;
// Factor on a pair's thickness: parts as near as that may touch soon, at any speed.
constexpr double kWatched = 1.5;
constexpr double kLongest = 4.0;        // of the usual reach: a longer piece of a way would need too many pairs
constexpr double kShortest = 1.0 / 64;  // of a way: pieces that are not needed shorter where nothing is near
constexpr double kAhead = 8.0;          // calls of limit() for which the motion of the present one is predicted
constexpr double kStepsAhead = 8.0;     // for which a motion is predicted
constexpr Index kMostFailures = 4;      // after each, proofs are tried half as often
constexpr int kCollisions = 8;          // passes
constexpr double kRounding = 1e-15;     // m
constexpr double kPushTime = 0.05;      // s: crossed parts that nothing else moves pass each other by an edge in this time

}  // namespace

SelfContact::SelfContact(Points rest, const std::vector<Triangle>& triangles, std::vector<double> masses,
                         const SelfContactParams& params)
    : clearance_(rest, triangles, kWatched * params.thickness),
      motion_(rest.size()),
      list_(std::move(rest), triangles, params.thickness, params.takes_lone_points),
      masses_(std::move(masses)),
      params_(params) {}

void SelfContact::keepWhole(const std::vector<char>& is_whole) {
  list_.keepWhole(is_whole);
  forgetNear();
}

void SelfContact::forgetNear() {
  near_.clear();
  measured_at_.clear();
  measured_reach_ = 0.0;
}

bool SelfContact::findCrossed(const Points& positions) {
  const bool has_changed = list_.findCrossed(positions);
  if (has_changed) forgetNear();
  return has_changed;
}

bool SelfContact::beginPushing(const Points& positions) {
  pushes_ = findPushes(list_, positions, masses_);
  return !pushes_.empty();
}

double SelfContact::dampingOf(const Push& push) const {
  double least = masses_[push.vertices[0]];
  for (const Index v : push.vertices) least = std::min(least, masses_[v]);
  return 2.0 * least * params_.rate;
}

double SelfContact::forceOf(const Push& push) const { return dampingOf(push) * list_.medianEdge() / kPushTime; }

void SelfContact::addPushes(const Points& velocities, Points& forces) const {
  for (const Push& push : pushes_) {
    double speed = 0.0;
    for (int v = 0; v < 5; ++v) speed += push.weight[v] * push.direction.dot(velocities[push.vertices[v]]);
    const Vec3 force = (forceOf(push) - dampingOf(push) * speed) * push.direction;
    for (int v = 0; v < 5; ++v) forces[push.vertices[v]] += push.weight[v] * force;
  }
}

double SelfContact::workOfPushes(const Points& before, const Points& after) const {
  double work = 0.0;
  for (const Push& push : pushes_)
    for (int v = 0; v < 5; ++v) {
      const Index i = push.vertices[v];
      work += forceOf(push) * push.weight[v] * push.direction.dot(after[i] - before[i]);
    }
  return work;
}

void SelfContact::addPushStiffness(double step, BlockSparse& stiffness_matrix) const {
  if (!(step > 0.0)) return;
  for (const Push& push : pushes_) {
    const Mat3 block = dampingOf(push) / step * push.direction * push.direction.transpose();
    for (int v = 0; v < 5; ++v)
      for (int w = 0; w <= v; ++w)
        stiffness_matrix.add(push.vertices[v], push.vertices[w], push.weight[v] * push.weight[w] * block);
  }
}

void SelfContact::addPushRowBounds(std::vector<double>& damping) const {
  // The absolute weights sum to two.
  for (const Push& push : pushes_)
    for (int v = 0; v < 5; ++v) damping[push.vertices[v]] += 2.0 * std::abs(push.weight[v]) * dampingOf(push);
}

bool SelfContact::touches(const Near& near) { return near.distance < near.pair.thickness && near.distance > 0.0; }

void SelfContact::addToMatrix(const Near& near, const Mat3& block, BlockSparse& matrix) {
  for (int v = 0; v < 4; ++v)
    for (int w = 0; w <= v; ++w)
      matrix.add(near.pair.vertices[v], near.pair.vertices[w], near.closest.weight[v] * near.closest.weight[w] * block);
}

// Pairs nearer than reach, or than the thickness.
const std::vector<SelfContact::Near>& SelfContact::measure(const Points& positions, double reach) {
  reach = std::max(reach, list_.thickness());
  if (reach <= measured_reach_ && positions == measured_at_) return near_;
  list_.update(positions, reach);
  near_.clear();
  list_.visitNear([&](const Pair& pair, double) {
    const Closest closest = findClosest(pair, positions);
    const double squared = closest.squaredDistance();
    if (squared < reach * reach) near_.push_back({pair, closest, std::sqrt(squared), weigh(pair, positions)});
  });
  measured_at_ = positions;
  measured_reach_ = reach;
  return near_;
}

void SelfContact::forgetMotion() {
  clearance_.forget();
  failures_ = pause_ = 0;
  was_uncrossed_ = false;
}

bool SelfContact::staysUncrossed(const Points& before, const Points& after, bool continues) {
  was_uncrossed_ = clearance_.staysUncrossed(before, after, continues && was_uncrossed_);
  if (was_uncrossed_) return true;
  if (pause_ > 0) {
    --pause_;
    return false;
  }
  for (std::size_t i = 0; i < motion_.size(); ++i) motion_[i] = after[i] - before[i];
  if (clearance_.prove(before, motion_, kAhead) && clearance_.staysUncrossed(before, after)) {
    failures_ = 0;
    was_uncrossed_ = true;
    return true;
  }
  failures_ = std::min(failures_ + 1, kMostFailures);
  pause_ = (Index{1} << failures_) - 1;
  return false;
}

bool SelfContact::mayTouch(const Points& positions, const Points& velocities, double time) {
  failures_ = pause_ = 0;
  was_uncrossed_ = false;
  if (clearance_.staysApart(positions, velocities, time)) return false;
  for (const double steps : {kStepsAhead, 1.0})
    if (clearance_.prove(positions, velocities, steps * time) && clearance_.isApart()) return false;
  for (std::size_t i = 0; i < motion_.size(); ++i) motion_[i] = positions[i] + time * velocities[i];
  const double watched_by_all = kWatched * list_.thickness();
  const PairList::Reach reach{watched_by_all, 1.0, watched_by_all + kLongest * list_.usualReach()};
  if (list_.areFar(positions, motion_, reach)) return false;
  list_.update(positions, motion_, reach);
  bool may_touch = false;
  list_.visitNear([&](const Pair& pair, double) {
    if (may_touch) return;
    const Closest closest = findClosest(pair, positions);
    const double distance = std::sqrt(closest.squaredDistance()), watched = kWatched * pair.thickness;
    // The rate of the distance: a common rotation brings no parts nearer.
    double rate = 0.0;
    for (int v = 0; v < 4; ++v) rate += closest.weight[v] * closest.gap.dot(velocities[pair.vertices[v]]) / distance;
    may_touch = distance < watched || distance + time * rate < watched;
  });
  return may_touch;
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
  const std::vector<Near>& all = measure(after, 0.0);
  return std::none_of(all.begin(), all.end(), touches);
}

// The closest points of nearly parallel edges leap as these turn, and with them the force. Their vertices meet triangles, too. So
// their share vanishes as they become parallel, with a continuous derivative [Li 2020, sec. 4.5].
double SelfContact::weigh(const Pair& pair, const Points& positions) const {
  if (!params_.hardens || !pair.is_edges) return 1.0;
  const auto& v = pair.vertices;
  const Vec3 a = positions[v[1]] - positions[v[0]], b = positions[v[3]] - positions[v[2]];
  const double c = a.cross(b).squaredNorm() / (kParallel * a.squaredNorm() * b.squaredNorm());
  return c < 1.0 ? c * (2.0 - c) : 1.0;
}

// Minus the energy times the derivative of the weight. With A = |a|^2, B = |b|^2: c = (1 - (a b)^2 / (A B)) / kParallel.
void SelfContact::addTurning(const Near& near, const Points& positions, Points& forces) const {
  if (!(near.weight > 0.0)) return;
  const auto& v = near.pair.vertices;
  const Vec3 a = positions[v[1]] - positions[v[0]], b = positions[v[3]] - positions[v[2]];
  const double squared_a = a.squaredNorm(), squared_b = b.squaredNorm(), product = a.dot(b);
  const double c = a.cross(b).squaredNorm() / (kParallel * squared_a * squared_b);
  const double factor =
      findSpring(near).energy / near.weight * (2.0 - 2.0 * c) * 2.0 * product / (kParallel * squared_a * squared_b);
  const Vec3 on_a = factor * (b - product / squared_a * a), on_b = factor * (a - product / squared_b * b);
  forces[v[1]] += on_a;
  forces[v[0]] -= on_a;
  forces[v[3]] += on_b;
  forces[v[2]] -= on_b;
}

SelfContact::Damping SelfContact::findDamping(const Near& near) const {
  if (!params_.hardens) return {params_.damping, 0.0};
  const double full = kDamped * near.pair.thickness, depth = near.pair.thickness - near.distance;
  const double damping = params_.damping * near.weight;
  return depth < full ? Damping{damping * depth / full, damping / full} : Damping{damping, 0.0};
}

double SelfContact::findOpening(const Near& near, const Points& velocities) {
  const Vec3 normal = near.closest.gap / near.distance;
  double speed = 0.0;
  for (int v = 0; v < 4; ++v) speed += near.closest.weight[v] * normal.dot(velocities[near.pair.vertices[v]]);
  return speed;
}

// Linear; where it hardens plus the barrier -y^2 ln(1 - y) [Li 2020, eq. 6], here of the share y of the depth beyond a soft part.
SelfContact::Spring SelfContact::findSpring(const Near& near) const {
  const double depth = near.pair.thickness - near.distance;
  if (!(depth > 0.0)) return {0.0, 0.0, 0.0};
  const double k = near.weight * stiffness(near.pair);
  Spring spring{0.5 * k * depth * depth, k * depth, k};
  const double deepest = (1.0 - kLeast) * near.pair.thickness, soft = kSoft * deepest, hard = deepest - soft;
  if (!params_.hardens || depth <= soft) return spring;
  const double y = (depth - soft) / hard, x = std::min(y, kHardest), over = y - x, rest = 1.0 - x, log = std::log(rest);
  const double slope = -2.0 * log + 4.0 * x / rest + x * x / (rest * rest), force = -2.0 * x * log + x * x / rest;
  const double scale = k * deepest * deepest;
  spring.energy += scale * (-x * x * log + over * (force + 0.5 * over * slope));
  spring.force += scale / hard * (force + over * slope);
  spring.stiffness += scale / (hard * hard) * slope;
  return spring;
}

double SelfContact::stiffness(const Pair& pair) const {
  double least = masses_[pair.vertices[0]];
  for (const Index v : pair.vertices) least = std::min(least, masses_[v]);
  return least * params_.rate * params_.rate;
}

void SelfContact::addForces(const Points& positions, Points& forces) {
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Pair& pair = near.pair;
    const Vec3 force = findSpring(near).force / near.distance * near.closest.gap;
    for (int v = 0; v < 4; ++v) forces[pair.vertices[v]] += near.closest.weight[v] * force;
    if (near.weight < 1.0) addTurning(near, positions, forces);
  }
}

void SelfContact::addDampingForces(const Points& positions, const Points& velocities, Points& forces) {
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Pair& pair = near.pair;
    const Vec3 normal = near.closest.gap / near.distance;
    const Vec3 force = -2.0 * findDamping(near).share * stiffness(pair) / params_.rate * findOpening(near, velocities) * normal;
    for (int v = 0; v < 4; ++v) forces[pair.vertices[v]] += near.closest.weight[v] * force;
  }
}

double SelfContact::potential(const Points& positions) {
  double sum = 0.0;
  for (const Near& near : measure(positions, 0.0)) sum += findSpring(near).energy;
  return sum;
}

void SelfContact::addStiffness(const Points& positions, const Points& velocities, double step, BlockSparse& stiffness_matrix) {
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    double along = findSpring(near).stiffness;
    if (step > 0.0) {
      const Damping damping = findDamping(near);
      along += 2.0 * stiffness(near.pair) / params_.rate * (damping.share / step - damping.onset * findOpening(near, velocities));
    }
    const Vec3 normal = near.closest.gap / near.distance;
    addToMatrix(near, std::max(0.0, along) * normal * normal.transpose(), stiffness_matrix);
  }
}

void SelfContact::addRowBounds(const Points& positions, std::vector<double>& stiffness_bounds, std::vector<double>& damping) {
  for (const Near& near : measure(positions, 0.0)) {
    const Pair& pair = near.pair;
    if (!(near.distance < pair.thickness)) continue;
    // The absolute weights sum to two.
    for (int v = 0; v < 4; ++v) {
      const double twice = 2.0 * std::abs(near.closest.weight[v]);
      stiffness_bounds[pair.vertices[v]] += twice * findSpring(near).stiffness;
      damping[pair.vertices[v]] += 2.0 * params_.damping / params_.rate * twice * stiffness(pair);
    }
  }
}

SelfContact::Rub SelfContact::findRub(const Near& near, const Points& positions, const std::vector<PairAnchor>& anchors) const {
  const Pair& pair = near.pair;
  const double spring = stiffness(pair), pressing = findSpring(near).force;
  const FrictionLaw law{params_.friction * pressing, params_.kinetic_friction * pressing, spring,
                        2.0 * params_.damping * spring / params_.rate};
  const Vec3 normal = near.closest.gap / near.distance;
  const auto at = std::lower_bound(anchors.begin(), anchors.end(), pair,
                                   [](const PairAnchor& a, const Pair& p) { return a.isBefore(p.vertices, p.is_edges); });
  if (at == anchors.end() || at->is_edges != pair.is_edges || at->vertices != pair.vertices)
    return {law, normal, Vec3::Zero(), false, nullptr};
  Vec3 moved = -at->offset;
  for (int v = 0; v < 4; ++v) moved += at->weight[v] * positions[pair.vertices[v]];
  return {law, normal, moved - moved.dot(normal) * normal, at->slides, &*at};
}

Vec3 SelfContact::findSliding(const Near& near, const Points& velocities) {
  Vec3 relative = Vec3::Zero();
  for (int v = 0; v < 4; ++v) relative += near.closest.weight[v] * velocities[near.pair.vertices[v]];
  const Vec3 normal = near.closest.gap / near.distance;
  return relative - relative.dot(normal) * normal;
}

void SelfContact::addFriction(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                              Points& forces) {
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    const Vec3 force = rub.law.findForce(rub.stretch, findSliding(near, velocities), rub.slides);
    for (int v = 0; v < 4; ++v) forces[near.pair.vertices[v]] += near.closest.weight[v] * force;
  }
}

double SelfContact::frictionEnergy(const Points& positions, const std::vector<PairAnchor>& anchors) {
  double sum = 0.0;
  if (anchors.empty()) return sum;
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    const double force = std::min(rub.law.stiffness * rub.stretch.norm(), rub.law.static_limit);
    sum += 0.5 * force * force / rub.law.stiffness;
  }
  return sum;
}

void SelfContact::addFrictionStiffness(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                                       double step, BlockSparse& stiffness_matrix) {
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    const double share = rub.law.findShare(rub.stretch, findSliding(near, velocities), rub.slides);
    const double along = share * ((rub.anchor ? rub.law.stiffness : 0.0) + rub.law.damping / step);
    addToMatrix(near, along * (Mat3::Identity() - rub.normal * rub.normal.transpose()), stiffness_matrix);
  }
}

void SelfContact::moveAnchors(const Points& positions, const Points& velocities, std::vector<PairAnchor>& anchors) {
  next_.clear();
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const Rub rub = findRub(near, positions, anchors);
    Vec3 stretch = rub.stretch;
    const bool slides = rub.law.slide(stretch, findSliding(near, velocities), rub.slides);
    if (rub.anchor && !slides) {
      next_.push_back(*rub.anchor);
      next_.back().slides = false;
    } else {
      const Pair& pair = near.pair;
      next_.push_back({pair.vertices, pair.is_edges, near.closest.weight, near.closest.gap - stretch, slides});
    }
  }
  std::sort(next_.begin(), next_.end(),
            [](const PairAnchor& a, const PairAnchor& b) { return a.isBefore(b.vertices, b.is_edges); });
  anchors = next_;
}

SelfContact::Approach SelfContact::makeApproach(const Near& near, const Points& before) const {
  const Pair& pair = near.pair;
  Approach approach;
  approach.vertices = pair.vertices;
  approach.num_first = pair.numFirst();
  approach.normal = near.closest.gap / near.distance;
  approach.room = kOfRoom * std::max(0.0, near.distance - kLeast * pair.thickness);
  for (int v = 0; v < 4; ++v) {
    const bool is_first = v < approach.num_first;
    double behind = 0.0;
    for (int w = 0; w < 4; ++w)
      if ((w < approach.num_first) == is_first)
        behind += std::abs(near.closest.weight[w]) * approach.normal.dot(before[pair.vertices[v]] - before[pair.vertices[w]]);
    approach.behind[v] = std::max(0.0, is_first ? behind : -behind);
  }
  return approach;
}

// A plane across the gap separates two convex primitives. Take the point of the first that moves farthest towards the second, and
// the point of the second that moves farthest towards the first. If both together use less than the gap, a moving plane between
// them remains a separating plane. Common motion does not count.
SelfContact::Worst SelfContact::findWorst(const Approach& approach) const {
  Worst worst{-1, -1, -approach.room};
  double first = 0.0, second = 0.0;
  for (int v = 0; v < 4; ++v) {
    const double along = approach.normal.dot(ways_[approach.vertices[v]]);
    if (v < approach.num_first) {
      const double nearing = -along - approach.behind[v];
      if (worst.first < 0 || nearing > first) {
        worst.first = approach.vertices[v];
        first = nearing;
      }
    } else {
      const double nearing = along - approach.behind[v];
      if (worst.second < 0 || nearing > second) {
        worst.second = approach.vertices[v];
        second = nearing;
      }
    }
  }
  worst.excess += first + second;
  return worst;
}

// Exchanges momentum within pairs that would use more than their room, one pair after the other, until none does.
void SelfContact::collide() {
  for (int pass = 0; pass < kCollisions; ++pass) {
    bool is_done = true;
    for (const Approach& approach : approaches_) {
      const Worst worst = findWorst(approach);
      const double mobility = mobility_[worst.first] + mobility_[worst.second];
      if (!(worst.excess > 0.0) || !(mobility > 0.0)) continue;
      is_done = false;
      // A little more than needed, so that the iteration ends.
      const double momentum = (worst.excess + (1.0 - kOfRoom) * approach.room) / mobility;
      ways_[worst.first] += mobility_[worst.first] * momentum * approach.normal;
      ways_[worst.second] -= mobility_[worst.second] * momentum * approach.normal;
      is_cut_[worst.first] = is_cut_[worst.second] = 1;
    }
    if (is_done) return;
  }
}

// Zones of pairs that still come too near move on as one rigid zone with their total momentum, or stay where one of their points
// is fixed. Zones that then come too near others are merged with them, until none does.
void SelfContact::stopTogether() {
  const auto find = [&](Index i) {
    while (zone_[i] != i) i = zone_[i] = zone_[zone_[i]];
    return i;
  };
  const Index n = static_cast<Index>(ways_.size());
  bool has_zones = false;
  for (bool is_done = false; !is_done;) {
    is_done = true;
    for (const Approach& approach : approaches_) {
      if (!(findWorst(approach).excess > kRounding)) continue;
      if (!has_zones) {
        zone_.resize(n);
        for (Index i = 0; i < n; ++i) zone_[i] = i;
        has_zones = true;
      }
      for (const Index v : approach.vertices) {
        const Index a = find(approach.vertices[0]), b = find(v);
        if (a == b) continue;
        zone_[std::max(a, b)] = std::min(a, b);
        is_done = false;
      }
    }
    if (is_done) return;
    // The motion of a zone is stored at its first point.
    zone_motion_.assign(n, Vec3::Zero());
    zone_mass_.assign(n, 0.0);
    for (Index i = 0; i < n; ++i) {
      const Index zone = find(i);
      zone_motion_[zone] += masses_[i] * ways_[i];
      zone_mass_[zone] += mobility_[i] > 0.0 ? masses_[i] : std::numeric_limits<double>::infinity();
    }
    for (Index i = 0; i < n; ++i) {
      const Index zone = find(i);
      if (zone_mass_[zone] == masses_[i]) continue;  // alone
      const Vec3 motion = std::isfinite(zone_mass_[zone]) ? Vec3(zone_motion_[zone] / zone_mass_[zone]) : Vec3::Zero();
      if (ways_[i] == motion) continue;
      ways_[i] = motion;
      is_cut_[i] = 1;
    }
  }
}

bool SelfContact::mustStop(const Points& before, const Points& after, bool continues) {
  const PairList::Reach reach{kLeast * list_.thickness(), 1.0 / kOfRoom};
  if (staysUncrossed(before, after, continues) || list_.areFar(before, after, reach)) return false;
  list_.update(before, after, reach);
  ways_.resize(before.size());
  bool must_stop = false;
  list_.visitNear([&](const Pair& pair, double least) {
    if (must_stop) return;
    for (const Index v : pair.vertices) ways_[v] = after[v] - before[v];
    double nearing = 0.0;  // squared, at most
    for (int v = 0; v < pair.numFirst(); ++v)
      for (int w = pair.numFirst(); w < 4; ++w)
        nearing = std::max(nearing, (ways_[pair.vertices[v]] - ways_[pair.vertices[w]]).squaredNorm());
    nearing = std::sqrt(nearing);
    const auto isRoomFor = [&](double distance) { return kOfRoom * (distance - kLeast * pair.thickness) > nearing; };
    if (isRoomFor(least)) return;
    const Closest closest = findClosest(pair, before);
    const Near near{pair, closest, std::sqrt(closest.squaredDistance())};
    if (!(near.distance > 0.0) || isRoomFor(near.distance)) return;
    must_stop = findWorst(makeApproach(near, before)).excess > 0.0;
  });
  return must_stop;
}

const std::vector<Index>& SelfContact::limit(const Points& before, Points& after, bool continues) {
  const Index n = static_cast<Index>(before.size());
  cut_.clear();
  if (!mustStop(before, after, continues)) return cut_;
  // Common motion brings no parts nearer.
  Vec3 shared = Vec3::Zero();
  bool does_one_stay = false;
  for (Index i = 0; i < n; ++i) {
    shared += after[i] - before[i];
    does_one_stay = does_one_stay || after[i] == before[i];
  }
  if (does_one_stay) shared.setZero();
  shared /= static_cast<double>(n);
  ways_.resize(n);
  double farthest = 0.0;
  for (Index i = 0; i < n; ++i) {
    ways_[i] = after[i] - before[i] - shared;
    farthest = std::max(farthest, ways_[i].squaredNorm());
  }
  // Pairs that are farther apart cannot use up their room.
  const double reach = kLeast * list_.thickness() + 2.0 / kOfRoom * std::sqrt(farthest);
  approaches_.clear();
  for (const Near& near : measure(before, reach))
    if (near.distance < reach && near.distance > 0.0) approaches_.push_back(makeApproach(near, before));
  if (approaches_.empty()) return cut_;
  is_cut_.assign(n, 0);
  mobility_.resize(n);
  for (Index i = 0; i < n; ++i) mobility_[i] = after[i] == before[i] ? 0.0 : 1.0 / masses_[i];
  collide();
  // Pairs outside this list stay apart if no point moves farther than the farthest one before the change.
  for (Vec3& way : ways_)
    if (way.squaredNorm() > farthest) way *= std::sqrt(farthest / way.squaredNorm());
  stopTogether();
  for (Index i = 0; i < n; ++i) {
    if (is_cut_[i] == 0) continue;
    after[i] = before[i] + shared + ways_[i];
    cut_.push_back(i);
  }
  return cut_;
}

Index SelfContact::countTouching(const Points& positions) {
  const std::vector<Near>& all = measure(positions, 0.0);
  return static_cast<Index>(std::count_if(all.begin(), all.end(), touches));
}

std::vector<SelfContactForce> SelfContact::listForces(const Points& positions, const Points& velocities,
                                                      const std::vector<PairAnchor>& anchors) {
  std::vector<SelfContactForce> list;
  for (const Near& near : measure(positions, 0.0)) {
    if (!touches(near)) continue;
    const double depth = near.pair.thickness - near.distance;
    Vec3 force = findSpring(near).force / near.distance * near.closest.gap;
    if (params_.friction > 0.0) {
      const Rub rub = findRub(near, positions, anchors);
      force += rub.law.findForce(rub.stretch, findSliding(near, velocities), rub.slides);
    }
    list.push_back({near.pair, near.closest, depth, force});
  }
  return list;
}

double SelfContact::leastDistance(const Points& positions) {
  double least = std::numeric_limits<double>::infinity();
  for (const Near& near : measure(positions, 0.0))
    if (near.distance < near.pair.thickness) least = std::min(least, near.distance);
  return least;
}

}  // namespace deformable_surface::contact
