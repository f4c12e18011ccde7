// The stiffness of the triangles, and the springs along their edges that stand for it.
#include "deformable_surface/model/mass_spring/triangle_membrane.h"

#include "deformable_surface/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "triangle_polar.h"

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 32;   // triangles per task: ten microseconds of work
constexpr Index kChunk = 256;  // two of them fit the second-level cache

// Of the three corners in the plane at rest, where inverse is that of the edges from the first.
std::array<Vec2, 3> findShapeGradients(const Mat2& inverse) {
  return {Vec2(-(inverse.row(0) + inverse.row(1))), Vec2(inverse.row(0)), Vec2(inverse.row(1))};
}

// Of the corners (0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2) of a triangle, N/m.
using CornerBlocks = std::array<Mat3, 6>;

// No eigenvalue is below `lowest`.
void computeBlocks(const Mat32& F, const Mat2& inverse, double area, double mu, double lambda, double lowest, Index element,
                   CornerBlocks& blocks) {
  const Polar p = decompose(F, element);

  // Principal stretches and directions: S = R^T F is symmetric.
  const Mat2 S = p.rotation.transpose() * F;
  const double mean = 0.5 * (S(0, 0) + S(1, 1)), difference = 0.5 * (S(0, 0) - S(1, 1));
  const double offdiagonal = 0.5 * (S(0, 1) + S(1, 0));
  const double radius = std::hypot(difference, offdiagonal);
  const double angle = 0.5 * std::atan2(offdiagonal, difference);
  const Vec2 v[2] = {Vec2(std::cos(angle), std::sin(angle)), Vec2(-std::sin(angle), std::cos(angle))};
  const double stretch[2] = {mean + radius, mean - radius};

  // d2W/dF2 has these eigenvectors (unit, 3 x 2) beside a plain 2 mu on the two remaining strains: R / sqrt 2 (dilation), R
  // turned (spin in the plane), and n v_k^T (tilt out of the plane). c is the effect of the rotation's change.
  const double c = 2.0 * mu - lambda * (p.trace - 2.0);
  const double spin = std::max(lowest, 2.0 * mu - (p.trace > 0.0 ? 2.0 * c / p.trace : 0.0)) - 2.0 * mu;
  Mat2 turn;
  turn << 0.0, -1.0, 1.0, 0.0;
  const Mat32 spin_mode = p.rotation * turn / std::sqrt(2.0), dilation_mode = p.rotation / std::sqrt(2.0);
  double tilt[2];
  for (int k = 0; k < 2; ++k) tilt[k] = std::max(lowest, 2.0 * mu - (stretch[k] > 1e-9 ? c / stretch[k] : 0.0)) - 2.0 * mu;

  // Shape function gradients of the corners in the plane at rest.
  Vec2 g[3];
  g[1] = inverse.row(0);
  g[2] = inverse.row(1);
  g[0] = -g[1] - g[2];
  for (int a = 0, place = 0; a < 3; ++a)
    for (int b = 0; b <= a; ++b) {
      Mat3 block = 2.0 * mu * g[a].dot(g[b]) * Mat3::Identity();
      block += 2.0 * lambda * (dilation_mode * g[a]) * (dilation_mode * g[b]).transpose();
      block += spin * (spin_mode * g[a]) * (spin_mode * g[b]).transpose();
      for (int k = 0; k < 2; ++k) block += tilt[k] * v[k].dot(g[a]) * v[k].dot(g[b]) * p.normal * p.normal.transpose();
      blocks[place++] = area * block;
    }
}

}  // namespace

