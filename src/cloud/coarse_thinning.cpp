#include "coarse_thinning.h"

#include "deformable_surface/base/median.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/parallel_sort.h"
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "point_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 512;  // points per task: about a millisecond of work
// Ratio of least distances between levels: the number of points is then met within a third.
constexpr double kLevelFactor = 1.15;
// Of the distance that half of the lists reach: beyond it a list of about thirty would hold less than a ring of remaining points.
constexpr double kListReach = 0.6;
// Of a part: fewer points do not show a surface; the rings decide about them.
constexpr Index kFewestOfPart = 64;
// A search asks for at most this multiple of the wanted neighbours, if other parts are in between.
constexpr Index kMaxAsked = 4;
constexpr Index kSpacingNeighbor = 6;  // that completes a hexagon
constexpr int kPasses = 2;             // over the points found, nearest first: the second finds paths that lead back

// The median distance of the nearest and of the farthest that are listed, m.
std::pair<double, double> measureLists(const Points& positions, const Lists& neighbors) {
  const Index n = neighbors.size();
  std::vector<double> nearest(n), farthest(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      if (neighbors.count(i) == 0) continue;
      nearest[i] = (positions[*neighbors.begin(i)] - positions[i]).norm();
      farthest[i] = (positions[neighbors.end(i)[-1]] - positions[i]).norm();
    }
  });
  // Points do not coincide: zero means an empty list.
  for (std::vector<double>* distances : {&nearest, &farthest})
    distances->erase(std::remove(distances->begin(), distances->end(), 0.0), distances->end());
  if (nearest.empty()) return {0.0, 0.0};
  return {findMedian(std::move(nearest)), findMedian(std::move(farthest))};
}

// Breaks ties without preferring any place of the cloud.
std::uint32_t scramble(Index i) { return static_cast<std::uint32_t>(i) * 2654435769u; }

struct Removal {
  double distance;  // m, to the point that stays
  Index point;      // in the cloud as it was at the beginning of the round
  bool operator<(const Removal& other) const {
    return std::make_tuple(distance, scramble(point)) < std::make_tuple(other.distance, scramble(other.point));
  }
};

// The remaining points that are nearer than the least distance to one that stays. Whole parts stay if few of their points would
// be left.
std::vector<Removal> findTooNear(const ThinnedCloud& cloud, const Lists& neighbors, const std::vector<char>& is_left,
                                 double least, Index num_parts) {
  const Index n = static_cast<Index>(cloud.positions.size());
  std::vector<double> nearest(n, std::numeric_limits<double>::infinity());  // that stays and came before
  std::vector<Index> num_kept(num_parts, 0);
  std::vector<char> is_kept(n, 0);
  const auto forNear = [&](Index i, const auto& isAsked, const auto& visit) {
    for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
      if (!isAsked(*j)) continue;
      const double distance = (cloud.positions[*j] - cloud.positions[i]).norm();
      if (!(distance < least)) break;
      if (cloud.part[*j] == cloud.part[i]) visit(*j, distance);
    }
  };
  const auto keep = [&](Index i) {
    is_kept[i] = 1;
    ++num_kept[cloud.part[i]];
    forNear(
        i, [](Index) { return true; }, [&](Index j, double distance) { nearest[j] = std::min(nearest[j], distance); });
  };
  for (Index i = 0; i < n; ++i)
    if (cloud.stays[i]) keep(i);
  // Lists are not mutual: where the sampling changes, one of two near points may not list the other.
  const auto lookBack = [&](Index i) {
    forNear(
        i, [&](Index j) { return is_kept[j] != 0; },
        [&](Index, double distance) { nearest[i] = std::min(nearest[i], distance); });
  };
  for (Index i = 0; i < n; ++i) {
    if (!is_left[i] || cloud.stays[i]) continue;
    lookBack(i);
    if (!(nearest[i] < least)) keep(i);
  }
  std::vector<Removal> removals;
  for (Index i = 0; i < n; ++i)
    if (is_left[i] && !is_kept[i] && nearest[i] < least && num_kept[cloud.part[i]] >= kFewestOfPart)
      removals.push_back({nearest[i], i});
  parallelSort(removals);
  return removals;
}

