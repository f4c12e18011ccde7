// The star of one point by inversion. With y = q / |q|^2 a circle through the origin becomes a line, and the circle is empty when
// all other images lie on the origin's side of that line: hull edges of the images are the Delaunay triangles at the origin.
#include "deformable_surface/geometry/delaunay_star.h"

#include "deformable_surface/base/simd.h"
#include "deformable_surface/geometry/direction.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace deformable_surface::geometry {
namespace {

// Directions closer than this count as one: far above rounding, so that the hull never has to decide between points collinear
// with the origin, and far below the angle between true neighbours.
constexpr double kSameDirection = 1e-12;

constexpr Index kLanes = 8;

// Adds to each place how many of the first m angles are less than its own.
DEFORMABLE_SURFACE_WIDE void countLess(Index m, Index filled, const double* angle, std::int64_t* place) {
  for (Index b = 0; b < m; ++b) {
    const double other = angle[b];
#pragma GCC ivdep
    for (Index a = 0; a < filled; ++a) place[a] += other < angle[a];
  }
}

// Sine and cosine of the sum of the angles at a and c of the quadrilateral a b c d (counter-clockwise), times the lengths of its
// sides: those of a product of complex numbers. Corners on one circle have a straight angle as sum.
struct AngleSum {
  double sine, cosine;
};
AngleSum addOppositeAngles(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const Vec2 ab = b - a, ad = d - a, cd = d - c, cb = b - c;
  const double sin_a = cross(ab, ad), cos_a = ab.dot(ad);
  const double sin_c = cross(cd, cb), cos_c = cd.dot(cb);
  return {sin_a * cos_c + cos_a * sin_c, cos_a * cos_c - sin_a * sin_c};
}

// True if the corners of the quadrilateral a b c d (counter-clockwise) lie on one circle: the angles at a and c sum to at least a
// straight angle less tie.
bool isCocircular(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, double tie) {
  const AngleSum sum = addOppositeAngles(a, b, c, d);
  return sum.cosine < 0.0 && sum.sine <= -tie * sum.cosine;
}

// True if the angle from a to b, counter-clockwise, is at most the one with this cosine (and so less than straight).
bool spansTriangle(const Vec2& a, const Vec2& b, double max_gap_cosine) {
  return cross(a, b) > 0.0 && a.dot(b) >= max_gap_cosine * std::sqrt(a.squaredNorm() * b.squaredNorm());
}

}  // namespace

bool isOutside(const Vec2& point, const std::vector<Vec2>& points, const DelaunayStar& star, double tie) {
  for (std::size_t r = 0; r < star.ring.size(); ++r) {
    const Vec2 &a = points[star.ring[r]], &b = points[star.ring[r + 1 < star.ring.size() ? r + 1 : 0]];
    if (cross(a, point) < 0.0 || cross(point, b) < 0.0) continue;
    const AngleSum sum = addOppositeAngles(Vec2::Zero(), a, point, b);
    return sum.sine > 0.0 && sum.sine > -tie * sum.cosine;
  }
  return false;
}

void DelaunayStarBuilder::sortByDirection(const std::vector<Vec2>& points) {
  unsorted_.clear();
  angle_.clear();
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i) {
    const double squared_distance = points[i].squaredNorm();
    using Limits = std::numeric_limits<double>;
    if (!(squared_distance >= Limits::min() && squared_distance <= Limits::max())) continue;
    angle_.push_back(directionOf(points[i]));
    unsorted_.push_back({angle_.back(), squared_distance, i});
  }
  // The place of each is the number of those before it. For a few dozen, counting in vector instructions is faster than a sort,
  // whose branches are unpredictable. What is behind the last fills a vector, and counts for nothing.
  const Index m = static_cast<Index>(unsorted_.size()), filled = (m + kLanes - 1) / kLanes * kLanes;
  angle_.resize(filled, 0.0);
  place_.assign(filled, 0);
  countLess(m, filled, angle_.data(), place_.data());
  // Of equal ones, which are rare, the earlier comes first.
  if (std::accumulate(place_.begin(), place_.begin() + m, std::int64_t{0}) != std::int64_t{m} * (m - 1) / 2)
    for (Index a = 0; a < m; ++a) place_[a] += std::count(angle_.begin(), angle_.begin() + a, angle_[a]);
  directions_.resize(m);
  for (Index a = 0; a < m; ++a) directions_[place_[a]] = unsorted_[a];
  // Of several in one direction the nearest stays; the first and the last may be in one direction too.
  std::size_t kept = 0;
  for (const Direction& d : directions_) {
    if (kept == 0 || d.angle - directions_[kept - 1].angle > kSameDirection) {
      directions_[kept++] = d;
    } else if (d.squared_distance < directions_[kept - 1].squared_distance) {
      directions_[kept - 1] = d;
    }
  }
  directions_.resize(kept);
  if (kept > 1 && directions_.front().angle + 4.0 - directions_.back().angle <= kSameDirection) {
    const bool last_is_nearer = directions_.back().squared_distance < directions_.front().squared_distance;
    directions_.erase(last_is_nearer ? directions_.begin() : directions_.end() - 1);
  }
}

