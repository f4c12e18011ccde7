// The limit of motion: no two parts cross, whatever the forces are.
#include "deformable_surface/base/disjoint_sets.h"
#include "deformable_surface/contact/self_contact.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "find_place.h"

namespace deformable_surface::contact {
namespace {

// Fraction of the room of a pair that its points may use in one step: below 1, so that rounding causes no crossing.
constexpr double kOfRoom = 0.9;
constexpr double kSteady = 1.5;      // growth of the largest way from one call of limit() to the next that costs no search
constexpr double kAhead = 8.0;       // calls of limit() for which the motion of the present one is predicted
constexpr int kRounds = 4;           // of passes: the first over all pairs, the others over those that push
constexpr int kColdRounds = 16;      // if nothing is known of the sub-step before
constexpr int kPasses = 8;           // of a round
constexpr double kSettled = 1e-3;    // of the farthest motion: smaller changes of ways are no reason for another pass
constexpr double kRounding = 1e-15;  // m
constexpr double kOutrun = 32.0;     // of the usual reach, ten edges or so: beyond it collisions are not worth it
// Where the farthest way is longer than the usual reach, a third of an edge, few points are mostly that fast. Each point then has
// a bound of its own, at least a share of the farthest way. Points that collisions drive beyond it are allowed more, a few times.
// Neither number was tried otherwise.
constexpr double kSlow = 1.0 / 64.0;
constexpr int kRaises = 3;
constexpr Index kBlock = 256;  // pairs per task: some microseconds

}  // namespace

bool SelfContact::staysUncrossed(const Points& before, const Points& after, bool continues) {
  was_uncrossed_ = clearance_.staysUncrossed(before, after, continues && was_uncrossed_);
  if (was_uncrossed_) return true;
  if (is_calm_ || has_proof_failed_) return false;
  for (std::size_t i = 0; i < motion_.size(); ++i) motion_[i] = after[i] - before[i];
  was_uncrossed_ = clearance_.prove(before, motion_, kAhead) && clearance_.staysUncrossed(before, after);
  has_proof_failed_ = !was_uncrossed_;
  return was_uncrossed_;
}

SelfContact::Approach SelfContact::makeApproach(const Near& near, const Points& before) const {
  const Pair& pair = near.pair;
  Approach approach;
  approach.vertices = pair.vertices;
  approach.num_first = pair.numFirst();
  approach.pushed.fill(0.0);
  approach.normal = near.closest.gap / near.distance;
  const auto roomTo = [&](double least) { return kOfRoom * std::max(0.0, near.distance - least * pair.thickness); };
  approach.room = roomTo(kLeast);
  approach.spare = roomTo(kFloor) - approach.room;
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

// Pairs that are farther apart cannot use up their room.
void SelfContact::findAllApproaches(const Points& before, double longest) {
  const double way = 2.0 / kOfRoom * longest;
  approaches_.clear();
  const std::vector<Near>& all = measure(before, way);
  parallelAppend(static_cast<Index>(all.size()), kBlock, approaches_, approach_parts_, [&](Index begin, Index end, auto& list) {
    for (Index k = begin; k < end; ++k)
      if (all[k].distance < kLeast * all[k].pair.thickness + way && all[k].distance > 0.0)
        list.push_back(makeApproach(all[k], before));
  });
}

void SelfContact::findApproaches(const Points& before) {
  approaches_.clear();
  list_.update(before, allowed_, {kLeast * list_.thickness(), 1.0 / kOfRoom});
  list_.collectNear(approaches_, approach_parts_, [&](const Pair& pair, double least, std::vector<Approach>& list) {
    double first = 0.0, second = 0.0;
    for (int v = 0; v < 4; ++v) {
      double& farthest = v < pair.numFirst() ? first : second;
      farthest = std::max(farthest, allowed_[pair.vertices[v]]);
    }
    const double reach = kLeast * pair.thickness + (first + second) / kOfRoom;
    if (!(least < reach)) return;
    const Closest closest = findClosest(pair, before);
    const double distance = std::sqrt(closest.squaredDistance());
    if (distance < reach && distance > 0.0) list.push_back(makeApproach({pair, closest, distance}, before));
  });
}

bool SelfContact::allowMore(double longest) {
  bool any = false;
  for (std::size_t i = 0; i < allowed_.size(); ++i) {
    const double way = std::min(longest, ways_[i].norm());
    if (!(way > allowed_[i])) continue;
    allowed_[i] = std::min(longest, 2.0 * way);
    any = true;
  }
  return any;
}

// A plane across the gap separates two convex primitives. Take the point of the first that moves farthest towards the second, and
// the point of the second that moves farthest towards the first. If both together use less than the gap, a moving plane between
// them remains a separating plane. Common motion does not count.
double SelfContact::findExcess(const Approach& approach, const std::array<Vec3, 4>& ways) {
  const double least = std::numeric_limits<double>::lowest();
  double first = least, second = least;
  for (int v = 0; v < 4; ++v) {
    const double along = approach.normal.dot(ways[v]);
    if (v < approach.num_first)
      first = std::max(first, -along - approach.behind[v]);
    else
      second = std::max(second, along - approach.behind[v]);
  }
  return -approach.room + (first + second);
}

// Exchanges momentum between the points of pairs that would use more than their room, one pair after the other, until none does.
// Momentum pushes but never pulls: what an earlier exchange has pushed farther than later ones leave necessary is taken back
// (projected Gauss-Seidel). Otherwise layers that press on each other would be driven apart, and gain energy. The passes begin
// with what was exchanged before, mostly in the last sub-step: a jam bears nearly the same forces again.
void SelfContact::collide(double settled) {
  exchangeAgain();
  const int rounds = last_exchanges_.empty() ? kColdRounds : kRounds;
  bool is_done = false;
  for (int round = 0; round < rounds && !is_done; ++round) {
    is_done = true;
    pushing_.clear();
    for (Approach& approach : approaches_) {
      is_done = !collide(approach, settled) && is_done;
      if (approach.pushes()) pushing_.push_back(&approach);
    }
    bool is_settled = is_done;
    for (int pass = 1; pass < kPasses && !is_settled; ++pass) {
      is_settled = true;
      for (Approach* approach : pushing_) is_settled = !collide(*approach, settled) && is_settled;
    }
  }
  exchanges_.clear();
  for (const Approach* approach : pushing_) exchanges_.push_back({approach->vertices, approach->num_first, approach->pushed});
  std::sort(exchanges_.begin(), exchanges_.end());
}

void SelfContact::exchangeAgain() {
  if (last_exchanges_.empty()) return;
  Index place = 0;
  for (Approach& approach : approaches_) {
    const Exchange key{approach.vertices, approach.num_first, {}};
    place = findPlace(last_exchanges_, key, place, std::less<Exchange>());
    if (place == static_cast<Index>(last_exchanges_.size())) continue;
    const Exchange* const at = &last_exchanges_[place];
    if (at->num_first != approach.num_first || at->vertices != approach.vertices) continue;
    for (int v = 0, k = 0; v < approach.num_first; ++v)
      for (int w = approach.num_first; w < 4; ++w, ++k) exchange(approach, v, w, approach.pushed[k], at->pushed[k]);
  }
}

void SelfContact::exchange(const Approach& approach, int v, int w, double& pushed, double momentum) {
  const Index first = approach.vertices[v], second = approach.vertices[w];
  pushed += momentum;
  ways_[first] += mobility_[first] * momentum * approach.normal;
  ways_[second] -= mobility_[second] * momentum * approach.normal;
  is_cut_[first] = is_cut_[second] = 1;
}

bool SelfContact::collide(Approach& approach, double settled) {
  std::array<double, 4> nearing;  // m, of each point towards the other primitive, beyond the closest point of its own
  for (int v = 0; v < 4; ++v)
    nearing[v] = (v < approach.num_first ? -1.0 : 1.0) * approach.normal.dot(ways_[approach.vertices[v]]) - approach.behind[v];
  bool any = false;
  for (int v = 0, k = 0; v < approach.num_first; ++v)
    for (int w = approach.num_first; w < 4; ++w, ++k) {
      const double excess = nearing[v] + nearing[w] - approach.room, first = mobility_[approach.vertices[v]],
                   second = mobility_[approach.vertices[w]];
      if (!(first + second > 0.0) || !(excess > 0.0 || approach.pushed[k] > 0.0)) continue;
      // A little more than needed, so that the iteration ends.
      const double momentum = std::max((excess + (1.0 - kOfRoom) * approach.room) / (first + second), -approach.pushed[k]);
      any = any || excess > 0.0 || -momentum * (first + second) > settled;
      exchange(approach, v, w, approach.pushed[k], momentum);
      nearing[v] -= first * momentum;
      nearing[w] -= second * momentum;
    }
  return any;
}

// Zones of pairs that still come too near move on as one rigid zone with their total momentum, or stay where one of their points
// is fixed. Zones that then come too near others are merged with them, until none does.
void SelfContact::stopTogether() {
  const Index n = static_cast<Index>(ways_.size());
  bool has_zones = false;
  for (bool is_done = false; !is_done;) {
    is_done = true;
    is_stopped_.resize(approaches_.size());
    parallelFor(static_cast<Index>(approaches_.size()), kBlock, [&](Index begin, Index end) {
      for (Index k = begin; k < end; ++k) {
        const auto& [a, b, c, d] = approaches_[k].vertices;
        is_stopped_[k] = findExcess(approaches_[k], {ways_[a], ways_[b], ways_[c], ways_[d]}) > approaches_[k].spare + kRounding;
      }
    });
    for (std::size_t k = 0; k < approaches_.size(); ++k) {
      if (is_stopped_[k] == 0) continue;
      const Approach& approach = approaches_[k];
      if (!has_zones) makeSingleSets(n, zone_);
      has_zones = true;
      for (const Index v : approach.vertices)
        if (joinSets(zone_, approach.vertices[0], v)) is_done = false;
    }
    if (is_done) return;
    // The motion of a zone is stored at its first point.
    zone_motion_.assign(n, Vec3::Zero());
    zone_mass_.assign(n, 0.0);
    for (Index i = 0; i < n; ++i) {
      const Index zone = findRoot(zone_, i);
      zone_motion_[zone] += masses_[i] * ways_[i];
      zone_mass_[zone] += mobility_[i] > 0.0 ? masses_[i] : std::numeric_limits<double>::infinity();
    }
    for (Index i = 0; i < n; ++i) {
      const Index zone = findRoot(zone_, i);
      if (zone_mass_[zone] == masses_[i]) continue;  // alone
      const Vec3 motion = std::isfinite(zone_mass_[zone]) ? Vec3(zone_motion_[zone] / zone_mass_[zone]) : Vec3::Zero();
      if (ways_[i] == motion) continue;
      ways_[i] = motion;
      is_cut_[i] = 1;
    }
  }
}

// With the total momentum, or not at all if a point stays. Collisions would throw points so far that they strain the surface with
// more energy than the forces have put in.
void SelfContact::moveAsOne(const Points& before, bool does_one_stay, Points& after) {
  Vec3 motion = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    motion += masses_[i] * (after[i] - before[i]);
    mass += masses_[i];
  }
  motion *= does_one_stay ? 0.0 : 1.0 / mass;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (after[i] == before[i] + motion) continue;
    after[i] = before[i] + motion;
    cut_.push_back(static_cast<Index>(i));
  }
}

