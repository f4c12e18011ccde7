// One projected Newton iteration with line search, shared by the implicit step and the static solution.
#pragma once

#include "bearing_parts.h"
#include "deformable_surface/linear/block_cholesky.h"
#include "deformable_surface/solve/system.h"
#include "product_solver.h"

#include <atomic>
#include <utility>

namespace deformable_surface::solve {

/// Minimises  Phi(x) = sum_i w_i/2 |x_i - y_i|^2 + E(x) + U(x) - L . x  over the free points, with E the elastic energy, U the
/// potential of conservative loads and L the forces that have no potential (viscous ones, follower pressure). L is evaluated
/// again at every iterate, at velocities (x - x_before) / step (zero if step is 0).
class NewtonDescent {
 public:
  struct Problem {
    const System& system;
    double time;                          // s, at which loads are evaluated
    double step;                          // s; 0 = statics
    const Points& before;                 // (n x 3) m
    const Points& target;                 // y, (n x 3) m
    const std::vector<double>& weight;    // w, (n) N/m
    const std::vector<double>& rounding;  // (n) N: forces below it are in balance
    double enough = 0.0;                  // N, the unbalanced force that ends the search: directions need be no better
  };

  /// Before the first iteration of a solution: forgets the results of earlier iterations. interrupt: see Integrator.
  void begin(const std::atomic<bool>* interrupt) {
    projected_in_a_row_ = 0;
    shift_ = last_residual_ = 0.0;
    is_indefinite_ = is_potential_known_ = is_factor_good_ = false;
    is_first_matrix_ = true;
    interrupt_ = interrupt;
  }
  bool isInterrupted() const { return interrupt_ && *interrupt_; }
  /// Work since the last call, in evaluations of all forces. It is counted, so that it is the same on every machine.
  double takePasses() { return std::exchange(passes_, 0.0); }

  /// Energy and potential of the loads at a state, J; remembered for the last one.
  double potential(const Problem& problem, const State& state);

  /// Computes the gradient at state.positions and returns its largest magnitude on a free point that is not in balance: the
  /// unbalanced force, N.
  double evaluate(const Problem& problem, State& state);

  /// After evaluate(): takes the exact matrix if it is positive definite, else the projected one, or the factor of the last
  /// iteration if that probably ends the search. Moves state.positions along the Newton direction and halves the step until
  /// Phi falls by Armijo's rule. tentative: the whole step is taken even if Phi rises, as long as it stays finite. If
  /// several such steps in a row had no definite matrix, a multiple of the masses is added to the exact one: the projected
  /// matrix hardly leaves a saddle.
  struct Step {
    double fraction;            // of the direction; 0 if no descent was found (the state is then unchanged)
    bool raised;                // Phi did not fall by the rule
    bool is_shortened = false;  // in parts that were stopped or led to no descent
    double drop = 0.0;          // J, of Phi
  };
  Step descend(const Problem& problem, State& state, bool tentative = false);

  /// After evaluate(): the unbalanced force, N, on the other parts than those that held up the last descend(), which shortened
  /// its step.
  double residualOfOthers(const Problem& problem) const;

  /// Work of the forces without a potential, as the last evaluate() found them, from `before` (n x 3) to state, J.
  double remainderWork(const Points& before, const State& state) const;
  /// Work of what the last evaluate() left unbalanced, from `before` (n x 3) to state, J: of the points on which it is at most
  /// `enough` (N).
  double unbalancedWork(const Points& before, const State& state, double enough) const;

 private:
  /// Phi up to a constant. The work of L since the last evaluate() uses its mean at both ends, which is exact for viscous
  /// forces. With constant L, energy that these dissipate would count as a gain.
  double merit(const Problem& problem, State& state);
  /// Sets the velocities and computes L at a state.
  void computeRemainder(const Problem& problem, State& state, Points& remainder);
  /// Fills and factorises the matrix; false if it is not positive definite.
  bool factorize(const Problem& problem, const State& state, model::Hessian hessian);
  /// Adds shift_ times the masses to the exact matrix, which was not definite; false if that is not enough.
  bool factorizeShifted(const System& system);
  /// Slope of Phi along the direction of the points that count, N m. counts(point).
  template <class Counts>
  double findSlope(const Counts& counts) const;
  /// Shortens the direction by the system's limit of motion, in the parts that it stops. Returns whether it was too long.
  bool shorten(const System& system, const Points& positions);
  /// Where hardly anything of the direction was taken.
  void moveByParts(const Problem& problem, State& state, Step& taken);
  /// Limits the motion along the direction, to reached_. Returns the points that are stopped.
  const std::vector<Index>& stop(const System& system, const Points& positions);
  /// The line search along the direction.
  Step search(const Problem& problem, double slope, bool tentative, State& state);
  /// Solves with the factor. Where the result is not finite, direction_ stays the steepest descent.
  void solveFactored(const Problem& problem, const State& state);
  /// Multiplies the vector by the inverse of the matrix without its skew part.
  void applyInverse(const System& system, const State& state, Eigen::VectorXd& vector);
  /// Sets solution_ to that of the matrix with its skew part.
  void solveWithSkew(const Problem& problem, const State& state);
  /// The direction for a model with stiffness products. It is as accurate as the gradient has fallen since the last one
  /// [Eisenstat and Walker 1996], and as accurate as a direction that ends the search has to be.
  void solveByProducts(const Problem& problem, const State& state);

  double passes_ = 0.0;
  bool is_potential_known_ = false;  // since begin()
  double potential_ = 0.0;           // J, at
  Points potential_at_;
  Points gradient_, conservative_, forces_, remainder_, remainder_there_, start_, reached_, rank_one_;
  BearingParts stopped_;  // in the last direction that was shortened
  std::vector<Index> listed_parts_;
  bool has_remainder_ = false;                       // any of L is not zero
  Eigen::VectorXd direction_, solution_, response_;  // (3 n)
  BlockSparse stiffness_;
  BlockCholesky factor_;
  ProductSolver products_;
  Points found_;                                                       // by it
  Eigen::VectorXd correction_, left_, former_left_, former_solution_;  // (3 n), of solveWithSkew()
  Points product_;
  double residual_ = 0.0, last_residual_ = 0.0;  // N, of the last evaluate(), and of the one that the last direction was of
  bool is_factor_good_ = false;                  // it is that of an exact matrix, and the whole of its last direction was taken
  bool is_first_matrix_ = true;                  // of this solution: its pattern is that of the state, whatever came before
  bool is_indefinite_ = false;                   // in this solution the exact products were not positive
  int projected_in_a_row_ = 0;                   // tentative steps without the exact matrix
  double shift_ = 0.0;                           // 1/s^2; 0 = none was needed yet
  const std::atomic<bool>* interrupt_ = nullptr;
};

}  // namespace deformable_surface::solve
