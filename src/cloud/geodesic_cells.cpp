// Paths from all chosen points at once divide the surface into cells; the rest works on the chosen points.
#include "deformable_surface/cloud/geodesic_cells.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "k_nearest.h"

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 1024;  // points per task: some milliseconds of work
// Points among which one thread passes lengths on one after the other; lengths for points of other threads follow a sweep later.
constexpr Index kSweep = 1 << 15;
// Listed neighbours that the search visits: more would make paths hardly straighter.
constexpr Index kSteps = 16;

const Index* endOfSteps(const Lists& neighbors, Index i) { return neighbors.begin(i) + std::min(kSteps, neighbors.count(i)); }

// Two chosen points whose cells touch without a detour between the points.
struct Touch {
  Index a, b;
  double length;  // m, in space
};

// Costs are distances of chosen points in space, raised so that a path of kKeptWay is a detour of kKeptDetour.
GeodesicGraph joinCells(const Points& positions, const Lists& neighbors, const std::vector<double>& distance,
                        const GeodesicCells& cells) {
  const Index n = neighbors.size();
  std::vector<std::vector<Touch>> blocks((n + kBlock - 1) / kBlock);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<Touch>& touches = blocks[begin / kBlock];
    for (Index u = begin; u < end; ++u) {
      const Index a = cells.owner[u];
      if (a < 0) continue;
      for (const Index* v = neighbors.begin(u); v != endOfSteps(neighbors, u); ++v) {
        const Index b = cells.owner[*v];
        if (b < 0 || b == a) continue;
        const double path = distance[u] + (positions[*v] - positions[u]).norm() + distance[*v];
        const double length = (cells.chosen[b] - cells.chosen[a]).norm();
        if (path <= kKeptWay * length) touches.push_back({a, b, length});
      }
    }
  });

  std::vector<std::vector<std::pair<Index, double>>> beside(cells.chosen.size());
  const auto insert = [&](Index a, Index b, double length) {
    for (const auto& known : beside[a]) {
      if (known.first == b) return;
    }
    beside[a].push_back({b, length});
  };
  for (const std::vector<Touch>& touches : blocks) {
    for (const Touch& touch : touches) {
      insert(touch.a, touch.b, touch.length);
      insert(touch.b, touch.a, touch.length);
    }
  }
  GeodesicGraph graph;
  graph.cost_is_distance = true;
  for (const auto& list : beside) {
    for (const auto& [b, length] : list) {
      graph.links.items.push_back(b);
      graph.cost.push_back(kKeptDetour / kKeptWay * length);
    }
    graph.links.offsets.push_back(static_cast<Index>(graph.links.items.size()));
  }
  return graph;
}

// The nearest chosen points of any point. They are among those nearest to the chosen point of its cell, which are searched for
// once.
class NearOfCells {
 public:
  NearOfCells(const Points& chosen, Index k)
      : chosen_(chosen), k_(k), tree_(chosen), around_(nearestNeighbors(chosen, kAround * k)), distance_(around_.items.size()) {
    for (Index a = 0; a < around_.size(); ++a)
      for (Index e = around_.offsets[a]; e < around_.offsets[a + 1]; ++e)
        distance_[e] = (chosen[around_.items[e]] - chosen[a]).norm();
  }

  /// The k nearest to a point, as KdTree::nearest() finds them. owner: of its cell, or -1.
  void find(const Vec3& point, Index owner, std::vector<Neighbor>& near) const {
    if (k_ < 1 || owner < 0 || !areAround(point, owner, near)) tree_.nearest(point, k_, near);
  }

 private:
  static constexpr Index kAround = 4;  // times the points wanted

  // False: there may be nearer ones than those around the owner.
  bool areAround(const Vec3& point, Index owner, std::vector<Neighbor>& near) const {
    constexpr double kRounding = 1.0 + 1e-9;
    KNearest nearest(k_, near);
    const auto measure = [&](Index b) {
      const Vec3 d = chosen_[b] - point;
      return d.x() * d.x() + d.y() * d.y() + d.z() * d.z();  // in the order of the tree
    };
    const double squared = measure(owner), to_owner = std::sqrt(squared);
    nearest.add(squared, owner);
    double reach = std::numeric_limits<double>::infinity();  // m, of the k nearest
    for (Index e = around_.offsets[owner]; e < around_.offsets[owner + 1]; ++e) {
      if (distance_[e] > kRounding * (to_owner + reach)) return true;  // this one and all that follow are farther
      const double to_other = measure(around_.items[e]);
      if (!(to_other <= nearest.bound())) continue;
      nearest.add(to_other, around_.items[e]);
      reach = std::sqrt(nearest.bound());
    }
    return around_.count(owner) + 1 == static_cast<Index>(chosen_.size());
  }

