// A knife in a step: what it went between. Apart from contact, because it does not push.
#pragma once

#include "deformable_surface/tool/tool.h"

namespace deformable_surface::tool {

/// Whether a solid lies across the straight way between two points (m, in its frame): the way goes in on one side of it and comes
/// out on an opposite one. A point inside counts as being where it would be pushed out.
bool isBetween(const geometry::Solid& solid, const Vec3& a, const Vec3& b);

/// The way of a tool through a step, looked at so often that it moves by no more than a resolution between two looks.
class BladeSweep {
 public:
  /// before, after (n x 3) m: points that move straight and evenly through the step, world; only those that the tool may come as
  /// near to as reach, m, count for how fast it is. resolution, m.
  BladeSweep(const ToolParams& tool, double time, double step, const Points& before, const Points& after, double reach,
             double resolution);

  /// Whether it came so near to any of the points; to one that is there at the beginning of the step.
  bool isNear() const { return !poses_.empty(); }
  bool isNear(const Vec3& point) const;
  /// Whether it went between two points that move straight and evenly in the world.
  bool wentBetween(const Vec3& a_before, const Vec3& a_after, const Vec3& b_before, const Vec3& b_after) const;

 private:
  geometry::Solid solid_;
  std::vector<Pose> poses_;  // evenly spaced in time, both ends included
  double travel_ = 0.0;      // m, at most, of a point near it in its frame
  double reach_;             // m
};

}  // namespace deformable_surface::tool
