#include "ring_thinning.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/geometry/delaunay_star.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace deformable_surface::cloud {
namespace {

// At a gap the tree is searched for at most this many list lengths: more would not be worth the time.
constexpr Index kMaxAsked = 4;
// The spacing is the distance of the neighbour that completes a hexagon.
constexpr Index kSpacingNeighbor = 6;

// The data of a neighbour, in one cache line.
struct alignas(64) Sample {
  Vec3 position, normal;
  double wanted;  // spacing, over the mean
};

// The neighbours of one point and the memory to find them and to evaluate its star.
struct Scratch {
  std::vector<Index> near;  // alive, of the same part, nearest first, at most k
  std::vector<Neighbor> found;
  Index asked = 0;          // of the tree, the last time
  std::vector<Index> seen;  // in the tree then, with points of other parts and beyond gaps
  std::vector<Vec2> projected;
  geometry::DelaunayStarBuilder builder;
  std::vector<Index> place;   // (n) place of a point among those found; stale if another point is there
  std::vector<double> bound;  // lengths of paths to those found
  std::vector<char> reached;  // whether they are no detour
};

// The next points are evaluated ahead, as many at a time, in tasks of kAheadInTask (a tenth of a millisecond of work), if so many
// points are left for each of them: fewer are too near each other. Chosen on jittered sheets of 30,000 and 100,000 points.
constexpr Index kAhead = 64, kAheadInTask = 8;
constexpr Index kLeftForEach = 64;

using Entry = std::pair<double, Index>;  // key, point

// What findNear() and evaluateKey() gave for a point before its turn.
struct Ahead {
  Entry entry;  // of the queue
  double key;
  bool is_enough;               // what findNear() returned
  Index asked;                  // of the tree; 0: nothing that could be used later was found
  std::vector<Index> depends;   // the points that all this depends on
  std::vector<Neighbor> found;  // what is to be stored if the list was not enough
};

// New lists for some points.
struct Refills {
  std::vector<Index> points;
  Lists lists;
};

class Thinning {
 public:
  explicit Thinning(RingCloud&& cloud)
      : k_(cloud.k),
        over_surface_(cloud.over_surface),
        left_out_(cloud.left_out),
        samples_(cloud.positions.size()),
        tree_(cloud.positions),
        lists_(std::move(cloud.neighbors)),
        alive_(cloud.positions.size(), 1),
        num_alive_(static_cast<Index>(cloud.positions.size())),
        num_parts_(static_cast<Index>(cloud.left_out.size())),
        part_(std::move(cloud.part)),
        stored_(cloud.positions.size()),
        changed_in_(cloud.positions.size(), 0) {
    const Index n = num_alive_;
    for (Index i = 0; i < n; ++i) {
      samples_[i] = {cloud.positions[i], cloud.normals[i], cloud.wanted.empty() ? 1.0 : cloud.wanted[i]};
      Index* const begin = lists_.items.data() + lists_.offsets[i];
      const auto isOther = [&](Index j) { return part_[j] != part_[i]; };
      stored_[i] = static_cast<Index>(std::remove_if(begin, begin + lists_.count(i), isOther) - begin);
    }

    // The points of each part, for parts too small to ask the tree.
    members_.offsets.assign(num_parts_ + 1, 0);
    for (Index part : part_) ++members_.offsets[part + 1];
    for (Index p = 0; p < num_parts_; ++p) members_.offsets[p + 1] += members_.offsets[p];
    members_.items.resize(n);
    std::vector<Index> next(members_.offsets.begin(), members_.offsets.end() - 1);
    for (Index i = 0; i < n; ++i) members_.items[next[part_[i]]++] = i;
    num_in_part_.resize(num_parts_);
    for (Index p = 0; p < num_parts_; ++p) num_in_part_[p] = members_.count(p);
  }

