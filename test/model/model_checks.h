// Checks for every model, whatever its material: momentum is conserved, rest stays rest, rigid motion causes no force, forces are
// minus the gradient of the energy, and the stiffness is their derivative.
#pragma once

#include "../support/dense.h"
#include "../support/surfaces.h"
#include "deformable_surface/model/deformable_model.h"

#include <Eigen/Eigenvalues>

#include <gtest/gtest.h>

namespace deformable_surface::test {

using model::DeformableModel;
using model::State;

inline State stateAt(const Points& positions) { return {positions, Points(positions.size(), Vec3::Zero())}; }

/// positions moved by up to amount in every direction.
inline Points perturb(Points positions, double amount, unsigned seed = 7) {
  std::mt19937 generator(seed);
  for (Vec3& p : positions) p += amount * randomVector(generator);
  return positions;
}

inline Points forcesAt(const DeformableModel& model, const State& state) {
  Points forces(state.positions.size(), Vec3::Zero());
  model.addForces(state, forces);
  return forces;
}

inline double largest(const Points& vectors) {
  double norm = 0.0;
  for (const Vec3& v : vectors) norm = std::max(norm, v.norm());
  return norm;
}

inline void checkRestIsAtRest(const DeformableModel& model, const Points& rest, double force_scale) {
  EXPECT_LT(largest(forcesAt(model, stateAt(rest))), 1e-10 * force_scale);
  EXPECT_NEAR(model.elasticEnergy(stateAt(rest)), 0.0, 1e-18 * force_scale);
}

/// angular: angular momentum is checked, too.
inline void checkMomentumIsKept(const DeformableModel& model, State state, bool angular = true) {
  std::mt19937 generator(3);
  for (Vec3& v : state.velocities) v = randomVector(generator);
  const Points forces = forcesAt(model, state);
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  double sizes = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    sum += forces[i];
    moment += state.positions[i].cross(forces[i]);
    sizes += forces[i].norm();
  }
  ASSERT_GT(sizes, 0.0);
  EXPECT_LT(sum.norm(), 1e-13 * sizes);
  if (angular) {
    EXPECT_LT(moment.norm(), 1e-12 * sizes);
  }
}

inline void checkRigidMotionIsNotNoticed(const DeformableModel& model, const Points& deformed) {
  const Mat3 rotation = someRotation();
  const Vec3 shift(0.7, -2.0, 1.5);
  Points moved = deformed;
  for (Vec3& p : moved) p = rotation * p + shift;
  const double energy = model.elasticEnergy(stateAt(deformed));
  ASSERT_GT(energy, 0.0);
  EXPECT_NEAR(model.elasticEnergy(stateAt(moved)), energy, 1e-10 * energy);
  const Points forces = forcesAt(model, stateAt(deformed)), moved_forces = forcesAt(model, stateAt(moved));
  const double scale = largest(forces);
  for (std::size_t i = 0; i < forces.size(); ++i) EXPECT_LT((moved_forces[i] - rotation * forces[i]).norm(), 1e-9 * scale) << i;
}

/// Central differences of the energy along random directions and along single coordinates.
inline void checkForcesAreMinusTheGradient(const DeformableModel& model, const Points& deformed, double length_scale) {
  const Points forces = forcesAt(model, stateAt(deformed));
  std::mt19937 generator(11);
  const double h = 1e-5 * length_scale;
  for (int trial = 0; trial < 10; ++trial) {
    Points direction(deformed.size(), Vec3::Zero());
    if (trial < 5) {
      for (Vec3& d : direction) d = randomVector(generator);
    } else {
      direction[generator() % direction.size()] = randomVector(generator);
    }
    Points ahead = deformed, behind = deformed;
    double expected = 0.0, size = 0.0;
    for (std::size_t i = 0; i < deformed.size(); ++i) {
      ahead[i] += h * direction[i];
      behind[i] -= h * direction[i];
      expected -= forces[i].dot(direction[i]);
      size += std::abs(forces[i].dot(direction[i]));
    }
    const double slope = (model.elasticEnergy(stateAt(ahead)) - model.elasticEnergy(stateAt(behind))) / (2.0 * h);
    EXPECT_NEAR(slope, expected, 1e-6 * size) << "direction " << trial;
  }
}

