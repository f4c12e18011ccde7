#include "narrow_gaps.h"

#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"

#include <algorithm>
#include <cmath>

#include "parts.h"
#include "rest_parts.h"
#include "spacing.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kBlock = 512;
constexpr Index kAsked = 8;        // simulation points around one that are asked for their part
constexpr Index kAskedDense = 48;  // points of the cloud: half a disc of five spacings across holds some forty
constexpr double kFar = 2.5;       // spacings of the simulation points: parts that are farther apart do not lie beside each other
constexpr double kNarrow = 5.0;    // of the cloud
constexpr double kOffPlane = 0.4;  // of its length: what rises more than that goes to another layer
constexpr double kMostBehind = 1.2;
constexpr double kFewest = 0.005;  // of the points: fewer lie at holes
constexpr double kShare = 0.9;     // of the gaps that the stated length joins
constexpr double kMargin = 1.25;
constexpr Index kFewestParts = 3;  // that no slit alone makes

// Points of the cloud in cells of simulation points that have one of another part near.
std::vector<Index> findBeside(const RestSurface& s, const std::vector<Index>& part, double far) {
  const cloud::KdTree tree(s.points);
  std::vector<char> is_beside(s.points.size());
  std::vector<cloud::Neighbor> near;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    tree.nearest(s.points[i], kAsked, near);
    for (const cloud::Neighbor& other : near)
      if (other.squared_distance <= far * far && part[other.index] != part[i]) is_beside[i] = is_beside[other.index] = 1;
  }
  std::vector<Index> beside;
  for (std::size_t i = 0; i < s.cells.owner.size(); ++i)
    if (s.cells.owner[i] >= 0 && is_beside[s.cells.owner[i]]) beside.push_back(static_cast<Index>(i));
  return beside;
}

}  // namespace

void noteNarrowGaps(RestSurface& s) {
  if (s.cells.owner.empty() || s.rings.ring.size() != static_cast<Index>(s.points.size())) return;
  const Parts parts = findParts(static_cast<Index>(s.points.size()), linksOf(s.rings.ring));
  if (parts.count() < 2) return;
  const double n = static_cast<double>(s.dense.positions.size()), spacing = findSpacing(s.area, n);
  const std::vector<Index> beside = findBeside(s, parts.label, kFar * findSpacing(s.area, s.points.size()));
  Points positions;
  for (const Index i : beside) positions.push_back(s.dense.positions[i]);
  if (positions.size() < 2) return;

  // The width of the gap at each of these (0: there is none), and the point on its other side.
  const cloud::KdTree tree(positions);
  std::vector<double> width(beside.size());
  std::vector<Index> opposite(beside.size());
  const auto partOf = [&](Index k) { return parts.label[s.cells.owner[beside[k]]]; };
  parallelFor(static_cast<Index>(beside.size()), kBlock, [&](Index begin, Index end) {
    std::vector<cloud::Neighbor> near;
    for (Index k = begin; k < end; ++k) {
      tree.nearest(positions[k], kAskedDense, near);
      const auto other = std::find_if(near.begin(), near.end(), [&](const auto& j) { return partOf(j.index) != partOf(k); });
      if (other == near.end() || other->squared_distance > kNarrow * kNarrow * spacing * spacing) continue;
      const Vec3 across = positions[other->index] - positions[k];
      const double length = across.norm();
      const auto isAlong = [&](Index i) { return std::abs(across.dot(s.dense.normals[i])) <= kOffPlane * length; };
      if (!isAlong(beside[k]) || !isAlong(beside[other->index])) continue;
      width[k] = length;
      opposite[k] = other->index;
    }
  });
  std::vector<char> has_gap(parts.count());
  std::vector<double> widths;
  for (std::size_t k = 0; k < width.size(); ++k) {
    // From behind another point it looks wider.
    if (width[k] == 0.0 || width[k] > kMostBehind * width[opposite[k]]) continue;
    has_gap[partOf(static_cast<Index>(k))] = 1;
    widths.push_back(width[k]);
  }
  if (static_cast<double>(widths.size()) < kFewest * n) return;
  std::sort(widths.begin(), widths.end());
  const double middle = widths[widths.size() / 2];
  const double most = kMargin * widths[static_cast<std::size_t>(kShare * static_cast<double>(widths.size() - 1))];
  const Index num_parts = static_cast<Index>(std::count(has_gap.begin(), has_gap.end(), 1));
  const std::string notice = formatCount(num_parts, "parts lie beside each other in one surface, with gaps of ") +
                             formatShort(1000.0 * middle) + " mm between them, " + formatShort(middle / spacing) + " spacings (" +
                             formatCount(static_cast<Index>(widths.size()),
                                         "points lie there): if points are missing "
                                         "there, input.min_gap ") +
                             formatShort(most) + " joins the parts";
  (num_parts >= kFewestParts ? s.warnings : s.notes).push_back(notice);
}

}  // namespace deformable_surface::simulation
