// Cuts and changes of the material of a mass-spring surface. Forces do not know of them:
// cut elements do not exist, and the others have other constants.
#include "deformable_surface/model/mass_spring/incidence.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <algorithm>

#include "balanced_plate.h"

namespace deformable_surface::model {
namespace {

using Link = MassSpring::Link;

// The edges of triangles that are gone, without those of a triangle that is left. Both (links) ascending.
std::vector<Link> findLostEdges(const std::vector<WeightedTriangle>& gone, const std::vector<WeightedTriangle>& left,
                                Index num_points) {
  std::vector<Link> edges;
  std::vector<char> is_beside(num_points, 0);
  const auto forEachEdge = [](const WeightedTriangle& t, const auto& visit) {
    for (int c = 0; c < 3; ++c) visit(Link(std::minmax({t.corner[c], t.corner[(c + 1) % 3]})));
  };
  for (const WeightedTriangle& t : gone)
    forEachEdge(t, [&](const Link& edge) {
      edges.push_back(edge);
      is_beside[edge.first] = is_beside[edge.second] = 1;
    });
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<char> is_left(edges.size(), 0);
  for (const WeightedTriangle& t : left)
    forEachEdge(t, [&](const Link& edge) {
      if (!is_beside[edge.first] || !is_beside[edge.second]) return;
      const auto found = std::lower_bound(edges.begin(), edges.end(), edge);
      if (found != edges.end() && *found == edge) is_left[found - edges.begin()] = 1;
    });
  std::vector<Link> lost;
  for (std::size_t e = 0; e < edges.size(); ++e)
    if (!is_left[e]) lost.push_back(edges[e]);
  return lost;
}

}  // namespace

bool MassSpring::isCut(Index i, Index j) const {
  return !cuts_.empty() && std::binary_search(cuts_.begin(), cuts_.end(), Link(std::min(i, j), std::max(i, j)));
}

void MassSpring::rememberMade() {
  if (!made_.masses.empty()) return;
  made_.triangles = triangles_;
  if (membrane_ == Membrane::kTriangles) made_.membrane = std::make_shared<const TriangleMembrane>(membrane_triangles_);
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
  for (const PointMaterial& material : materials_) plate.shares.push_back(material.bending);
  if (cuts_.empty()) {
    plate.triangles = triangles_;
    bending_ = CurvatureBending(plate, held_, edges_);
    whole_.reset();
  } else {
    if (!whole_) {
      plate.triangles = made_.triangles;
      whole_ = std::make_shared<const BalancedPlate>(balancePlate(clampPlate(plate, held_, edges_)));
    }
    plate.triangles = triangles_;
    plate.ring = Lists{};
    plate.ring.offsets.reserve(plate_.ring.offsets.size());
    plate.ring.items.reserve(plate_.ring.items.size());
    for (Index i = 0; i < plate_.ring.size(); ++i) {
      for (const Index* j = plate_.ring.begin(i); j != plate_.ring.end(i); ++j)
        if (!isCut(i, *j)) plate.ring.items.push_back(*j);
      plate.ring.offsets.push_back(static_cast<Index>(plate.ring.items.size()));
    }
    bending_ = CurvatureBending(*whole_, plate, held_, edges_);
  }
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
    membrane_triangles_ =
        TriangleMembrane(scaled, made_.points, made_.membrane_stiffness, made_.poisson_ratio, made_.membrane.get());
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
  std::vector<WeightedTriangle> gone;
  for (const WeightedTriangle& t : made_.triangles) {
    const bool is_cut = isCut(t.corner[0], t.corner[1]) || isCut(t.corner[1], t.corner[2]) || isCut(t.corner[2], t.corner[0]);
    (is_cut ? gone : triangles_).push_back(t);
  }
  if (membrane_ == Membrane::kTriangles && !gone.empty()) {
    // Links that only held removed triangles together.
    const std::vector<Link> lost = findLostEdges(gone, triangles_, static_cast<Index>(made_.points.size()));
    std::vector<Link> all;
    std::set_union(cuts_.begin(), cuts_.end(), lost.begin(), lost.end(), std::back_inserter(all));
    cuts_ = std::move(all);
  }
  rebuild();
}

}  // namespace deformable_surface::model
