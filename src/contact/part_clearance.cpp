#include "deformable_surface/contact/part_clearance.h"

#include <algorithm>
#include <utility>

namespace deformable_surface::contact {

PartClearance::PartClearance(std::vector<Index> points, Index n) : points_(std::move(points)), is_part_(n, 0) {
  for (const Index i : points_) is_part_[i] = 1;
}

bool PartClearance::follow(std::shared_ptr<const ClearMotion> motion, const Points& positions) {
  motion_ = std::move(motion);
  if (!motion_) return false;
  for (std::size_t i = 0; i < is_part_.size(); ++i) {
    if (is_part_[i]) continue;
    const double aside = (positions[i] - motion_->from[i]).lpNorm<Eigen::Infinity>();
    if (!motion_->way[i].isZero(0.0) || !(aside <= motion_->tolerance)) return false;
  }
  // If the leader rests, nothing is predicted to move.
  const auto found = std::lower_bound(points_.begin(), points_.end(), motion_->leader);
  const bool leads = found != points_.end() && *found == motion_->leader;
  leader_ = leads ? static_cast<Index>(found - points_.begin()) : -1;
  return true;
}

bool PartClearance::covers(const Points& part) const {
  const double share = leader_ >= 0 ? motion_->shareAt(part[leader_]) : 0.0;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Vec3 predicted = motion_->from[points_[k]] + share * motion_->way[points_[k]];
    if (!((part[k] - predicted).lpNorm<Eigen::Infinity>() <= motion_->tolerance)) return false;
  }
  return true;
}

}  // namespace deformable_surface::contact
