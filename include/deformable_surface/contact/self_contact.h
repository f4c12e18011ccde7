// Contact of a surface with itself: repulsion of near parts, and a limit of motion that prevents interpenetration.
//
// Triangles have a thickness. Springs push nearer parts apart. A limit on the motion of each point in a step ensures that no two
// parts cross, at any speed. After [Chen 2025] (bounds instead of root finding), with half-spaces instead of their balls: a
// ball locks points at the least distance.
#pragma once

#include "deformable_surface/contact/clearance.h"
#include "deformable_surface/contact/friction_anchors.h"
#include "deformable_surface/contact/friction_law.h"
#include "deformable_surface/contact/pair_list.h"
#include "deformable_surface/contact/pair_watch.h"
#include "deformable_surface/contact/untangling.h"
#include "deformable_surface/linear/block_sparse.h"

#include <memory>
#include <utility>
#include <vector>

namespace deformable_surface::contact {

struct SelfContactParams {
  double thickness = 0.0;         // m: distance of layers at rest
  double rate = 0.0;              // 1/s: a spring's stiffness is the least mass of its pair times the square of the rate
  double damping = 0.05;          // of the springs, as a share of critical
  double friction = 0.0;          // Coulomb's coefficient of pairs that stick
  double kinetic_friction = 0.0;  // of pairs that slide, not above friction
  bool hardens = false;           // springs become ever stiffer towards the least distance that limit() allows, and damping sets
                                  // in gradually: for methods that search a balance of forces
  bool is_body = false;           // the skin of one: points without triangles are inside it and no part of it. On surfaces these
                                  // touch the triangles of others
  bool looks_first = false;       // contact acts where a quick look finds parts near each other: see Clearance::lookInstead()
  double compliance = 0.0;        // m/Pa, of a pad between parts; 0: none
  std::vector<double> areas{};    // (n) m^2, that vertices stand for on one side; empty without a pad
};

/// The contact force of one pair.
struct SelfContactForce {
  Pair pair;
  Closest closest;
  double depth;  // m, thickness minus distance
  Vec3 force;    // N, of spring and friction, on the first primitive
};

/// Contact of one surface. Not thread-safe: all functions share scratch memory. Results depend only on positions and velocities,
/// not on earlier calls. Those of mayTouch() also depend on what was proven() before, those of limit() on what was called since
/// the last mayTouch().
class SelfContact {
 public:
  /// rest: (n) m; masses: (n) kg. Parts that pass through each other at rest have no contact there: see PairList.
  SelfContact(Points rest, const std::vector<Triangle>& triangles, std::vector<double> masses, const SelfContactParams& params);

  /// See PairList.
  void keepWhole(const std::vector<char>& is_whole);
  /// (n) kg, from now on.
  void setMasses(const std::vector<double>& masses);
  /// See SelfContactParams.
  void setRate(double rate);
  /// m/Pa, of contact between flat layers without a pad: the largest of all places.
  double ownCompliance() const;
  /// At the beginning of a step that lasts a time, s: whether two parts are near each other, or will be if their distance keeps
  /// changing at its present rate. Checks only pairs that are nearer than 1.5 thicknesses plus four times PairList::usualReach().
  bool mayTouch(const Points& positions, const Points& velocities, double time);
  /// Tries to prove that nothing comes near while the points keep their velocities for some steps of a time, s (or any other unit
  /// of time). See Clearance.
  bool foresee(const Points& positions, const Points& velocities, double time);
  /// Whether nothing is near anything at rest: by proof, for surfaces that lie open (seen from one side, nothing is over
  /// anything), or by a quick look.
  bool isClear(const Points& rest);
  bool looksFirst() const { return params_.looks_first; }
  /// m, where a quick look saw something near last.
  const Vec3& placeSeen() const { return clearance_.placeSeen(); }
  /// What is known of the present motion, for snapshots. See Clearance.
  std::shared_ptr<const ClearMotion> proven() const { return clearance_.proven(); }
  void setProven(std::shared_ptr<const ClearMotion> proven) { clearance_.setProven(std::move(proven)); }
  /// Whether no two parts cross on straight paths from before to after, (n x 3) m, nor are nearer than their thickness at the
  /// end. False also where 64 pieces of the paths do not decide it, as for paths of hundreds of spacings.
  bool staysApart(const Points& before, const Points& after);

