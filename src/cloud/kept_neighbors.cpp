#include "deformable_surface/cloud/kept_neighbors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_surface::cloud {
namespace {

constexpr double kRounding = 1e-9;       // of a distance, far above what rounding makes of it
constexpr std::size_t kMostStrays = 16;  // all of them are looked at for each point
constexpr Index kCandidatesPerOne = 2;   // of the nearest: neighbours change after about half of their distance

// Summed in the order of the tree, which gives the same bits.
Neighbor measure(const Points& points, const Vec3& at, Index other) {
  const Vec3& p = points[other];
  const double x = p.x() - at.x(), y = p.y() - at.y(), z = p.z() - at.z();
  return {x * x + y * y + z * z, other};
}

// Distances anew, and sorted. They were sorted before the last moves.
void renew(const Points& points, const Vec3& at, std::vector<Neighbor>& candidates) {
  for (auto it = candidates.begin(); it != candidates.end(); ++it) {
    const Neighbor renewed = measure(points, at, it->index);
    auto to = it;
    for (; to != candidates.begin() && renewed < to[-1]; --to) *to = to[-1];
    *to = renewed;
  }
}

}  // namespace

KeptNeighborhoods::KeptNeighborhoods(double radius, double skin) : radius_(radius), skin_(skin) {}

void KeptNeighborhoods::update(const Points& positions) {
  const double most = 0.25 * skin_ * skin_;
  bool is_kept = tree_ && positions.size() == searched_.size();
  strays_.clear();
  for (std::size_t i = 0; is_kept && i < positions.size(); ++i) {
    if ((positions[i] - searched_[i]).squaredNorm() <= most) continue;
    strays_.push_back(static_cast<Index>(i));
    is_kept = strays_.size() <= kMostStrays && positions[i].allFinite();  // the tree refuses others
  }
  positions_ = positions;
  if (is_kept) return;
  strays_.clear();
  searched_ = positions;
  tree_.emplace(positions);
  candidates_.resize(positions.size());
  for (auto& list : candidates_) list.clear();
}

void KeptNeighborhoods::find(Index i, std::vector<Neighbor>& out) {
  const Vec3& at = positions_[i];
  const auto isWithin = [&](const Neighbor& q) { return q.squared_distance <= radius_ * radius_; };
  if (std::binary_search(strays_.begin(), strays_.end(), i)) {
    tree_->withinRadius(at, (1.0 + kRounding) * (radius_ + 0.5 * skin_), out);
    renew(positions_, at, out);
    out.erase(std::partition_point(out.begin(), out.end(), isWithin), out.end());
  } else {
    std::vector<Neighbor>& candidates = candidates_[i];
    if (candidates.empty()) tree_->withinRadius(searched_[i], (1.0 + kRounding) * (radius_ + skin_), candidates);
    renew(positions_, at, candidates);
    out.assign(candidates.begin(), std::partition_point(candidates.begin(), candidates.end(), isWithin));
  }
  for (const Index stray : strays_) {
    const Neighbor other = measure(positions_, at, stray);
    if (!isWithin(other)) continue;
    const auto to = std::lower_bound(out.begin(), out.end(), other);
    if (to == out.end() || to->index != stray) out.insert(to, other);
  }
}

KeptNearest::KeptNearest(const KdTree& tree, const Points& points, Index k, Index num_places)
    : tree_(tree), points_(points), k_(k), candidates_(num_places) {}

void KeptNearest::find(Index place, const Vec3& at, std::vector<Neighbor>& out) {
  Candidates& candidates = candidates_[place];
  std::vector<Neighbor>& found = candidates.found;
  renew(points_, at, found);
  const Index k = std::min(k_, tree_.size());
  const double moved = (at - candidates.searched_at).norm();
  if (static_cast<Index>(found.size()) < k ||
      (k > 0 && !(std::sqrt(found[k - 1].squared_distance) < (1.0 - kRounding) * candidates.distance - moved))) {
    tree_.nearest(at, kCandidatesPerOne * k_, found);
    candidates.searched_at = at;
    candidates.distance = static_cast<Index>(found.size()) < tree_.size() ? std::sqrt(found.back().squared_distance)
                                                                          : std::numeric_limits<double>::infinity();
  }
  out.assign(found.begin(), found.begin() + k);
}

}  // namespace deformable_surface::cloud
