// Parts of a mass-spring surface for sleeping: the same elements with the same numbers in the same order, on fewer points. A step
// costs only the part, and every force is as in the whole.
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include "deformable_surface/base/marks.h"
#include "deformable_surface/model/mass_spring/incidence.h"

namespace deformable_surface::model {

void Springs::markPartners(const std::vector<Index>& points, std::vector<char>& marked) const {
  if (links_.empty()) return;
  for (const Index i : points)
    for (Index k = incidence_.offsets[i]; k < incidence_.offsets[i + 1]; k += 2) marked[incidence_.items[k + 1]] = 1;
}

Springs Springs::makePart(const PartIndex& part) const {
  Springs springs;
  if (links_.empty()) return springs;
  const std::vector<Index> found = findElements(part.wanted, incidence_, 2, [&](Index k) { return incidence_.items[k]; });
  springs.links_.reserve(found.size());
  springs.rest_length_.reserve(found.size());
  springs.stiffness_.reserve(found.size());
  for (const Index s : found) {
    springs.links_.emplace_back(part.new_index[links_[s].first], part.new_index[links_[s].second]);
    springs.rest_length_.push_back(rest_length_[s]);
    springs.stiffness_.push_back(stiffness_[s]);
  }
  springs.prepareForceLoop(part.size());
  return springs;
}

void TriangleMembrane::markPartners(const std::vector<Index>& points, std::vector<char>& marked) const {
  if (elements_.empty()) return;
  for (const Index i : points)
    for (const Index* item = incidence_.begin(i); item != incidence_.end(i); ++item)
      for (const Index point : patches_[patchOf(*item)].points) marked[point] = 1;
}

TriangleMembrane TriangleMembrane::makePart(const PartIndex& part) const {
  TriangleMembrane membrane;
  if (elements_.empty()) return membrane;
  membrane.mu_ = mu_;
  membrane.lambda_ = lambda_;
  const std::vector<Index> found =
      findElements(part.wanted, incidence_, 1, [&](Index k) { return patchOf(incidence_.items[k]); });
  std::vector<Index> kept;
  for (const Index p : found)
    for (const Index t : patches_[p].elements)
      if (t >= 0) kept.push_back(t);
  std::sort(kept.begin(), kept.end());
  membrane.elements_.reserve(kept.size());
  for (const Index t : kept) {
    membrane.elements_.push_back(elements_[t]);
    for (Index& corner : membrane.elements_.back().corner) corner = part.new_index[corner];
  }
  membrane.patches_.reserve(found.size());
  for (const Index p : found) {
    membrane.num_fours_ += p < num_fours_;
    membrane.patches_.push_back(patches_[p]);
    for (Index& point : membrane.patches_.back().points) point = part.new_index[point];
    for (Index& t : membrane.patches_.back().elements)
      if (t >= 0) t = static_cast<Index>(std::lower_bound(kept.begin(), kept.end(), t) - kept.begin());
  }
  membrane.prepareForceLoop(part.size());
  return membrane;
}

void CurvatureBending::markPartners(const std::vector<Index>& points, std::vector<char>& marked) const {
  if (neighbors_.size() == 0) return;
  // Each fit once, though all its points use it. Kept by the thread: later calls allocate nothing.
  static thread_local Marks seen;
  seen.begin(neighbors_.size());
  const auto markFitsOf = [&](Index i) {
    for (Index k = loop_.users().offsets[i]; k < loop_.users().offsets[i + 1]; k += 2) {
      const Index fit = loop_.fitOf(k);
      if (!seen.take(fit)) continue;
      for (const Index* j = neighbors_.begin(fit); j != neighbors_.end(fit); ++j) {
        if (*j < numPoints())
          marked[*j] = 1;
        else
          for (const Index point : edge_points_[*j - numPoints()].points) marked[point] = 1;
      }
    }
  };
  for (const Index i : points) {
    markFitsOf(i);
    for (auto rider = firstRider(i); rider != riders_.end() && rider->first == i; ++rider) markFitsOf(rider->second);
  }
}

CurvatureBending CurvatureBending::makePart(const PartIndex& part) const {
  CurvatureBending bending;
  bending.poisson_ratio_ = poisson_ratio_;
  if (neighbors_.size() == 0) return bending;
  std::vector<Index> wanted = part.wanted;
  for (const Index i : part.wanted)
    for (auto rider = firstRider(i); rider != riders_.end() && rider->first == i; ++rider) wanted.push_back(rider->second);
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  const std::vector<Index> fits = findElements(wanted, loop_.users(), 2, [&](Index k) { return loop_.fitOf(k); });
  // Points on edges belong to the part if one of its fits uses them.
  const Index num_points = numPoints();
  std::vector<Index> points = part.points, new_edge(edge_points_.size(), -1);
  std::size_t num_rows = 0;
  for (const Index fit : fits) {
    num_rows += neighbors_.count(fit);
    for (const Index* j = neighbors_.begin(fit); j != neighbors_.end(fit); ++j)
      if (*j >= num_points) new_edge[*j - num_points] = 0;
  }
  for (std::size_t e = 0; e < edge_points_.size(); ++e) {
    if (new_edge[e] < 0) continue;
    new_edge[e] = static_cast<Index>(points.size());
    points.push_back(num_points + static_cast<Index>(e));
    bending.edge_points_.push_back(edge_points_[e]);
    for (Index& point : bending.edge_points_.back().points) point = part.new_index[point];
  }
  bending.neighbors_.items.reserve(num_rows);
  bending.neighbors_.offsets.reserve(points.size() + 1);
  bending.rows_.reserve(num_rows);
  bending.rest_curvature_.assign(points.size(), Vec3::Zero());
  bending.weight_.assign(points.size(), 0.0);
  auto next = fits.begin();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Index i = points[k];
    const bool has_fit = next != fits.end() && *next == i;
    if (has_fit) {
      ++next;
      bending.rest_curvature_[k] = rest_curvature_[i];
      bending.weight_[k] = weight_[i];
    }
    for (Index r = neighbors_.offsets[i]; has_fit && r < neighbors_.offsets[i + 1]; ++r) {
      const Index j = neighbors_.items[r];
      bending.neighbors_.items.push_back(j < num_points ? part.new_index[j] : new_edge[j - num_points]);
      bending.rows_.push_back(rows_[r]);
    }
    bending.neighbors_.offsets.push_back(static_cast<Index>(bending.neighbors_.items.size()));
  }
  bending.prepareForceLoop();
  return bending;
}

