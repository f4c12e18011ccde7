// The loops over points and pairs of an elastic solid, four points side by side. A simulation spends its time here.
#pragma once

#include "deformable_surface/model/elastic_solid/fitted_gradients.h"
#include "deformable_surface/model/elastic_solid/point_rooms.h"

namespace deformable_surface::model {

/// Stress laws, with P the first Piola-Kirchhoff stress and psi the energy density:
///   kCorotated   psi = mu |F - R|^2 + lambda/2 tr^2(R^T F - I),  P = 2 mu (F - R) + lambda tr(R^T F - I) R,
///   kLinear      psi = mu |e|^2 + lambda/2 tr^2(e), e = (F + F^T)/2 - I,  P = 2 mu e + lambda tr(e) I,
///   kNeoHookean  psi = mu/2 (|F|^2 - 3) - mu ln J + lambda/2 (J - 1)^2, J = det F,  P = mu F + s cof F,
///                s = lambda (J - 1) - mu / J; from J = 0.1 down, ln J goes on as a parabola [Bonet and Wood 2008],
///   kBound       P = 2 mu F + lambda tr(F) I, linear in F: for motions instead of places, at least as stiff as the others
///                while lambda tr(R^T F - I) <= 2 mu,
///   kTangent     P = 2 mu F + lambda tr(R^T F) R + R [M a]x, a the axial vector of R^T F - F^T R: for motions, the derivative
///                of one of the first two where SolidPasses::prepareTangent() was called,
///   kNeoHookeanTangent  P = mu F + s' (cof A : F) cof A + s d(cof A)[F]: the same of kNeoHookean, A its F there.
/// R is the rotation nearest to F (a proper one, also where F turns the body inside out).
enum class StressLaw { kCorotated, kLinear, kNeoHookean, kBound, kTangent, kNeoHookeanTangent };

/// Constants of an elastic solid at rest; only the gradients change, by plastic flow.
struct SolidRest {
  PairFit fit;  // strain is measured with its corrected gradients; its m is not kept, its pairs do not ascend
  ConsistentGradients gradients;
  PairFit near;                   // the fit that motions from point to point are compared with; its pairs are the first in fit
  std::vector<double> volumes;    // (n) m^3
  double mu = 0.0, lambda = 0.0;  // Lame's, Pa
  double stabilization = 0.0;     // s, Pa m^3
  Vec3 across = Vec3::Zero();     // the normal of a planar solid
};

struct PassArrays;

class SolidPasses {
 public:
  explicit SolidPasses(SolidRest given);

  SolidRest rest;
  Index size() const { return rest.fit.size(); }

  /// First pass: with Q_i = V_i P_i and N_i = -s F'_i of each point in a block of PointRooms, its action on its neighbours,
  /// -Q_i g_ij - N_i m'_ij, and on itself, Q_i sum_j g_ij + N_i sum_j m'_ij + 2 s sum_j w'_ij (x_j - x_i). Quantities with a dash
  /// belong to `near`. positions: (4 x n) padded.
  void spreadStress(StressLaw law, Index begin, Index end, const double* positions);
  /// Second pass: adds the force on each point, N. forces: (n x 3). Call it after all blocks of the first pass.
  void gatherForces(Index begin, Index end, double* forces) const { rooms_.addForces(begin, end, forces); }
  /// Stores R and M of every point for kTangent. In kCorotated M = (lambda tr(S - I) - 2 mu) (tr(S) I - S)^-1, S = R^T F, in
  /// kLinear -mu. is_positive: eigenvalues of M below -mu are raised to it, so that no motion of the point gains
  /// energy. For kNeoHookeanTangent stores A, s and s'; is_positive: a smaller |s|, for the same. The completion of a deficient F
  /// is taken as constant. begin: a multiple of four.
  void prepareTangent(StressLaw law, bool is_positive, Index begin, Index end, const double* positions);
  /// A bound of the largest stiffness of a point by kNeoHookean over that at rest (neo_hookean::boundStiffening()).
  double boundStiffening(Index begin, Index end, const double* positions) const;
  /// Allocates the memory for prepareTangent().
  void beginTangent();

  /// Energy of the points, J:  sum_i V_i psi_i + s/2 sum_i sum_j w'_ij |x_j - x_i - F'_i (X_j - X_i)|^2.
  double sumEnergy(StressLaw law, Index begin, Index end, const double* positions) const;

  /// F_i of one point (slow), completed where its neighbours span no volume: missing directions are as at rest across the plane
  /// of a planar solid; else they keep their length, perpendicular to the rest, and so have no strain.
  Mat3 fitGradient(Index i, const double* positions) const;
  /// The stress by law of one F.
  Mat3 findStress(StressLaw law, const Mat3& F) const;
  /// psi by law (not kBound) of one F, J/m^3.
  double findDensity(StressLaw law, const Mat3& F) const;
  /// From now on F_i is computed with the rows (at_rest) times a matrix: g_ij = inverse^T g_ij at rest. Different
  /// points may be changed at once.
  void setPlastic(Index i, const ConsistentGradients& at_rest, const Mat3& inverse);
  /// Whether its neighbours span fewer dimensions than the solid.
  bool isDeficient(Index i) const { return rest.fit.rank[i] < (rest.across.isZero(0.0) ? 3 : 2); }

 private:
  PassArrays arraysOf(const double* positions) const;
  void spreadOne(StressLaw law, Index i, Index place, const double* positions, double* room) const;
  void prepareOne(StressLaw law, bool is_positive, Index i, const double* positions);
  void prepareNeoHookean(bool is_positive, Index i, const double* positions);
  double findEnergy(StressLaw law, Index i, const double* positions) const;

  std::vector<double> constants_;  // (n / 4 x 13 x 4): V, sum_j g_ij, K'^-1, sum_j m'_ij of four points side by side
  std::vector<double> tangent_;    // (n / 4 x 15 x 4): R by rows, M xx xy xz yy yz zz, or A by rows, s, s'; empty until asked for
  std::vector<char> is_deficient_;  // (n) or empty: none is
  PointRooms rooms_;
};

/// The rotation nearest to F, also where F is singular or inside out. Where several are equally near, always the same.
Mat3 findRotation(const Mat3& F);
/// cof F, which turns areas, also where F is singular.
Mat3 findCofactors(const Mat3& F);

}  // namespace deformable_surface::model
