// Bounds of the stiffness of kept bonds, four triangles at once.
#include "deformable_surface/base/parallel.h"
#include "kept_triangles.h"

#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 256;
constexpr Index kFours = kBlock / 4;
constexpr int kStrains = 9;  // three e, c and s

DEFORMABLE_SURFACE_INLINE void cross(const Double4* a, const Double4* b, Double4* product) {
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

DEFORMABLE_SURFACE_INLINE void dot(const Double4* a, const Double4* b, Double4& product) {
  product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// G M^-1 G^T with masses of one, rows and columns e, c, s by edges.
DEFORMABLE_SURFACE_INLINE void multiplyGradients(const DeformedTriangles& d, double by_inertia,
                                                 Double4 (&product)[kStrains][kStrains]) {
  Double4 moved[3][3][3];                         // of strain, edge: by the place of the last end
  Double4 turned_first[3][3], turned_last[3][3];  // of u by turning the normals at both ends
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    for (int x = 0; x < 3; ++x) {
      moved[0][a][x] = d.r[a][x] * d.inverse[a];
      moved[1][a][x] = d.normal[b][x] - d.normal[a][x];
      moved[2][a][x] = 0.5 * (d.normal[a][x] + d.normal[b][x]);
    }
    cross(d.normal[a], d.r[a], turned_first[a]);
    cross(d.normal[b], d.r[a], turned_last[a]);
  }
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    for (int p = 0; p < 3; ++p)
      for (int q = 0; q < 3; ++q) {
        Double4 same, next;
        dot(moved[p][a], moved[q][a], same);
        dot(moved[p][a], moved[q][b], next);
        product[3 * p + a][3 * q + a] = 2.0 * same;
        product[3 * p + a][3 * q + b] = product[3 * q + b][3 * p + a] = -next;
      }
    Double4 first, last, next;
    dot(turned_first[a], turned_first[a], first);
    dot(turned_last[a], turned_last[a], last);
    dot(turned_last[a], turned_first[b], next);
    first *= by_inertia;
    last *= by_inertia;
    next *= by_inertia;
    product[3 + a][3 + a] += first + last;
    product[6 + a][6 + a] += 0.25 * (first + last);
    const Double4 mixed = 0.5 * (last - first);
    product[3 + a][6 + a] += mixed;
    product[6 + a][3 + a] += mixed;
    // The normal between the two edges is at the last end of one and at the first of the other.
    const Double4 half = 0.5 * next;
    product[3 + a][3 + b] -= next;
    product[3 + a][6 + b] += half;
    product[6 + a][3 + b] -= half;
    product[6 + a][6 + b] += 0.5 * half;
    for (int p = 1; p < 3; ++p)
      for (int q = 1; q < 3; ++q) product[3 * q + b][3 * p + a] = product[3 * p + a][3 * q + b];
  }
}

// S v for the strains; tension: of bonds, N/m, which acts in all directions and is not counted along the bond again.
DEFORMABLE_SURFACE_INLINE void multiplyStiffness(const PresentBonds::FourTriangles& t, const DeformedTriangles& d,
                                                 const Double4* tension, const Double4 (&v)[kStrains][kStrains],
                                                 Double4 (&product)[kStrains][kStrains]) {
  for (int q = 0; q < kStrains; ++q) {
    const Double4 e[3] = {v[0][q], v[1][q], v[2][q]}, c[3] = {v[3][q], v[4][q], v[5][q]};
    Double4 by_e[3], by_c[3];
    multiply(t.stretching, d.held, e, by_e);
    multiply(t.bending, d.smooth, c, by_c);
    for (int a = 0; a < 3; ++a) {
      product[a][q] = by_e[a] - tension[a] * e[a];
      product[3 + a][q] = by_c[a];
      product[6 + a][q] = d.shearing[a] * v[6 + a][q];
    }
  }
}

// The trace of the square of a matrix.
DEFORMABLE_SURFACE_INLINE void squareTrace(const Double4 (&matrix)[kStrains][kStrains], Double4& trace) {
  trace = matrix[0][0] * matrix[0][0];
  for (int p = 1; p < kStrains; ++p) {
    Double4 beside = matrix[p][0] * matrix[0][p];
    for (int q = 1; q < p; ++q) beside += matrix[p][q] * matrix[q][p];
    trace += matrix[p][p] * matrix[p][p] + 2.0 * beside;
  }
}

