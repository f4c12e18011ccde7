// A cheap proof that a moving surface does not pass through itself: seen from one direction, nothing lies over anything.
#pragma once

#include "deformable_surface/contact/outlines.h"
#include "deformable_surface/contact/pair_list.h"

#include <memory>
#include <vector>

namespace deformable_surface::contact {

/// A motion at constant velocities, and by how much each coordinate may leave it.
struct ClearMotion {
  Points from, way;                                 // (n x 3) m: where it begins, and to its end
  Index leader = 0;                                 // the point that moves farthest: shows how much of the motion is done
  double tolerance = -1.0, apart_tolerance = -1.0;  // m, until something may cross, or be near; negative: not proven

  /// The share of the motion that is done where the leader is at a place.
  double shareAt(const Vec3& of_leader) const;
  std::size_t bytes() const { return sizeof(ClearMotion) + (from.size() + way.size()) * sizeof(Vec3); }
};

/// Each connected part of the surface is projected onto a plane. No two of its triangles overlap there under two conditions
/// [Volino and Magnenat-Thalmann 1994]. All triangles keep their orientation. Each loop of the boundary, seen from its middle, is
/// passed once around in a constant sense: the loop around the part anticlockwise, those of its holes clockwise. The reason: the
/// number of places above a point of the plane is the sum of the winding numbers of the loops about it, which is at most one.
/// Primitives without a common vertex are then at least as far apart as the least altitude of two kinds of triangles: those of
/// the projected surface, and those that the edges of the loops form with their middles. Boxes keep the parts apart.
///
/// The points' motion is predicted. The proof holds as long as all remain within a tolerance of it, for one step or for many.
/// This is cheap to check.
class Clearance {
 public:
  /// For primitives that are to stay farther apart than distance (m). rest: (n) m. Proves nothing where findOutlines() finds
  /// nothing.
  Clearance(const Points& rest, const std::vector<Triangle>& triangles, double distance);

  /// Tries the proof for points that keep their velocities (n) for a time; m and s, or any other unit of time.
  bool prove(const Points& positions, const Points& velocities, double time);
  void forget() { proven_.reset(); }
  /// Whether all primitives are farther apart than the distance throughout the motion of the last prove().
  bool isApart() const { return proven_ && proven_->apart_tolerance > 0.0; }
  /// The same at these positions.
  bool isApartAt(const Points& positions) const { return isApart() && isNear(positions, proven_->apart_tolerance); }
  /// The same from these positions on, for points that keep their velocities for a time.
  bool staysApart(const Points& positions, const Points& velocities, double time) const;
  /// Whether nothing crosses anything on straight paths from `before` to `after`. knows_before: it was so on paths to `before`.
  bool staysUncrossed(const Points& before, const Points& after, bool knows_before = false) const {
    return proven_ && (knows_before || isNear(before, proven_->tolerance)) && isNear(after, proven_->tolerance);
  }
  /// What is proven; null: nothing. It remains true, whatever has happened since.
  std::shared_ptr<const ClearMotion> proven() const { return proven_; }
  void setProven(std::shared_ptr<const ClearMotion> proven) { proven_ = std::move(proven); }

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
  std::shared_ptr<ClearMotion> takeSpare();

  const double distance_;
  Outlines outlines_;
  std::vector<Flat> flat_;   // (n)
  std::vector<Room> rooms_;  // of blocks of triangles
  std::vector<Box> boxes_;   // of the parts
  std::shared_ptr<const ClearMotion> proven_;
  std::vector<std::shared_ptr<ClearMotion>> spares_;  // all made here: those that nobody else holds are used again
};

}  // namespace deformable_surface::contact
