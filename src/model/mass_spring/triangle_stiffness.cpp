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

// A function of a symmetric matrix with these eigenvalues, in its directions, from the values at the larger and the smaller one.
// radius: half their difference; mean: half their sum.
Mat2 makeTensor(const Mat2& symmetric, double mean, double radius, double at_larger, double at_smaller) {
  const double slope = radius > 0.0 ? 0.5 * (at_larger - at_smaller) / radius : 0.0;
  return slope * (symmetric - mean * Mat2::Identity()) + 0.5 * (at_larger + at_smaller) * Mat2::Identity();
}

// No eigenvalue is below `lowest`. d2W/dF2 has these eigenvectors (unit, 3 x 2) beside a plain 2 mu on the two remaining strains:
// R / sqrt 2 (dilation), R turned (spin in the plane), and n v^T (tilt out of the plane) for the principal directions v.
void computeBlocks(const Mat32& F, const Mat2& inverse, double area, double mu, double lambda, double lowest, Index element,
                   CornerBlocks& blocks) {
  const Polar p = decompose(F, element);
  // The principal stretches are the eigenvalues of the symmetric S = R^T F.
  Mat2 S = p.rotation.transpose() * F;
  S(0, 1) = S(1, 0) = 0.5 * (S(0, 1) + S(1, 0));
  const double mean = 0.5 * (S(0, 0) + S(1, 1)), difference = 0.5 * (S(0, 0) - S(1, 1));
  const double radius = std::sqrt(difference * difference + S(0, 1) * S(0, 1));
  // c is the effect of the rotation's change.
  const double c = 2.0 * mu - lambda * (p.trace - 2.0);
  const double spin = std::max(lowest, 2.0 * mu - (p.trace > 0.0 ? 2.0 * c / p.trace : 0.0)) - 2.0 * mu;
  const auto findTilt = [&](double stretch) {
    return std::max(lowest, 2.0 * mu - (stretch > 1e-9 ? c / stretch : 0.0)) - 2.0 * mu;
  };
  const Mat2 tilt = makeTensor(S, mean, radius, findTilt(mean + radius), findTilt(mean - radius));

  // Of the second and the third corner: the gradient g of the shape function at rest, and R g along the two modes in the plane.
  const Vec2 g[2] = {inverse.row(0), inverse.row(1)};
  Vec3 dilated[2], spun[2];
  for (int a = 0; a < 2; ++a) {
    dilated[a] = p.rotation * g[a];
    spun[a] = p.rotation * Vec2(-g[a].y(), g[a].x());
  }
  const auto computeBlock = [&](int a, int b) -> Mat3 {
    const Vec3 across = area * g[a].dot(tilt * g[b]) * p.normal;
    Mat3 block = area * lambda * dilated[a] * dilated[b].transpose() + 0.5 * area * spin * spun[a] * spun[b].transpose() +
                 across * p.normal.transpose();
    block.diagonal().array() += 2.0 * area * mu * g[a].dot(g[b]);
    return block;
  };
  // Common motion takes no force: the blocks of a corner add up to zero.
  const Mat3 second = computeBlock(0, 0), mixed = computeBlock(1, 0), third = computeBlock(1, 1);
  blocks[2] = second;
  blocks[4] = mixed;
  blocks[5] = third;
  blocks[1] = -(second + mixed.transpose());
  blocks[3] = -(mixed + third);
  blocks[0] = -(blocks[1] + blocks[3]);
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
    const Mat2 H = makeTensor(C, mean, radius, large, small);
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