// The remaining points, and their lists within their part.
ThinnedCloud takeLeft(ThinnedCloud& cloud, const Lists& neighbors, const std::vector<char>& is_left) {
  ThinnedCloud left;
  left.removed = std::move(cloud.removed);
  left.diameter = std::move(cloud.diameter);
  const Index n = static_cast<Index>(is_left.size());
  std::vector<Index> new_index(n, -1), old_index;
  for (Index i = 0; i < n; ++i) {
    if (!is_left[i]) continue;
    new_index[i] = static_cast<Index>(old_index.size());
    old_index.push_back(i);
  }
  const Index m = static_cast<Index>(old_index.size());
  left.index.resize(m);
  left.positions.resize(m);
  left.part.resize(m);
  left.stays.resize(m);
  std::vector<std::vector<Index>> items((m + kBlock - 1) / kBlock);
  left.neighbors.offsets.resize(m + 1);
  parallelFor(m, kBlock, [&](Index begin, Index end) {
    std::vector<Index>& listed = items[begin / kBlock];
    for (Index l = begin; l < end; ++l) {
      const Index i = old_index[l];
      left.index[l] = cloud.index[i];
      left.positions[l] = cloud.positions[i];
      left.part[l] = cloud.part[i];
      left.stays[l] = cloud.stays[i];
      const std::size_t before = listed.size();
      for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j)
        if (is_left[*j] && cloud.part[*j] == cloud.part[i]) listed.push_back(new_index[*j]);
      left.neighbors.offsets[l + 1] = static_cast<Index>(listed.size() - before);
    }
  });
  std::partial_sum(left.neighbors.offsets.begin(), left.neighbors.offsets.end(), left.neighbors.offsets.begin());
  left.neighbors.items.reserve(left.neighbors.offsets.back());
  for (const std::vector<Index>& listed : items)
    left.neighbors.items.insert(left.neighbors.items.end(), listed.begin(), listed.end());
  return left;
}

// Keeps the points around a point (nearest first) that can be reached over listed points without a detour.
class WayCheck {
 public:
  explicit WayCheck(const ThinnedCloud& cloud) : cloud_(cloud) {}

  void keepReached(Index i, std::vector<Neighbor>& found) {
    const std::size_t count = found.size();
    const double squared_spacing = count > 0 ? found[std::min<std::size_t>(kSpacingNeighbor, count) - 1].squared_distance : 0.0;
    place_.clear();
    for (const Neighbor& neighbor : found) place_.add(neighbor.index);
    bound_.assign(count, std::numeric_limits<double>::infinity());
    most_.clear();
    for (const Neighbor& neighbor : found)
      most_.push_back(kKeptWay * std::sqrt(std::max(neighbor.squared_distance, squared_spacing)));
    num_missing_ = count;
    relax(i, 0.0);
    for (int pass = 0; pass < kPasses; ++pass) {
      for (std::size_t f = 0; f < count && num_missing_ > 0; ++f)
        if (bound_[f] < std::numeric_limits<double>::infinity()) relax(found[f].index, bound_[f]);
    }
    if (num_missing_ == 0) return;
    std::size_t kept = 0;
    for (std::size_t f = 0; f < count; ++f)
      if (bound_[f] <= most_[f]) found[kept++] = found[f];
    found.resize(kept);
  }

 private:
  void relax(Index from, double to_from) {
    for (const Index* j = cloud_.neighbors.begin(from); j != cloud_.neighbors.end(from); ++j) {
      const Index at = place_.find(*j);
      if (at < 0) continue;
      const double bound = to_from + (cloud_.positions[*j] - cloud_.positions[from]).norm();
      double& least = bound_[at];
      if (!(bound < least)) continue;
      num_missing_ -= !(least <= most_[at]) && bound <= most_[at];
      least = bound;
    }
  }

  const ThinnedCloud& cloud_;
  PointMap place_;                    // among those found
  std::vector<double> bound_, most_;  // m, of those found: length of the path, and the longest one without a detour
  std::size_t num_missing_ = 0;       // whose bound is above
};

