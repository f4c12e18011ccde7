#include "deformable_surface/model/elastic_solid/point_volumes.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/geometry/convex_cell.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::model {
namespace {

constexpr Index kBlock = 64;   // points a task: a millisecond or so
constexpr Index kClosest = 3;  // neighbours whose distances give the spacing: a corner of a lattice has as many
// Of the farthest neighbour's distance: facets of the hull nearer to its middle belong to a flat set, and gaps wider than its
// inverse are the outside of one.
constexpr double kNearest = 1e-4;
// Of a cell's size squared: largest boundary area of a point below the surface whose cell just reaches it.
constexpr double kGrazes = 0.1;
// Of a cell: gaps that take a smaller share of it are dents between the points of a convex surface, some hundredths of it if its
// radius is four spacings. If they take a larger share, the points are layers far apart.
constexpr double kDent = 0.05, kLayer = 0.95;
constexpr double kSameCorner = 1e-7;        // of a corner's distance: as many copies of it as it has facets differ by rounding
enum Facet { kBetween, kOutside, kToGap };  // to a neighbour, of the hull, or to a gap

// Cuts the cells of the points one after the other, in coordinates relative to the point. In a plane cells are prisms.
class Cutter {
 public:
  Cutter(const Points& points, const Lists& neighbors, const Vec3& across)
      : points_(points), neighbors_(neighbors), across_(across), is_planar_(!across.isZero(0.0)) {}

  /// Moves on to point i.
  void moveTo(Index i);
  /// Cuts its cell among its neighbours, within the hull of all of them. Returns the distance of the cell's corners before the
  /// hull cut it, at most that of the neighbours.
  double cut();
  /// Whether it lies at a gap: some place is nearest to it, among its neighbours, and yet farther than `empty`, m.
  bool findGaps(double empty);
  /// Removes the part of the cell in the gaps found, and between them and the body. False if it is negligible.
  bool cutGaps();

  /// Of the cell, in a plane area and length.
  double volume() const { return volume_; }
  Vec3 outside() const;

 private:
  Vec3 flatten(const Vec3& p) const { return p - across_.dot(p) * across_; }
  void measure(double volume, const Vec3& area) {
    volume_ = std::max(0.0, volume) / height_;
    outside_ = area / height_;
  }

  const Points& points_;
  const Lists& neighbors_;
  const Vec3 across_;
  const bool is_planar_;

  double volume_ = 0.0, height_ = 1.0;  // m^3, or m^2; m, of the prism, or 1
  Vec3 outside_ = Vec3::Zero();
  double reach_ = 0.0;      // m, how far neighbours are
  Points beside_, around_;  // points that cut the cell, and points of the hull
  geometry::ConvexCell hull_, cell_, star_, part_;
  Points corners_;            // of the cell that no hull has cut
  std::vector<char> is_gap_;  // of its corners
};

void Cutter::moveTo(Index i) {
  const Index count = neighbors_.count(i);
  beside_.clear();
  reach_ = 0.0;
  for (const Index* j = neighbors_.begin(i); j != neighbors_.end(i); ++j) {
    beside_.push_back(flatten(points_[*j] - points_[i]));
    reach_ = std::max(reach_, beside_.back().norm());
  }
  if (is_planar_) {
    // A prism over the cell in the plane: each point around it stands above and below.
    height_ = reach_;
    around_.clear();
    for (const double height : {-height_, height_}) {
      for (Index k = 0; k < count; ++k) around_.push_back(beside_[k] + height * across_);
      around_.push_back(height * across_);
      beside_.push_back(height * across_);
    }
    reach_ *= 2.0;
  }
}

double Cutter::cut() {
  const Points& around = is_planar_ ? around_ : beside_;

  // The hull's facets are the corners of its dual about a point inside, { y : (p - middle) . y <= 1 for all p }.
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : around) middle += p / static_cast<double>(around.size() + 1);
  hull_.reset(1.0 / (kNearest * reach_));
  hull_.cut(-middle, 1.0);
  for (const Vec3& p : around) hull_.cut(p - middle, 1.0);

  cell_.reset(reach_);
  for (const Vec3& p : beside_) cell_.cut(p, 0.5 * p.squaredNorm(), kBetween);
  double farthest = 0.0;
  for (const Vec3& corner : cell_.corners()) farthest = std::max(farthest, flatten(corner).norm());
  for (const Vec3& facet : hull_.corners()) cell_.cut(facet, 1.0 + facet.dot(middle), kOutside);
  measure(cell_.volume(), cell_.area(kOutside));
  return farthest;
}

