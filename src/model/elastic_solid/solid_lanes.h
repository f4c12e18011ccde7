// Strains and stresses of four points of an elastic solid, side by side. Forces, energies and tangents
// start with them.
#pragma once

#include "deformable_surface/base/simd.h"
#include "deformable_surface/model/elastic_solid/solid_passes.h"
#include "neo_hookean.h"

namespace deformable_surface::model {

// The arrays of both fits; those of the near one have a dash in solid_passes.h.
struct PassArrays {
  Index n;
  const Index *offsets, *items, *places;
  const double* row;
  const Index *near_offsets, *near_items;
  const double *m, *constants, *tangent, *positions;
  const char* deficient;
  double mu, lambda, stabilization, across[3];
};

namespace lanes {

// Of a rotation: enough for stretches between an eighth and eight. The remaining ones are treated one by one.
constexpr int kMostIterations = 9;
constexpr double kConverged = 1e-14;  // squared change after which the next iterate is exact to rounding, as the order is two
constexpr double kSmallest = 1e-3;    // determinant of F below which iterations may not end in a rotation

// A matrix of each of four points, side by side, such as F: entry [row][column].
struct Four {
  Double4 at[3][3];
};

// Sums over the neighbours j of (x_j - x_i) row_j[c] for c < 3, x y z 0 each; rows of kWidth numbers, places of kStride.
template <int kWidth, int kStride>
DEFORMABLE_SURFACE_INLINE void gatherPairs(Index begin, Index end, const Index* items, const double* rows,
                                           const double* positions, Index i, Double4* columns) {
  Double4 here, a[3]{}, b[3]{};
  load(positions + kStride * static_cast<std::ptrdiff_t>(i), here);
  Index k = begin;
  for (; k + 1 < end; k += 2) {
    const double* u = rows + kWidth * static_cast<std::ptrdiff_t>(k);
    Double4 d, e;
    load(positions + kStride * static_cast<std::ptrdiff_t>(items[k]), d);
    load(positions + kStride * static_cast<std::ptrdiff_t>(items[k + 1]), e);
    d -= here;
    e -= here;
    for (int c = 0; c < 3; ++c) {
      a[c] += d * u[c];
      b[c] += e * u[kWidth + c];
    }
  }
  if (k < end) {
    const double* u = rows + kWidth * static_cast<std::ptrdiff_t>(k);
    Double4 d;
    load(positions + kStride * static_cast<std::ptrdiff_t>(items[k]), d);
    d -= here;
    for (int c = 0; c < 3; ++c) a[c] += d * u[c];
  }
  for (int c = 0; c < 3; ++c) columns[c] = a[c] + b[c];
}

// The same of four points in a row, side by side.
template <int kWidth>
DEFORMABLE_SURFACE_INLINE void gatherFour(Index first, Index n, const Index* offsets, const Index* items, const double* rows,
                                          const double* positions, Four& A) {
  Double4 columns[4][3];
  for (Index lane = 0; lane < 4; ++lane) {
    const Index i = first + lane < n ? first + lane : n - 1;  // the last group is filled up
    gatherPairs<kWidth, 4>(offsets[i], offsets[i + 1], items, rows, positions, i, columns[lane]);
  }
  for (int c = 0; c < 3; ++c) {
    transpose(columns[0][c], columns[1][c], columns[2][c], columns[3][c]);
    for (int r = 0; r < 3; ++r) A.at[r][c] = columns[r][c];
  }
}

// product = a * K^-1, K^-1 symmetric.
DEFORMABLE_SURFACE_INLINE void multiplyByInverse(const Four& a, const double* constants, Four& product) {
  Double4 xx, xy, xz, yy, yz, zz;
  load(constants, xx);
  load(constants + 4, xy);
  load(constants + 8, xz);
  load(constants + 12, yy);
  load(constants + 16, yz);
  load(constants + 20, zz);
  for (int r = 0; r < 3; ++r) {
    product.at[r][0] = a.at[r][0] * xx + a.at[r][1] * xy + a.at[r][2] * xz;
    product.at[r][1] = a.at[r][0] * xy + a.at[r][1] * yy + a.at[r][2] * yz;
    product.at[r][2] = a.at[r][0] * xz + a.at[r][1] * yz + a.at[r][2] * zz;
  }
}

// C = cof A, and det A.
DEFORMABLE_SURFACE_INLINE void findCofactors(const Four& A, Four& C, Double4& determinant) {
  for (int r = 0; r < 3; ++r) {
    const int s = (r + 1) % 3, t = (r + 2) % 3;
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3, e = (c + 2) % 3;
      C.at[r][c] = A.at[s][d] * A.at[t][e] - A.at[s][e] * A.at[t][d];
    }
  }
  determinant = A.at[0][0] * C.at[0][0] + A.at[0][1] * C.at[0][1] + A.at[0][2] * C.at[0][2];
}

// The rotations nearest to four F by Newton's iteration R <- (R + R^-T) / 2 [Higham 1986]. A lane is skipped (not sound) if F
// is nearly singular, inside out or not finite.
DEFORMABLE_SURFACE_INLINE void findRotations(const Four& F, Four& R, bool* is_sound) {
  R = F;
  Double4 first{}, change{};
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    Four C;
    Double4 determinant;
    findCofactors(R, C, determinant);
    if (iteration == 0) first = determinant;
    const Double4 half = 0.5 / determinant;
    change = Double4{};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        const Double4 next = 0.5 * R.at[r][c] + half * C.at[r][c], d = next - R.at[r][c];
        change += d * d;
        R.at[r][c] = next;
      }
    if (change[0] < kConverged && change[1] < kConverged && change[2] < kConverged && change[3] < kConverged) break;
  }
  for (int lane = 0; lane < 4; ++lane) is_sound[lane] = change[lane] < kConverged && first[lane] > kSmallest;
}