// Neighbours of all remaining points, by paths over the former lists.
Lists findNeighbors(const ThinnedCloud& cloud, Index wanted, bool over_surface) {
  const Index n = static_cast<Index>(cloud.positions.size());
  Lists near = nearestNeighbors(cloud.positions, wanted);
  std::vector<Index> count(n);
  const Index num_blocks = (n + kBlock - 1) / kBlock;
  std::vector<std::vector<Index>> few(num_blocks), farther(num_blocks);  // points of which too few were reached; their new lists
  const auto measure = [](const Vec3& d) { return d.x() * d.x() + d.y() * d.y() + d.z() * d.z(); };  // in the order of the tree
  // Leaves those of the part of point i that are reached. asked: of how many, with point i. False: too few.
  const auto keep = [&](Index i, Index asked, WayCheck& check, std::vector<Neighbor>& found) {
    const auto isOther = [&](const Neighbor& neighbor) {
      return neighbor.index == i || cloud.part[neighbor.index] != cloud.part[i];
    };
    found.erase(std::remove_if(found.begin(), found.end(), isOther), found.end());
    if (over_surface) check.keepReached(i, found);
    count[i] = std::min(wanted, static_cast<Index>(found.size()));
    return static_cast<Index>(found.size()) > wanted / 2 || asked > kMaxAsked * wanted || asked >= n;
  };
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    WayCheck check(cloud);
    std::vector<Neighbor> found;
    for (Index i = begin; i < end; ++i) {
      found.clear();
      for (const Index* j = near.begin(i); j != near.end(i); ++j)
        found.push_back({measure(cloud.positions[*j] - cloud.positions[i]), *j});
      if (!keep(i, wanted + 1, check, found)) few[begin / kBlock].push_back(i);
      for (Index m = 0; m < count[i]; ++m) near.items[near.offsets[i] + m] = found[m].index;
    }
  });
  if (std::any_of(few.begin(), few.end(), [](const std::vector<Index>& points) { return !points.empty(); })) {
    const KdTree tree(cloud.positions);
    parallelFor(num_blocks, 1, [&](Index block, Index) {
      WayCheck check(cloud);
      std::vector<Neighbor> found;
      for (const Index i : few[block]) {
        Index asked = wanted + 1;
        do {
          asked *= 2;
          tree.nearest(cloud.positions[i], asked, found);
        } while (!keep(i, asked, check, found));
        for (Index m = 0; m < count[i]; ++m) farther[block].push_back(found[m].index);
      }
    });
  }
  Lists lists;
  lists.offsets.resize(n + 1);
  for (Index i = 0; i < n; ++i) lists.offsets[i + 1] = lists.offsets[i] + count[i];
  lists.items.resize(lists.offsets[n]);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    const std::vector<Index>& points = few[begin / kBlock];
    std::size_t next = 0;
    const Index* of_next = farther[begin / kBlock].data();
    for (Index i = begin; i < end; ++i) {
      const bool is_farther = next < points.size() && points[next] == i;
      std::copy_n(is_farther ? of_next : near.begin(i), count[i], lists.items.begin() + lists.offsets[i]);
      if (!is_farther) continue;
      of_next += count[i];
      ++next;
    }
  });
  return lists;
}

}  // namespace

void thinCoarsely(const Lists& neighbors, Index stop, Index wanted, bool over_surface, ThinnedCloud& cloud) {
  const Lists* lists = &neighbors;
  Index num_left = static_cast<Index>(cloud.positions.size());
  const Index num_parts = cloud.part.empty() ? 0 : *std::max_element(cloud.part.begin(), cloud.part.end()) + 1;
  double diameter = 0.0;
  for (;;) {
    const auto [nearest, farthest] = measureLists(cloud.positions, *lists);
    const double largest = kListReach * farthest;
    std::vector<char> is_left(cloud.positions.size(), 1);
    const Index before = num_left;
    bool is_done = false;
    // All at once as long as enough stay, then level by level.
    std::vector<Removal> removals = findTooNear(cloud, *lists, is_left, largest, num_parts);
    const bool is_last = num_left - static_cast<Index>(removals.size()) < stop;
    for (double least = is_last ? nearest : largest; least > 0.0 && least <= largest && !is_done; least *= kLevelFactor) {
      if (is_last) removals = findTooNear(cloud, *lists, is_left, least, num_parts);
      is_done = num_left - static_cast<Index>(removals.size()) < stop;
      for (const Removal& removal : removals) {
        if (is_done) break;
        is_left[removal.point] = 0;
        diameter = std::max(diameter, 2.0 * removal.distance);
        cloud.removed.push_back(cloud.index[removal.point]);
        cloud.diameter.push_back(diameter);
      }
      if (!is_done) num_left -= static_cast<Index>(removals.size());
    }
    const bool are_all = num_left == before;
    if (!are_all || lists == &neighbors) cloud = takeLeft(cloud, *lists, is_left);
    if (are_all) return;
    cloud.neighbors = findNeighbors(cloud, wanted, over_surface);
    if (is_done) return;
    lists = &cloud.neighbors;
  }
}

}  // namespace deformable_surface::cloud
