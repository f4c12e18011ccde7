// Contact of a surface with itself: what pushes near parts apart, and what keeps them from passing through each other.
//
// Triangles have a thickness. Parts nearer than that are pushed apart by springs; a limit on the way of each point in a step
// makes sure that no two parts cross, however fast they come. After [Chen 2025] (bounds in place of root finding), with
// half-spaces in place of their balls: a ball locks points that have come as near as they may.
#pragma once

#include "deformable_surface/contact/friction_anchors.h"
#include "deformable_surface/contact/friction_law.h"
#include "deformable_surface/contact/pair_list.h"
#include "deformable_surface/linear/block_sparse.h"

#include <vector>

namespace deformable_surface::contact {

struct SelfContactParams {
  double thickness = 0.0;  // m: layers rest so far apart
  double rate = 0.0;       // 1/s: a spring's stiffness is the least mass of its pair times the square of it
  double damping = 0.05;   // of the springs, as a share of critical
  double friction = 0.0;   // Coulomb's coefficient
};

/// What one pair feels.
struct SelfContactForce {
  Pair pair;
  Closest closest;
  double depth;  // m, thickness less distance
  Vec3 force;    // N, of spring and friction, on the first primitive
};

/// Contact of one surface. Not thread-safe: all functions use the same scratch memory. Results depend on positions and velocities
/// alone, not on earlier calls.
class SelfContact {
 public:
  /// rest: (n) m; masses: (n) kg. Triangles that cross others at rest never act.
  SelfContact(Points rest, const std::vector<Triangle>& triangles, std::vector<double> masses, const SelfContactParams& params);

  /// See SelfContactParams.
  void setRate(double rate) { params_.rate = rate; }
  /// Whether two parts can come nearer than their thickness within a time, s, at these velocities. Only parts that are in the
  /// usual list of pairs are looked at.
  bool mayTouch(const Points& positions, const Points& velocities, double time);

  /// Adds the springs' forces, N.
  void addForces(const Points& positions, Points& forces);
  /// Adds those of the springs' damping, N.
  void addDampingForces(const Points& positions, const Points& velocities, Points& forces);
  /// Potential of the springs, J.
  double potential(const Points& positions);
  /// Adds minus the derivative of the springs' forces along their gaps, N/m, and that of the damping with respect to velocity
  /// over step (s; 0 = none): positive semidefinite.
  void addStiffness(const Points& positions, double step, BlockSparse& stiffness);
  /// Adds upper bounds of the row sums of the derivatives of all forces with respect to position (N/m) and velocity (N s/m).
  void addRowBounds(const Points& positions, std::vector<double>& stiffness, std::vector<double>& damping);

  // Friction by FrictionLaw: the spring of a pair that sticks is as stiff, and damped, as the one that pushes it apart. anchors:
  // of the pairs that stick, ascending; others begin to stick where they are.
  void addFriction(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors, Points& forces);
  /// J, in the springs of friction.
  double frictionEnergy(const Points& positions, const std::vector<PairAnchor>& anchors);
  /// Of the forces of friction, as addStiffness().
  void addFrictionStiffness(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                            double step, BlockSparse& stiffness);
  /// Where pairs stick from now on. Overwritten.
  void moveAnchors(const Points& positions, const Points& velocities, std::vector<PairAnchor>& anchors);

  /// Changes straight ways from `before` to `after` such that no two parts cross on them, at any time in between, if all points
  /// go at constant speed. Parts that would come too near collide without bouncing; where that does not suffice, they go on
  /// together. Both take energy and keep momentum. Points that stay, stay, and stop what would go on with them. Returns those
  /// whose ways were changed, ascending, until the next call.
  const std::vector<Index>& limit(const Points& before, Points& after);

  /// Number of pairs nearer than their thickness, and what they feel. anchors: as in addFriction().
  Index countTouching(const Points& positions);
  std::vector<SelfContactForce> listForces(const Points& positions, const Points& velocities,
                                           const std::vector<PairAnchor>& anchors);
  /// m, of the nearest pair; infinite if none is nearer than the thickness.
  double leastDistance(const Points& positions);
  Index numSearches() const { return list_.numSearches(); }
  const PairList& pairs() const { return list_; }

 private:
  struct Near {
    const Pair* pair;
    Closest closest;
    double distance;
  };
  // A near pair, seen along its gap.
  struct Approach {
    std::array<Index, 4> vertices;
    int num_first;
    Vec3 normal;                   // unit, from the second primitive to the first
    std::array<double, 4> behind;  // m, how far each point is behind the closest point of its primitive
    double room;                   // m, that the two primitives together may use up
  };
  // Of the points that come farthest towards the other primitive.
  struct Worst {
    Index first, second;
    double excess;  // m, beyond the room; positive: the pair is to be stopped
  };

  /// How the parts of a pair that touches have moved along each other.
  struct Rub {
    FrictionLaw law;
    Vec3 normal;   // unit
    Vec3 stretch;  // m
    bool slides;
    const PairAnchor* anchor;  // null: they have just met
  };
  Rub findRub(const Near& near, const Points& positions, const std::vector<PairAnchor>& anchors) const;
  /// m/s, along the surfaces.
  static Vec3 findSliding(const Near& near, const Points& velocities);

  static bool touches(const Near& near);
  /// Adds the block, as seen by the gap, to those of its vertices.
  static void addToMatrix(const Near& near, const Mat3& block, BlockSparse& matrix);
  const std::vector<Near>& measure(const Points& positions, double reach);
  double stiffness(const Pair& pair) const;
  Approach makeApproach(const Near& near, const Points& before) const;
  Worst findWorst(const Approach& approach) const;
  void collide();
  void stopTogether();

  PairList list_;
  const std::vector<double> masses_;
  SelfContactParams params_;
  Points measured_at_;
  double measured_reach_ = 0.0;
  std::vector<Near> near_;
  Points ways_;                   // m, less what all share
  std::vector<double> mobility_;  // 1/kg, zero of points that stay
  std::vector<Approach> approaches_;
  Points zone_motion_;             // kg m
  std::vector<double> zone_mass_;  // kg; infinite: it stays
  std::vector<Index> zone_;        // by point: another point of its zone, or itself
  std::vector<char> is_cut_;
  std::vector<Index> cut_;
  std::vector<PairAnchor> next_;
};

}  // namespace deformable_surface::contact