  /// Adds the springs' forces, N.
  void addForces(const Points& positions, Points& forces);
  /// Adds the damping forces of the springs, N.
  void addDampingForces(const Points& positions, const Points& velocities, Points& forces);
  /// Potential of the springs, J.
  double potential(const Points& positions);
  /// Adds minus the derivative of the forces of springs and damping along their gaps, N/m: with respect to position, and with
  /// respect to velocity over step (s; 0: no damping). Positive semidefinite.
  void addStiffness(const Points& positions, const Points& velocities, double step, BlockSparse& stiffness);
  /// Adds upper bounds of the row sums of the derivatives of the springs' forces with respect to position, N/m.
  void addStiffnessBounds(const Points& positions, std::vector<double>& bounds);
  /// The same of the damping forces, and of those of friction's dampers, with respect to velocity, N s/m.
  void addDampingBounds(const Points& positions, std::vector<double>& bounds);

  // Friction by FrictionLaw: the spring of a sticking pair has the stiffness and damping of its contact spring. anchors: of the
  // sticking pairs, ascending; other pairs begin to stick at their present places.
  void addFriction(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors, Points& forces);
  /// The same as if nothing moved, of the pairs that have anchors.
  void addFrictionAtRest(const Points& positions, const std::vector<PairAnchor>& anchors, Points& forces);
  /// Energy of the friction springs, J.
  double frictionEnergy(const Points& positions, const std::vector<PairAnchor>& anchors);
  /// Adds the stiffness of friction, as addStiffness(), with that of its springs also where step is 0.
  void addFrictionStiffness(const Points& positions, const Points& velocities, const std::vector<PairAnchor>& anchors,
                            double step, BlockSparse& stiffness);
  /// Updates the places at which pairs stick, in place, at the end of a step (s).
  void moveAnchors(const Points& positions, const Points& velocities, double step, std::vector<PairAnchor>& anchors);

  /// From now on, what crosses at these positions has no contact, in place of what does so at rest: see PairList. Returns whether
  /// anything has changed.
  bool findCrossed(const Points& positions);
  /// Chooses the forces that push crossed parts apart from these positions on: constant, against dampers as strong as the
  /// critical ones of springs. Returns whether there are any.
  bool beginPushing(const Points& positions);
  void endPushing() { pushes_.clear(); }
  /// Adds these forces, N.
  void addPushes(const Points& velocities, Points& forces) const;
  /// Work of the constant part, J.
  double workOfPushes(const Points& before, const Points& after) const;
  /// As addStiffness() and addDampingBounds(), of these forces.
  void addPushStiffness(double step, BlockSparse& stiffness) const;
  void addPushRowBounds(std::vector<double>& damping) const;

  /// Changes straight paths from `before` to `after` so that no two parts cross at any time, with all points at constant speed.
  /// Parts that would come too near collide inelastically. Where that does not suffice, they move on together. Both dissipate
  /// energy and conserve momentum. Points that do not move stay, and stop the parts that would move on with them. Returns the
  /// points whose paths were changed, ascending; valid until the next call. What Clearance proves not to cross is not changed.
  /// continues: `before` is where the last call ended, which saves a check, and collisions begin with those of that call.
  const std::vector<Index>& limit(const Points& before, Points& after, bool continues = false);