// Computed by all threads, a chunk of triangles at a time. One of them meanwhile adds the chunk before, in the order of the
// triangles.
void TriangleMembrane::addStiffness(const State& state, Hessian hessian, BlockSparse& stiffness) const {
  const double lowest = hessian == Hessian::kPositive ? 0.0 : -std::numeric_limits<double>::infinity();
  const Index n = static_cast<Index>(elements_.size());
  std::array<CornerBlocks, kChunk> chunks[2];
  const auto compute = [&](Index begin, Index end, std::array<CornerBlocks, kChunk>& blocks) {
    for (Index t = begin; t < end; ++t) {
      const Element& e = elements_[t];
      computeBlocks(gradient(e, state), e.inverse, e.area, mu_, lambda_, lowest, t, blocks[t % kChunk]);
    }
  };
  const auto add = [&](Index begin, Index end, const std::array<CornerBlocks, kChunk>& blocks) {
    for (Index t = begin; t < end; ++t) {
      const Index* const corner = elements_[t].corner;
      for (int a = 0, place = 0; a < 3; ++a)
        for (int b = 0; b <= a; ++b) stiffness.add(corner[a], corner[b], blocks[t % kChunk][place++]);
    }
  };
  for (Index first = 0; first < n + kChunk; first += kChunk) {
    const Index size = std::clamp(n - first, Index{0}, kChunk), parity = first / kChunk % 2;
    parallelFor((size + kBlock - 1) / kBlock + 1, 1, [&](Index task, Index) {
      const Index begin = first + (task - 1) * kBlock;
      if (task > 0)
        compute(begin, std::min(begin + kBlock, first + size), chunks[parity]);
      else if (first > 0)
        add(first - kChunk, std::min(first, n), chunks[1 - parity]);
    });
  }
}

// A wave in the plane is resisted by 2 mu + lambda in stretching and by mu in shearing: their mean.
void TriangleMembrane::computeSpringsAlong(std::vector<double>& stiffness) const {
  stiffness.clear();
  stiffness.reserve(3 * elements_.size());
  for (const Element& e : elements_) {
    const auto g = findShapeGradients(e.inverse);
    for (int c = 0; c < 3; ++c) stiffness.push_back(-0.5 * (3.0 * mu_ + lambda_) * e.area * g[c].dot(g[(c + 1) % 3]));
  }
}

// The tilt modes of addStiffness() without their direction. Pressure, which would buckle, counts as zero.
void TriangleMembrane::computeSpringsAcross(const State& state, std::vector<double>& stiffness) const {
  stiffness.resize(3 * elements_.size());
  for (std::size_t t = 0; t < elements_.size(); ++t) {
    const Element& e = elements_[t];
    const Mat32 F = gradient(e, state);
    const double J = F.col(0).cross(F.col(1)).norm(), trace = std::sqrt(F.squaredNorm() + 2.0 * J);
    // The squares of the stretches are the eigenvalues of F^T F.
    const Mat2 C = F.transpose() * F;
    const double mean = 0.5 * (C(0, 0) + C(1, 1)), radius = std::hypot(0.5 * (C(0, 0) - C(1, 1)), C(0, 1));
    const double c = 2.0 * mu_ - lambda_ * (trace - 2.0);
    const auto findTension = [&](double squared) {
      return squared > 1e-18 ? std::max(0.0, 2.0 * mu_ - c / std::sqrt(squared)) : 0.0;
    };
    const double large = findTension(mean + radius), small = findTension(mean - radius);
    // The tensor with these eigenvalues in the directions of those of C.
    const double slope = radius > 0.0 ? 0.5 * (large - small) / radius : 0.0;
    const Mat2 H = slope * (C - mean * Mat2::Identity()) + 0.5 * (large + small) * Mat2::Identity();
    const auto g = findShapeGradients(e.inverse);
    for (int k = 0; k < 3; ++k) stiffness[3 * t + k] = -e.area * g[k].dot(H * g[(k + 1) % 3]);
  }
}

void TriangleMembrane::addRowBounds(std::vector<double>& stiffness) const {
  const double largest = 2.0 * mu_ + 2.0 * std::max(0.0, lambda_);
  for (const Element& e : elements_) {
    const Vec2 g1 = e.inverse.row(0), g2 = e.inverse.row(1);
    const double norm[3] = {(g1 + g2).norm(), g1.norm(), g2.norm()};
    const double sum = norm[0] + norm[1] + norm[2];
    for (int c = 0; c < 3; ++c) stiffness[e.corner[c]] += e.area * largest * norm[c] * sum;
  }
}

}  // namespace deformable_surface::model
