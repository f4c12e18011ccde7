// A cheap proof that a moving surface does not pass through itself: seen from one direction, nothing lies over anything.
#pragma once

#include "deformable_surface/contact/outlines.h"
#include "deformable_surface/contact/pair_list.h"

#include <vector>

namespace deformable_surface::contact {

/// Each connected part of the surface is projected onto a plane. No two of its triangles overlap there under two conditions
/// [Volino and Magnenat-Thalmann 1994]. All triangles keep their orientation. Each loop of the boundary, seen from its middle, is
/// passed once around in a constant sense: the loop around the part anticlockwise, those of its holes clockwise. The reason: the
/// number of places above a point of the plane is the sum of the winding numbers of the loops about it, which is at most one.
/// Primitives without a common vertex are then at least as far apart as the least altitude of two kinds of triangles: those of
/// the projected surface, and those that the edges of the loops form with their middles. Boxes keep the parts apart.
///
/// The points' motion is predicted. The proof holds as long as all remain within a tolerance of it. This is cheap to check.
class Clearance {
 public:
  /// For primitives that are to stay farther apart than distance (m). rest: (n) m. Proves nothing where findOutlines() finds
  /// nothing.
  Clearance(const Points& rest, const std::vector<Triangle>& triangles, double distance);

  /// Tries the proof for points that keep their velocities (n) for a time; m and s, or any other unit of time.
  bool prove(const Points& positions, const Points& velocities, double time);
  void forget() { tolerance_ = apart_tolerance_ = -1.0; }
  /// Whether all primitives are farther apart than the distance throughout the motion of the last prove().
  bool isApart() const { return apart_tolerance_ > 0.0; }
  /// The same at these positions.
  bool isApartAt(const Points& positions) const { return isApart() && isNear(positions, apart_tolerance_); }
  /// Whether nothing crosses anything on straight paths from `before` to `after`.
  bool staysUncrossed(const Points& before, const Points& after) const {
    return tolerance_ > 0.0 && isNear(before, tolerance_) && isNear(after, tolerance_);
  }

 private:
  // A point in the plane at the beginning and the end of the motion, m.
  struct Flat {
    double u, v, u_end, v_end;
  };
  // m, by which each point may deviate from the prediction before two primitives can cross, or be as near as the distance.
  struct Room {
    double uncrossed, apart;

    bool isLeft() const { return uncrossed > 0.0; }
    void restrict(const Room& other);
  };

  Room findRoom(const Points& positions, const Points& motion);
  Vec3 findDirection(const Outlines::Part& part, const Outlines::Part& next, const Points& positions, const Points& motion) const;
  void project(const Outlines::Part& part, const Outlines::Part& next, const Vec3& direction, const Points& positions,
               const Points& motion);
  Room checkTriangles(Index begin, Index end) const;
  Room checkLoop(const Outlines::Loop& loop, Index end) const;
  Room checkParts(const Points& positions, const Points& motion);
  Room roomOf(double twice_area, double length, double arms) const;
  bool isNear(const Points& positions, double tolerance) const;

  const double distance_;
  Outlines outlines_;
  std::vector<Flat> flat_;                            // (n)
  std::vector<Room> rooms_;                           // of blocks of triangles
  std::vector<Box> boxes_;                            // of the parts
  double tolerance_ = -1.0, apart_tolerance_ = -1.0;  // m, by which each coordinate may deviate; negative: not proven
  Points from_, motion_;                              // m, the prediction
  Index leader_ = 0;                                  // the point that moves farthest: shows how much of the motion is done
};

}  // namespace deformable_surface::contact