  /// Number of pairs nearer than their thickness, and their forces. anchors: as in addFriction().
  Index countTouching(const Points& positions);
  std::vector<SelfContactForce> listForces(const Points& positions, const Points& velocities,
                                           const std::vector<PairAnchor>& anchors);
  /// Distance of the nearest pair, m; infinite if none is nearer than the thickness.
  double leastDistance(const Points& positions);
  /// Forgets the motion since the last mayTouch(), for a call of limit() outside of a step.
  void forgetMotion();
  Index numSearches() const { return list_.numSearches(); }
  /// Number of pairs that touched in addForces(), and that limit() has let collide, in all their calls: tells how much work
  /// contact is. It does not depend on lists.
  std::size_t numNear() const { return num_near_; }
  /// Number of pairs that the last limit() has let collide.
  Index numApproaches() const { return static_cast<Index>(approaches_.size()); }
  const PairList& pairs() const { return list_; }
  const PairWatch& watch() const { return watch_; }

 private:
  // Fraction of a pair's thickness: limit() lets parts that move come no nearer; where collisions have not settled, no nearer
  // than half of that.
  static constexpr double kLeast = Pair::kLeast, kFloor = 0.25;

  struct Near {
    Pair pair;
    Closest closest;
    double distance;
    double weight = 1.0;  // of the pair's spring: below 1 for nearly parallel edges if springs harden
    // Only of pairs that touch. N/m, of a spring with weight 1, and 1/s, of the oscillation that damping is a share of the
    // critical one of.
    double stiffness = 0.0, rate = 0.0;
    Index place = -1;  // where its anchor was, or would have been, when it was looked for last; -1: it was not
  };
  // A near pair, projected on its gap.
  struct Approach {
    std::array<Index, 4> vertices;
    int num_first;
    Vec3 normal;                   // unit, from the second primitive to the first
    std::array<double, 4> behind;  // m, distance of each point behind the closest point of its primitive
    double room;                   // m, by which the two primitives together may approach
    double spare;                  // m, beyond that, if collisions have not settled
    std::array<double, 4> pushed;  // kg m, in a sub-step, between each point of the first primitive and each of the second

    bool pushes() const { return pushed != std::array<double, 4>{}; }
  };
  // What a pair has exchanged in the last sub-step.
  struct Exchange {
    std::array<Index, 4> vertices;
    int num_first;
    std::array<double, 4> pushed;  // kg m, as in Approach

    bool operator<(const Exchange& other) const {
      return num_first != other.num_first ? num_first < other.num_first : vertices < other.vertices;
    }
  };

  /// Relative tangential displacement of the parts of a touching pair.
  struct Rub {
    FrictionLaw law;
    Vec3 normal;               // unit
    Vec3 stretch;              // m
    double slid;               // m, since the parts last stuck
    const PairAnchor* anchor;  // null: a new contact
  };
  /// Of the pair; null: it has none. guess: where it may be, if it was not looked for before.
  static const PairAnchor* findAnchor(Near& near, const std::vector<PairAnchor>& anchors, Index guess);
  Rub findRub(const Near& near, const Points& positions, const PairAnchor* anchor) const;
  /// Calls visit(near, rub) for the pairs that touch.
  template <class Visit>
  void forEachRub(const Points& positions, const std::vector<PairAnchor>& anchors, const Visit& visit);
  /// Sliding velocity, m/s, along the surfaces.
  static Vec3 findSliding(const Near& near, const Points& velocities);

