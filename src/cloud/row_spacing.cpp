#include "deformable_surface/cloud/row_spacing.h"

#include "deformable_surface/base/median.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace deformable_surface::cloud {
namespace {

constexpr Index kLookedAt = 1000;
constexpr Index kNear = 8;     // neighbours that tell the direction of a row
constexpr Index kOfArea = 12;  // neighbours that tell the area of a point
// Of the directions to near neighbours the share across the row over that along it: 0.8 to 1 in lattices, 0.74 at random places,
// below 0.4 in rows of twice the spacing and more that are jittered by up to 0.3 of it.
constexpr double kInRows = 0.45;
constexpr double kNextInRow = 2.2;  // distances between neighbours along a row: the next point of a jittered row is nearer

// The directions to the nearest neighbours, of trace 1.
Mat3 sumDirections(const Points& x, const Lists& neighbors, Index i) {
  Mat3 sum = Mat3::Zero();
  const double nearest = (x[*neighbors.begin(i)] - x[i]).squaredNorm();
  for (Index k = 0; k < std::min(kNear, neighbors.count(i)); ++k) {
    const Vec3 d = x[neighbors.begin(i)[k]] - x[i];
    sum += std::exp(1.0 - d.squaredNorm() / nearest) / d.squaredNorm() * d * d.transpose();
  }
  return sum / sum.trace();
}

struct Group {
  Index size;   // kNear: or more
  double next;  // from its points to the nearest others; 0: none among the neighbours, or of a large group
};

// The points that steps up to so long lead to.
Group findGroup(const Points& x, const Lists& neighbors, Index i, double step) {
  std::vector<Index> members{i};
  const auto isMember = [&](Index j) { return std::find(members.begin(), members.end(), j) != members.end(); };
  for (std::size_t m = 0; m < members.size(); ++m) {
    const Index from = members[m];
    for (const Index* j = neighbors.begin(from); j != neighbors.end(from) && (x[*j] - x[from]).norm() <= step; ++j)
      if (!isMember(*j)) members.push_back(*j);
    if (static_cast<Index>(members.size()) >= kNear) return {kNear, 0.0};
  }
  double next = std::numeric_limits<double>::infinity();
  for (const Index from : members)
    for (const Index* j = neighbors.begin(from); j != neighbors.end(from); ++j)
      if (!isMember(*j)) next = std::min(next, (x[*j] - x[from]).norm());
  return {static_cast<Index>(members.size()), std::isfinite(next) ? next : 0.0};
}

}  // namespace

RowSpacing findRowSpacing(const Points& x, const Lists& neighbors) {
  std::vector<double> shares, spacings, sizes_of_groups, in_groups;
  const Index n = neighbors.size(), stride = std::max(Index{1}, n / kLookedAt);
  for (Index i = 0; i < n; i += stride) {
    const Index count = neighbors.count(i);
    if (count < kNear) continue;
    Mat3 directions = sumDirections(x, neighbors, i);
    double along = (x[*neighbors.begin(i)] - x[i]).norm();
    for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
      if (neighbors.count(*j) < kNear) continue;
      directions += sumDirections(x, neighbors, *j);
      along += (x[*neighbors.begin(*j)] - x[*j]).norm() / count;
    }
    along /= 2.0;
    const Vec3 sizes = Eigen::SelfAdjointEigenSolver<Mat3>(directions, Eigen::EigenvaluesOnly).eigenvalues();
    shares.push_back(sizes[1] / sizes[2]);
    // Of a point; the disc of more neighbours would reach beyond a narrow strip.
    const Index num = std::min(kOfArea, count);
    const double area = kPi * (x[neighbors.begin(i)[num - 1]] - x[i]).squaredNorm() / num;
    spacings.push_back(area / (along * along));
    const Group group = findGroup(x, neighbors, i, kNextInRow * along);
    sizes_of_groups.push_back(group.size);
    in_groups.push_back(group.next > 0.0 ? along / group.next : 1.0);
  }
  RowSpacing result;
  if (shares.empty() || findMedian(std::move(shares)) > kInRows) return result;
  if (findMedian(std::move(sizes_of_groups)) < kNear)
    result.groups = std::min(1.0, findMedian(std::move(in_groups)));
  else
    result.rows = std::clamp(findMedian(std::move(spacings)), 1.0, kFarthestRows);
  return result;
}

}  // namespace deformable_surface::cloud
