#include "references.h"

#include <Eigen/Cholesky>

#include <cmath>
#include <vector>

namespace deformable_surface::physics {
namespace {

constexpr int kSteps = 2000;     // of the fourth-order integration: errors below the digits that are compared
constexpr int kBisections = 80;  // more than the bits of a double
constexpr int kTerms = 60;       // of Hencky's series, whose terms fall like powers of a third

// Of each side: (1 - xi^2)^2 xi^(2 i), xi from -1 to 1.
constexpr int kShapes = 6;
constexpr int kDegree = 4 + 2 * (kShapes - 1);
using Polynomial = Eigen::Matrix<double, kDegree + 1, 1>;

Polynomial shapeAcross(int i) {
  Polynomial shape = Polynomial::Zero();
  shape[2 * i] = 1.0;
  shape[2 * i + 2] = -2.0;
  shape[2 * i + 4] = 1.0;
  return shape;
}

Polynomial differentiate(const Polynomial& p) {
  Polynomial slope = Polynomial::Zero();
  for (int k = 1; k <= kDegree; ++k) slope[k - 1] = k * p[k];
  return slope;
}

double integrateProduct(const Polynomial& p, const Polynomial& q) {
  double sum = 0.0;
  for (int k = 0; k <= kDegree; ++k)
    for (int l = k % 2; l <= kDegree; l += 2) sum += 2.0 * p[k] * q[l] / (k + l + 1.0);
  return sum;
}

}  // namespace

// Shooting from the free end, in the angle from the vertical, phi = pi / 2 - theta: for heavy strips it is exponentially small
// there, so that its logarithm is bisected.
ElasticaTip solveElastica(double gamma, double force) {
  const double h = 1.0 / kSteps;
  double low = std::log(1e-300), high = std::log(0.5 * std::acos(-1.0));
  ElasticaTip tip;
  for (int iteration = 0; iteration < kBisections; ++iteration) {
    const double middle = 0.5 * (low + high);
    // phi, phi', droop, reach over the distance t from the free end.
    double y[4] = {std::exp(middle), 0.0, 0.0, 0.0};
    const auto slope = [&](double t, const double* at, double* k) {
      k[0] = at[1];
      k[1] = (gamma * t + force) * std::sin(at[0]);
      k[2] = std::cos(at[0]);
      k[3] = std::sin(at[0]);
    };
    for (int i = 0; i < kSteps && y[0] < 4.0; ++i) {
      const double t = i * h;
      double k1[4], k2[4], k3[4], k4[4], z[4];
      slope(t, y, k1);
      for (int c = 0; c < 4; ++c) z[c] = y[c] + 0.5 * h * k1[c];
      slope(t + 0.5 * h, z, k2);
      for (int c = 0; c < 4; ++c) z[c] = y[c] + 0.5 * h * k2[c];
      slope(t + 0.5 * h, z, k3);
      for (int c = 0; c < 4; ++c) z[c] = y[c] + h * k3[c];
      slope(t + h, z, k4);
      for (int c = 0; c < 4; ++c) y[c] += h / 6.0 * (k1[c] + 2.0 * k2[c] + 2.0 * k3[c] + k4[c]);
    }
    (y[0] < 0.5 * std::acos(-1.0) ? low : high) = middle;
    tip = {y[2], y[3]};
  }
  return tip;
}

double solveHencky(double poisson_ratio) {
  // The coefficients for b_0, and those of 1 / B.
  std::vector<double> b(kTerms), inverse(kTerms);
  const auto expand = [&](double first) {
    b[0] = first;
    inverse[0] = 1.0 / first;
    for (int n = 1; n < kTerms; ++n) {
      double square = 0.0;  // the coefficient n - 1 of 1 / B^2
      for (int k = 0; k < n; ++k) square += inverse[k] * inverse[n - 1 - k];
      b[n] = -2.0 * square / (n * (n + 1.0));
      double sum = 0.0;
      for (int k = 0; k < n; ++k) sum += inverse[k] * b[n - k];
      inverse[n] = -sum / first;
    }
  };
  const auto edge = [&](double first) {
    expand(first);
    double sum = 0.0;
    for (int n = 0; n < kTerms; ++n) sum += (2.0 * n + 1.0 - poisson_ratio) * b[n];
    return sum;
  };
  double low = 1.5, high = 2.5;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (edge(middle) < 0.0 ? low : high) = middle;
  }
  expand(0.5 * (low + high));
  double height = 0.0;
  for (int n = 0; n < kTerms; ++n) height += inverse[n] / (n + 1.0);
  return height;
}