  Simplification run(Index min_points, const std::vector<char>& stays) {
    const Index n = num_alive_;
    Simplification result;
    result.num_points = n;

    // Keys of all points, in the order in which the tree holds them in memory. A point whose list is too short uses the lists of
    // others, which therefore do not change until all keys are computed.
    std::vector<double> key(n);
    constexpr Index kBlock = 1024;
    std::vector<Refills> refills((n + kBlock - 1) / kBlock);
    parallelFor(n, kBlock, [&](Index begin, Index end) {
      Scratch scratch;
      Refills& refilled = refills[begin / kBlock];
      for (Index s = begin; s < end; ++s) {
        const Index i = tree_.order()[s];
        if (!findNear(i, scratch)) {
          refilled.points.push_back(i);
          for (const Neighbor& neighbor : scratch.found) refilled.lists.items.push_back(neighbor.index);
          refilled.lists.offsets.push_back(static_cast<Index>(refilled.lists.items.size()));
        }
        key[i] = evaluateKey(i, scratch);
      }
    });
    for (const Refills& refilled : refills)
      for (Index r = 0; r < static_cast<Index>(refilled.points.size()); ++r)
        store(refilled.points[r], refilled.lists.count(r), [&](Index s) { return refilled.lists.begin(r)[s]; });
    std::vector<Entry> entries;
    for (Index i = 0; i < n; ++i) {
      if (!stays[i]) entries.push_back({key[i], i});
    }
    Queue queue(std::greater<Entry>(), std::move(entries));

    // Removals let keys grow: a key in the queue is a lower bound and is evaluated again when its turn comes.
    Scratch scratch;
    double diameter = 0.0;
    std::vector<Ahead> ahead;
    std::size_t next = 0;  // in ahead
    while (num_alive_ > min_points && !(queue.empty() && next == ahead.size())) {
      if (next == ahead.size()) {
        takeAhead(queue, ahead);
        next = 0;
      }
      Ahead* const done = next < ahead.size() && (queue.empty() || ahead[next].entry < queue.top()) ? &ahead[next++] : nullptr;
      const Index i = (done ? done->entry : queue.top()).second;
      if (!done) {
        queue.pop();
        if (!queue.empty()) prefetch(queue.top().second);
      }
      if (num_in_part_[part_[i]] <= kMinPartPoints && !left_out_[part_[i]]) continue;
      const bool is_known = done && isValid(*done);
      if (!(is_known ? done->is_enough : findNear(i, scratch))) {
        const std::vector<Neighbor>& found = is_known ? done->found : scratch.found;
        store(i, static_cast<Index>(found.size()), [&](Index s) { return found[s].index; });
        changed_in_[i] = round_;
      }
      const Entry fresh(is_known ? done->key : evaluateKey(i, scratch), i);
      if ((!queue.empty() && queue.top() < fresh) || (next < ahead.size() && ahead[next].entry < fresh)) {
        queue.push(fresh);
        continue;
      }
      remove(i);
      diameter = std::max(diameter, fresh.first);
      result.removed.push_back(i);
      result.diameter.push_back(diameter);
    }
    return result;
  }

 private:
  using Queue = std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>>;

  // Takes the next points from the queue and evaluates them in parallel, as if it were the turn of each. None with one thread.
  void takeAhead(Queue& queue, std::vector<Ahead>& ahead) {
    ++round_;
    const bool pays = numThreads() > 1 && num_alive_ >= kAhead * kLeftForEach;
    ahead.resize(pays ? std::min<std::size_t>(kAhead, queue.size()) : 0);
    for (Ahead& a : ahead) {
      a.entry = queue.top();
      queue.pop();
    }
    parallelFor(static_cast<Index>(ahead.size()), kAheadInTask, [&](Index begin, Index end) {
      Scratch& scratch = scratch_ahead_[begin / kAheadInTask];
      for (Index a = begin; a < end; ++a) {
        if (a + 1 < end) prefetch(ahead[a + 1].entry.second);
        evaluateAhead(ahead[a], scratch);
      }
    });
  }

  void evaluateAhead(Ahead& ahead, Scratch& scratch) const {
    const Index i = ahead.entry.second;
    ahead.asked = 0;
    if (num_in_part_[part_[i]] <= k_) return;
    ahead.is_enough = findNear(i, scratch);
    ahead.key = evaluateKey(i, scratch);
    ahead.asked = scratch.asked;
    ahead.depends = ahead.is_enough ? scratch.near : scratch.seen;
    if (!ahead.is_enough) ahead.found = scratch.found;
  }

  // Whether it would be the same now. A list that was enough depends on which of its points are alive. What the tree gave depends
  // on all points that it gave, and on their lists.
  bool isValid(const Ahead& ahead) const {
    if (num_in_part_[part_[ahead.entry.second]] <= k_) return false;
    const std::vector<Index>& points = ahead.depends;
    if (ahead.is_enough) return std::all_of(points.begin(), points.end(), [&](Index j) { return alive_[j] != 0; });
    return ahead.asked > 0 && ahead.asked < num_alive_ &&
           std::all_of(points.begin(), points.end(), [&](Index j) { return changed_in_[j] != round_; });
  }

