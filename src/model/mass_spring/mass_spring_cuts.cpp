// What a cut leaves of a mass-spring surface. Apart from the model's forces, which know nothing of it: elements that are cut are not there.
#include "deformable_surface/model/mass_spring/incidence.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <algorithm>

namespace deformable_surface::model {
namespace {

using Link = MassSpring::Link;

// The edges of triangles, each once, ascending.
std::vector<Link> collectEdges(const std::vector<WeightedTriangle>& triangles) {
  std::vector<Link> edges;
  for (const WeightedTriangle& t : triangles)
    for (int c = 0; c < 3; ++c) edges.push_back(std::minmax({t.corner[c], t.corner[(c + 1) % 3]}));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace

bool MassSpring::isCut(Index i, Index j) const {
  return !cuts_.empty() && std::binary_search(cuts_.begin(), cuts_.end(), Link(std::min(i, j), std::max(i, j)));
}

void MassSpring::groupTriangles() {
  std::vector<std::pair<Index, Index>> corners;
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (int c = 0; c < 3; ++c) corners.emplace_back(triangles_[t].corner[c], static_cast<Index>(3 * t) + c);
  triangle_corners_ = groupByPoint(static_cast<Index>(whole_.points.size()), corners);
}

Springs MassSpring::takeWhole(const Springs& springs) const {
  std::vector<Link> links;
  std::vector<double> stiffness;
  for (std::size_t s = 0; s < springs.links().size(); ++s) {
    if (isCut(springs.links()[s].first, springs.links()[s].second)) continue;
    links.push_back(springs.links()[s]);
    stiffness.push_back(springs.stiffness()[s]);
  }
  return Springs(std::move(links), whole_.points, std::move(stiffness));
}

void MassSpring::buildBending() {
  const BendingRest& b = bending_rest_;
  if (b.points.empty()) return;
  if (cuts_.empty()) {
    bending_ = CurvatureBending(b.points, b.normals, b.ring, b.areas, b.rigidity, held_);
    return;
  }
  Lists ring;
  for (Index i = 0; i < b.ring.size(); ++i) {
    for (const Index* j = b.ring.begin(i); j != b.ring.end(i); ++j)
      if (!isCut(i, *j)) ring.items.push_back(*j);
    ring.offsets.push_back(static_cast<Index>(ring.items.size()));
  }
  bending_ = CurvatureBending(b.points, b.normals, ring, b.areas, b.rigidity, held_);
}

void MassSpring::setCuts(const std::vector<Link>& links) {
  if (links == cuts_) return;
  if (cuts_.empty()) {
    whole_.triangles = triangles_;
    whole_.stretching = stretching_;
    whole_.bending_springs = bending_springs_;
  }
  cuts_ = links;
  triangles_.clear();
  for (const WeightedTriangle& t : whole_.triangles)
    if (!isCut(t.corner[0], t.corner[1]) && !isCut(t.corner[1], t.corner[2]) && !isCut(t.corner[2], t.corner[0])) triangles_.push_back(t);
  if (membrane_ == Membrane::kTriangles && !cuts_.empty()) {
    // Links that only held together what is gone.
    const std::vector<Link> before = collectEdges(whole_.triangles), after = collectEdges(triangles_);
    std::vector<Link> lost;
    std::set_difference(before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(lost));
    std::vector<Link> all;
    std::set_union(cuts_.begin(), cuts_.end(), lost.begin(), lost.end(), std::back_inserter(all));
    cuts_ = std::move(all);
  }
  groupTriangles();
  stretching_ = takeWhole(whole_.stretching);
  bending_springs_ = takeWhole(whole_.bending_springs);
  if (membrane_ == Membrane::kTriangles)
    membrane_triangles_ = TriangleMembrane(triangles_, whole_.points, whole_.membrane_stiffness, whole_.poisson_ratio);
  buildBending();
}

}  // namespace deformable_surface::model