// s of kNeoHookean and its derivative, as neo_hookean::findFactor().
DEFORMABLE_SURFACE_INLINE void findFactors(double mu, double lambda, const Double4& J, Double4& factor, Double4& slope) {
  const Double4 least = Double4{} + neo_hookean::kCrushed, held = J < least ? least : J, inverse = 1.0 / held;
  factor = lambda * (J - 1.0) - mu * inverse * (1.0 - inverse * (J - held));
  slope = lambda + mu * inverse * inverse;
}

// P by law; of kCorotated with the rotations.
DEFORMABLE_SURFACE_INLINE void findStresses(StressLaw law, double mu, double lambda, const Four& F, const Four& R, Four& P) {
  if (law == StressLaw::kCorotated) {
    Double4 trace{};
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) trace += R.at[r][c] * F.at[r][c];
    const Double4 turned = lambda * (trace - 3.0) - 2.0 * mu;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) P.at[r][c] = 2.0 * mu * F.at[r][c] + turned * R.at[r][c];
    return;
  }
  if (law == StressLaw::kNeoHookean) {
    Four C;
    Double4 J;
    findCofactors(F, C, J);
    Double4 factor, slope;
    findFactors(mu, lambda, J, factor, slope);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) P.at[r][c] = mu * F.at[r][c] + factor * C.at[r][c];
    return;
  }
  const double rest = law == StressLaw::kLinear ? 1.0 : 0.0;
  const Double4 trace = (F.at[0][0] - rest) + (F.at[1][1] - rest) + (F.at[2][2] - rest);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      P.at[r][c] = law == StressLaw::kLinear ? mu * (F.at[r][c] + F.at[c][r]) : 2.0 * mu * F.at[r][c];
      if (r == c) P.at[r][c] += lambda * trace - 2.0 * mu * rest;
    }
}

// P of a motion by kTangent, from R and M of four points.
DEFORMABLE_SURFACE_INLINE void findTangentStresses(double mu, double lambda, const Four& F, const double* tangent, Four& P) {
  Four R, A;
  Double4 M[6], trace{};
  for (int k = 0; k < 9; ++k) load(tangent + 4 * k, R.at[k / 3][k % 3]);
  for (int k = 0; k < 6; ++k) load(tangent + 36 + 4 * k, M[k]);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) A.at[r][c] = R.at[0][r] * F.at[0][c] + R.at[1][r] * F.at[1][c] + R.at[2][r] * F.at[2][c];
  const Double4 x = A.at[2][1] - A.at[1][2], y = A.at[0][2] - A.at[2][0], z = A.at[1][0] - A.at[0][1];
  const Double4 u = M[0] * x + M[1] * y + M[2] * z, v = M[1] * x + M[3] * y + M[4] * z, w = M[2] * x + M[4] * y + M[5] * z;
  trace = lambda * (A.at[0][0] + A.at[1][1] + A.at[2][2]);
  for (int r = 0; r < 3; ++r) {
    P.at[r][0] = 2.0 * mu * F.at[r][0] + trace * R.at[r][0] + w * R.at[r][1] - v * R.at[r][2];
    P.at[r][1] = 2.0 * mu * F.at[r][1] + trace * R.at[r][1] + u * R.at[r][2] - w * R.at[r][0];
    P.at[r][2] = 2.0 * mu * F.at[r][2] + trace * R.at[r][2] + v * R.at[r][0] - u * R.at[r][1];
  }
}

