// The second derivative of psi is mu I + s' g g^T + s H, g = cof F, H the second derivative of J. With the singular
// values d1 >= d2 >= |d3| of F, the last with the sign of J, H has the eigenvalues +-d1, +-d2, +-d3 for motions in pairs of axes,
// and for stretches along the axes those of [0 d3 d2; d3 0 d1; d2 d1 0], the roots of x^3 - |F|^2 x - 2 J [Smith et al. 2018].
#include "neo_hookean.h"

#include "deformable_surface/model/elastic_solid/solid_passes.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace deformable_surface::model::neo_hookean {
namespace {

// The largest root of x^3 - square x - 2 J: the largest eigenvalue of H; with -J, that of -H.
double findLargestRoot(double square, double J) {
  const double third = std::sqrt(square / 3.0);
  if (!(third > 0.0)) return 0.0;
  return 2.0 * third * std::cos(std::acos(std::clamp(J / (third * third * third), -1.0, 1.0)) / 3.0);
}

// By Sylvester's rule; the first entry is positive.
bool isPositive(const Mat3& A) { return A.topLeftCorner<2, 2>().determinant() >= 0.0 && A.determinant() >= 0.0; }

}  // namespace

double findPressed(double mu, double lambda, double growth) {
  const double beyond = std::min(0.0, 1.0 + growth - kCrushed) / kCrushed;
  const double logarithm = beyond < 0.0 ? std::log(kCrushed) + beyond * (1.0 - 0.5 * beyond) : std::log1p(growth);
  return 0.5 * lambda * growth * growth - mu * logarithm;
}

Factor findFactor(double mu, double lambda, double J) {
  const double inverse = 1.0 / std::max(J, kCrushed);
  return {lambda * (J - 1.0) - mu * inverse * (1.0 - inverse * std::min(0.0, J - kCrushed)), lambda + mu * inverse * inverse};
}

// Near rest mu (g1 - growth) is a small difference of large numbers. So both come from the invariants of Green's strain G, with
// which J^2 - 1 = 2 g1 + 4 g2 + 8 g3.
double findDensity(double mu, double lambda, const Mat3& F) {
  const Mat3 G = 0.5 * (F.transpose() * F - Mat3::Identity());
  const double J = F.determinant(), g1 = G.trace(), g2 = 0.5 * (g1 * g1 - G.squaredNorm()), g3 = G.determinant();
  const bool is_crushed = J < kCrushed;
  const double growth = is_crushed ? J - 1.0 : (2.0 * g1 + 4.0 * g2 + 8.0 * g3) / (J + 1.0);
  const double sheared = is_crushed ? g1 - growth : (g1 * growth - 4.0 * g2 - 8.0 * g3) / (J + 1.0);
  return mu * sheared + (mu * growth + findPressed(mu, lambda, growth));
}

Mat3 findStress(double mu, double lambda, const Mat3& F) {
  return mu * F + findFactor(mu, lambda, F.determinant()).value * findCofactors(F);
}

Factor limitFactor(double mu, const Mat3& F, Factor s) {
  const double J = F.determinant(), square = F.squaredNorm();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(F.transpose() * F, Eigen::EigenvaluesOnly);
  Vec3 d = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();  // ascending
  if (J < 0.0) d[0] = -d[0];
  const double most = mu / d[2];
  s = {std::clamp(s.value, -most, most), std::max(0.0, s.slope)};
  const Vec3 g(d[1] * d[2], d[2] * d[0], d[0] * d[1]);
  Mat3 stretching = s.slope * g * g.transpose();
  stretching.diagonal().array() += mu;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    stretching(l, m) += s.value * d[k];
    stretching(m, l) += s.value * d[k];
  }
  if (isPositive(stretching)) return s;
  const double least = mu / findLargestRoot(square, s.value > 0.0 ? -J : J);
  s.value = std::clamp(s.value, -least, least);
  return s;
}

// Three kinds of motions: those that keep the volume; those along g, which is nearly an eigenvector, so that what it exchanges
// with others is added; and waves, a n^T, for which H is zero.
double boundStiffening(double mu, double lambda, const Mat3& F) {
  const double J = F.determinant(), square = F.squaredNorm();
  const auto [s, slope] = findFactor(mu, lambda, J);
  const Mat3 C = F.transpose() * F, CC = C * C;
  const double area = findCofactors(F).squaredNorm();
  Eigen::SelfAdjointEigenSolver<Mat3> solver;
  solver.computeDirect(C, Eigen::EigenvaluesOnly);
  const double wave = mu + slope * solver.eigenvalues()[1] * solver.eigenvalues()[2];
  const double shape = mu + std::abs(s) * findLargestRoot(square, s > 0.0 ? J : -J);
  if (!(area > 0.0)) return shape / (2.0 * mu);
  // g^T H g and |H g|^2, over |g|^2.
  const double own = 2.0 * J * square / area;
  const double all = (square * square * square - 2.0 * square * CC.trace() + CC.cwiseProduct(C).sum()) / area;
  const double exchanged = std::abs(s) * std::sqrt(std::max(0.0, all - own * own));
  const double volume = std::max(shape, mu + slope * area + s * own) + exchanged;
  return std::max({shape / (2.0 * mu), volume / (2.0 * mu + 3.0 * lambda), wave / (2.0 * mu + lambda)});
}

}  // namespace deformable_surface::model::neo_hookean
