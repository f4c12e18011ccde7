#include "parts.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/links.h"

#include <algorithm>
#include <numeric>

#include "rest_parts.h"

namespace deformable_surface::simulation {
Parts findParts(Index n, const std::vector<std::pair<Index, Index>>& links) {
  Parts parts;
  Index count = 0;
  parts.label = cloud::labelComponents(n, links, count);
  parts.size.assign(count, 0);
  for (const Index label : parts.label) ++parts.size[label];
  return parts;
}

std::vector<char> markLargest(const Parts& parts, Index most) {
  std::vector<Index> order(parts.count());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return parts.size[a] > parts.size[b]; });
  std::vector<char> is_large(parts.count(), 0);
  for (Index k = 0; k < std::min(most, parts.count()); ++k) is_large[order[k]] = 1;
  std::vector<char> marked;
  for (const Index label : parts.label) marked.push_back(is_large[label]);
  return marked;
}

std::vector<std::pair<Index, Index>> linksOf(const Lists& neighbors) {
  std::vector<std::pair<Index, Index>> links;
  for (Index i = 0; i < neighbors.size(); ++i)
    for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) links.emplace_back(i, *j);
  return links;
}

void leaveOut(const std::string& why, const Parts& parts, const std::vector<char>& kept, RestSurface& s) {
  cloud::CleanCloud& dense = s.dense;
  std::vector<Index> new_index(kept.size(), -1);
  std::vector<char> is_out(parts.count(), 0);
  Index n = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    is_out[parts.label[i]] = !kept[i];
    if (!kept[i]) continue;
    dense.positions[n] = dense.positions[i];
    if (!dense.normals.empty()) dense.normals[n] = dense.normals[i];
    if (!s.off_surface.empty()) s.off_surface[n] = s.off_surface[i];
    new_index[i] = n++;
  }
  if (n == static_cast<Index>(kept.size())) return;
  s.notes.push_back(why + ": " + formatCount(static_cast<Index>(std::count(is_out.begin(), is_out.end(), 1)), "of ") +
                    formatCount(parts.count(), "parts of the cloud are left out, ") +
                    formatCount(static_cast<Index>(kept.size()) - n, "points, which become NaN"));
  dense.positions.resize(n);
  if (!dense.normals.empty()) dense.normals.resize(n);
  if (!s.off_surface.empty()) s.off_surface.resize(n);
  for (Index& point : dense.point_of_input)
    if (point >= 0) point = new_index[point];
}

void keepLargestParts(const SceneParams& params, const Parts& parts, RestSurface& s) {
  leaveOut("input.largest_parts " + std::to_string(params.input.largest_parts), parts,
           markLargest(parts, params.input.largest_parts), s);
}

void LooseParts::follow(Index n, const std::vector<std::pair<Index, Index>>* links) {
  if (!links) {
    links_.clear();
    parts_.label.assign(n, 0);
    parts_.size.assign(n > 0 ? 1 : 0, n);
  } else if (static_cast<Index>(parts_.label.size()) != n || links_ != *links) {
    links_ = *links;
    parts_ = findParts(n, links_);
  }
}

void LooseParts::find(const std::vector<char>& held, const std::vector<double>& stiffness, const Points& loads,
                      const Points& positions, const ContactLoad& contact, double time) {
  constexpr double kRounding = 1e-6;  // of the sum of the sizes
  is_held_.assign(parts_.count(), 0);
  sizes_.assign(parts_.count(), 0.0);
  sums_.assign(parts_.count(), Vec3::Zero());
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const Index p = parts_.label[i];
    if (held[i] || stiffness[i] > 0.0) is_held_[p] = 1;
    sums_[p] += loads[i];
    sizes_[p] += loads[i].norm();
  }
  for (std::size_t i = 0; i < loads.size() && !contact.isEmpty(); ++i) {
    const Index p = parts_.label[i];
    if (!is_held_[p] && sums_[p].norm() > 0.0) is_held_[p] = contact.mayHold(positions[i], sums_[p].normalized(), time);
  }
  is_loose_.assign(parts_.count(), 0);
  count_ = points_ = 0;
  for (Index p = 0; p < parts_.count(); ++p) {
    if (is_held_[p] || !(sums_[p].norm() > kRounding * sizes_[p])) continue;
    if (count_++ == 0) load_ = sums_[p].norm();
    is_loose_[p] = 1;
  }
  for (std::size_t i = 0; i < loads.size(); ++i)
    if (isLoose(static_cast<Index>(i)) && points_++ == 0) place_ = positions[i];
}

std::string LooseParts::describe() const {
  return "nothing holds " + formatCount(count_, count_ == 1 ? "part of what is simulated, " : "parts of what is simulated, ") +
         formatCount(points_, points_ == 1 ? "point, at " : "points, the first at ") + formatPlace(place_) +
         " m, against the loads: without an equilibrium it stays where it is";
}

}  // namespace deformable_surface::simulation