double ElasticCable::x(double s, double tension) const {
  const double up = 0.5 * weight;
  return tension * s / stiffness +
         tension * length / weight * (std::asinh(up / tension) - std::asinh((up - weight * s / length) / tension));
}

double ElasticCable::z(double s, double tension) const {
  const double up = 0.5 * weight;
  const auto root = [](double q) { return std::sqrt(1.0 + q * q); };
  return weight * s / stiffness * (0.5 - 0.5 * s / length) +
         tension * length / weight * (root(up / tension) - root((up - weight * s / length) / tension));
}

double ElasticCable::solveTension(double span) const {
  double low = 1e-6 * weight, high = 1e6 * weight;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = std::sqrt(low * high);
    (x(length, middle) < span ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

double sagCantilever(double s, double time) {
  double w = s * s * (6.0 - 4.0 * s + s * s) / 24.0;
  if (time == kAtRest) return w;
  // Roots of cos b cosh b = -1; of the ninth the amplitude is a millionth of the first's.
  for (const double b :
       {1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349, 14.1371683910, 17.2787595321, 20.4203522510, 23.5619449018}) {
    const double sigma = (std::sinh(b) - std::sin(b)) / (std::cosh(b) + std::cos(b));
    const double mode = std::cosh(b * s) - std::cos(b * s) - sigma * (std::sinh(b * s) - std::sin(b * s));
    w -= 2.0 * sigma / std::pow(b, 5) * mode * std::cos(b * b * time);
  }
  return w;
}

ClampedPlate::ClampedPlate() {
  // Over xi: int phi phi, int phi'' phi, int phi'' phi'', int phi.
  Eigen::MatrixXd mass(kShapes, kShapes), mixed(kShapes, kShapes), bending(kShapes, kShapes);
  Eigen::VectorXd load(kShapes);
  Polynomial one = Polynomial::Zero();
  one[0] = 1.0;
  for (int i = 0; i < kShapes; ++i) {
    const Polynomial p = shapeAcross(i), second = differentiate(differentiate(p));
    load[i] = integrateProduct(p, one);
    for (int k = 0; k < kShapes; ++k) {
      const Polynomial q = shapeAcross(k);
      mass(i, k) = integrateProduct(p, q);
      mixed(i, k) = integrateProduct(second, q);
      bending(i, k) = integrateProduct(second, differentiate(differentiate(q)));
    }
  }
  // xi = 2 x - 1: second derivatives by x are four times as large, so the load is a sixteenth.
  Eigen::MatrixXd stiffness(kShapes * kShapes, kShapes * kShapes);
  Eigen::VectorXd right(kShapes * kShapes);
  for (int i = 0; i < kShapes; ++i)
    for (int j = 0; j < kShapes; ++j) {
      right[i * kShapes + j] = load[i] * load[j] / 16.0;
      for (int k = 0; k < kShapes; ++k)
        for (int l = 0; l < kShapes; ++l)
          stiffness(i * kShapes + j, k * kShapes + l) =
              bending(i, k) * mass(j, l) + 2.0 * mixed(i, k) * mixed(j, l) + mass(i, k) * bending(j, l);
    }
  const Eigen::VectorXd solution = stiffness.ldlt().solve(right);
  amplitudes_ = Eigen::Map<const Eigen::Matrix<double, kShapes, kShapes>>(solution.data());
}

double ClampedPlate::operator()(double x, double y) const {
  const double xi = 2.0 * x - 1.0, eta = 2.0 * y - 1.0;
  if (!(std::abs(xi) < 1.0 && std::abs(eta) < 1.0)) return 0.0;
  double sum = 0.0;
  for (int i = 0; i < kShapes; ++i)
    for (int j = 0; j < kShapes; ++j) sum += amplitudes_(i, j) * std::pow(xi, 2 * i) * std::pow(eta, 2 * j);
  return sum * std::pow((1.0 - xi * xi) * (1.0 - eta * eta), 2);
}

}  // namespace deformable_surface::physics