  const Points& chosen_;
  const Index k_;
  const KdTree tree_;
  const Lists around_;            // of the chosen points, nearest first
  std::vector<double> distance_;  // m, to them
};

// Calls visit(v, to) for the next points of a path from u, with its length there.
template <class Visit>
void forSteps(const Points& positions, const Lists& neighbors, double distance, Index u, const Visit& visit) {
  for (const Index* v = neighbors.begin(u); v != endOfSteps(neighbors, u); ++v)
    visit(*v, distance + (positions[*v] - positions[u]).norm());
}

// Replaces value by `to` while isLess(to, value), whatever other threads write meanwhile. Returns whether it did.
template <class T, class IsLess>
bool lower(std::atomic<T>& value, T to, const IsLess& isLess) {
  T known = value.load(std::memory_order_relaxed);
  while (isLess(to, known)) {
    if (value.compare_exchange_weak(known, to)) return true;
  }
  return false;
}

// Lengths of the shortest paths from any chosen point, m. Points whose length has changed wait to pass it on. They do so in the
// order of the cloud, forwards and backwards: points near in space are near in memory, while an order by length would jump
// about. Points beyond a horizon wait until nothing changes below it. The lengths do not depend on the order, and so not on the
// number of threads.
std::vector<double> findDistances(const Points& positions, const Lists& neighbors, const std::vector<Index>& chosen) {
  const Index n = neighbors.size();
  std::vector<std::atomic<double>> distance(n);
  std::vector<std::atomic<char>> waits(n);
  for (std::atomic<double>& d : distance) d.store(std::numeric_limits<double>::infinity(), std::memory_order_relaxed);
  double spacing = 0.0;
  for (Index i : chosen) {
    distance[i] = 0.0;
    waits[i] = 1;
    if (neighbors.count(i) > 0)
      spacing += (positions[*neighbors.begin(i)] - positions[i]).norm() / static_cast<double>(chosen.size());
  }
  // About a quarter of the size of cells: with a far horizon many lengths are passed on before they are final.
  double horizon =
      0.25 * spacing * std::sqrt(static_cast<double>(n) / static_cast<double>(std::max<std::size_t>(1, chosen.size())));
  std::atomic<bool> any_beyond{!chosen.empty()};
  for (; any_beyond; horizon = horizon > 0.0 ? 2.0 * horizon : std::numeric_limits<double>::infinity()) {
    std::atomic<bool> any_changed{true};
    for (bool is_forward = true; any_changed; is_forward = !is_forward) {
      any_changed = any_beyond = false;
      parallelFor(n, kSweep, [&](Index begin, Index end) {
        for (Index k = begin; k < end; ++k) {
          const Index u = is_forward ? k : n - 1 - k;
          if (!waits[u].load(std::memory_order_relaxed)) continue;
          if (!(distance[u].load(std::memory_order_relaxed) <= horizon)) {
            any_beyond = true;
            continue;
          }
          // First the mark, then the length: a length written in between sets the mark again.
          waits[u].exchange(0);
          any_changed = true;
          forSteps(positions, neighbors, distance[u].load(), u, [&](Index v, double to) {
            if (lower(distance[v], to, std::less<double>())) waits[v].store(1);
          });
        }
      });
    }
  }
  return std::vector<double>(distance.begin(), distance.end());
}

