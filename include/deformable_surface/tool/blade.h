// A knife in a step: what it went between. Apart from contact, because it does not push.
#pragma once

#include "deformable_surface/tool/tool.h"

#include <cstdint>
#include <vector>

namespace deformable_surface::tool {

/// Whether a solid lies across the straight way between two points (m, in its frame): the way goes in on one side of it and comes
/// out on an opposite one. A point inside counts as being where it would be pushed out.
bool isBetween(const geometry::Solid& solid, const Vec3& a, const Vec3& b);

/// The way of a tool through a step, looked at in even intervals of time between which it moves by no more than a resolution.
/// Only the looks at which it is near are taken: intervals that it spends farther away than it goes in them are passed over, so
/// that the work for a pair of points grows with the logarithm of the way alone.
class BladeSweep {
 public:
  /// before, after (n x 3) m: points that move straight and evenly through the step, world; only those that the tool may come as
  /// near to as reach, m, count for how fast it is. resolution, m, above 0. tool is kept by reference.
  BladeSweep(const ToolParams& tool, double time, double step, const Points& before, const Points& after, double reach,
             double resolution);

  using Look = std::int64_t;
  /// Consecutive looks; none if last < first.
  struct Looks {
    Look first = 0, last = -1;
  };

  /// Whether it came so near to any of the points; to one that is there at the beginning of the step.
  bool isNear() const { return !pieces_.empty(); }
  bool isNear(const Vec3& point) const;
  /// Between the first and the last of these lie all looks at which it may touch a ball whose centre moves straight and evenly.
  Looks findLooks(const Vec3& before, const Vec3& after, double radius) const;
  Looks all() const { return pieces_.empty() ? Looks{} : Looks{0, num_looks_}; }
  /// Whether it went between two points that move straight and evenly in the world, at one of these looks. Where taken is given,
  /// it grows by the number of poses that were looked at.
  bool wentBetween(const Vec3& a_before, const Vec3& a_after, const Vec3& b_before, const Vec3& b_after, const Looks& looks,
                   std::int64_t* taken = nullptr) const;

 private:
  // Of the path: the looks on it, and how the tool moves from one of them to the next.
  struct Piece {
    Looks looks;
    Vec3 move;    // m
    double turn;  // rad
  };
  // Two points, at the beginning and the end of the step.
  struct Pair {
    Vec3 a_before, a_after, b_before, b_after;
    double half;  // m, of their distance at most
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
  double travel_ = 0.0;  // m, at most, of a point near it in its frame
  Look num_looks_ = 0;   // beside that at the beginning
  double still_ = 0.0;   // m: looks between which it moves by less count as one
  Pose first_;
  std::vector<Piece> pieces_;  // empty: it is nowhere near
};

}  // namespace deformable_surface::tool