  double forceOf(const Push& push) const;    // N
  double dampingOf(const Push& push) const;  // N s/m, along the direction
  void beginMotion();
  bool comesNear(const Pair& pair, const Points& positions, const Points& velocities, double time, double most) const;
  bool staysUncrossed(const Points& before, const Points& after, bool continues);
  /// Whether a pair may use up its room on the paths.
  bool mustStop(const Points& before, const Points& after, bool continues);
  void forgetNear();
  static bool touches(const Near& near) { return near.distance < near.pair.thickness && near.distance > 0.0; }
  /// Adds the block, given at the gap, to the blocks of the pair's vertices.
  static void addToMatrix(const Near& near, const Mat3& block, BlockSparse& matrix);
  /// The pairs that touch, or may come too near on a relative way, m.
  std::vector<Near>& measure(const Points& positions, double way = 0.0);
  double penalty(const Pair& pair) const;    // N/m, without a pad
  double stiffness(const Pair& pair) const;  // N/m
  /// Sets Near::stiffness, and Near::rate to that of the least mass on this spring.
  void setSpring(Near& near) const;
  /// Sets Near::stiffness and Near::rate.
  void findRates();
  struct Spring {
    double energy, force, stiffness;  // J, N, N/m
  };
  Spring findSpring(const Near& near) const;
  struct Damping {
    double share, onset;  // of critical damping; its derivative by the depth, 1/m
  };
  Damping findDamping(const Near& near) const;
  /// Of the gap, m/s.
  static double findOpening(const Near& near, const Points& velocities);
  /// See Near::weight.
  double weigh(const Pair& pair, const Points& positions) const;
  /// Adds the forces that turn nearly parallel edges: their weight depends on the angle.
  void addTurning(const Near& near, const Points& positions, Points& forces) const;
  Approach makeApproach(const Near& near, const Points& before) const;
  /// Fills approaches_ with the pairs that may use up their room if no point moves farther than longest, m, or than allowed_.
  void findAllApproaches(const Points& before, double longest);
  void findApproaches(const Points& before);
  /// Raises allowed_ where points move farther, to twice their way, but at most to longest, m. Returns whether any did.
  bool allowMore(double longest);
  /// m, by which the pair approaches beyond its room on ways (m) of its vertices; positive: it must be stopped.
  static double findExcess(const Approach& approach, const std::array<Vec3, 4>& ways);
  /// settled: m, smaller changes are no reason for another pass.
  void collide(double settled);
  /// Of one pair. Returns whether it would have used more than its room, or much less than it was pushed for.
  bool collide(Approach& approach, double settled);
  /// Between a point of the first primitive and one of the second.
  void exchange(const Approach& approach, int v, int w, double& pushed, double momentum);
  void exchangeAgain();
  void stopTogether();
  void moveAsOne(const Points& before, bool does_one_stay, Points& after);

  bool may_touch_ = false;                          // the last answer that needed a look at pairs: saves time, changes nothing
  bool is_calm_ = false;                            // parts of the surface are not tried in this step
  bool was_uncrossed_ = false;                      // by clearance_, where the last call of limit() ended
  bool has_proof_failed_ = false;                   // in limit(): none is tried until the next step
  Points motion_;                                   // m, scratch
  Points way_, piece_begin_, piece_end_, reached_;  // m, of staysApart()
  PairList list_;
  PairWatch watch_{list_};
  Clearance clearance_;
  std::vector<double> masses_;
  SelfContactParams params_;
  Points measured_at_;
  double measured_way_ = -1.0;  // m, for which near_ is complete; negative: it is not
  double usual_way_ = 0.0;      // m, from one call of limit() to the next
  std::vector<Near> near_;
  std::vector<double> borne_;  // (n) N/m, scratch: of all springs at a point
  AppendedParts<Near> near_parts_;
  Points ways_, free_ways_;       // m, without the common motion; before collisions
  std::vector<double> allowed_;   // m, for which approaches_ are complete; empty: as far as the farthest moves
  std::vector<double> mobility_;  // 1/kg, zero for fixed points
  std::vector<Approach> approaches_;
  AppendedParts<Approach> approach_parts_;
  std::vector<char> is_stopped_;  // (approaches)
  std::vector<Approach*> pushing_;
  std::vector<Exchange> exchanges_, last_exchanges_;  // of these collisions and those before, in order
  Points zone_motion_;                                // kg m
  std::vector<double> zone_mass_;                     // kg; infinite: fixed
  std::vector<Index> zone_;                           // by point: another point of its zone, or itself
  std::vector<char> is_cut_;
  std::vector<Index> cut_;
  std::vector<PairAnchor> next_, begun_;
  std::vector<char> is_kept_;  // (anchors)
  std::size_t num_near_ = 0;
  std::vector<Push> pushes_;
};

}  // namespace deformable_surface::contact
