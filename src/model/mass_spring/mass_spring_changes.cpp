// Cuts and changes of the material of a mass-spring surface. Forces do not know of them:
// cut elements do not exist, and the others have other constants.
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

void MassSpring::rememberMade() {
  if (!made_.masses.empty()) return;
  made_.triangles = triangles_;
  made_.links = stretching_.links();
  made_.stiffness = stretching_.stiffness();
  made_.across = bending_springs_.links();
  made_.across_stiffness = bending_springs_.stiffness();
  made_.masses = masses_;
}

void MassSpring::groupTriangles() {
  std::vector<std::pair<Index, Index>> corners;
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (int c = 0; c < 3; ++c) corners.emplace_back(triangles_[t].corner[c], static_cast<Index>(3 * t) + c);
  triangle_corners_ = groupByPoint(static_cast<Index>(made_.points.size()), corners);
}

Springs MassSpring::takeSprings(const std::vector<Link>& links, const std::vector<double>& stiffness) const {
  std::vector<Link> kept;
  std::vector<double> k;
  for (std::size_t s = 0; s < links.size(); ++s) {
    const auto [i, j] = links[s];
    if (isCut(i, j)) continue;
    kept.push_back(links[s]);
    k.push_back(materials_.empty() ? stiffness[s] : 0.5 * (materials_[i].stretching + materials_[j].stretching) * stiffness[s]);
  }
  return Springs(std::move(kept), made_.points, std::move(k));
}

void MassSpring::buildBending() {
  if (plate_.points.empty()) return;
  PlateRest plate = plate_;
  plate.triangles = triangles_;
  for (const PointMaterial& material : materials_) plate.shares.push_back(material.bending);
  if (!cuts_.empty()) {
    plate.ring = Lists{};
    for (Index i = 0; i < plate_.ring.size(); ++i) {
      for (const Index* j = plate_.ring.begin(i); j != plate_.ring.end(i); ++j)
        if (!isCut(i, *j)) plate.ring.items.push_back(*j);
      plate.ring.offsets.push_back(static_cast<Index>(plate.ring.items.size()));
    }
  }
  bending_ = CurvatureBending(plate, held_, edges_);
  forgetGuesses();
}

void MassSpring::rebuild() {
  groupTriangles();
  stretching_ = takeSprings(made_.links, made_.stiffness);
  bending_springs_ = takeSprings(made_.across, made_.across_stiffness);
  if (membrane_ == Membrane::kTriangles) {
    // The energy of a triangle is proportional to its weight.
    std::vector<WeightedTriangle> scaled = triangles_;
    if (!materials_.empty())
      for (WeightedTriangle& t : scaled)
        t.weight *=
            (materials_[t.corner[0]].stretching + materials_[t.corner[1]].stretching + materials_[t.corner[2]].stretching) / 3.0;
    membrane_triangles_ = TriangleMembrane(scaled, made_.points, made_.membrane_stiffness, made_.poisson_ratio);
  }
  for (std::size_t i = 0; i < materials_.size(); ++i) masses_[i] = made_.masses[i] * materials_[i].density;
  buildBending();
  forgetGuesses();
}

void MassSpring::setMaterial(const std::vector<PointMaterial>& materials) {
  rememberMade();
  materials_ = materials;
  rebuild();
}

void MassSpring::setCuts(const std::vector<Link>& links) {
  if (links == cuts_) return;
  rememberMade();
  cuts_ = links;
  triangles_.clear();
  for (const WeightedTriangle& t : made_.triangles)
    if (!isCut(t.corner[0], t.corner[1]) && !isCut(t.corner[1], t.corner[2]) && !isCut(t.corner[2], t.corner[0]))
      triangles_.push_back(t);
  if (membrane_ == Membrane::kTriangles && !cuts_.empty()) {
    // Links that only held removed triangles together.
    const std::vector<Link> before = collectEdges(made_.triangles), after = collectEdges(triangles_);
    std::vector<Link> lost;
    std::set_difference(before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(lost));
    std::vector<Link> all;
    std::set_union(cuts_.begin(), cuts_.end(), lost.begin(), lost.end(), std::back_inserter(all));
    cuts_ = std::move(all);
  }
  rebuild();
}

}  // namespace deformable_surface::model