bool SelfContact::mustStop(const Points& before, const Points& after, bool continues) {
  if (staysUncrossed(before, after, continues)) return false;
  const auto waysOf = [&](const Pair& pair) {
    std::array<Vec3, 4> ways;
    for (int v = 0; v < 4; ++v) ways[v] = after[pair.vertices[v]] - before[pair.vertices[v]];
    return ways;
  };
  const auto hasRoom = [](const Pair& pair, double distance, const std::array<Vec3, 4>& ways) {
    return kOfRoom * (distance - kLeast * pair.thickness) > pair.findRelativeWay([&](int v) -> const Vec3& { return ways[v]; });
  };
  const auto exceedsRoom = [&](const Near& near) {
    const std::array<Vec3, 4> ways = waysOf(near.pair);
    return near.distance > 0.0 && !hasRoom(near.pair, near.distance, ways) && findExcess(makeApproach(near, before), ways) > 0.0;
  };
  const double way = findLargestRelativeWay(before, after) / kOfRoom;
  usual_way_ = std::min(kSteady * way, (1.0 - kLeast) * list_.thickness());
  if (way <= measured_way_ && before == measured_at_) {
    std::atomic<bool> is_any{false};
    parallelFor(static_cast<Index>(near_.size()), kBlock, [&](Index begin, Index end) {
      for (Index k = begin; k < end && !is_any; ++k)
        if (exceedsRoom(near_[k])) is_any = true;
    });
    return is_any;
  }
  const auto test = [&](const Pair& pair, double least) {
    if (hasRoom(pair, least, waysOf(pair))) return false;
    const Closest closest = findClosest(pair, before);
    return exceedsRoom({pair, closest, std::sqrt(closest.squaredDistance())});
  };
  if (watch_.ensure(before, way, before, after)) return watch_.isAnyNear(way, test);
  list_.update(before, after, {kLeast * list_.thickness(), 1.0 / kOfRoom});
  return list_.isAnyNear(test);
}

