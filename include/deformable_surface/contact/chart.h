// A part of a surface, seen from one direction: a cheap proof that nothing of it lies over anything.
#pragma once

#include "deformable_surface/contact/box_tree.h"
#include "deformable_surface/contact/outlines.h"

#include <vector>

namespace deformable_surface::contact {

/// Each connected part is projected onto a plane. No two of its triangles overlap there under two conditions [Volino and
/// Magnenat-Thalmann 1994]. All triangles keep their orientation. Each loop of the boundary, seen from its middle, is passed once
/// around in a constant sense: the loop around the part anticlockwise, those of its holes clockwise. The reason: the number of
/// places above a point of the plane is the sum of the winding numbers of the loops about it, which is at most one. Primitives
/// without a common vertex are then at least as far apart as the least altitude of two kinds of triangles: those of the projected
/// surface, and those that the edges of the loops form with their middles. Boxes keep the parts apart.
class Chart {
 public:
  /// m, by which each point may deviate from its predicted motion before two primitives can cross, or be as near as the distance.
  struct Room {
    double uncrossed, apart;

    bool isLeft() const { return uncrossed > 0.0; }
    void restrict(const Room& other);
  };
  // A point in the plane at the beginning and the end of the motion, m.
  struct Flat {
    double u, v, u_end, v_end;
  };
  /// Memory that charts of one surface share, one after the other.
  struct Scratch {
    std::vector<Flat> flat;   // (n)
    std::vector<Room> rooms;  // of blocks of triangles
    std::vector<Box> boxes;   // of the parts
  };

  /// For primitives that are to stay farther apart than distance (m). outlines: without parts, the chart proves nothing.
  Chart(Outlines outlines, double distance) : distance_(distance), outlines_(std::move(outlines)) {}

  bool isEmpty() const { return outlines_.numParts() == 0; }
  double edge() const { return outlines_.edge; }  // m, median at rest
  /// For straight paths of all points of the surface, at constant speed. Not positive if nothing is proven. At most a fifth of an
  /// edge.
  Room findRoom(const Points& positions, const Points& motion, Scratch& scratch) const;

 private:
  Vec3 findDirection(const Outlines::Part& part, const Outlines::Part& next, const Points& positions, const Points& motion) const;
  void project(const Outlines::Part& part, const Outlines::Part& next, const Vec3& direction, const Points& positions,
               const Points& motion, std::vector<Flat>& flat) const;
  Room checkTriangles(Index begin, Index end, const std::vector<Flat>& flat) const;
  Room checkLoop(const Outlines::Loop& loop, Index end, const std::vector<Flat>& flat) const;
  Room checkParts(const Points& positions, const Points& motion, std::vector<Box>& boxes) const;
  Room roomOf(double twice_area, double length, double arms) const;

  double distance_;
  Outlines outlines_;
};

}  // namespace deformable_surface::contact
