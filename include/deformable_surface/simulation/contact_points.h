// The points of a surface that touch tools: its simulation points, and points of the cloud between them. Apart from contact,
// which knows tools, so that all loads of contact see these points in one way.
#pragma once

#include "deformable_surface/linear/block_sparse.h"
#include "deformable_surface/transfer/sampled_points.h"

#include <memory>
#include <utility>
#include <vector>

namespace deformable_surface::simulation {

/// They are numbered: the simulation points first, then those between. The latter have no mass of their own. Contact takes that
/// of the simulation point in whose cell a point lies: the same penalty, so that one of them alone, at the corner of a box,
/// carries as much as a simulation point does. For damping, which would shorten the stable step, all of a cell together have half
/// of it.
class ContactPoints {
 public:
  /// masses (m): kg, of the simulation points; kept by reference.
  explicit ContactPoints(const std::vector<double>& masses) : masses_(masses) {}

  /// Null: none.
  void setBetween(std::shared_ptr<const transfer::SampledPoints> between);
  const transfer::SampledPoints* between() const { return between_.get(); }
  const std::shared_ptr<const transfer::SampledPoints>& sharedBetween() const { return between_; }
  /// Points between that follow both sides of a cut (1): they touch nothing. Empty: none.
  void setSevered(std::vector<char> is_severed) { is_severed_ = std::move(is_severed); }
  /// Becomes the points of a part: new_index (of the simulation points there) or -1, the same in every call.
  void takePart(const ContactPoints& whole, const std::vector<Index>& new_index);
  /// Of takePart(): the number here of each point there or -1, and the other way round.
  const std::vector<Index>& numberInPart() const { return number_in_part_; }
  const std::vector<Index>& numberInWhole() const { return number_in_whole_; }

  Index numSimulated() const { return static_cast<Index>(masses_.size()); }
  Index size() const { return numSimulated() + (between_ ? between_->size() : 0); }
  bool isBetween(Index p) const { return p >= numSimulated(); }
  bool isSevered(Index p) const { return !is_severed_.empty() && isBetween(p) && is_severed_[p - numSimulated()]; }
  /// The simulation point that it is, or in whose cell it lies.
  Index simulationPointOf(Index p) const { return isBetween(p) ? between_->cellOf(p - numSimulated()) : p; }
  double massOf(Index p) const { return masses_[simulationPointOf(p)]; }  // kg, for the penalty
  double dampedMassOf(Index p) const { return isBetween(p) ? damped_mass_[p - numSimulated()] : masses_[p]; }  // kg
  double totalMass() const;  // kg, of the surface
  /// kg: bound of the row sum, over all points that act on simulation point i, of their masses for damping.
  double dampedMassOn(Index i) const { return masses_[i] + (between_ ? damped_mass_on_[i] : 0.0); }
  /// Whether nothing that pushes it moves a simulation point. held (m).
  bool isHeld(Index p, const std::vector<char>& held) const;

  /// m, from the positions of the simulation points.
  Vec3 place(Index p, const Points& positions) const {
    return isBetween(p) ? between_->place(p - numSimulated(), positions) : positions[p];
  }
  /// m/s, from their velocities.
  Vec3 findVelocity(Index p, const Points& velocities) const {
    return isBetween(p) ? between_->findVelocity(p - numSimulated(), velocities) : velocities[p];
  }
  /// The same of all of them (size()).
  void placeAll(const Points& positions, Points& all) const;
  /// Adds what a force on a point, N, does to the simulation points.
  void addForce(Index p, const Points& positions, const Vec3& force, Points& forces) const {
    if (isBetween(p))
      between_->scatter(p - numSimulated(), positions, force, forces);
    else
      forces[p] += force;
  }
  /// Adds what a stiffness on it, N/m, does to them; and a bound of the sums of its rows, where a value bounds the block.
  void addStiffness(Index p, const Mat3& block, BlockSparse& stiffness) const;
  void addRowBound(Index p, double value, std::vector<double>& bound) const;

 private:
  void numberPart(const ContactPoints& whole, const std::vector<Index>& new_index);
  double sumOfWeights(Index s) const;

  const std::vector<double>& masses_;
  std::shared_ptr<const transfer::SampledPoints> between_;
  std::vector<double> damped_mass_;     // (points between) kg
  std::vector<double> damped_mass_on_;  // (m) kg, of damped_mass_ alone
  std::vector<char> is_severed_;        // (points between), or empty
  std::shared_ptr<const transfer::SampledPoints> taken_from_;
  std::vector<Index> number_in_part_, number_in_whole_;
};

}  // namespace deformable_surface::simulation