// The chosen point at the start of each path. Of several shortest paths to a point the one with the nearest last step
// counts, ties by index. A step too short to lengthen a path, after rounding, is on none.
void findOwners(const Points& positions, const Lists& neighbors, const std::vector<Index>& chosen,
                const std::vector<double>& distance, std::vector<Index>& owner) {
  const Index n = neighbors.size();
  std::vector<std::atomic<Index>> before(n);
  for (std::atomic<Index>& b : before) b.store(-1, std::memory_order_relaxed);
  const auto isNearer = [&](Index a, Index b) {
    return b < 0 || std::make_pair(distance[a], a) < std::make_pair(distance[b], b);
  };
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index u = begin; u < end; ++u) {
      if (!(distance[u] < std::numeric_limits<double>::infinity())) continue;
      forSteps(positions, neighbors, distance[u], u, [&](Index v, double to) {
        if (to == distance[v] && distance[u] < distance[v]) lower(before[v], u, isNearer);
      });
    }
  });
  for (std::size_t a = 0; a < chosen.size(); ++a) owner[chosen[a]] = static_cast<Index>(a);
  std::vector<Index> way;
  for (Index i = 0; i < n; ++i) {
    Index at = i;
    for (; owner[at] < 0 && before[at] >= 0; at = before[at]) way.push_back(at);
    for (Index passed : way) owner[passed] = owner[at];
    way.clear();
  }
}

}  // namespace

GeodesicCells findGeodesicCells(const Points& positions, const Lists& neighbors, const std::vector<Index>& chosen, Index k) {
  const Index n = neighbors.size();
  GeodesicCells cells;
  cells.owner.assign(n, -1);
  for (Index i : chosen) cells.chosen.push_back(positions[i]);

  const std::vector<double> distance = findDistances(positions, neighbors, chosen);
  findOwners(positions, neighbors, chosen, distance, cells.owner);

  const GeodesicGraph graph = joinCells(positions, neighbors, distance, cells);
  cells.neighbors = keepGeodesicNeighbors(graph, cells.chosen, {}, nearestNeighbors(cells.chosen, k)).lists;
  return cells;
}

Lists findChosenNear(const GeodesicCells& cells, const Points& positions, Index k) {
  return findChosenNear(cells, cells.owner, positions, k);
}

Lists findChosenNear(const GeodesicCells& cells, const std::vector<Index>& owner, const Points& positions, Index k) {
  const Index n = static_cast<Index>(positions.size());
  const Lists& neighbors = cells.neighbors;
  const auto measure = [&](Index a, Index b) { return (cells.chosen[b] - cells.chosen[a]).norm(); };
  const auto lists = [&](Index a, Index b) { return std::find(neighbors.begin(a), neighbors.end(a), b) != neighbors.end(a); };
  const auto isNear = [&](Index a, Index b) {
    if (a == b || lists(a, b)) return true;
    const double longest = kKeptWay * measure(a, b);
    return std::any_of(neighbors.begin(a), neighbors.end(a),
                       [&](Index m) { return lists(m, b) && measure(a, m) + measure(m, b) <= longest; });
  };

  const NearOfCells search(cells.chosen, k);
  std::vector<std::vector<Index>> found((n + kBlock - 1) / kBlock);
  std::vector<Index> count(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<Neighbor> near;
    for (Index i = begin; i < end; ++i) {
      const Index a = owner[i];
      search.find(positions[i], a, near);
      const auto isApart = [&](const Neighbor& other) { return !isNear(a, other.index); };
      const auto kept = a < 0 ? near.end() : std::remove_if(near.begin(), near.end(), isApart);
      if (kept != near.end()) {
        // Others in their place.
        near.erase(kept, near.end());
        const auto add = [&](Index b) { near.push_back({(cells.chosen[b] - positions[i]).squaredNorm(), b}); };
        add(a);
        std::for_each(neighbors.begin(a), neighbors.end(a), add);
        std::sort(near.begin(), near.end());
        const auto same = [](const Neighbor& x, const Neighbor& y) { return x.index == y.index; };
        near.erase(std::unique(near.begin(), near.end(), same), near.end());
        if (static_cast<Index>(near.size()) > k) near.resize(k);
      }
      count[i] = static_cast<Index>(near.size());
      for (const Neighbor& other : near) found[begin / kBlock].push_back(other.index);
    }
  });
  Lists result;
  result.offsets.resize(n + 1);
  for (Index i = 0; i < n; ++i) result.offsets[i + 1] = result.offsets[i] + count[i];
  result.items.resize(result.offsets[n]);
  parallelFor(n, kBlock, [&](Index begin, Index) {
    const std::vector<Index>& part = found[begin / kBlock];
    std::copy(part.begin(), part.end(), result.items.begin() + result.offsets[begin]);
  });
  return result;
}

}  // namespace deformable_surface::cloud
