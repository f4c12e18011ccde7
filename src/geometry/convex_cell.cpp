#include "deformable_surface/geometry/convex_cell.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::geometry {
namespace {

constexpr double kTouch = 1e-12;  // of the cube's size: well above rounding, well below any part of a cell that counts

}  // namespace

void ConvexCell::reset(double half_size) {
  half_size_ = half_size;
  corners_.clear();
  first_.assign(1, 0);
  labels_.assign(6, -1);
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-half_size, half_size}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const double turn = side > 0.0 ? half_size : -half_size;
      for (const auto& [a, b] : {std::pair<double, double>{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
        Vec3 corner;
        corner[axis] = side;
        corner[u] = a * turn;
        corner[v] = b * half_size;
        corners_.push_back(corner);
      }
      first_.push_back(static_cast<Index>(corners_.size()));
    }
}

void ConvexCell::cut(const Vec3& normal, double offset, int label) {
  const double touch = kTouch * half_size_ * normal.norm();
  height_.clear();
  double highest = -1.0;
  for (const Vec3& corner : corners_) {
    height_.push_back(normal.dot(corner) - offset);
    highest = std::max(highest, height_.back());
  }
  if (!(highest > touch)) return;

  kept_.clear();
  kept_first_.assign(1, 0);
  kept_labels_.clear();
  rim_.clear();
  for (std::size_t f = 0; f + 1 < first_.size(); ++f) {
    const Index begin = first_[f], end = first_[f + 1];
    for (Index k = begin; k < end; ++k) {
      const Index next = k + 1 < end ? k + 1 : begin;
      const double here = height_[k], there = height_[next];
      if (here <= touch) kept_.push_back(corners_[k]);
      if (std::abs(here) <= touch) rim_.push_back(corners_[k]);
      if ((here < -touch && there > touch) || (here > touch && there < -touch)) {
        kept_.push_back(corners_[k] + here / (here - there) * (corners_[next] - corners_[k]));
        rim_.push_back(kept_.back());
      }
    }
    endFacet(labels_[f]);
  }

  // The new facet: all on the plane, around their middle.
  if (rim_.size() >= 3) {
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : rim_) middle += p / static_cast<double>(rim_.size());
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u).normalized();
    order_.clear();
    for (std::size_t k = 0; k < rim_.size(); ++k)
      order_.emplace_back(std::atan2(v.dot(rim_[k] - middle), u.dot(rim_[k] - middle)), static_cast<Index>(k));
    std::sort(order_.begin(), order_.end());
    // Each corner came from two facets or more.
    for (const auto& [angle, k] : order_)
      if (static_cast<Index>(kept_.size()) == kept_first_.back() || (kept_.back() - rim_[k]).norm() > touch / normal.norm())
        kept_.push_back(rim_[k]);
    endFacet(label);
  }
  std::swap(labels_, kept_labels_);
  std::swap(corners_, kept_);
  std::swap(first_, kept_first_);
}

// A facet with fewer than three corners is only an edge and is dropped.
void ConvexCell::endFacet(int label) {
  if (static_cast<Index>(kept_.size()) - kept_first_.back() < 3) {
    kept_.resize(kept_first_.back());
    return;
  }
  kept_first_.push_back(static_cast<Index>(kept_.size()));
  kept_labels_.push_back(label);
}

Vec3 ConvexCell::area(int label) const {
  Vec3 twice = Vec3::Zero();
  for (std::size_t f = 0; f + 1 < first_.size(); ++f) {
    if (labels_[f] != label) continue;
    const Vec3& from = corners_[first_[f]];
    for (Index k = first_[f] + 2; k < first_[f + 1]; ++k) twice += (corners_[k - 1] - from).cross(corners_[k] - from);
  }
  return 0.5 * twice;
}

double ConvexCell::volume() const {
  if (corners_.empty()) return 0.0;
  // Relative to one of its corners, so that no large terms cancel.
  const Vec3& from = corners_.front();
  double six_times = 0.0;
  for (std::size_t f = 0; f + 1 < first_.size(); ++f)
    for (Index k = first_[f] + 2; k < first_[f + 1]; ++k)
      six_times += (corners_[first_[f]] - from).dot((corners_[k - 1] - from).cross(corners_[k] - from));
  return six_times / 6.0;
}

}  // namespace deformable_surface::geometry
