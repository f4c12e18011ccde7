// Points between the simulation points, evaluated one by one: some of the dense points, or places on flat triangles. Transfer
// evaluates all dense points at once; contact needs few of them, in every sub-step, and applies forces to them.
#pragma once

#include "deformable_surface/transfer/transfer.h"

#include <algorithm>
#include <array>
#include <vector>

namespace deformable_surface::transfer {

/// A place on the flat triangle between three simulation points: p = sum_k weight[k] x_corner[k]; weights sum to 1.
struct PlaceOnTriangle {
  std::array<Index, 3> corner;
  std::array<double, 3> weight;

  /// The corner with the largest weight, of equal ones the first.
  Index nearest() const { return corner[std::max_element(weight.begin(), weight.end()) - weight.begin()]; }
  /// From values at the simulation points.
  Vec3 interpolate(const Points& values) const {
    return weight[0] * values[corner[0]] + weight[1] * values[corner[1]] + weight[2] * values[corner[2]];
  }
};

/// Dense points in the cells of simulation points. Each is where Transfer places it: p = sum_j w_j x_j + h n, with x_j the
/// simulation points that it follows, n the unit normal of the transferred tangents and h its height over the fitted plane.
/// Results are those of Transfer except for its float rounding. Places on triangles have no height.
class SampledPoints {
 public:
  SampledPoints() = default;
  /// Spare samples are used only where the others do not suffice. The surface is only nearly where its triangles have places.
  enum Use : char { kAlways = 0, kSpare = 1, kSparePlace = 2 };
  /// rows: an operator for the sampled points alone. simulation (m x 3): at rest, m. cell (s): the simulation point of the cell
  /// of each sample, ascending. use (s): the spare ones last in each cell; empty: all are used always.
  SampledPoints(const Transfer& rows, const Points& simulation, const std::vector<Index>& cell, std::vector<Use> use = {});
  /// Each place is in the cell of its nearest(). All are spare places.
  SampledPoints(const std::vector<PlaceOnTriangle>& places, const Points& simulation);

  bool areLinear() const { return frame_.empty(); }
  Index size() const { return static_cast<Index>(cell_.size()); }
  /// The samples of a cell are consecutive, the spare ones last.
  Index begin(Index cell) const { return begin_[cell]; }
  Index beginSpare(Index cell) const { return begin_spare_[cell]; }
  Index end(Index cell) const { return begin_[cell + 1]; }
  Index cellOf(Index s) const { return cell_[s]; }
  bool isSpare(Index s) const { return !use_.empty() && use_[s] != kAlways; }
  bool hasPlaces() const { return std::find(use_.begin(), use_.end(), kSparePlace) != use_.end(); }
  bool isPlace(Index s) const { return !use_.empty() && use_[s] == kSparePlace; }
  /// Largest distance, m, at rest, of the samples of a cell from its simulation point: of those that are no places, and of all.
  double radius(Index cell) const { return radius_[cell]; }
  double extent(Index cell) const { return extent_[cell]; }
  /// The same of all cells.
  double largestExtent() const { return largest_extent_; }
  /// Bound of the distance of a sample from the simulation point of its cell, as a fraction of findReach().
  double share(Index s) const { return share_[s]; }
  /// Largest distance, m, of the samples of the cell from the planes fitted through the simulation points at rest.
  double height(Index cell) const { return height_[cell]; }
  /// Largest present distance, m, of the samples of the cell from its simulation point: that at rest times the local stretch of
  /// the surface, and what a sharp bend can add, which the samples do not follow.
  double findReach(Index cell, const Points& simulation_now) const;
  /// The same at rest.
  double restReach(Index cell) const;

  /// Position, m, from the present positions (m x 3) of the simulation points.
  Vec3 place(Index s, const Points& simulation_now) const;
  /// Velocity, m/s, without the contribution of h n.
  Vec3 findVelocity(Index s, const Points& velocities) const;
  /// Adds to forces (m x 3), N, the effect of a force on the sample: the transpose of the derivative of place().
  void scatter(Index s, const Points& simulation_now, const Vec3& force, Points& forces) const;
  /// visit(simulation point, weight) for the points that a sample follows; weights sum to 1.
  template <class Visit>
  void visitWeights(Index s, const Visit& visit) const {
    for (Index e = s * k_; e < (s + 1) * k_; ++e)
      if (value_[e] != 0.0) visit(source_[e], value_[e]);
  }

  /// The samples whose sources are all kept, for fewer simulation points: new_index (of the former points) or -1. old receives
  /// the former index of each kept sample.
  SampledPoints takePart(const std::vector<Index>& new_index, Index new_size, std::vector<Index>& old) const;

 private:
  struct Gradient {
    double x, y;  // 1/m
  };
  struct Frame {
    Vec3 offset = Vec3::Zero();       // m, of the point, beyond the value of the row: rounding
    Vec3 tangent_x, tangent_y;        // the same of the tangents: all of a tangent where neighbours are collinear
    double slope_x, slope_y, height;  // of the fitted plane, and m over it
  };
  struct Tangents {
    Vec3 x, y, normal;  // normal: not of unit length
  };
  Tangents findTangents(Index s, const Points& simulation_now) const;
  void findExtents(Index num_cells);
  void finish(const Points& simulation);
  void listCells(Index num_cells);
  double findSpread(Index cell, const Points& simulation) const;

  Index k_ = 0;
  std::vector<Index> source_;       // (s x k)
  std::vector<double> value_;       // (s x k) weights
  std::vector<Gradient> gradient_;  // (s x k) weights of the gradient rows; none on triangles
  std::vector<Frame> frame_;        // (s); none on triangles
  std::vector<Index> cell_, begin_, begin_spare_;
  std::vector<Use> use_;                          // (s), or empty
  std::vector<double> share_;                     // (s)
  std::vector<double> radius_, extent_, height_;  // (m)
  double largest_extent_ = 0.0;                   // m
  std::vector<double> spread_;  // (m) m, at rest, from the simulation point of the cell to the farthest of its sources
  Lists sources_;               // (m)
};

}  // namespace deformable_surface::transfer
