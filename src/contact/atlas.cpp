#include "deformable_surface/contact/atlas.h"

#include <algorithm>

namespace deformable_surface::contact {
namespace {

constexpr Index kFewPatches = 4;  // in the smallest charts, without their margin
constexpr Index kParts = 4;       // of a chart

void sortOut(std::vector<Index>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

Atlas::Atlas(const Points& rest, const std::vector<Triangle>& triangles, const Patches& patches, double distance)
    : rest_(rest),
      triangles_(triangles),
      patches_(patches),
      distance_(distance),
      patch_of_(rest.size(), -1),
      neighbors_(patches.size()),
      triangles_at_(rest.size()) {
  for (Index p = 0; p < patches.size(); ++p) {
    neighbors_[p].push_back(p);
    patches.visitVertices(p, [&](Index v) { patch_of_[v] = p; });
  }
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const Index v : triangles[t]) {
      triangles_at_[v].push_back(static_cast<Index>(t));
      for (const Index w : triangles[t])
        if (patch_of_[v] < patch_of_[w]) neighbors_[patch_of_[v]].push_back(patch_of_[w]);
    }
  for (std::vector<Index>& neighbors : neighbors_) sortOut(neighbors);
  if (patches.size() > kFewPatches) split(0, patches.size());
}

// Patches that follow each other lie together: see Patches.
void Atlas::split(Index first, Index end) {
  if (first == end) return;
  const std::size_t self = nodes_.size();
  const bool is_all = end - first == patches_.size();
  if (!is_all) nodes_.push_back({first, end, 0, {}, {}});
  if (end - first > kFewPatches)
    for (Index k = 0; k < kParts; ++k) split(first + k * (end - first) / kParts, first + (k + 1) * (end - first) / kParts);
  if (!is_all) nodes_[self].behind = size();
}

void Atlas::make(Node& node) {
  for (Index p = node.first; p < node.end; ++p)
    node.patches.insert(node.patches.end(), neighbors_[p].begin(), neighbors_[p].end());
  sortOut(node.patches);
  std::vector<Index> own, points;
  for (const Index p : node.patches)
    patches_.visitVertices(p, [&](Index v) { own.insert(own.end(), triangles_at_[v].begin(), triangles_at_[v].end()); });
  sortOut(own);
  for (const Index t : own) points.insert(points.end(), triangles_[t].begin(), triangles_[t].end());
  sortOut(points);
  Points rest;
  for (const Index i : points) rest.push_back(rest_[i]);
  std::vector<Triangle> triangles;
  for (const Index t : own) {
    triangles.push_back(triangles_[t]);
    for (Index& v : triangles.back()) v = static_cast<Index>(std::lower_bound(points.begin(), points.end(), v) - points.begin());
  }
  Outlines outlines = findOutlines(rest, triangles);
  const auto rename = [&](Index& i) { i = i < 0 ? i : points[i]; };
  std::for_each(outlines.points.begin(), outlines.points.end(), rename);
  std::for_each(outlines.loop_points.begin(), outlines.loop_points.end(), rename);
  for (Triangle& t : outlines.triangles) std::for_each(t.begin(), t.end(), rename);
  for (Outlines::Loop& loop : outlines.loops) rename(loop.middle);
  // A point without triangles is in no chart.
  const auto hasLone = [&](Index p) {
    bool has = false;
    patches_.visitVertices(p, [&](Index v) { has = has || triangles_at_[v].empty(); });
    return has;
  };
  node.patches.erase(std::remove_if(node.patches.begin(), node.patches.end(), hasLone), node.patches.end());
  node.chart.emplace(std::move(outlines), distance_);
}

const Chart& Atlas::chart(Index chart) {
  Node& node = nodes_[chart];
  if (!node.chart) make(node);
  return *node.chart;
}

const std::vector<Index>& Atlas::patchesIn(Index chart) {
  Node& node = nodes_[chart];
  if (!node.chart) make(node);
  return node.patches;
}

}  // namespace deformable_surface::contact
