// Point sets with parts that are close in space and far apart along the surface, with the part of each point, for tests and
// measurements of geodesics.
#pragma once

#include "deformable_surface/cloud/geodesics.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace deformable_surface::test {

struct Gapped {
  Points positions, normals;
  std::vector<int> part;       // points of different parts are not to be linked; -1 = do not ask
  std::vector<char> is_asked;  // far from what joins the parts, and from other ends

  void add(const Vec3& position, const Vec3& normal, int of_part, bool asked) {
    positions.push_back(position);
    normals.push_back(normal);
    part.push_back(of_part);
    is_asked.push_back(asked);
  }
};

class Jitter {
 public:
  Jitter(double share, unsigned seed) : share_(share), random_(seed) {}
  double draw() { return share_ * (static_cast<double>(random_()) / 2147483648.0 - 1.0); }

 private:
  double share_;
  std::mt19937 random_;
};

/// Two bars of five rows and fifty columns in the x-z plane, joined over the first five columns; spacing 1, `layers` of them in
/// y. Rows beside the gap are not moved across it, so the gap has the stated width.
inline Gapped makeTwoBars(double gap, double share, int layers = 1, unsigned seed = 1) {
  constexpr int kColumns = 50, kRows = 5, kFarFromJoint = 18;
  Gapped bars;
  Jitter jitter(share, seed);
  const int filling = std::max(0, static_cast<int>(std::lround(gap)) - 1);
  for (int layer = 0; layer < layers; ++layer) {
    for (int i = 0; i < kColumns; ++i) {
      for (int row = 0; row < 2 * kRows + filling; ++row) {
        const bool is_lower = row < kRows, is_upper = row >= kRows + filling;
        const bool is_edge = row == kRows - 1 || row == kRows + filling;
        if (!is_lower && !is_upper && i >= kRows) continue;
        const double dx = jitter.draw(), dy = layers > 1 ? jitter.draw() : 0.0, dz = jitter.draw();
        double z = row;
        if (!is_lower) z = kRows - 1 + (is_upper ? gap + (row - kRows - filling) : gap * (row - kRows + 1) / (filling + 1));
        bars.add(Vec3(i + dx, layer + dy, z + (is_edge ? 0.0 : dz)), Vec3::UnitY(),
                 is_lower   ? 0
                 : is_upper ? 1
                            : -1,
                 i >= kFarFromJoint);
      }
    }
  }
  return bars;
}

/// Sheets of spacing 1 above each other, displaced so that points do not face each other. Normals point up, or, for a body,
/// outward: down on the lowest one; a body has a rim.
inline Gapped makeStack(int sheets, double gap, double share, bool is_body, unsigned seed = 1) {
  constexpr int kSide = 40, kMargin = 7;
  Gapped stack;
  Jitter jitter(share, seed);
  for (int s = 0; s < sheets; ++s) {
    for (int i = 0; i < kSide; ++i) {
      for (int j = 0; j < kSide; ++j) {
        const double dx = jitter.draw(), dy = jitter.draw();
        const bool is_inside = std::min({i, j, kSide - 1 - i, kSide - 1 - j}) >= kMargin;
        const Vec3 normal(0.0, 0.0, is_body && s == 0 ? -1.0 : 1.0);
        stack.add(Vec3(i + 0.3 * (s % 2) + dx, j + 0.2 * (s % 2) + dy, s * gap), normal, s, is_inside);
      }
    }
  }
  for (int t = 0; is_body && t < kSide; ++t) {
    const double z = 0.5 * gap, far = kSide - 0.4;
    stack.add(Vec3(-0.4, t, z), Vec3(-1, 0, 0), -1, false);
    stack.add(Vec3(far, t, z), Vec3(1, 0, 0), -1, false);
    stack.add(Vec3(t, -0.4, z), Vec3(0, -1, 0), -1, false);
    stack.add(Vec3(t, far, z), Vec3(0, 1, 0), -1, false);
  }
  return stack;
}

