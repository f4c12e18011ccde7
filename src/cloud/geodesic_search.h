// Paths from one point over a graph: a search, and a quick upper bound of its distances. Private.
#pragma once

#include "deformable_surface/cloud/geodesics.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "point_map.h"

namespace deformable_surface::cloud {

/// Dijkstra's search in the order of cost, ties by index.
class Search {
 public:
  Search(const GeodesicGraph& graph, const Points& positions) : graph_(graph), positions_(positions) {}

  // Calls visit(point, distance) for the points in the order of cost, the source first, until it returns false, or a point is
  // farther than reach. admits(point, cost): false for points that need not be visited, nor those behind them.
  template <class Visit, class Admit>
  void run(Index source, double reach, const Visit& visit, const Admit& admits) {
    met_.clear();
    states_.clear();
    queue_.clear();
    // Points farther than reach are not visited. No length is needed if the cost is the distance.
    const double most = graph_.cost_is_distance ? reach : std::numeric_limits<double>::infinity();
    offer(source, 0.0, 0.0);
    while (!queue_.empty()) {
      const auto [queued, point, number] = queue_.front();
      std::pop_heap(queue_.begin(), queue_.end(), std::greater<Entry>());
      queue_.pop_back();
      State& state = states_[number];
      if (state.settled) continue;
      state.settled = true;
      const double cost = state.cost, length = state.length;
      const double distance = graph_.cost_is_distance ? cost : length;
      if (!(distance <= reach) || !visit(point, distance)) return;
      for (Index e = graph_.links.offsets[point]; e < graph_.links.offsets[point + 1]; ++e) {
        const Index to = graph_.links.items[e];
        if (!(cost + graph_.cost[e] <= most) || !admits(to, cost + graph_.cost[e])) continue;
        offer(to, cost + graph_.cost[e], graph_.cost_is_distance ? 0.0 : length + (positions_[to] - positions_[point]).norm());
      }
    }
  }

  template <class Visit>
  void run(Index source, double reach, const Visit& visit) {
    run(source, reach, visit, [](Index, double) { return true; });
  }

  bool costIsDistance() const { return graph_.cost_is_distance; }

 private:
  using Entry = std::tuple<double, Index, Index>;  // cost, point, its number
  struct State {
    double cost, length;
    bool settled;
  };

  void offer(Index point, double cost, double length) {
    Index number = met_.find(point);
    if (number < 0) {
      number = met_.add(point);
      states_.push_back({std::numeric_limits<double>::infinity(), 0.0, false});
    }
    State& state = states_[number];
    if (!(std::tie(cost, length) < std::tie(state.cost, state.length))) return;
    if (cost < state.cost) {
      queue_.push_back({cost, point, number});
      std::push_heap(queue_.begin(), queue_.end(), std::greater<Entry>());
    }
    state.cost = cost;
    state.length = length;
  }

  const GeodesicGraph& graph_;
  const Points& positions_;
  PointMap met_;
  std::vector<State> states_;
  std::vector<Entry> queue_;
};

/// True if paths over listed neighbours alone, taken nearest first, already show that none of them needs more than a detour: an
/// upper bound of the distances that is nearly always enough, at a fraction of the cost of a search.
class QuickCheck {
 public:
  explicit QuickCheck(const GeodesicGraph& graph) : graph_(graph) {}

  bool run(Index i, const Points& positions, const Index* begin, const Index* end, double max_detour) {
    if (isReachedInOrder(i, positions, begin, end, max_detour)) return true;
    met_.clear();
    most_.clear();
    for (const Index* j = begin; j != end; ++j) {
      met_.add(*j);
      most_.push_back(max_detour * (positions[*j] - positions[i]).norm());
    }
    missing_ = most_.size();
    bound_.assign(end - begin, std::numeric_limits<double>::infinity());
    relax(i, 0.0);
    // Bounds only fall. Once none is missing, the answer is known. A second pass finds paths that lead back.
    for (int pass = 0; pass < kPasses; ++pass) {
      for (std::size_t m = 0; m < bound_.size() && missing_ > 0; ++m) {
        if (bound_[m] < std::numeric_limits<double>::infinity()) relax(begin[m], bound_[m]);
      }
    }
    return missing_ == 0;
  }
  // Whether the pass showed this for the entry at `place` of the list. After a run that returned false.
  bool isShown(std::size_t place) const { return bound_[place] <= most_[place]; }

 private:
  // The same with the first path found to each point, whose last link begins at one taken before. Where this succeeds, run()
  // would have done so, too: it looks at these paths among others. Most links are then not looked at. Links are read backwards: a
  // graph's costs are the same in both directions.
  bool isReachedInOrder(Index i, const Points& positions, const Index* begin, const Index* end, double max_detour) {
    met_.clear();
    met_.add(i);
    bound_.assign(1, 0.0);
    for (const Index* j = begin; j != end; ++j) {
      const double most = max_detour * (positions[*j] - positions[i]).norm();
      const auto findPath = [&] {
        for (Index e = graph_.links.offsets[*j]; e < graph_.links.offsets[*j + 1]; ++e) {
          const Index from = met_.find(graph_.links.items[e]);
          if (from < 0 || !(bound_[from] + graph_.cost[e] <= most)) continue;
          met_.add(*j);
          bound_.push_back(bound_[from] + graph_.cost[e]);
          return true;
        }
        return false;
      };
      if (!findPath()) return false;
    }
    return true;
  }

  void relax(Index from, double cost) {
    for (Index e = graph_.links.offsets[from]; e < graph_.links.offsets[from + 1]; ++e) {
      const Index to = met_.find(graph_.links.items[e]);
      if (to < 0 || !(cost + graph_.cost[e] < bound_[to])) continue;
      missing_ -= !(bound_[to] <= most_[to]) && cost + graph_.cost[e] <= most_[to];
      bound_[to] = cost + graph_.cost[e];
    }
  }

  // A search costs as much as several tens of passes.
  static constexpr int kPasses = 2;

  const GeodesicGraph& graph_;
  PointMap met_;
  std::vector<double> bound_, most_;  // m, of the listed points: the bound found, and the longest path that is no detour
  std::size_t missing_ = 0;           // listed points whose bound is above that
};

}  // namespace deformable_surface::cloud
