// The limit of motion in steps of the awake part of a surface: it knows the rest of it only by what was proven of the whole.
#pragma once

#include "deformable_surface/contact/part_clearance.h"
#include "deformable_surface/contact/self_contact.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/solve/motion_limit.h"

#include <vector>

namespace deformable_surface::simulation {

/// Stops nothing. Once a motion is no longer known to be free, its step is void: hasLeft().
class PartMotionLimit : public solve::MotionLimit {
 public:
  /// contact: of the surface, with n points, kept by reference. points: of the part, ascending.
  PartMotionLimit(contact::SelfContact& contact, const std::vector<Index>& points, Index n);

  /// Before a step of a time (s) from a state of the surface, of which all points rest that are not of the part: proves that
  /// nothing comes near if that is not known already. Returns whether it is now.
  bool foresee(const model::State& whole, double time);
  const std::vector<Index>& limit(const Points& before, Points& after, bool continues) const override;
  /// Nothing is ever stopped.
  const std::vector<Index>& parts() const override { return none_; }
  bool hasLeft() const { return has_left_; }

 private:
  bool renew(const Points& before, const Points& after) const;

  contact::SelfContact& contact_;
  const std::vector<Index> points_, none_;
  mutable contact::PartClearance clearance_;
  mutable Points whole_, motion_;  // (n) m
  mutable bool has_left_ = false;
};

}  // namespace deformable_surface::simulation