const std::vector<Index>& SelfContact::limit(const Points& before, Points& after, bool continues) {
  const Index n = static_cast<Index>(before.size());
  cut_.clear();
  last_exchanges_.swap(exchanges_);
  exchanges_.clear();
  if (!continues) last_exchanges_.clear();
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
  if (!(std::sqrt(farthest) <= kOutrun * list_.usualReach())) {
    moveAsOne(before, does_one_stay, after);
    return cut_;
  }
  const double longest = std::sqrt(farthest);
  const bool are_few_fast = longest > list_.usualReach();
  allowed_.assign(are_few_fast ? n : 0, 0.0);
  if (are_few_fast)
    for (Index i = 0; i < n; ++i) allowed_[i] = std::max(kSlow * longest, ways_[i].norm());
  free_ways_ = ways_;
  mobility_.resize(n);
  for (Index i = 0; i < n; ++i) mobility_[i] = after[i] == before[i] ? 0.0 : 1.0 / masses_[i];
  for (int raises = 0;; ++raises) {
    if (are_few_fast)
      findApproaches(before);
    else
      findAllApproaches(before, longest);
    if (approaches_.empty()) return cut_;
    num_near_ += approaches_.size();
    is_cut_.assign(n, 0);
    collide(kSettled * longest);
    if (raises == kRaises || !allowMore(longest)) break;
    ways_ = free_ways_;
    last_exchanges_.swap(exchanges_);
  }
  // The first sub-step of Verlet bears half.
  if (!continues)
    for (Exchange& exchange : exchanges_)
      for (double& momentum : exchange.pushed) momentum *= 2.0;
  // Pairs outside this list stay apart if no point moves farther than allowed.
  for (Index i = 0; i < n; ++i) {
    const double most = are_few_fast ? allowed_[i] * allowed_[i] : farthest;
    if (ways_[i].squaredNorm() > most) ways_[i] *= std::sqrt(most / ways_[i].squaredNorm());
  }
  stopTogether();
  while (allowMore(longest)) {
    findApproaches(before);
    stopTogether();
  }
  for (Index i = 0; i < n; ++i) {
    if (is_cut_[i] == 0) continue;
    after[i] = before[i] + shared + ways_[i];
    cut_.push_back(i);
  }
  return cut_;
}

}  // namespace deformable_surface::contact
