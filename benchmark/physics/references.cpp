#include "references.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
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

// A quarter of the ring, see FlatRing.
struct RingQuarter {
  double curvature = 1.0, constant = -2.5, pressure = 3.0;  // of the widest point; c; P
};
struct RingEnd {
  double angle, slope, curvature, x, y;  // turned; kappa' and kappa there; from the widest point
};

RingEnd integrateRing(const RingQuarter& ring, std::vector<Vec2>* places = nullptr) {
  const double h = 0.5 * std::acos(-1.0) / kSteps;
  // theta from the vertical, kappa, kappa', x, y
  double y[5] = {0.0, ring.curvature, 0.0, 0.0, 0.0};
  const auto slope = [&](const double* at, double* k) {
    k[0] = at[1];
    k[1] = at[2];
    k[2] = at[1] * (ring.constant - 0.5 * at[1] * at[1]) + ring.pressure;
    k[3] = -std::sin(at[0]);
    k[4] = std::cos(at[0]);
  };
  for (int i = 0; i < kSteps; ++i) {
    if (places) places->emplace_back(y[3], y[4]);
    double k1[5], k2[5], k3[5], k4[5], z[5];
    slope(y, k1);
    for (int c = 0; c < 5; ++c) z[c] = y[c] + 0.5 * h * k1[c];
    slope(z, k2);
    for (int c = 0; c < 5; ++c) z[c] = y[c] + 0.5 * h * k2[c];
    slope(z, k3);
    for (int c = 0; c < 5; ++c) z[c] = y[c] + h * k3[c];
    slope(z, k4);
    for (int c = 0; c < 5; ++c) y[c] += h / 6.0 * (k1[c] + 2.0 * k2[c] + 2.0 * k3[c] + k4[c]);
  }
  if (places) places->emplace_back(y[3], y[4]);
  return {y[0], y[2], y[1], y[3], y[4]};
}

// Newton's method on two of the three numbers of a quarter: it turns by a right angle, and `rest` vanishes at its end.
template <class Rest>
void solveQuarter(double RingQuarter::*one, double RingQuarter::*other, const Rest& rest, RingQuarter& ring) {
  constexpr double kDifference = 1e-6;
  const double right = 0.5 * std::acos(-1.0);
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto misses = [&](const RingQuarter& at) {
      const RingEnd end = integrateRing(at);
      return Vec2(end.angle - right, rest(end));
    };
    const Vec2 miss = misses(ring);
    if (miss.norm() < 1e-11) return;
    RingQuarter by_one = ring, by_other = ring;
    by_one.*one += kDifference;
    by_other.*other += kDifference;
    Eigen::Matrix2d slopes;
    slopes << (misses(by_one) - miss) / kDifference, (misses(by_other) - miss) / kDifference;
    const Vec2 change = slopes.inverse() * miss;
    ring.*one -= change[0];
    ring.*other -= change[1];
  }
}

// The free ring, further and further from the circle, until it is that far; `reached` grows from negative to positive.
template <class Reached>
RingQuarter followRing(const Reached& reached) {
  constexpr double kStep = 0.05;  // of the curvature of the widest point
  RingQuarter before, ring;
  const auto solveFree = [](double curvature, RingQuarter& at) {
    at.curvature = curvature;
    solveQuarter(
        &RingQuarter::constant, &RingQuarter::pressure, [](const RingEnd& end) { return end.slope; }, at);
  };
  for (double curvature = 1.0 + kStep; curvature < 4.0; curvature += kStep) {
    before = ring;
    solveFree(curvature, ring);
    if (reached(ring) >= 0.0) break;
  }
  double low = before.curvature, high = ring.curvature;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    solveFree(middle, ring);
    (reached(ring) < 0.0 ? low : high) = middle;
  }
  return ring;
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

FlatRing solveRing(double pressure, double gap) {
  RingQuarter ring =
      followRing([&](const RingQuarter& at) { return std::max(at.pressure - pressure, 0.5 * gap - integrateRing(at).y); });
  if (ring.pressure < pressure - 1e-6) {
    constexpr int kLoads = 20;
    const double first = ring.pressure;
    for (int load = 1; load <= kLoads; ++load) {
      ring.pressure = first + (pressure - first) * load / kLoads;
      solveQuarter(
          &RingQuarter::curvature, &RingQuarter::constant, [&](const RingEnd& end) { return end.y - 0.5 * gap; }, ring);
    }
  }
  FlatRing flat;
  const RingEnd end = integrateRing(ring, &flat.quarter);
  for (Vec2& place : flat.quarter) place.x() -= end.x;
  flat.half_height = end.y;
  flat.half_width = -end.x;
  flat.force = 2.0 * std::abs(end.slope);
  flat.flattest = end.curvature;
  return flat;
}

double findRingPressure(double half_height) {
  return followRing([&](const RingQuarter& at) { return half_height - integrateRing(at).y; }).pressure;
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