bool MassSpring::markPartners(const std::vector<Index>& points, std::vector<char>& marked) const {
  if (volume_stiffness_ > 0.0) return false;
  stretching_.markPartners(points, marked);
  bending_springs_.markPartners(points, marked);
  membrane_triangles_.markPartners(points, marked);
  bending_.markPartners(points, marked);
  // The area of a point is that of its triangles, also where these are no elements.
  for (const Index i : points)
    for (const Index* c = triangle_corners_.begin(i); c != triangle_corners_.end(i); ++c)
      for (const Index corner : triangles_[*c / 3].corner) marked[corner] = 1;
  return true;
}

Partition::Part MassSpring::makePart(const std::vector<char>& wanted) const {
  PartIndex index;
  for (Index i = 0; i < static_cast<Index>(wanted.size()); ++i)
    if (wanted[i]) index.wanted.push_back(i);
  std::vector<char> present = wanted;
  if (!markPartners(index.wanted, present)) return {};
  index.new_index.assign(wanted.size(), -1);
  for (Index i = 0; i < static_cast<Index>(wanted.size()); ++i) {
    if (!present[i]) continue;
    index.new_index[i] = index.size();
    index.points.push_back(i);
  }

  std::unique_ptr<MassSpring> part(new MassSpring);
  part->masses_.reserve(index.points.size());
  for (const Index i : index.points) part->masses_.push_back(masses_[i]);
  part->membrane_ = membrane_;
  part->along_damping_ = along_damping_;
  part->relative_damping_ = relative_damping_;
  part->stretching_ = stretching_.makePart(index);
  part->bending_springs_ = bending_springs_.makePart(index);
  part->membrane_triangles_ = membrane_triangles_.makePart(index);
  part->bending_ = bending_.makePart(index);
  part->plate_.rigidity = plate_.rigidity;
  const std::vector<Index> found =
      findElements(index.wanted, triangle_corners_, 1, [&](Index k) { return triangle_corners_.items[k] / 3; });
  std::vector<std::pair<Index, Index>> corners;
  corners.reserve(3 * found.size());
  part->triangles_.reserve(found.size());
  for (const Index t : found) {
    WeightedTriangle triangle = triangles_[t];
    for (int c = 0; c < 3; ++c) {
      triangle.corner[c] = index.new_index[triangle.corner[c]];
      corners.emplace_back(triangle.corner[c], static_cast<Index>(3 * part->triangles_.size()) + c);
    }
    part->triangles_.push_back(triangle);
  }
  part->triangle_corners_ = groupByPoint(index.size(), corners);
  return {std::move(part), std::move(index.points)};
}

}  // namespace deformable_surface::model
