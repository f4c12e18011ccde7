// A network of springs: Hooke's law, and damping along the spring or as published. Used for the published membrane and
// bending, and for the damping of the membrane of triangles.
#pragma once

#include "deformable_surface/base/padded_points.h"
#include "deformable_surface/model/deformable_model.h"
#include "deformable_surface/model/mass_spring/part_index.h"

namespace deformable_surface::model {

class Springs {
 public:
  Springs() = default;

  /// links (s) of distinct points among num_points; lengths at rest from rest positions; stiffness (s), N/m.
  Springs(std::vector<std::pair<Index, Index>> links, const Points& rest, std::vector<double> stiffness);

  /// Marks the other ends of the springs at points.
  void markPartners(const std::vector<Index>& points, std::vector<char>& marked) const;
  /// The springs that touch a wanted point, in their order.
  Springs makePart(const PartIndex& part) const;

  /// Adds f_i = k (|I| - l0) I/|I| [Su 2007, eq. 2, the sign that pulls i towards j], if elastic, and the damping tension
  /// beta k (v_j - v_i).I/|I| along I/|I|. I = s_j - s_i.
  /// Coincident ends are pushed apart in a direction fixed by their indices, so that an exact collapse can recover.
  /// positions: those of the state.
  void addForces(const State& state, const PaddedPoints& positions, bool elastic, double beta, Points& forces) const;

  /// Adds f_i = beta k (v_j - v_i) [Su 2007, eq. 3]: damps rotations too and does not keep angular momentum.
  void addRelativeDamping(const State& state, double beta, Points& forces) const;

  /// sum of k/2 (|I| - l0)^2, J.
  double energy(const State& state) const;

  /// Adds k [d d^T + (1 - l0/|I|) (1 - d d^T)], if elastic, and beta k / step d d^T. kPositive omits the second term of
  /// springs under compression, where it is negative.
  void addStiffness(const State& state, bool elastic, double beta, double step, Hessian hessian, BlockSparse& stiffness) const;

  /// Adds beta k / step in every direction: the damping matrix of addRelativeDamping() over the step.
  void addRelativeDampingMatrix(double beta, double step, BlockSparse& stiffness) const;

  /// See DeformableModel::addRowBounds; the same for both kinds of damping.
  void addRowBounds(bool elastic, double beta, std::vector<double>& stiffness, std::vector<double>& damping) const;

  /// Largest | |I| / l0 - 1 |.
  double maxStretch(const State& state) const;
  /// Raises strain (n) to the largest | |I| / l0 - 1 | of each point's links.
  void raisePointStrain(const State& state, std::vector<double>& strain) const;

  const std::vector<std::pair<Index, Index>>& links() const { return links_; }
  const std::vector<double>& restLengths() const { return rest_length_; }
  const std::vector<double>& stiffness() const { return stiffness_; }

 private:
  Vec3 direction(std::size_t s, const State& state, double& length) const;
  void prepareForceLoop(Index num_points);

  // Constants.
  std::vector<std::pair<Index, Index>> links_;
  std::vector<double> rest_length_, stiffness_;
  std::vector<Index> group_ends_;        // four springs side by side, the last ones repeated: (2 x 4) ends
  std::vector<double> group_constants_;  // and (2 x 4) stiffness, rest length
  Lists incidence_;                      // per point: 2 items a spring, the spring and its other end; ascending spring
  // Scratch: tension over length of each spring, padded to groups.
  mutable std::vector<double> pull_;
  mutable PaddedPoints velocities_;
};

}  // namespace deformable_surface::model