// P of a motion by kNeoHookeanTangent, from A, s and its derivative of four points. F: of the motion.
DEFORMABLE_SURFACE_INLINE void findNeoHookeanTangentStresses(double mu, const Four& F, const double* tangent, Four& P) {
  Four A, C;
  Double4 factor, slope, J, change{};
  for (int k = 0; k < 9; ++k) load(tangent + 4 * k, A.at[k / 3][k % 3]);
  load(tangent + 36, factor);
  load(tangent + 40, slope);
  findCofactors(A, C, J);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) change += C.at[r][c] * F.at[r][c];
  change *= slope;
  for (int r = 0; r < 3; ++r) {
    const int s = (r + 1) % 3, t = (r + 2) % 3;
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3, e = (c + 2) % 3;
      const Double4 turned =
          F.at[s][d] * A.at[t][e] + A.at[s][d] * F.at[t][e] - F.at[s][e] * A.at[t][d] - A.at[s][e] * F.at[t][d];
      P.at[r][c] = mu * F.at[r][c] + change * C.at[r][c] + factor * turned;
    }
  }
}

// psi of kNeoHookean, as neo_hookean::findDensity().
DEFORMABLE_SURFACE_INLINE void findNeoHookeanDensities(double mu, double lambda, const Four& F, Double4& densities) {
  Four C;
  Double4 J, G[6];
  findCofactors(F, C, J);
  for (int r = 0, k = 0; r < 3; ++r)
    for (int c = r; c < 3; ++c, ++k) {
      G[k] = F.at[0][r] * F.at[0][c] + F.at[1][r] * F.at[1][c] + F.at[2][r] * F.at[2][c];
      G[k] = 0.5 * (r == c ? G[k] - 1.0 : G[k]);
    }
  const Double4 yz = G[3] * G[5] - G[4] * G[4];
  const Double4 g1 = G[0] + G[3] + G[5], g2 = yz + (G[0] * G[5] - G[2] * G[2]) + (G[0] * G[3] - G[1] * G[1]),
                g3 = G[0] * yz - G[1] * (G[1] * G[5] - G[2] * G[4]) + G[2] * (G[1] * G[4] - G[2] * G[3]);
  const auto is_crushed = J < neo_hookean::kCrushed;
  const Double4 growth = is_crushed ? J - 1.0 : (2.0 * g1 + 4.0 * g2 + 8.0 * g3) / (J + 1.0);
  const Double4 sheared = is_crushed ? g1 - growth : (g1 * growth - 4.0 * g2 - 8.0 * g3) / (J + 1.0);
  for (int lane = 0; lane < 4; ++lane)
    densities[lane] = mu * sheared[lane] + (mu * growth[lane] + neo_hookean::findPressed(mu, lambda, growth[lane]));
}

// psi by law (not kBound or a tangent); of kCorotated with the rotations.
DEFORMABLE_SURFACE_INLINE void findDensities(StressLaw law, double mu, double lambda, const Four& F, const Four& R,
                                             Double4& densities) {
  if (law == StressLaw::kNeoHookean) {
    findNeoHookeanDensities(mu, lambda, F, densities);
    return;
  }
  Double4 square{}, trace{};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      const double rest = r == c ? 1.0 : 0.0;
      const Double4 strain = law == StressLaw::kCorotated ? F.at[r][c] - R.at[r][c] : 0.5 * (F.at[r][c] + F.at[c][r]) - rest;
      square += strain * strain;
      if (law == StressLaw::kCorotated) trace += R.at[r][c] * strain;
      if (law == StressLaw::kLinear && r == c) trace += strain;
    }
  densities = mu * square + 0.5 * lambda * trace * trace;
}

DEFORMABLE_SURFACE_INLINE void addAcross(const PassArrays& a, Four& F) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) F.at[r][c] += a.across[r] * a.across[c];
}

}  // namespace lanes
}  // namespace deformable_surface::model
