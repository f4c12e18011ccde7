#include "deformable_surface/model/elastic_solid/point_volumes.h"

#include "deformable_surface/base/parallel.h"
#include "deformable_surface/geometry/convex_cell.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace deformable_surface::model {
namespace {

constexpr Index kMostMeasured = 20000;               // cells of a cloud: a third of a second
constexpr double kWhole = 4294967296.0;              // 2^32
constexpr std::uint32_t kGoldenRatio = 2654435769u;  // of 2^32: multiples of it, modulo that, are spread evenly
constexpr Index kBlock = 64;                         // points a task: a millisecond or so
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

  /// Moves on to point i. False if it has too few neighbours for a cell.
  bool moveTo(Index i);
  /// Cuts its cell among its neighbours. Returns the distance of the cell's corners, at most that of the neighbours.
  double cut();
  /// Cuts the cell by the hull of all neighbours.
  void cutOutside();
  /// Whether the cell, whose corners lie so far away (m) and which no hull has cut, ends at neighbours all around. Points that
  /// are farther away than the neighbours could not cut it either.
  bool isInner(double farthest) const { return farthest < 0.5 * reach_; }
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
  double size_ = 0.0;       // m, what the cell is cut from
  Points beside_, around_;  // points that cut the cell, and points of the hull
  geometry::ConvexCell hull_, cell_, star_, part_;
  Points corners_;            // of the cell that no hull has cut
  std::vector<char> is_gap_;  // of its corners
};

bool Cutter::moveTo(Index i) {
  const Index count = neighbors_.count(i);
  if (count < (is_planar_ ? 2 : 3)) return false;
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
  }
  size_ = (is_planar_ ? 2.0 : 1.0) * reach_;
  return true;
}

double Cutter::cut() {
  cell_.reset(size_);
  for (const Vec3& p : beside_) cell_.cut(p, 0.5 * p.squaredNorm(), kBetween);
  double farthest = 0.0;
  for (const Vec3& corner : cell_.corners()) farthest = std::max(farthest, flatten(corner).norm());
  measure(cell_.volume(), Vec3::Zero());
  return farthest;
}

void Cutter::cutOutside() {
  const Points& around = is_planar_ ? around_ : beside_;

  // The hull's facets are the corners of its dual about a point inside, { y : (p - middle) . y <= 1 for all p }.
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : around) middle += p / static_cast<double>(around.size() + 1);
  hull_.reset(1.0 / (kNearest * size_));
  hull_.cut(-middle, 1.0);
  for (const Vec3& p : around) hull_.cut(p - middle, 1.0);

  for (const Vec3& facet : hull_.corners()) cell_.cut(facet, 1.0 + facet.dot(middle), kOutside);
  measure(cell_.volume(), cell_.area(kOutside));
}

// Corners of the cell that no hull has cut are the centres of empty spheres through the point and its neighbours. With these
// neighbours the point spans a Delaunay cell, which fills the directions in which its corner is the farthest of all. Spheres
// in gaps are large: the body does not extend in their directions.
bool Cutter::findGaps(double empty) {
  const double infinite = size_ / kNearest;
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

// cuts_all: cells that end at neighbours all around are cut by the hull of their neighbours, too.
PointCells findCells(const Points& points, const Lists& neighbors, const Vec3& across, Outline outline, bool cuts_all) {
  const bool is_planar = !across.isZero(0.0);
  const Index n = neighbors.size();
  PointCells cells{std::vector<double>(points.size(), 0.0), Points(points.size(), Vec3::Zero())};
  std::vector<double> farthest(n, 0.0);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    Cutter cutter(points, neighbors, across);
    for (Index i = begin; i < end; ++i) {
      if (!cutter.moveTo(i)) continue;
      farthest[i] = cutter.cut();
      if (cuts_all || !cutter.isInner(farthest[i])) cutter.cutOutside();
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
      cutter.cutOutside();
      if (!cutter.cutGaps()) continue;
      cells.volume[i] = cutter.volume();
      cells.outside[i] = cutter.outside();
    }
  });
  return cells;
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

std::vector<double> measureAround(const Points& points, const Lists& neighbors, const Vec3& across,
                                  const std::vector<Index>& owner, Index m) {
  const Index n = neighbors.size();
  std::vector<double> sum(m, 0.0);
  if (n <= kMostMeasured) {
    const std::vector<double> volume = findCells(points, neighbors, across, Outline::kSurface, false).volume;
    for (Index i = 0; i < n; ++i) sum[owner[i]] += volume[i];
    return sum;
  }
  std::vector<Index> measured;
  for (Index i = 0; i < n; ++i)
    if (static_cast<std::uint32_t>(i) * kGoldenRatio < kWhole * kMostMeasured / n) measured.push_back(i);
  std::vector<double> volume(measured.size(), 0.0);
  parallelFor(static_cast<Index>(measured.size()), kBlock, [&](Index begin, Index end) {
    Cutter cutter(points, neighbors, across);
    for (Index k = begin; k < end; ++k) {
      if (!cutter.moveTo(measured[k])) continue;
      if (!cutter.isInner(cutter.cut())) cutter.cutOutside();
      volume[k] = cutter.volume();
    }
  });
  // Of an owner without a measured point: the mean of all.
  const double mean = std::accumulate(volume.begin(), volume.end(), 0.0) / static_cast<double>(volume.size());
  std::vector<Index> count(m, 0), of_all(m, 0);
  for (std::size_t k = 0; k < measured.size(); ++k) {
    sum[owner[measured[k]]] += volume[k];
    ++count[owner[measured[k]]];
  }
  for (const Index o : owner) ++of_all[o];
  for (Index o = 0; o < m; ++o) sum[o] = of_all[o] * (count[o] > 0 ? sum[o] / count[o] : mean);
  return sum;
}

void fillCells(const std::vector<double>& around, const Lists& neighbors, std::vector<double>& volume) {
  const std::vector<double> cells = volume;
  double sum = 0.0;
  for (Index i = 0; i < neighbors.size(); ++i) {
    const double cell = meanOver(cells, neighbors, i);
    if (cell > 0.0) volume[i] *= meanOver(around, neighbors, i) / cell;
    sum += volume[i];
  }
  const double scale = sum > 0.0 ? std::accumulate(around.begin(), around.end(), 0.0) / sum : 1.0;
  for (double& v : volume) v *= scale;
}

PointCells findPointCells(const Points& points, const Lists& neighbors, const Vec3& across, Outline outline) {
  return findCells(points, neighbors, across, outline, true);
}

}  // namespace deformable_surface::model
