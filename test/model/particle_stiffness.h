// The exact stable step of oriented particles, from the stiffness matrix of a state.
#pragma once

#include <Eigen/Eigenvalues>

#include <cmath>

#include "particle_states.h"

namespace deformable_surface::test {

/// The stiffness of positions and orientations over their masses, by differences of forces and torques.
inline Eigen::MatrixXd measureStiffness(const OrientedParticles& model, const State& state) {
  const Index n = state.size();
  Eigen::MatrixXd matrix(6 * n, 6 * n);
  const double h = 1e-6;
  for (Index i = 0; i < n; ++i)
    for (int axis = 0; axis < 6; ++axis) {
      Points forces[2], torques[2];
      const double mass = axis < 3 ? model.masses()[i] : model.inertias()[i], step = axis < 3 ? h * kSpacing : h;
      for (int side = 0; side < 2; ++side) {
        State s = state;
        const Vec3 move = (side ? step : -step) * Vec3::Unit(axis % 3);
        if (axis < 3) {
          s.positions[i] += move;
        } else {
          s.orientations[i] = turnBy(move, s.orientations[i]);
        }
        evaluate(model, s, forces[side], torques[side]);
      }
      for (Index j = 0; j < n; ++j) {
        const double by_mass = std::sqrt(mass * model.masses()[j]), by_inertia = std::sqrt(mass * model.inertias()[j]);
        matrix.block<3, 1>(6 * j, 6 * i + axis) = -(forces[1][j] - forces[0][j]) / (2.0 * step * by_mass);
        matrix.block<3, 1>(6 * j + 3, 6 * i + axis) = -(torques[1][j] - torques[0][j]) / (2.0 * step * by_inertia);
      }
    }
  return 0.5 * (matrix + matrix.transpose());
}

/// The exact stable step of such a state, s.
inline double measureStableStep(const OrientedParticles& model, const State& state) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(measureStiffness(model, state), Eigen::EigenvaluesOnly);
  return 2.0 / std::sqrt(solver.eigenvalues().maxCoeff());
}

}  // namespace deformable_surface::test
