// Divides a cloud into parts and thins it: point by point (ring_thinning.h), in large clouds after a coarser pass that removes
// most points (coarse_thinning.h).
#include "deformable_surface/cloud/simplification.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/links.h"
#include "deformable_surface/cloud/rings.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "coarse_thinning.h"
#include "ring_thinning.h"
#include "signed_sets.h"

namespace deformable_surface::cloud {
namespace {

// Parts whose share of the points wanted is less than kMinPartPoints are left out if they would keep more than one point in
// kSmallPartsShare of those wanted.
constexpr Index kSmallPartsShare = 10;

// A cloud is large if it has kLarge times the points that are thinned one by one. Distances alone decide about its surplus, down
// to kLeftForRings times the wanted number.
constexpr Index kLarge = 6;
constexpr Index kLeftForRings = 4;

// The part of the surface of each point: connected by links among its k nearest. Parts are numbered in the order of
// their smallest index.
std::vector<Index> labelParts(const Points& positions, const Points& normals, const Lists& neighbors, Index k, Index& num_parts) {
  const LinkRule rule(positions, normals, neighbors);
  const Index n = neighbors.size();
  constexpr Index kBlock = 1024;  // points per task: less than a millisecond of work
  SignedSets sets(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const Index* last = neighbors.begin(i) + std::min(k, neighbors.count(i));
      for (const Index* j = neighbors.begin(i); j != last; ++j)
        if (rule.accepts(i, *j)) sets.join(i, *j, false);
    }
  });
  std::vector<Index> part(n);
  num_parts = 0;
  for (Index i = 0; i < n; ++i) {
    const Index root = sets.find(i);
    part[i] = root == i ? num_parts++ : part[root];
  }
  return part;
}

// Marks (num_parts, 1) the parts that are left out.
std::vector<char> findLeftOut(const std::vector<Index>& part, Index num_parts, Index target) {
  std::vector<char> is_small(num_parts);
  if (target == 0) return is_small;
  std::vector<std::int64_t> size(num_parts);
  for (const Index p : part) ++size[p];
  std::int64_t kept = 0;
  for (Index p = 0; p < num_parts; ++p) {
    is_small[p] = size[p] * target < std::int64_t{kMinPartPoints} * static_cast<std::int64_t>(part.size());
    if (is_small[p]) kept += std::min<std::int64_t>(size[p], kMinPartPoints);
  }
  if (kept * kSmallPartsShare <= target) is_small.assign(num_parts, 0);
  return is_small;
}

// First coarsely, then by rings.
Simplification simplifyLarge(const Points& positions, const Points& normals, const std::vector<double>& wanted, Index k,
                             Index min_points, Index stop, const Lists& neighbors, std::vector<Index> part,
                             const std::vector<char>& left_out, std::vector<char> stays, bool over_surface) {
  const Index n = static_cast<Index>(positions.size());
  ThinnedCloud cloud{std::vector<Index>(n), positions, {}, std::move(part), std::move(stays), {}, {}};
  std::iota(cloud.index.begin(), cloud.index.end(), 0);
  thinCoarsely(neighbors, stop, 2 * k, over_surface, cloud);

  Points left_normals;
  for (Index i : cloud.index) left_normals.push_back(normals[i]);
  std::vector<double> left_wanted;
  if (!wanted.empty())
    for (Index i : cloud.index) left_wanted.push_back(wanted[i]);
  Simplification rest = thinByRings(
      {cloud.positions, left_normals, left_wanted, k, std::move(cloud.neighbors), std::move(cloud.part), left_out, over_surface},
      min_points, cloud.stays);
  Simplification result;
  result.num_points = n;
  result.removed = std::move(cloud.removed);
  result.diameter = std::move(cloud.diameter);
  double diameter = result.diameter.empty() ? 0.0 : result.diameter.back();
  for (std::size_t r = 0; r < rest.removed.size(); ++r) {
    result.removed.push_back(cloud.index[rest.removed[r]]);
    result.diameter.push_back(diameter = std::max(diameter, rest.diameter[r]));
  }
  return result;
}

std::vector<Index> keepAllBut(Index num_points, const Index* begin, const Index* end) {
  std::vector<char> keeps(num_points, 1);
  for (const Index* i = begin; i != end; ++i) keeps[*i] = 0;
  std::vector<Index> kept;
  for (Index i = 0; i < num_points; ++i) {
    if (keeps[i]) kept.push_back(i);
  }
  return kept;
}

}  // namespace

