// From a closed surface to the elastic solid within it. Only here some simulation points are no points of
// the cloud.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/cloud/farthest_points.h"
#include "deformable_surface/cloud/geodesic_cells.h"
#include "deformable_surface/cloud/interior.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/rings.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "../../spacing.h"
#include "rest.h"

namespace deformable_surface::simulation {
namespace {

// Of the inside: for a scan with an open base a seventh of it is in doubt, for a hemisphere two thirds.
constexpr double kMostDoubtful = 0.2;

struct Hull {
  std::vector<double> areas;        // (n) m^2
  double area = 0.0, volume = 0.0;  // m^2, m^3
};

Hull measureHull(const RestSurface& s) {
  Hull hull;
  hull.areas = cloud::buildRings(s.dense.positions, s.dense.normals, s.dense_neighbors).area;
  for (std::size_t i = 0; i < hull.areas.size(); ++i) {
    hull.area += hull.areas[i];
    hull.volume += hull.areas[i] * s.dense.normals[i].dot(s.dense.positions[i] - s.dense.positions[0]) / 3.0;
  }
  return hull;
}

// The spacing at which points on the surface and inside together have the wanted number; no finer than the cloud's.
double chooseSpacing(const cloud::SimplificationParams& how, const Hull& hull, Index points) {
  const double finest = findSpacing(hull.area, points);
  if (how.method == cloud::SimplificationMethod::kNone) return finest;
  const bool by_threshold = how.target_points == 0 && !how.threshold.is_auto;
  if (by_threshold) return std::max(finest, 0.5 * how.threshold.value);  // of a body, it is twice the least distance
  const Index target = findSolidTarget(how, points);
  double low = finest, high = std::sqrt(hull.area);
  const auto countAt = [&](double h) {
    return hull.area / (h * h) + std::max(0.0, std::abs(hull.volume) - 0.5 * h * hull.area) / (h * h * h);
  };
  if (countAt(finest) <= target) return finest;
  // Bisection down to rounding.
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (countAt(middle) > target ? low : high) = middle;
  }
  return high;
}

// The chosen point of the surface that each point of it belongs to.
std::vector<Index> findOwners(const SceneParams& params, const RestSurface& s) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  std::vector<Index> owner(n);
  if (static_cast<Index>(s.dense_index.size()) == n) {
    std::iota(owner.begin(), owner.end(), Index{0});
    return owner;
  }
  if (!params.neighbors.areEuclidean())
    owner = cloud::findGeodesicCells(s.dense.positions, s.dense_neighbors, s.dense_index, params.neighbors.k).owner;
  Points chosen;
  for (const Index i : s.dense_index) chosen.push_back(s.dense.positions[i]);
  const cloud::KdTree tree(chosen);
  std::vector<cloud::Neighbor> near;
  for (Index i = 0; i < n; ++i) {
    if (!params.neighbors.areEuclidean() && owner[i] >= 0) continue;
    tree.nearest(s.dense.positions[i], 1, near);
    owner[i] = near.front().index;
  }
  return owner;
}

// Every point of the surface follows its chosen one and the neighbours of that, nearest first.
Lists findFollowed(const RestSurface& s, const std::vector<Index>& owner, const Lists& neighbors, Index k) {
  Lists followed;
  std::vector<std::pair<double, Index>> near;
  for (std::size_t d = 0; d < owner.size(); ++d) {
    const auto add = [&](Index j) { near.emplace_back((s.points[j] - s.dense.positions[d]).squaredNorm(), j); };
    near.clear();
    add(owner[d]);
    for (const Index* j = neighbors.begin(owner[d]); j != neighbors.end(owner[d]); ++j) add(*j);
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), static_cast<std::size_t>(k)));
    for (const auto& entry : near) followed.items.push_back(entry.second);
    followed.offsets.push_back(static_cast<Index>(followed.items.size()));
  }
  return followed;
}

}  // namespace

void buildFilledSolid(const SceneParams& params, RestSurface& s) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  const Hull hull = measureHull(s);
  if (!(hull.area > 0.0))
    throw InputError(
        "elastic_solid.fill: found a cloud without area, as of points on a line; accepted: points on a closed surface");
  const double spacing = chooseSpacing(params.simplification, hull, n);
  const Index on_surface = std::min(n, std::max(Index{4}, static_cast<Index>(std::lround(hull.area / (spacing * spacing)))));
  s.order.num_points = n;
  if (on_surface < n)
    s.order =
        cloud::orderByDistance(s.dense.positions, s.dense_neighbors, on_surface, choosePinPoints(params, s.dense.positions));
  s.dense_index = s.order.keepCount(on_surface);
  const std::vector<Index> owner = findOwners(params, s);

  const cloud::SurfaceDipoles dipoles =
      cloud::gatherDipoles(s.dense.positions, s.dense.normals, hull.areas, owner, static_cast<Index>(s.dense_index.size()));
  const cloud::Interior interior = cloud::fillSurface(dipoles, s.dense.positions, spacing);
  if (interior.doubtful > kMostDoubtful)
    throw InputError("elastic_solid.fill: found a surface that does not close, or normals that do not agree: at " +
                     formatShort(100.0 * interior.doubtful) +
                     " per cent of the places within it the winding number is neither 0 nor 1; "
                     "accepted: a closed surface with all normals on one side of it, or without normals: these are then "
                     "estimated, and can be wrong where parts are near each other");
  if (interior.points.empty())
    throw InputError("elastic_solid.fill: found no place inside the surface at a spacing of " + formatShort(spacing) +
                     " m; accepted: a closed surface with more points than its thickness asks for");
  for (const Index i : s.dense_index) {
    s.points.push_back(s.dense.positions[i]);
    s.normals.push_back(s.dense.normals[i]);
  }
  s.points.insert(s.points.end(), interior.points.begin(), interior.points.end());
  s.normals.resize(s.points.size(), Vec3::Zero());
  s.notes.push_back(formatCount(static_cast<Index>(interior.points.size()), "points inside, ") + formatShort(spacing) +
                    " m apart, fill the surface");

  s.solid_neighbors = cloud::nearestNeighbors(s.points, 2 * params.neighbors.k);
  s.detours = keepNearOverBody(params.neighbors, s.points, s.solid_neighbors, s);
  const Lists followed = findFollowed(s, owner, s.solid_neighbors, 2 * params.transfer.k);
  s.solid_transfer = transfer::SolidTransfer(s.dense.positions, s.dense.normals, s.points, followed);
}

}  // namespace deformable_surface::simulation
