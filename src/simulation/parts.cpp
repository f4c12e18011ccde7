#include "parts.h"

#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/links.h"

#include <algorithm>
#include <numeric>

#include "rest_parts.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kMostSizes = 5;  // that a sentence lists

// "12, 5 and 3", the largest first; "12, 5, 3, 2, 2 and fewer" where there are more.
std::string listSizes(std::vector<Index> sizes) {
  std::sort(sizes.begin(), sizes.end(), std::greater<Index>());
  const Index listed = std::min(kMostSizes, static_cast<Index>(sizes.size()));
  const bool has_more = listed < static_cast<Index>(sizes.size());
  std::string text;
  for (Index k = 0; k < listed; ++k) {
    if (k > 0) text += k + 1 == listed && !has_more ? " and " : ", ";
    text += std::to_string(sizes[k]);
  }
  return text + (has_more ? " and fewer" : "");
}

// Dense points that belong to simulation points which are marked.
Index countDense(const RestSurface& s, const std::vector<char>& marked) {
  const cloud::KdTree tree(s.points);
  std::vector<cloud::Neighbor> near;
  Index found = 0;
  for (std::size_t i = 0; i < s.dense.positions.size(); ++i) {
    Index owner = s.cells.owner.empty() ? -1 : s.cells.owner[i];
    if (owner < 0) {
      tree.nearest(s.dense.positions[i], 1, near);
      owner = near.front().index;
    }
    found += marked[owner];
  }
  return found;
}

// Which points are pinned or anchored.
std::vector<char> markHeld(const SceneParams& params, const RestSurface& s) {
  std::vector<char> held = s.pinned;
  const cloud::KdTree tree(s.points);
  std::vector<cloud::Neighbor> near;
  for (const AnchorParams& anchor : params.anchors) {
    tree.nearest(anchor.point, 1, near);
    held[near.front().index] = 1;
  }
  return held;
}

}  // namespace

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

void keepLargestParts(const SceneParams& params, const Parts& parts, RestSurface& s) {
  const Index most = params.input.keep_parts;
  if (most == 0 || parts.count() <= most) return;
  const std::vector<char> kept = markLargest(parts, most);
  cloud::CleanCloud& dense = s.dense;
  std::vector<Index> new_index(kept.size(), -1);
  Index n = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (!kept[i]) continue;
    dense.positions[n] = dense.positions[i];
    if (!dense.normals.empty()) dense.normals[n] = dense.normals[i];
    if (!s.off_surface.empty()) s.off_surface[n] = s.off_surface[i];
    new_index[i] = n++;
  }
  s.notes.push_back("input.keep_parts " + std::to_string(most) + ": " + count(parts.count() - most, "of ") +
                    count(parts.count(), "parts of the cloud are left out, ") +
                    count(static_cast<Index>(kept.size()) - n, "points, which become NaN"));
  dense.positions.resize(n);
  if (!dense.normals.empty()) dense.normals.resize(n);
  if (!s.off_surface.empty()) s.off_surface.resize(n);
  for (Index& point : dense.point_of_input)
    if (point >= 0) point = new_index[point];
}

void noteParts(const SceneParams& params, RestSurface& s) {
  const Index n = static_cast<Index>(s.points.size());
  if (s.model->stretchLinks().empty()) return;
  const Parts parts = findParts(n, s.model->stretchLinks());
  if (parts.count() < 2) return;
  const std::vector<char> held = markHeld(params, s);
  std::vector<char> is_held(parts.count(), 0);
  for (Index i = 0; i < n; ++i)
    if (held[i]) is_held[parts.label[i]] = 1;
  std::vector<Index> sizes;
  for (Index p = 0; p < parts.count(); ++p)
    if (!is_held[p]) sizes.push_back(parts.size[p]);
  if (sizes.empty()) return;
  std::vector<char> loose;
  for (const Index label : parts.label) loose.push_back(is_held[label] ? 0 : 1);
  const bool is_any_held = static_cast<Index>(sizes.size()) < parts.count();
  (is_any_held ? s.warnings : s.notes)
      .push_back(count(static_cast<Index>(sizes.size()), "of ") +
                 count(parts.count(), "parts of what is simulated held by no pin and no anchor, with ") + listSizes(sizes) +
                 " simulation points (" + count(countDense(s, loose), "points of the cloud)") +
                 (is_any_held ? "; input.keep_parts leaves small parts out" : ""));
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
  return "nothing holds " + count(count_, count_ == 1 ? "part of what is simulated, " : "parts of what is simulated, ") +
         count(points_, points_ == 1 ? "point, at " : "points, the first at ") + formatShort(place_.x()) + ", " +
         formatShort(place_.y()) + ", " + formatShort(place_.z()) +
         " m, against the loads: without an equilibrium it stays where it is";
}

}  // namespace deformable_surface::simulation
