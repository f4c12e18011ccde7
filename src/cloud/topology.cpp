// Components, boundary loops and Euler characteristic, measured on the triangles of the rings.
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/cloud/rings.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace deformable_surface::cloud {
namespace {

// True for the weights of triangles on which all stars agree: an ordinary one, or one of the four in a square cell.
bool isAgreed(double weight) {
  constexpr double kRounding = 1e-9;
  return std::abs(weight - 1.0) < kRounding || std::abs(weight - 0.5) < kRounding;
}

// Directed edges of triangles, kept at the vertex they leave. On an oriented surface each is used by one triangle at most.
class DirectedEdges {
 public:
  DirectedEdges(Index num_points, const std::vector<Triangle>& triangles) : begin_(num_points + 1, 0) {
    for (const Triangle& t : triangles) {
      for (Index corner : t.corner) ++begin_[corner + 1];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    end_.assign(begin_.begin(), begin_.end() - 1);
    to_.resize(begin_.back());
  }

  bool contains(Index from, Index to) const {
    return std::find(to_.begin() + begin_[from], to_.begin() + end_[from], to) != to_.begin() + end_[from];
  }
  void insert(Index from, Index to) { to_[end_[from]++] = to; }

  Index countOut(Index from) const { return end_[from] - begin_[from]; }

  // Calls visit(from, to) for the edges that no triangle uses the other way round: the boundary.
  template <class Visit>
  void forBoundary(Index from, const Visit& visit) const {
    for (Index e = begin_[from]; e < end_[from]; ++e) {
      if (!contains(to_[e], from)) visit(to_[e]);
    }
  }

 private:
  std::vector<Index> begin_, end_, to_;
};

struct Loops {
  Index boundary = 0;
  Index gaps = 0;  // between stars that disagree: a triangulation would fill them
};

// Boundary edges followed head to tail; a walk that comes back to a vertex has closed a loop. Loops that pass mostly points with
// closed rings are gaps.
Loops countLoops(const DirectedEdges& edges, const std::vector<char>& open) {
  const Index n = static_cast<Index>(open.size());
  Lists boundary;
  for (Index i = 0; i < n; ++i) {
    edges.forBoundary(i, [&](Index to) { boundary.items.push_back(to); });
    boundary.offsets.push_back(static_cast<Index>(boundary.items.size()));
  }
  Loops loops;
  std::vector<Index> next(boundary.offsets.begin(), boundary.offsets.end() - 1);
  std::vector<Index> walk;
  std::vector<char> on_walk(n, 0);
  for (Index start = 0; start < n; ++start) {
    walk.assign(1, start);
    on_walk[start] = 1;
    for (Index at = start; next[at] < boundary.offsets[at + 1];) {
      at = boundary.items[next[at]++];
      if (!on_walk[at]) {
        walk.push_back(at);
        on_walk[at] = 1;
        continue;
      }
      Index length = 0, num_open = 0, passed;
      do {
        passed = walk.back();
        walk.pop_back();
        on_walk[passed] = 0;
        ++length;
        num_open += open[passed];
      } while (passed != at);
      walk.push_back(at);
      on_walk[at] = 1;
      ++(2 * num_open > length ? loops.boundary : loops.gaps);
    }
    for (Index i : walk) on_walk[i] = 0;
  }
  return loops;
}

}  // namespace

Topology measureTopology(const Rings& rings) {
  const Index n = rings.ring.size();

  // Heavier triangles first. A triangle that would use an edge a second time in the same direction overlaps another. One on which
  // stars disagree must join two existing triangles: otherwise it may lie above them.
  std::vector<Index> order(rings.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return rings.triangles[a].weight > rings.triangles[b].weight; });
  DirectedEdges edges(n, rings.triangles);
  Index num_triangles = 0;
  for (Index t : order) {
    const auto& [a, b, c] = rings.triangles[t].corner;
    if (edges.contains(a, b) || edges.contains(b, c) || edges.contains(c, a)) continue;
    const int joined = edges.contains(b, a) + edges.contains(c, b) + edges.contains(a, c);
    if (!isAgreed(rings.triangles[t].weight) && joined < 2) continue;
    edges.insert(a, b);
    edges.insert(b, c);
    edges.insert(c, a);
    ++num_triangles;
  }

  // Every boundary edge has one triangle, every other edge two.
  Index num_boundary = 0, num_vertices = 0;
  for (Index i = 0; i < n; ++i) {
    num_vertices += edges.countOut(i) > 0;
    edges.forBoundary(i, [&](Index) { ++num_boundary; });
  }
  const Index num_edges = (3 * num_triangles + num_boundary) / 2;

  Topology topology;
  labelComponents(rings, topology.components);
  const Loops loops = countLoops(edges, rings.open);
  topology.boundary_loops = loops.boundary;
  topology.euler_characteristic = num_vertices - num_edges + num_triangles + loops.gaps;
  return topology;
}

std::vector<Index> labelComponents(const Rings& rings, Index& num_components) {
  Index num_with_isolated = 0;
  std::vector<Index> label = labelComponents(rings.ring, num_with_isolated);

  // Components of one point are no components: the others are renumbered in the same order.
  std::vector<Index> renumbered(num_with_isolated, -1);
  num_components = 0;
  for (std::size_t i = 0; i < label.size(); ++i) {
    Index& number = renumbered[label[i]];
    if (number < 0 && rings.ring.count(static_cast<Index>(i)) > 0) number = num_components++;
    label[i] = number;
  }
  return label;
}

}  // namespace deformable_surface::cloud
