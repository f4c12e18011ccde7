#include "deformable_surface/model/elastic_solid/point_volumes.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/geometry/convex_cell.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 64;        // points a task: a millisecond or so
// Of the farthest neighbour's distance: facets of the hull nearer to its middle are those of a flat set.
constexpr double kNearest = 1e-4;
// Of a cell's size squared: what a point under the surface may have of it, where its cell just reaches it.
constexpr double kGrazes = 0.1;
enum Facet { kBetween, kOutside };  // to a neighbour, or of the hull

// The origin's cell among those beside it, within the hull of it and those around it, all relative to it and within reach.
void cutCell(const Points& beside, const Points& around, double reach, geometry::ConvexCell& hull, geometry::ConvexCell& cell) {
  // The hull's facets are the corners of its dual about a point inside, { y : (p - middle) . y <= 1 for all p }.
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : around) middle += p / static_cast<double>(around.size() + 1);
  hull.reset(1.0 / (kNearest * reach));
  hull.cut(-middle, 1.0);
  for (const Vec3& p : around) hull.cut(p - middle, 1.0);

  cell.reset(reach);
  for (const Vec3& p : beside) cell.cut(p, 0.5 * p.squaredNorm(), kBetween);
  for (const Vec3& facet : hull.corners()) cell.cut(facet, 1.0 + facet.dot(middle), kOutside);
}

Vec3 dropGrazing(const Vec3& area, double size) { return area.norm() > kGrazes * size ? area : Vec3(Vec3::Zero()); }

}  // namespace

PointCells findPointCells(const Points& points, const Lists& neighbors, const Vec3& across) {
  const bool is_planar = !across.isZero(0.0);
  PointCells cells{std::vector<double>(points.size(), 0.0), Points(points.size(), Vec3::Zero())};
  parallelFor(neighbors.size(), kBlock, [&](Index begin, Index end) {
    geometry::ConvexCell hull, cell;
    Points beside, around;
    for (Index i = begin; i < end; ++i) {
      if (neighbors.count(i) < (is_planar ? 2 : 3)) continue;
      beside.clear();
      double reach = 0.0;
      for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
        const Vec3 d = points[*j] - points[i];
        beside.push_back(d - across.dot(d) * across);
        reach = std::max(reach, beside.back().norm());
      }
      if (!is_planar) {
        cutCell(beside, beside, reach, hull, cell);
        cells.volume[i] = std::max(0.0, cell.volume());
        cells.outside[i] = dropGrazing(cell.area(kOutside), std::cbrt(cells.volume[i] * cells.volume[i]));
        continue;
      }
      // A prism over the cell in the plane: of those around, each stands above and below.
      around.clear();
      for (const double height : {-reach, reach}) {
        for (Index k = 0; k < neighbors.count(i); ++k) around.push_back(beside[k] + height * across);
        around.push_back(height * across);
        beside.push_back(height * across);
      }
      cutCell(beside, around, 2.0 * reach, hull, cell);
      cells.volume[i] = std::max(0.0, cell.volume()) / reach;
      cells.outside[i] = dropGrazing(cell.area(kOutside) / reach, std::sqrt(cells.volume[i]));
    }
  });
  return cells;
}

}  // namespace deformable_surface::model