// Corners of the cell that no hull has cut are the centres of empty spheres through the point and its neighbours. With these
// neighbours the point spans a Delaunay cell, which fills the directions in which its corner is the farthest of all. Spheres
// in gaps are large: the body does not extend in their directions.
bool Cutter::findGaps(double empty) {
  const double infinite = reach_ / kNearest;
  star_.reset(infinite);
  for (const Vec3& p : beside_) star_.cut(p, 0.5 * p.squaredNorm());
  corners_.clear();
  for (const Vec3& copy : star_.corners()) {
    const Vec3 corner = flatten(copy);
    const auto isSame = [&](const Vec3& other) { return (other - corner).norm() <= kSameCorner * corner.norm(); };
    if (std::none_of(corners_.begin(), corners_.end(), isSame)) corners_.push_back(corner);
  }
  is_gap_.clear();
  for (const Vec3& corner : corners_) is_gap_.push_back(corner.norm() > empty && corner.cwiseAbs().maxCoeff() <= 0.5 * infinite);
  return std::find(is_gap_.begin(), is_gap_.end(), 1) != is_gap_.end();
}

bool Cutter::cutGaps() {
  const double whole = cell_.volume();
  double gaps = 0.0;
  Vec3 area = cell_.area(kOutside);
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    if (!is_gap_[k]) continue;
    part_ = cell_;
    for (std::size_t other = 0; other < corners_.size(); ++other)
      if (other != k) part_.cut(corners_[other] - corners_[k], 0.0, kToGap);
    gaps += part_.volume();
    area -= part_.area(kOutside) + part_.area(kToGap);
  }
  if (!(gaps > kDent * whole && gaps < kLayer * whole)) return false;
  measure(whole - gaps, area);
  return true;
}

Vec3 Cutter::outside() const {
  const double size = is_planar_ ? std::sqrt(volume_) : std::cbrt(volume_ * volume_);
  return outside_.norm() > kGrazes * size ? outside_ : Vec3(Vec3::Zero());
}

double meanOver(const std::vector<double>& values, const Lists& neighbors, Index i) {
  double sum = values[i];
  for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) sum += values[*j];
  return sum / (1 + neighbors.count(i));
}

}  // namespace

std::vector<double> findPointSpacing(const Points& points, const Lists& neighbors, const std::vector<double>& volume,
                                     bool is_planar) {
  const Index n = neighbors.size();
  std::vector<double> closest(n, 0.0), spacing(n, 0.0);
  for (Index i = 0; i < n; ++i) {
    const Index count = std::min(kClosest, neighbors.count(i));
    for (Index k = 0; k < count; ++k) closest[i] += (points[neighbors.begin(i)[k]] - points[i]).norm() / count;
  }
  for (Index i = 0; i < n; ++i) {
    const double mean = meanOver(volume, neighbors, i);
    spacing[i] = std::max(is_planar ? std::sqrt(mean) : std::cbrt(mean), meanOver(closest, neighbors, i));
  }
  return spacing;
}

PointCells findPointCells(const Points& points, const Lists& neighbors, const Vec3& across, Outline outline) {
  const bool is_planar = !across.isZero(0.0);
  const Index n = neighbors.size();
  PointCells cells{std::vector<double>(points.size(), 0.0), Points(points.size(), Vec3::Zero())};
  std::vector<double> farthest(n, 0.0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    Cutter cutter(points, neighbors, across);
    for (Index i = begin; i < end; ++i) {
      if (neighbors.count(i) < (is_planar ? 2 : 3)) continue;
      cutter.moveTo(i);
      farthest[i] = cutter.cut();
      cells.volume[i] = cutter.volume();
      cells.outside[i] = cutter.outside();
    }
  });

  if (outline == Outline::kRough) return cells;
  // For points on the boundary: removes gaps.
  const std::vector<double> spacing = findPointSpacing(points, neighbors, cells.volume, is_planar);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    Cutter cutter(points, neighbors, across);
    for (Index i = begin; i < end; ++i) {
      if (!(farthest[i] > kEmptySphere * spacing[i])) continue;
      cutter.moveTo(i);
      if (!cutter.findGaps(kEmptySphere * spacing[i])) continue;
      cutter.cut();
      if (!cutter.cutGaps()) continue;
      cells.volume[i] = cutter.volume();
      cells.outside[i] = cutter.outside();
    }
  });
  return cells;
}

}  // namespace deformable_surface::model
