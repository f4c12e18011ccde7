// The points of a surface that touch tools: its simulation points, and points of the cloud between them. All loads of contact
// share them.
#pragma once

#include "deformable_surface/linear/block_sparse.h"
#include "deformable_surface/transfer/sampled_points.h"

#include <memory>
#include <utility>
#include <vector>

namespace deformable_surface::simulation {

/// Numbering: the simulation points first, then those between. The latter have no mass of their own. For contact, each has the
/// mass of the simulation point in whose cell it lies: the same penalty, so that a single one, at the corner of a box, carries as
/// much as a simulation point. It has less where it follows points so light that its spring would shorten the stable step, as on
/// uneven meshes. For damping, which would shorten that step, too, all points of a cell together have half of that mass, and
/// spare points none.
class ContactPoints {
 public:
  /// masses (m): kg, of the simulation points; kept by reference.
  explicit ContactPoints(const std::vector<double>& masses) : masses_(masses) {}

  /// Null: none.
  void setBetween(std::shared_ptr<const transfer::SampledPoints> between);
  /// The masses have changed: those of points between are taken anew.
  void followMasses();
  const transfer::SampledPoints* between() const { return between_.get(); }
  const std::shared_ptr<const transfer::SampledPoints>& sharedBetween() const { return between_; }
  /// Areas at rest, m^2: of each simulation point (m), or, where points come and go, per mass (m^2/kg). Default: none.
  struct Areas {
    std::vector<double> of_points;
    double per_mass = 0.0;
  };
  void setAreas(Areas areas) { areas_ = std::move(areas); }
  const Areas& areas() const { return areas_; }
  /// m^2: of the simulation point; if it is shared, an equal part of it for this point and each of those between in its cell that
  /// are not spare.
  double areaOf(Index p, bool is_shared) const;
  /// Points between that follow both sides of a cut (1): they touch nothing. Empty: none.
  void setSevered(std::vector<char> is_severed) { is_severed_ = std::move(is_severed); }
  /// Becomes the points of a part: new_index (of the simulation points of the whole) or -1, the same in every call.
  void takePart(const ContactPoints& whole, const std::vector<Index>& new_index);
  /// Result of takePart(): the number in the part of each point of the whole or -1, and the inverse.
  const std::vector<Index>& numberInPart() const { return number_in_part_; }
  const std::vector<Index>& numberInWhole() const { return number_in_whole_; }

  Index numSimulated() const { return static_cast<Index>(masses_.size()); }
  Index size() const { return numSimulated() + (between_ ? between_->size() : 0); }
  bool isBetween(Index p) const { return p >= numSimulated(); }
  /// Points between that touch only where they are deeper than the others of their cell.
  bool isSpare(Index p) const { return isBetween(p) && between_->isSpare(p - numSimulated()); }
  bool isSevered(Index p) const { return !is_severed_.empty() && isBetween(p) && is_severed_[p - numSimulated()]; }
  /// The simulation point itself, or the one in whose cell the point lies.
  Index simulationPointOf(Index p) const { return isBetween(p) ? between_->cellOf(p - numSimulated()) : p; }
  /// kg, for the penalty: of points between at most twice ownMassOf().
  double massOf(Index p) const {
    return isBetween(p) ? mass_share_[p - numSimulated()] * masses_[simulationPointOf(p)] : masses_[p];
  }
  /// kg, with which a point resists a force: 1 / sum_j (w_j^2 / m_j). At rate r it is the stiffest spring that adds r^2 to the
  /// square of a frequency; that of massOf() adds a third to a half of it in even clouds, at most twice it.
  double ownMassOf(Index p) const;
  double dampedMassOf(Index p) const { return isBetween(p) ? damped_mass_[p - numSimulated()] : masses_[p]; }  // kg
  double totalMass() const;  // kg, of the surface
  /// Bound of v . D v / v . M v, with M of the masses and D of the masses for damping of all points, over motions v along one
  /// direction: of D whichever points are damped, and in whichever directions. Found when first asked for.
  double dampedShare() const;
  /// Whether all simulation points that the point follows are held. held (m).
  bool isHeld(Index p, const std::vector<char>& held) const;

  /// Position, m, from those of the simulation points.
  Vec3 place(Index p, const Points& positions) const {
    return isBetween(p) ? between_->place(p - numSimulated(), positions) : positions[p];
  }
  /// Velocity, m/s, from those of the simulation points.
  Vec3 findVelocity(Index p, const Points& velocities) const {
    return isBetween(p) ? between_->findVelocity(p - numSimulated(), velocities) : velocities[p];
  }
  /// Positions of all points (size()).
  void placeAll(const Points& positions, Points& all) const;
  /// Adds the effect of a force on a point, N, to the forces on the simulation points.
  void addForce(Index p, const Points& positions, const Vec3& force, Points& forces) const {
    if (isBetween(p))
      between_->scatter(p - numSimulated(), positions, force, forces);
    else
      forces[p] += force;
  }
  /// Adds the effect of a stiffness on a point, N/m, to that of the simulation points; and a bound of its row sums, where value
  /// bounds the block.
  void addStiffness(Index p, const Mat3& block, BlockSparse& stiffness) const;
  void addRowBound(Index p, double value, std::vector<double>& bound) const;

 private:
  void numberPart(const ContactPoints& whole, const std::vector<Index>& new_index);
  std::vector<Index> countInCells() const;
  double sumOfWeights(Index s) const;
  double findDampedShare() const;

  const std::vector<double>& masses_;
  std::shared_ptr<const transfer::SampledPoints> between_;
  std::vector<double> mass_share_;     // (points between) massOf() over the mass of the simulation point of the cell
  std::vector<double> damped_mass_;    // (points between) kg
  mutable double damped_share_ = 0.0;  // 0: not found yet
  std::vector<Index> sharing_;         // (m) points that share the area of a cell; empty: each has one
  Areas areas_;
  std::vector<char> is_severed_;  // (points between), or empty
  std::shared_ptr<const transfer::SampledPoints> taken_from_;
  std::vector<Index> number_in_part_, number_in_whole_;
};

}  // namespace deformable_surface::simulation