  // (d + 2 r) / 2 with the ring's diameter d and the nearest distance r; without a ring, as if its diameter were 2 r. Divided by
  // the wanted spacing.
  // Call findNear() first.
  double evaluateKey(Index i, Scratch& scratch) const {
    if (scratch.near.empty() || left_out_[part_[i]]) return 0.0;
    for (Index j : scratch.near) __builtin_prefetch(&samples_[j]);
    const Sample& own = samples_[i];
    const double nearest = (samples_[scratch.near[0]].position - own.position).norm();
    const TangentPlane plane(own.position, own.normal);
    scratch.projected.clear();
    for (Index j : scratch.near) {
      const Sample& other = samples_[j];
      if (!isFlat(other.position - own.position, own.normal, other.normal)) continue;
      scratch.projected.push_back(plane.project(other.position));
    }
    const std::vector<Index>& ring = scratch.builder.build(scratch.projected).ring;
    double squared_diameter = 0.0;
    for (std::size_t a = 0; a < ring.size(); ++a) {
      const Vec2& qa = scratch.projected[ring[a]];
      squared_diameter = std::max(squared_diameter, qa.squaredNorm());
      for (std::size_t b = 0; b < a; ++b) {
        squared_diameter = std::max(squared_diameter, (qa - scratch.projected[ring[b]]).squaredNorm());
      }
    }
    return (ring.empty() ? 2.0 * nearest : 0.5 * std::sqrt(squared_diameter) + nearest) / own.wanted;
  }

  // Prefetches the data that the evaluation of a key reads first: the order of points is unpredictable.
  void prefetch(Index i) const {
    __builtin_prefetch(lists_.begin(i));
    __builtin_prefetch(lists_.end(i));
    __builtin_prefetch(&samples_[i]);
  }

  // False: the stored neighbours do not suffice; scratch.found has all that should be stored instead.
  bool findNear(Index i, Scratch& scratch) const {
    const Index wanted = std::min(k_, num_in_part_[part_[i]] - 1);
    takeStored(i, wanted, scratch.near);
    if (static_cast<Index>(scratch.near.size()) == wanted) return true;
    find(i, wanted, scratch);
    scratch.found.resize(std::min(scratch.found.size(), static_cast<std::size_t>(lists_.count(i))));
    scratch.near.clear();
    for (const Neighbor& neighbor : scratch.found)
      if (static_cast<Index>(scratch.near.size()) < wanted) scratch.near.push_back(neighbor.index);
    return false;
  }

  // Stores as many as fit. get(s): the s-th.
  template <class Get>
  void store(Index i, Index count, Get&& get) {
    stored_[i] = count;
    for (Index s = 0; s < count; ++s) lists_.items[lists_.offsets[i] + s] = get(s);
  }

  // Every entry is written and only alive ones are counted: branches would be mispredicted.
  void takeStored(Index i, Index wanted, std::vector<Index>& near) const {
    near.resize(wanted);
    Index count = 0;
    const Index* end = lists_.begin(i) + stored_[i];
    for (const Index* j = lists_.begin(i); j != end && count < wanted; ++j) {
      near[count] = *j;
      count += alive_[*j];
    }
    near.resize(count);
  }

  // Finds the nearest alive points of the same part: in the part's own list if it is small, else in the tree, with growing
  // numbers while points of other parts are in between.
  void find(Index i, Index wanted, Scratch& scratch) const {
    std::vector<Neighbor>& found = scratch.found;
    const Index part = part_[i];
    const auto isOther = [&](const Neighbor& neighbor) { return neighbor.index == i || part_[neighbor.index] != part; };
    if (num_in_part_[part] <= k_) {
      found.clear();
      const Index* begin = members_.begin(part);
      for (const Index* j = begin; j != begin + num_in_part_[part]; ++j) {
        found.push_back({(samples_[*j].position - samples_[i].position).squaredNorm(), *j});
      }
      std::sort(found.begin(), found.end());
      found.erase(std::remove_if(found.begin(), found.end(), isOther), found.end());
    } else {
      for (Index asked = lists_.count(i) + 1;; asked = std::min(2 * asked, num_alive_)) {
        tree_.nearest(samples_[i].position, asked, found);
        scratch.asked = asked;
        scratch.seen.clear();
        for (const Neighbor& neighbor : found) scratch.seen.push_back(neighbor.index);
        found.erase(std::remove_if(found.begin(), found.end(), isOther), found.end());
        if (over_surface_) eraseUnreached(i, scratch);
        if (static_cast<Index>(found.size()) >= wanted || asked >= num_alive_) break;
        if (over_surface_ && asked > kMaxAsked * lists_.count(i)) break;
      }
    }
  }