/// The exact stiffness is the derivative of the forces.
inline void checkStiffnessIsTheDerivative(const DeformableModel& model, const Points& rest, double length_scale) {
  const Index n = static_cast<Index>(rest.size());
  BlockSparse stiffness;
  stiffness.begin(n);
  model.stiffnessMatrix()->addStiffness(stateAt(rest), 0.0, model::Hessian::kExact, stiffness);
  stiffness.finish();
  std::mt19937 generator(5);
  const double h = 1e-6 * length_scale;
  Eigen::VectorXd direction(3 * n);
  for (Eigen::Index i = 0; i < direction.size(); ++i) direction[i] = uniform(generator);
  Points ahead = rest, behind = rest;
  for (Index i = 0; i < n; ++i) {
    ahead[i] += h * direction.segment<3>(3 * i);
    behind[i] -= h * direction.segment<3>(3 * i);
  }
  const Points forces_ahead = forcesAt(model, stateAt(ahead)), forces_behind = forcesAt(model, stateAt(behind));
  Eigen::VectorXd product;
  stiffness.multiply(direction, product);
  Points rank_one;
  const double coefficient = model.stiffnessMatrix()->rankOneStiffness(stateAt(rest), rank_one);
  if (coefficient > 0.0) {
    const Eigen::Map<const Eigen::VectorXd> v(rank_one.data()->data(), 3 * n);
    product += coefficient * v.dot(direction) * v;
  }
  const double scale = product.lpNorm<Eigen::Infinity>();
  ASSERT_GT(scale, 0.0);
  for (Index i = 0; i < n; ++i) {
    const Vec3 difference = -(forces_ahead[i] - forces_behind[i]) / (2.0 * h);
    EXPECT_LT((difference - product.segment<3>(3 * i)).norm(), 1e-5 * scale) << i;
  }
}

/// The damping matrix of the model: the stiffness of a step minus that of statics, times the step.
inline Eigen::MatrixXd dampingMatrix(const DeformableModel& model, const Points& positions) {
  const double step = 0.01;
  Eigen::MatrixXd matrix[2];
  for (int with_step = 0; with_step < 2; ++with_step) {
    BlockSparse stiffness;
    stiffness.begin(static_cast<Index>(positions.size()));
    model.stiffnessMatrix()->addStiffness(stateAt(positions), with_step * step, model::Hessian::kPositive, stiffness);
    stiffness.finish();
    matrix[with_step] = makeDense(stiffness);
  }
  return step * (matrix[1] - matrix[0]);
}

/// Viscous forces are linear in the velocities: the damping matrix reproduces them up to rounding, for any velocities.
inline void checkDampingMatrixGivesTheViscousForces(const DeformableModel& model, const Points& positions) {
  const Index n = static_cast<Index>(positions.size());
  State moving = stateAt(positions);
  std::mt19937 generator(5);
  Eigen::VectorXd velocities(3 * n);
  for (Index i = 0; i < n; ++i) velocities.segment<3>(3 * i) = moving.velocities[i] = randomVector(generator);
  const Points forces = forcesAt(model, moving), elastic = forcesAt(model, stateAt(positions));
  const Eigen::VectorXd expected = -dampingMatrix(model, positions) * velocities;
  const double scale = expected.lpNorm<Eigen::Infinity>();
  ASSERT_GT(scale, 0.0);
  for (Index i = 0; i < n; ++i) EXPECT_LT((forces[i] - elastic[i] - expected.segment<3>(3 * i)).norm(), 1e-9 * scale) << i;
}

/// The stiffness is not negative along any direction, also far from rest.
inline void checkStiffnessIsPositive(const DeformableModel& model, const Points& deformed) {
  const Index n = static_cast<Index>(deformed.size());
  BlockSparse stiffness;
  stiffness.begin(n);
  model.stiffnessMatrix()->addStiffness(stateAt(deformed), 0.0, model::Hessian::kPositive, stiffness);
  stiffness.finish();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(makeDense(stiffness), Eigen::EigenvaluesOnly);
  EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-9 * solver.eigenvalues().maxCoeff());
}

/// Gershgorin's row bounds are not below the largest eigenvalues of M^-1 K and M^-1 C.
inline void checkRowBoundsHold(const DeformableModel& model, const Points& rest) {
  const Index n = static_cast<Index>(rest.size());
  BlockSparse stiffness;
  stiffness.begin(n);
  model.stiffnessMatrix()->addStiffness(stateAt(rest), 0.0, model::Hessian::kPositive, stiffness);
  stiffness.finish();
  std::vector<double> rows(n, 0.0), damping(n, 0.0);
  model.addRowBounds(stateAt(rest), rows, damping);
  const auto checkBound = [&](Eigen::MatrixXd matrix, const std::vector<double>& bounds) {
    double bound = 0.0;
    for (Index i = 0; i < n; ++i) {
      bound = std::max(bound, bounds[i] / model.masses()[i]);
      matrix.middleRows<3>(3 * i) /= std::sqrt(model.masses()[i]);
      matrix.middleCols<3>(3 * i) /= std::sqrt(model.masses()[i]);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix, Eigen::EigenvaluesOnly);
    EXPECT_LE(solver.eigenvalues().maxCoeff(), bound * (1.0 + 1e-9));
  };
  checkBound(makeDense(stiffness), rows);
  checkBound(dampingMatrix(model, rest), damping);
}

}  // namespace deformable_surface::test
