#include "oriented_motion.h"

#include "deformable_surface/base/simd.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::solve {
namespace {

constexpr double kSmall = 0.04;  // rad^2, of half an angle: below it the series end with terms below rounding

template <class T>
struct Turned {
  T x, y, z, w;
};

// (c, s h) q, brought back to length one by a step of Newton's method: both were unit but for rounding.
template <class T>
DEFORMABLE_SURFACE_INLINE void turn(const T& c, const T& s, const T* h, Turned<T>& q) {
  const T a = s * h[0], b = s * h[1], d = s * h[2];
  const T x = c * q.x + q.w * a + (b * q.z - d * q.y);
  const T y = c * q.y + q.w * b + (d * q.x - a * q.z);
  const T z = c * q.z + q.w * d + (a * q.y - b * q.x);
  const T w = c * q.w - (a * q.x + b * q.y + d * q.z);
  const T scale = 1.5 - 0.5 * (x * x + y * y + z * z + w * w);
  q.x = scale * x;
  q.y = scale * y;
  q.z = scale * z;
  q.w = scale * w;
}

// By twice the vector h, rad, with the series of cos |h| and sin |h| / |h|.
template <class T>
DEFORMABLE_SURFACE_INLINE void turnLittle(const T* h, const T& x, Turned<T>& q) {
  constexpr double kCosine[] = {1.0 / 90, 1.0 / 56, 1.0 / 30, 1.0 / 12, 1.0 / 2};
  constexpr double kSine[] = {1.0 / 110, 1.0 / 72, 1.0 / 42, 1.0 / 20, 1.0 / 6};
  T c = x - x + 1.0, s = c;
  for (int k = 0; k < 5; ++k) {
    c = 1.0 - x * kCosine[k] * c;
    s = 1.0 - x * kSine[k] * s;
  }
  turn(c, s, h, q);
}

DEFORMABLE_SURFACE_INLINE void turnOne(double half, const double* spin, double* q) {
  const double h[3] = {half * spin[0], half * spin[1], half * spin[2]}, x = h[0] * h[0] + h[1] * h[1] + h[2] * h[2];
  Turned<double> turned{q[0], q[1], q[2], q[3]};
  if (x <= kSmall) {
    turnLittle(h, x, turned);
  } else {
    const double angle = std::sqrt(x);
    turn(std::cos(angle), std::sin(angle) / angle, h, turned);
  }
  q[0] = turned.x;
  q[1] = turned.y;
  q[2] = turned.z;
  q[3] = turned.w;
}

// Four points at once. Those that turn far, or not at all, are left to the loop over single ones.
DEFORMABLE_SURFACE_WIDE
void turnRange(Index size, double half, const double* spins, const char* held, double* orientations) {
  Index k = 0;
  for (; k + 4 <= size; k += 4) {
    const double* const spin = spins + 3 * k;
    double* const q = orientations + 4 * k;
    const Double4 h[3] = {half * Double4{spin[0], spin[3], spin[6], spin[9]}, half * Double4{spin[1], spin[4], spin[7], spin[10]},
                          half * Double4{spin[2], spin[5], spin[8], spin[11]}};
    const Double4 x = h[0] * h[0] + h[1] * h[1] + h[2] * h[2];
    const bool all_little = x[0] <= kSmall && x[1] <= kSmall && x[2] <= kSmall && x[3] <= kSmall;
    if (!all_little || (held && (held[k] | held[k + 1] | held[k + 2] | held[k + 3]) != 0)) {
      for (Index i = 0; i < 4; ++i)
        if (!held || held[k + i] == 0) turnOne(half, spin + 3 * i, q + 4 * i);
      continue;
    }
    Turned<Double4> turned;
    load(q, turned.x);
    load(q + 4, turned.y);
    load(q + 8, turned.z);
    load(q + 12, turned.w);
    transpose(turned.x, turned.y, turned.z, turned.w);
    turnLittle(h, x, turned);
    transpose(turned.x, turned.y, turned.z, turned.w);
    store(turned.x, q);
    store(turned.y, q + 4);
    store(turned.z, q + 8);
    store(turned.w, q + 12);
  }
  for (; k < size; ++k)
    if (!held || held[k] == 0) turnOne(half, spins + 3 * k, orientations + 4 * k);
}

}  // namespace

void turnPoints(Index begin, Index end, double dt, const Points& spins, const char* held, Orientations& orientations) {
  static_assert(sizeof(Quaternion) == 4 * sizeof(double));
  if (begin == end) return;
  turnRange(end - begin, 0.5 * dt, spins[begin].data(), held ? held + begin : nullptr, orientations[begin].coeffs().data());
}

DEFORMABLE_SURFACE_WIDE void kickFirst(Index size, HalfKicks half, const double* force, double* velocity) {
#pragma GCC ivdep
  for (Index k = 0; k < size; ++k) velocity[k] = half.decay[k] * velocity[k] + half.kick[k] * force[k];
}

DEFORMABLE_SURFACE_WIDE void kickLast(Index size, HalfKicks half, const double* force, double* velocity) {
#pragma GCC ivdep
  for (Index k = 0; k < size; ++k) velocity[k] = half.decay[k] * (velocity[k] + half.kick[k] * force[k]);
}

DEFORMABLE_SURFACE_WIDE void kickTwice(Index size, HalfKicks half, const double* force, double* velocity) {
#pragma GCC ivdep
  for (Index k = 0; k < size; ++k) {
    const double kick = half.kick[k] * force[k], decay = half.decay[k];
    velocity[k] = decay * (decay * (velocity[k] + kick)) + kick;
  }
}

DEFORMABLE_SURFACE_WIDE void drift(Index size, double dt, HalfKicks half, const double* force, const double* velocity,
                                   double* position, double* predicted) {
#pragma GCC ivdep
  for (Index k = 0; k < size; ++k) {
    position[k] += dt * velocity[k];
    predicted[k] = half.decay[k] * (velocity[k] + half.kick[k] * force[k]);
  }
}

}  // namespace deformable_surface::solve