  // Erases points that no short path over stored links leads to. All stored ones were reached in this way before, the first ones
  // along the surface of the full cloud: none spans a gap, however much larger than the gap the spacing has become. Nearest
  // first, until all are reached; else once more with the shortest of these paths. A path to a point nearer than the spacing
  // is as long as the remaining points allow, so it is compared with the spacing: such points must be removed.
  void eraseUnreached(Index i, Scratch& scratch) const {
    std::vector<Neighbor>& found = scratch.found;
    std::vector<Index>& place = scratch.place;
    std::vector<double>& bounds = scratch.bound;
    std::vector<char>& reached = scratch.reached;
    const Index num_found = static_cast<Index>(found.size());
    place.resize(samples_.size());
    for (Index f = 0; f < num_found; ++f) place[found[f].index] = f;
    reached.resize(num_found);
    const double squared_spacing = num_found > 0 ? found[std::min(kSpacingNeighbor, num_found) - 1].squared_distance : 0.0;
    for (const bool is_hasty : {true, false}) {
      bounds.assign(num_found, std::numeric_limits<double>::infinity());
      std::fill(reached.begin(), reached.end(), 0);
      Index num_missing = num_found;
      const auto relax = [&](Index from, double to_from, Index max_steps) {
        const Index* end = lists_.begin(from) + std::min(max_steps, stored_[from]);
        for (const Index* j = lists_.begin(from); j != end; ++j) {
          const Index f = place[*j];
          if (f >= num_found || found[f].index != *j || (is_hasty && reached[f])) continue;
          const double bound = to_from + (samples_[*j].position - samples_[from].position).norm();
          if (!(bound < bounds[f])) continue;
          bounds[f] = bound;
          const double squared_length = std::max(found[f].squared_distance, squared_spacing);
          if (reached[f] || !(bound * bound <= kKeptWay * kKeptWay * squared_length)) continue;
          reached[f] = 1;
          --num_missing;
        }
      };
      relax(i, 0.0, stored_[i]);
      for (Index f = 0; f < num_found && num_missing > 0; ++f) {
        const Index from = found[f].index;
        if (bounds[f] < std::numeric_limits<double>::infinity()) relax(from, bounds[f], is_hasty ? k_ : stored_[from]);
      }
      if (num_missing == 0) return;
    }
    Index kept = 0;
    for (Index f = 0; f < num_found; ++f) {
      if (reached[f]) found[kept++] = found[f];
    }
    found.resize(kept);
  }

  void remove(Index i) {
    tree_.remove(i);
    alive_[i] = 0;
    changed_in_[i] = round_;
    --num_alive_;
    const Index part = part_[i];
    if (--num_in_part_[part] > k_) return;
    // A part that has become small: its list is kept exact, the alive points first.
    const auto begin = members_.items.begin() + members_.offsets[part];
    const auto end = begin + (num_in_part_[part] == k_ ? members_.count(part) : num_in_part_[part] + 1);
    std::stable_partition(begin, end, [&](Index j) { return alive_[j] != 0; });
  }

  const Index k_;
  const bool over_surface_;
  const std::vector<char>& left_out_;  // (num_parts) go first, and wholly
  std::vector<Sample> samples_;        // (n)
  KdTree tree_;                        // of the alive points
  Lists lists_;                        // nearest neighbours of the same part; some dead
  std::vector<char> alive_;            // (n)
  Index num_alive_;
  Index num_parts_;
  std::vector<Index> part_;         // (n)
  std::vector<Index> stored_;       // (n) entries of lists_ in use
  Lists members_;                   // (num_parts)
  std::vector<Index> num_in_part_;  // alive
  Index round_ = 0;                 // of points that are evaluated ahead
  std::vector<Index> changed_in_;   // (n) round in which a point was removed or its list was stored anew
  std::vector<Scratch> scratch_ahead_{kAhead / kAheadInTask};
};

}  // namespace

Simplification thinByRings(RingCloud cloud, Index min_points, const std::vector<char>& stays) {
  return Thinning(std::move(cloud)).run(min_points, stays);
}

}  // namespace deformable_surface::cloud
