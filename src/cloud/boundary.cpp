// Boundary and corner points, found by the angles at which a point sees its neighbours on the tangent plane.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/cloud/rings.h"
#include "wide_gaps.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_surface::cloud {
namespace {

// A corner turns by more than half a right angle; a rounded outline, sampled with as few as eight points, does not.
constexpr double kCornerTurn = kPi / 4.0;

struct Gap {
  double width = 2.0 * kPi;  // rad
  double middle = 0.0;       // rad, direction of its bisector
};

// The widest angle without neighbours. angles is reordered.
Gap findWidestGap(std::vector<double>& angles) {
  Gap gap;
  if (angles.empty()) return gap;
  std::sort(angles.begin(), angles.end());
  gap.width = 0.0;
  for (std::size_t a = 0; a < angles.size(); ++a) {
    const double next = a + 1 < angles.size() ? angles[a + 1] : angles[0] + 2.0 * kPi;
    if (next - angles[a] > gap.width) gap = {next - angles[a], 0.5 * (next + angles[a])};
  }
  return gap;
}

class BoundaryFinder {
 public:
  BoundaryFinder(const Points& positions, const Points& normals, const Lists& neighbors, Index k)
      : positions_(positions), normals_(normals), neighbors_(neighbors), k_(k), rule_(positions, normals, neighbors) {}

  Boundary find() const {
    const Index n = neighbors_.size();
    constexpr Index kBlock = 1024;
    std::vector<char> has_gap(n);
    Boundary boundary{std::vector<char>(n), std::vector<char>(n), std::vector<float>(n)};
    parallelFor(n, kBlock, [&](Index begin, Index end) {
      WideGaps gaps(kBoundaryGap);
      for (Index i = begin; i < end; ++i) has_gap[i] = hasGap(i, gaps);
    });
    // A single point with a gap is an uneven spot inside; a boundary continues on both sides.
    for (Index i = 0; i < n; ++i) {
      if (!has_gap[i]) continue;
      Index with_gap = 0;
      forNeighbors(i, k_, [&](Index j) { with_gap += has_gap[j]; });
      boundary.is_boundary[i] = with_gap >= 2;
    }
    std::vector<double> angles;
    for (Index i = 0; i < n; ++i) {
      if (boundary.is_boundary[i]) boundary.corner_gap[i] = findCornerGap(i, boundary.is_boundary, angles);
      boundary.is_corner[i] = boundary.corner_gap[i] > 0.0f;
    }
    return boundary;
  }

 private:
  // Calls visit(j) for the linked ones among the count nearest neighbours.
  template <class Visit>
  void forNeighbors(Index i, Index count, const Visit& visit) const {
    const Index* end = neighbors_.begin(i) + std::min(count, neighbors_.count(i));
    for (const Index* j = neighbors_.begin(i); j != end; ++j) {
      if (rule_.accepts(i, *j)) visit(*j);
    }
  }

  // Whether the 2k nearest neighbours, and so the k nearest too, leave a wide gap.
  bool hasGap(Index i, WideGaps& gaps) const {
    const TangentPlane plane(positions_[i], normals_[i]);
    const Index* end = neighbors_.begin(i) + std::min(2 * k_, neighbors_.count(i));
    gaps.clear();
    for (const Index* j = neighbors_.begin(i); j != end && !gaps.isEmpty(); ++j)
      if (rule_.accepts(i, *j)) gaps.add(plane.project(positions_[*j]));
    return !gaps.isEmpty();
  }

  Gap findGap(Index i, Index count, std::vector<double>& angles) const {
    const TangentPlane plane(positions_[i], normals_[i]);
    angles.clear();
    forNeighbors(i, count, [&](Index j) {
      const Vec2 q = plane.project(positions_[j]);
      angles.push_back(std::atan2(q.y(), q.x()));
    });
    return findWidestGap(angles);
  }

  // Both the gap and the two branches of the boundary must turn: the gap alone is wide at every tooth of a ragged edge, and the
  // branches alone turn at the neighbours of a corner too. 0: no corner.
  float findCornerGap(Index i, const std::vector<char>& is_boundary, std::vector<double>& angles) const {
    const Gap gap = findGap(i, k_, angles);
    if (!(gap.width > kPi + kCornerTurn)) return 0.0f;
    const TangentPlane plane(positions_[i], normals_[i]);
    const Vec2 along(-std::sin(gap.middle), std::cos(gap.middle));
    Vec2 branch[2] = {Vec2::Zero(), Vec2::Zero()};
    forNeighbors(i, k_, [&](Index j) {
      if (!is_boundary[j]) return;
      const Vec2 q = plane.project(positions_[j]);
      branch[q.dot(along) > 0.0 ? 1 : 0] += q;
    });
    // The end of a hair has one branch or none.
    const double lengths = branch[0].norm() * branch[1].norm();
    const bool is_corner = lengths == 0.0 || branch[0].dot(branch[1]) > -std::cos(kCornerTurn) * lengths;
    return is_corner ? static_cast<float>(gap.width) : 0.0f;
  }

  const Points& positions_;
  const Points& normals_;
  const Lists& neighbors_;
  const Index k_;
  const LinkRule rule_;
};

}  // namespace

Boundary findBoundary(const Points& positions, const Points& normals, const Lists& neighbors, Index k) {
  if (positions.size() != normals.size() || static_cast<Index>(positions.size()) != neighbors.size()) {
    throw InputError("findBoundary: found " + std::to_string(positions.size()) + " positions, " + std::to_string(normals.size()) +
                     " normals and " + std::to_string(neighbors.size()) + " neighbour lists; accepted: equally many");
  }
  if (k < 1) throw InputError("findBoundary: k: found " + std::to_string(k) + "; accepted: at least 1");
  return BoundaryFinder(positions, normals, neighbors, k).find();
}

void limitCorners(Index most, Boundary& boundary) {
  std::vector<std::pair<float, Index>> corners;
  for (std::size_t i = 0; i < boundary.is_corner.size(); ++i)
    if (boundary.is_corner[i]) corners.emplace_back(-boundary.corner_gap[i], static_cast<Index>(i));
  std::sort(corners.begin(), corners.end());
  for (std::size_t c = std::max(most, Index{0}); c < corners.size(); ++c) {
    boundary.is_corner[corners[c].second] = 0;
    boundary.corner_gap[corners[c].second] = 0.0f;
  }
}

}  // namespace deformable_surface::cloud