/// A sheet of spacing 1 folded over along y: two leaves joined by a half circle. Normals follow the sheet.
inline Gapped makeFold(double gap, double share, unsigned seed = 1) {
  constexpr int kLength = 24, kWidth = 30, kFarFromFold = 8, kFarFromEdge = 4;
  Gapped fold;
  Jitter jitter(share, seed);
  const double radius = 0.5 * gap, arc = std::acos(-1.0) * radius;
  for (int i = -kLength; i <= kLength; ++i) {
    for (int j = 0; j < kWidth; ++j) {
      const double u = i + jitter.draw(), v = j + jitter.draw();  // along the unfolded sheet; the bend is about u = 0
      const bool asked = std::abs(i) >= kFarFromFold && std::min({kLength - std::abs(i), j, kWidth - 1 - j}) >= kFarFromEdge;
      const double angle = std::min(std::max(u, -0.5 * arc), 0.5 * arc) / radius, beyond = std::abs(u) - 0.5 * arc;
      const Vec3 outward(-std::cos(angle), 0.0, std::sin(angle));
      fold.add(radius * outward + Vec3(std::max(beyond, 0.0), v, 0.0), outward, i < 0 ? 0 : 1, asked);
    }
  }
  return fold;
}

/// Two legs of a pair of trousers, upright and round: points spaced 1 around them and `along` upwards. Normals point outward.
inline Gapped makeLegs(double radius, double along, double gap, double share, unsigned seed = 1) {
  constexpr int kRows = 16, kFarFromEnd = 4;
  Gapped legs;
  Jitter jitter(share, seed);
  const double turn = 2.0 * std::acos(-1.0);
  const int around = static_cast<int>(std::lround(turn * radius));
  for (int leg = 0; leg < 2; ++leg) {
    for (int row = 0; row < kRows; ++row) {
      for (int k = 0; k < around; ++k) {
        const double angle = turn * (k + 0.5 * (row % 2) + jitter.draw()) / around;
        const Vec3 outward(std::cos(angle), std::sin(angle), 0.0), beside(radius + 0.5 * gap, 0.0, 0.0);
        legs.add((leg == 0 ? -1.0 : 1.0) * beside + radius * outward + Vec3(0.0, 0.0, along * (row + jitter.draw())), outward,
                 leg, std::min(row, kRows - 1 - row) >= kFarFromEnd);
      }
    }
  }
  return legs;
}

/// Without a share of the points, at random: a sampling with holes, whose density varies from place to place.
inline Gapped dropPoints(const Gapped& cloud, double share, unsigned seed = 1) {
  Gapped left;
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < cloud.positions.size(); ++i)
    if (static_cast<double>(random()) >= share * 4294967296.0)
      left.add(cloud.positions[i], cloud.normals[i], cloud.part[i], cloud.is_asked[i] != 0);
  return left;
}

/// The remaining coupling of neighbours, (sum of kernel times weight) / (sum of kernel), over the pairs in question: within a
/// part, and across. The kernel is Wendland's C2, as wide as the longest pair of a point, because models couple near pairs more
/// than far ones.
struct Coupling {
  double within = 0.0, across = 0.0;
};
inline Coupling measureCoupling(const Gapped& cloud, const Lists& links, const std::vector<double>& weight) {
  Coupling sum, all;
  const auto measure = [&](Index i, Index e) { return (cloud.positions[links.items[e]] - cloud.positions[i]).norm(); };
  for (Index i = 0; i < links.size(); ++i) {
    double longest = 0.0;
    for (Index e = links.offsets[i]; e < links.offsets[i + 1]; ++e) longest = std::max(longest, measure(i, e));
    for (Index e = links.offsets[i]; e < links.offsets[i + 1]; ++e) {
      const Index j = links.items[e];
      if (!cloud.is_asked[i] || !cloud.is_asked[j]) continue;
      const double s = measure(i, e) / longest, kernel = std::pow(1.0 - s, 4) * (4.0 * s + 1.0);
      (cloud.part[i] == cloud.part[j] ? sum.within : sum.across) += kernel * weight[e];
      (cloud.part[i] == cloud.part[j] ? all.within : all.across) += kernel;
    }
  }
  return {sum.within / all.within, all.across > 0.0 ? sum.across / all.across : 0.0};
}

}  // namespace deformable_surface::test