std::vector<Index> Simplification::keepCount(Index target) const {
  const Index excess = std::max(0, num_points - std::max(0, target));
  return keepAllBut(num_points, removed.data(), removed.data() + std::min(excess, static_cast<Index>(removed.size())));
}

std::vector<Index> Simplification::keepDiameter(double threshold) const {
  const auto reached = std::lower_bound(diameter.begin(), diameter.end(), threshold);
  return keepAllBut(num_points, removed.data(), removed.data() + (reached - diameter.begin()));
}

Simplification simplify(const Points& positions, const Points& normals, Index k, Index min_points,
                        const std::vector<Index>& protected_points) {
  const Lists neighbors = nearestNeighbors(positions, 2 * std::max(k, Index{3}));
  std::vector<char> is_corner;
  if (positions.size() == normals.size() && k >= 3) is_corner = findBoundary(positions, normals, neighbors, k).is_corner;
  return simplify(positions, normals, k, min_points, protected_points, neighbors, is_corner, false);
}

Simplification simplify(const Points& positions, const Points& normals, Index k, Index min_points,
                        const std::vector<Index>& protected_points, const Lists& neighbors, const std::vector<char>& is_corner,
                        bool over_surface, Index target, const std::vector<double>& wanted, Index one_by_one) {
  const Index n = static_cast<Index>(positions.size());
  std::vector<std::string> problems;
  if (positions.size() != normals.size()) {
    problems.push_back("simplify: found " + std::to_string(n) + " positions and " + std::to_string(normals.size()) +
                       " normals; accepted: equally many");
  }
  if (k < 3) problems.push_back("simplify: k: found " + std::to_string(k) + "; accepted: at least 3");
  if (min_points < 0) problems.push_back("simplify: min_points: found " + std::to_string(min_points) + "; accepted: at least 0");
  for (Index i : protected_points) {
    if (i >= 0 && i < n) continue;
    problems.push_back("simplify: found the protected point " + std::to_string(i) + "; accepted: 0 to " + std::to_string(n - 1));
    break;
  }
  if (!wanted.empty() && wanted.size() != positions.size()) {
    problems.push_back("simplify: found " + std::to_string(n) + " positions and " + std::to_string(wanted.size()) +
                       " spacings wanted; accepted: as many, or none");
  }
  const auto isSpacing = [](double spacing) { return spacing > 0.0 && std::isfinite(spacing); };
  if (!std::all_of(wanted.begin(), wanted.end(), isSpacing))
    problems.push_back("simplify: a spacing wanted is not a finite number above 0");
  if (!problems.empty()) throw InputError(std::move(problems));
  std::vector<char> stays = is_corner;
  Index num_parts = 0;
  std::vector<Index> part = labelParts(positions, normals, neighbors, k, num_parts);
  const std::vector<char> left_out = findLeftOut(part, num_parts, target);
  const Index num_left_out = static_cast<Index>(std::count(left_out.begin(), left_out.end(), 1));
  std::vector<Index> left_out_points;
  for (Index i = 0; i < n; ++i) {
    if (!left_out[part[i]]) continue;
    left_out_points.push_back(i);
    stays[i] = 0;
  }
  for (const Index i : protected_points) stays[i] = 1;
  // Distances alone space evenly: as many points must be left for the rings as for the finest spacing everywhere.
  const double finest = wanted.empty() ? 1.0 : std::min(1.0, *std::min_element(wanted.begin(), wanted.end()));
  const std::int64_t stop = static_cast<std::int64_t>(
      std::max<std::int64_t>(one_by_one, std::int64_t{kLeftForRings} * std::max(target, min_points)) / (finest * finest));
  Simplification result =
      n > kLarge * stop
          ? simplifyLarge(positions, normals, wanted, k, min_points, static_cast<Index>(stop), neighbors, std::move(part),
                          left_out, std::move(stays), over_surface)
          : thinByRings({positions, normals, wanted, k, neighbors, std::move(part), left_out, over_surface}, min_points, stays);
  result.num_left_out = num_left_out;
  result.left_out = std::move(left_out_points);
  return result;
}

}  // namespace deformable_surface::cloud