void DelaunayStarBuilder::findHull(const std::vector<Vec2>& points) {
  const Index m = static_cast<Index>(directions_.size());
  hull_.clear();
  if (m == 0) return;

  // A gap of half a turn or more makes the origin a hull vertex: the scan starts after it and does not close. Otherwise it starts
  // at the longest image, which is on the hull, and comes back to it.
  bool closed = true;
  Index start = 0;
  double nearest = directions_[0].squared_distance;
  for (Index d = 0; d < m; ++d) {
    nearest = std::min(nearest, directions_[d].squared_distance);
    const double next = d + 1 < m ? directions_[d + 1].angle : directions_[0].angle + 4.0;
    if (!closed) continue;
    if (next - directions_[d].angle >= 2.0 - kSameDirection) {
      closed = false;
      start = d + 1 < m ? d + 1 : 0;
    } else if (directions_[d].squared_distance < directions_[start].squared_distance) {
      start = d;
    }
  }
  std::rotate(directions_.begin(), directions_.begin() + start, directions_.end());

  // The radius of the inversion is the nearest distance, so that no image overflows.
  image_.clear();
  for (const Direction& d : directions_) image_.push_back(points[d.neighbor] * (nearest / d.squared_distance));
  for (Index step = 0; step < m + (closed ? 1 : 0); ++step) {
    const Vec2& y = image_[step < m ? step : 0];
    while (hull_.size() >= 2) {
      const Vec2 &last = image_[hull_.back()], &before = image_[hull_[hull_.size() - 2]];
      if (cross(last - before, y - last) > 0.0) break;
      hull_.pop_back();
    }
    if (step < m) hull_.push_back(step);
  }
}

void DelaunayStarBuilder::fillRing(const std::vector<Vec2>& points, double tie, double max_gap_cosine) {
  star_.ring.clear();
  for (std::size_t h = 0; h < hull_.size(); ++h) {
    // Between the two corners of a hull edge, seen from the origin, those cocircular with it belong to the same cell.
    const bool last = h + 1 == hull_.size();
    const Index from = hull_[h], to = last ? static_cast<Index>(directions_.size()) : hull_[h + 1];
    const Index first_member = directions_[from].neighbor;
    const Vec2 &a = points[first_member], &c = points[directions_[last ? hull_[0] : to].neighbor];
    star_.ring.push_back(first_member);
    if (to - from == 1 || !spansTriangle(a, c, max_gap_cosine)) continue;
    for (Index step = from + 1; step < to; ++step) {
      const Index between = directions_[step].neighbor;
      if (isCocircular(Vec2::Zero(), a, points[between], c, tie)) star_.ring.push_back(between);
    }
  }
}

