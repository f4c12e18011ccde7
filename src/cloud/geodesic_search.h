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

/// Shows for most pairs of a point and a listed one, at a fraction of the cost of a search, that no detour separates them: by any
/// path over listed points that is short enough. Not for all: the paths that it meets are not the shortest ones.
class QuickCheck {
 public:
  explicit QuickCheck(const GeodesicGraph& graph) : graph_(graph) {}

  /// Whether this is shown for all of the list.
  bool run(Index i, const Points& positions, const Index* begin, const Index* end, double max_detour) {
    met_.clear();
    bound_.clear();
    waiting_.clear();
    is_shown_.assign(end - begin, 1);
    reach(i, 0.0);
    // Links of a graph made from these lists have their order.
    Index own = graph_.links.offsets[i];
    for (const Index* j = begin; j != end; ++j) {
      const double most = max_detour * (positions[*j] - positions[i]).norm();
      const bool is_linked = own < graph_.links.offsets[i + 1] && graph_.links.items[own] == *j;
      const double cost = is_linked ? graph_.cost[own++] : std::numeric_limits<double>::infinity();
      const Waiting to{*j, static_cast<Index>(j - begin), most};
      if (cost <= most)
        reach(*j, cost);
      else if (!findPath(to))
        waiting_.push_back(to);
    }
    for (int pass = 0; pass < kPasses && !waiting_.empty(); ++pass)
      waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), [&](const Waiting& to) { return findPath(to); }),
                     waiting_.end());
    for (const Waiting& to : waiting_) is_shown_[to.place] = 0;
    return waiting_.empty();
  }

  /// Of the last run, for the entry at `place` of the list.
  bool isShown(std::size_t place) const { return is_shown_[place] != 0; }

 private:
  struct Waiting {
    Index point, place;
    double most;  // m, the longest path that is no detour
  };

  void reach(Index point, double bound) {
    met_.add(point);
    bound_.push_back(bound);
  }

  // Takes the first link with a point that has been reached, if that is no detour: most links are then not looked at. They are
  // read backwards: a graph's costs are the same in both directions.
  bool findPath(const Waiting& to) {
    for (Index e = graph_.links.offsets[to.point]; e < graph_.links.offsets[to.point + 1]; ++e) {
      const Index from = met_.find(graph_.links.items[e]);
      if (from < 0 || !(bound_[from] + graph_.cost[e] <= to.most)) continue;
      reach(to.point, bound_[from] + graph_.cost[e]);
      return true;
    }
    return false;
  }

  // Later passes find paths over points that are listed later. A search costs as much as several tens of passes.
  static constexpr int kPasses = 2;

  const GeodesicGraph& graph_;
  PointMap met_;
  std::vector<double> bound_;     // m, of the points met: the length of a path to them
  std::vector<Waiting> waiting_;  // listed points that have not been reached
  std::vector<char> is_shown_;    // by place in the list
};

}  // namespace deformable_surface::cloud
