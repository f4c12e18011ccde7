// A knife in a step: finds pairs of points that it passed between. A knife applies no force here; that is contact.
#pragma once

#include "deformable_surface/tool/tool.h"

#include <cstdint>
#include <vector>

namespace deformable_surface::tool {

/// Whether a solid lies across the straight segment between two points (m, in its frame): the segment enters on one side and
/// leaves on an opposite one. A point inside counts as being where it would be pushed out.
bool isBetween(const geometry::Solid& solid, const Vec3& a, const Vec3& b);

/// The resolution, m, with which a knife must be sampled in a step so that nothing slips through it: its own passage past a point
/// halved, between fixed shares of the spacing, m, of the points. before, after: (n x 3) m, of the points that move in the step.
double findBladeResolution(const ToolParams& tool, double time, double step, const Points& before, const Points& after,
                           double spacing);

/// The motion of a tool through a step, sampled at even intervals of time in which it moves by no more than a resolution. Only
/// samples at which the tool is near are evaluated. Intervals in which it cannot reach the points are skipped, so that the work
/// for a pair of points grows with the logarithm of the path alone.
class BladeSweep {
 public:
  /// before, after (n x 3) m: points that move at constant velocity through the step, world. Only points that the tool may
  /// approach to within reach, m, count for its speed. resolution, m, above 0. tool is kept by reference.
  BladeSweep(const ToolParams& tool, double time, double step, const Points& before, const Points& after, double reach,
             double resolution);

  using Look = std::int64_t;
  /// Consecutive samples; none if last < first.
  struct Looks {
    Look first = 0, last = -1;
  };

  /// Whether the tool comes within reach of any of the points; isNear(point): of a point at this place at the beginning of the
  /// step.
  bool isNear() const { return !pieces_.empty(); }
  bool isNear(const Vec3& point) const;
  /// All samples at which the tool may touch a ball whose centre moves at constant velocity lie between the first and the last.
  Looks findLooks(const Vec3& before, const Vec3& after, double radius) const;
  Looks all() const { return pieces_.empty() ? Looks{} : Looks{0, num_looks_}; }
  /// Whether the tool passed between two points with constant velocities in the world, at one of these samples. taken, if given,
  /// is increased by the number of evaluated poses.
  bool wentBetween(const Vec3& a_before, const Vec3& a_after, const Vec3& b_before, const Vec3& b_after, const Looks& looks,
                   std::int64_t* taken = nullptr) const;

 private:
  // A segment of the path: its samples, and the motion of the tool from one to the next.
  struct Piece {
    Looks looks;
    Vec3 move;    // m
    double turn;  // rad
  };
  // Two points, at the beginning and the end of the step.
  struct Pair {
    Vec3 a_before, a_after, b_before, b_after;
    double half;  // m, half of their largest distance
  };

  Pose poseAt(Look look) const;
  double timeAt(Look look) const { return time_ + static_cast<double>(look) * step_ / static_cast<double>(num_looks_); }
  void addPieces();
  template <class Visit>
  bool visitNear(const Piece& piece, const Looks& looks, const Vec3& before, const Vec3& after, double radius,
                 const Visit& visit) const;
  bool isBetweenAt(const Pose& pose, double share, const Pair& pair) const;

  const ToolParams& tool_;
  double time_, step_;   // s
  double reach_;         // m
  double travel_ = 0.0;  // m, upper bound, of a point near the tool in the tool's frame
  Look num_looks_ = 0;   // without the one at the beginning
  double still_ = 0.0;   // m: samples between which the tool moves by less count as one
  Pose first_;
  std::vector<Piece> pieces_;  // empty: the tool is not near
};

}  // namespace deformable_surface::tool
