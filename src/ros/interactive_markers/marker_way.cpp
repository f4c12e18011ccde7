#include "marker_way.h"

#include <algorithm>

namespace deformable_surface::node {

double MarkerWay::measure(const tool::Pose& a, const tool::Pose& b) const {
  return std::max((b.position - a.position).norm(), lever_ * a.orientation.angularDistance(b.orientation));
}

void MarkerWay::append(const tool::Pose& pose) {
  const auto isNear = [&](const tool::Pose& place) { return measure(place, pose) <= loop_; };
  if (isNear(pose_)) {
    ahead_.clear();
  } else {
    const auto earlier = std::find_if(ahead_.begin(), ahead_.end(), isNear);
    if (earlier != ahead_.end()) ahead_.erase(earlier + 1, ahead_.end());
  }
  ahead_.push_back(pose);
}

void MarkerWay::advance(double length) {
  while (!ahead_.empty()) {
    const tool::Pose next = ahead_.front();
    const double distance = measure(pose_, next);
    if (!(distance <= length)) {
      const double share = length / distance;
      pose_ = {pose_.position + share * (next.position - pose_.position), pose_.orientation.slerp(share, next.orientation)};
      return;
    }
    pose_ = next;
    length -= distance;
    ahead_.pop_front();
  }
}

}  // namespace deformable_surface::node