// A bound of the absolute eigenvalues of S N, N symmetric, from the mean and the deviation of their squares [Wolkowicz 1980].
DEFORMABLE_SURFACE_INLINE void boundEigenvalue(const PresentBonds::FourTriangles& t, const DeformedTriangles& d,
                                               const Double4* tension, Double4 (&gradients)[kStrains][kStrains], Double4& bound) {
  Double4 matrix[kStrains][kStrains];
  multiplyStiffness(t, d, tension, gradients, matrix);
  const Double4 zero = matrix[0][0] - matrix[0][0], one = zero + 1.0;
  Double4 squares, fourths;
  squareTrace(matrix, squares);
  const Double4 shrink = (squares > zero ? one : zero) / (squares > zero ? squares : one);
  // N S N S has the trace of (S N)^2, and is a symmetric matrix times S.
  Double4 inner[kStrains][kStrains];
  for (int p = 0; p < kStrains; ++p)
    for (int q = 0; q <= p; ++q) {
      inner[p][q] = gradients[p][0] * matrix[0][q];
      for (int k = 1; k < kStrains; ++k) inner[p][q] += gradients[p][k] * matrix[k][q];
      inner[p][q] *= shrink;
      inner[q][p] = inner[p][q];
    }
  multiplyStiffness(t, d, tension, inner, matrix);
  squareTrace(matrix, fourths);  // over the square of the trace of squares
  constexpr double kMean = 1.0 / kStrains;
  Double4 deviation = kMean * fourths - kMean * kMean;
  deviation = deviation > zero ? deviation : zero;
  takeRoots(deviation);
  bound = squares * (kMean + std::sqrt(kStrains - 1.0) * deviation);
  bound = bound > zero ? bound : zero;
  takeRoots(bound);
}

// The largest eigenvalue of three bonds with a tension in all directions, from the trace and the sum of minors: one of the three
// is zero.
DEFORMABLE_SURFACE_INLINE void findOfTension(const Double4* tension, Double4& largest) {
  const Double4 sum = tension[0] + tension[1] + tension[2], zero = sum - sum;
  Double4 root = sum * sum - 3.0 * (tension[0] * tension[1] + tension[1] * tension[2] + tension[2] * tension[0]);
  root = root > zero ? root : zero;
  takeRoots(root);
  largest = sum + root;
}

// A bound of what slopes of the energy add, f at first ends and l at last ends of edges: for the normal n of a corner with the
// edge r_a to it and r_b from it, (f n.r_b + l n.r_a) to second order. With the corner turned by w and moved by x this is (w x
// n).(f (x_next - x) + l (x - x_last)), of all corners at most the root of the squares of the factors of x, and -w^2 (f n.r_b + l
// n.r_a) / 2. Turns about the normal itself change nothing. The largest eigenvalue of the factors in place of that root saved no
// sub-step of a tissue, and one of 1000 crumpled states then stiffened too much within four sub-steps.
DEFORMABLE_SURFACE_INLINE void boundBySlopes(const DeformedTriangles& d, double by_inertia, Double4& bound) {
  const Double4 zero = d.e[0] - d.e[0];
  Double4 first[3], last[3], squares = zero, turned = zero;
  for (int a = 0; a < 3; ++a) {
    const Double4 sheared = 0.5 * d.by_s[a];
    first[a] = sheared - d.by_c[a];
    last[a] = sheared + d.by_c[a];
  }
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const Double4 mine = last[a] - first[b];
    squares += first[b] * first[b] + last[a] * last[a] + mine * mine;
    const Double4 curved = -(first[b] * d.u_first[b] + last[a] * d.u_last[a]);
    turned = curved > turned ? curved : turned;
  }
  bound = by_inertia * squares;
  takeRoots(bound);
  bound += by_inertia * turned;
}

DEFORMABLE_SURFACE_WIDE
void boundTriangles(const PackedParticles& particles, const PresentBonds::FourTriangles* fours, double by_inertia, Index begin,
                    Index end, double* bounds) {
  for (Index k = begin; k < end; ++k) {
    const PresentBonds::FourTriangles& t = fours[k];
    DeformedTriangles d;
    deform(particles, t, d);
    const Double4 zero = d.e[0] - d.e[0];
    Double4 tension[3];
    for (int a = 0; a < 3; ++a) {
      const Double4 pull = d.by_e[a] * d.inverse[a];
      tension[a] = pull > zero ? pull : zero;
    }
    Double4 gradients[kStrains][kStrains], stretched, by_tension, by_slopes;
    multiplyGradients(d, by_inertia, gradients);
    boundEigenvalue(t, d, tension, gradients, stretched);
    findOfTension(tension, by_tension);
    boundBySlopes(d, by_inertia, by_slopes);
    store(stretched + by_tension + by_slopes, bounds + 4 * static_cast<std::ptrdiff_t>(k));
  }
}

}  // namespace

void PresentBonds::addRowBounds(const PackedParticles& particles, double inertia_by_mass, std::vector<double>& bounds) const {
  parallelFor(static_cast<Index>(fours_.size()), kFours, [&](Index begin, Index end) {
    boundTriangles(particles, fours_.data(), 1.0 / inertia_by_mass, begin, end, triangle_bounds_.data());
  });
  parallelFor(static_cast<Index>(bounds.size()), kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      for (Index k = corner_begins_[i]; k < corner_begins_[i + 1]; ++k) bounds[i] += triangle_bounds_[corners_[k] / 3];
  });
}

}  // namespace deformable_surface::model