// Marks the steps with triangles (cell_size 1 until measured) and rotates an open ring to start after its widest gap.
void DelaunayStarBuilder::openRing(const std::vector<Vec2>& points, double max_gap_cosine) {
  const std::size_t m = star_.ring.size();
  star_.cell_size.assign(m, 1);
  double widest = 0.0;
  std::size_t start = 0;
  for (std::size_t r = 0; r < m; ++r) {
    const Vec2 &a = points[star_.ring[r]], &b = points[star_.ring[r + 1 < m ? r + 1 : 0]];
    if (m > 1 && spansTriangle(a, b, max_gap_cosine)) continue;
    star_.cell_size[r] = 0;
    double gap = std::atan2(cross(a, b), a.dot(b));
    if (gap <= 0.0) gap += 2.0 * kPi;
    if (gap > widest) {
      widest = gap;
      start = r + 1 < m ? r + 1 : 0;
    }
  }
  star_.open = m == 0 || widest > 0.0;
  std::rotate(star_.ring.begin(), star_.ring.begin() + start, star_.ring.end());
  std::rotate(star_.cell_size.begin(), star_.cell_size.begin() + start, star_.cell_size.end());
}

// Removes members from the ends of an open ring while the outermost triangle has an angle beyond max_gap at the member next to
// the end: seen from there it is a gap, so that all three corners agree that there is no triangle. On a straight edge this is the
// degenerate triangle of three collinear points.
void DelaunayStarBuilder::trimRing(const std::vector<Vec2>& points, double max_gap_cosine) {
  if (!star_.open) return;
  std::vector<Index>&ring = star_.ring, &cell_size = star_.cell_size;
  std::size_t begin = 0, end = ring.size();
  while (end - begin >= 2 && cell_size[begin] > 0) {
    const Vec2 &outer = points[ring[begin]], &inner = points[ring[begin + 1]];
    if (spansTriangle(-inner, outer - inner, max_gap_cosine)) break;
    ++begin;
  }
  while (end - begin >= 2 && cell_size[end - 2] > 0) {
    const Vec2 &outer = points[ring[end - 1]], &inner = points[ring[end - 2]];
    if (spansTriangle(outer - inner, -inner, max_gap_cosine)) break;
    --end;
    cell_size[end - 1] = 0;
  }
  for (std::vector<Index>* list : {&ring, &cell_size}) {
    list->erase(list->begin() + end, list->end());
    list->erase(list->begin(), list->begin() + begin);
  }
}

// Joins consecutive triangles into cells where the ring member between them is cocircular with its two ring neighbours.
void DelaunayStarBuilder::measureCells(const std::vector<Vec2>& points, double tie) {
  const std::size_t m = star_.ring.size();
  const auto isInsideCell = [&](std::size_t r) {
    const std::size_t before = r > 0 ? r - 1 : m - 1, after = r + 1 < m ? r + 1 : 0;
    return star_.cell_size[before] > 0 && star_.cell_size[r] > 0 &&
           isCocircular(points[star_.ring[before]], points[star_.ring[r]], points[star_.ring[after]], Vec2::Zero(), tie);
  };
  // A closed ring may start anywhere: start it where a cell does.
  if (!star_.open) {
    std::size_t start = 0;
    while (start < m && isInsideCell(start)) ++start;
    if (start < m) std::rotate(star_.ring.begin(), star_.ring.begin() + start, star_.ring.end());
  }
  star_.area = star_.share = 0.0;
  for (std::size_t begin = 0, end = 0; begin < m; begin = end) {
    double area = 0.0;
    do {
      if (star_.cell_size[end] > 0) area += 0.5 * cross(points[star_.ring[end]], points[star_.ring[end + 1 < m ? end + 1 : 0]]);
      ++end;
    } while (end < m && isInsideCell(end));
    if (star_.cell_size[begin] == 0) continue;
    const Index corners = static_cast<Index>(end - begin) + 2;
    std::fill(star_.cell_size.begin() + begin, star_.cell_size.begin() + end, corners);
    star_.area += area;
    star_.share += area / corners;
  }
}

const DelaunayStar& DelaunayStarBuilder::build(const std::vector<Vec2>& points, double tie, double max_gap) {
  const double max_gap_cosine = std::cos(max_gap);
  sortByDirection(points);
  findHull(points);
  fillRing(points, tie, max_gap_cosine);
  openRing(points, max_gap_cosine);
  trimRing(points, max_gap_cosine);
  measureCells(points, tie);
  return star_;
}

}  // namespace deformable_surface::geometry
