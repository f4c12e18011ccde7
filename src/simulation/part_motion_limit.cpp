#include "part_motion_limit.h"

namespace deformable_surface::simulation {

PartMotionLimit::PartMotionLimit(contact::SelfContact& contact, const std::vector<Index>& points, Index n)
    : contact_(contact), points_(points), clearance_(points, n), motion_(n, Vec3::Zero()) {}

bool PartMotionLimit::foresee(const model::State& whole, double time) {
  has_left_ = false;
  whole_ = whole.positions;
  if (clearance_.follow(contact_.proven(), whole_)) return true;
  clearance_.forget();  // its memory is used again
  return contact_.foresee(whole_, whole.velocities, time) && clearance_.follow(contact_.proven(), whole_);
}

// The motion of the present sub-step is taken to go on.
bool PartMotionLimit::renew(const Points& before, const Points& after) const {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    whole_[points_[k]] = before[k];
    motion_[points_[k]] = after[k] - before[k];
  }
  clearance_.forget();
  return contact_.foresee(whole_, motion_, 1.0) && clearance_.follow(contact_.proven(), whole_) && clearance_.covers(after);
}

const std::vector<Index>& PartMotionLimit::limit(const Points& before, Points& after, bool continues) const {
  if (has_left_ || (clearance_.covers(after) && (continues || clearance_.covers(before)))) return none_;
  has_left_ = !renew(before, after);
  return none_;
}

}  // namespace deformable_surface::simulation
