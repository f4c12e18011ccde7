// Some of the dense points, followed one by one. Apart from the transfer, which makes all of them at once: contact looks at few
// of them, in every sub-step, and puts forces on them.
#pragma once

#include "deformable_surface/transfer/transfer.h"

#include <vector>

namespace deformable_surface::transfer {

/// Dense points in the cells of simulation points. Each is where Transfer puts it: p = sum_j w_j x_j + h n, with x_j the
/// simulation points that it follows, n the unit normal of the transferred tangents and h its height over the fitted plane.
/// Results are Transfer's but for its float rounding.
class SampledPoints {
 public:
  SampledPoints() = default;
  /// rows: an operator on the sampled points alone. simulation (m x 3): at rest, m. cell (s): the simulation point of the cell in
  /// which each lies, ascending.
  SampledPoints(const Transfer& rows, const Points& simulation, const std::vector<Index>& cell);

  Index size() const { return static_cast<Index>(cell_.size()); }
  /// The samples of a cell follow each other.
  Index begin(Index cell) const { return begin_[cell]; }
  Index end(Index cell) const { return begin_[cell + 1]; }
  Index cellOf(Index s) const { return cell_[s]; }
  /// m, at rest, of the sample of a cell that is farthest from its simulation point.
  double radius(Index cell) const { return radius_[cell]; }
  /// How far from the simulation point of its cell a sample lies at rest, as a share of radius().
  double share(Index s) const { return share_[s]; }
  /// m, how far samples of the cell lie beside the planes that are fitted through the simulation points at rest.
  double height(Index cell) const { return height_[cell]; }
  /// The simulation points that samples of the cell follow, ascending.
  const Lists& sources() const { return sources_; }
  /// m, how far from the simulation point of the cell its samples can be now: as at rest, stretched as the surface is there.
  double findReach(Index cell, const Points& simulation_now) const;

  /// m, from the positions (m x 3) of the simulation points now.
  Vec3 place(Index s, const Points& simulation_now) const;
  /// m/s, but for what h n adds.
  Vec3 findVelocity(Index s, const Points& velocities) const;
  /// Adds to forces (m x 3), N, what a force on the sample does to the simulation points: the transpose of the derivative of
  /// place().
  void scatter(Index s, const Points& simulation_now, const Vec3& force, Points& forces) const;
  /// visit(simulation point, weight) for the points that a sample follows; weights sum to 1.
  template <class Visit>
  void visitWeights(Index s, const Visit& visit) const {
    for (Index e = s * k_; e < (s + 1) * k_; ++e)
      if (rows_[e].value != 0.0) visit(rows_[e].point, rows_[e].value);
  }

  /// The samples of which all sources are left, for fewer simulation points: new_index (of those before) or -1. old (as many as
  /// are left) says which they were.
  SampledPoints takePart(const std::vector<Index>& new_index, Index new_size, std::vector<Index>& old) const;

 private:
  struct Entry {
    Index point;
    double value, gradient_x, gradient_y;  // weights of the value row and, 1/m, of the gradient rows
  };
  struct Frame {
    Vec3 offset = Vec3::Zero();       // m, of the point, beside what the row gives: rounding
    Vec3 tangent_x, tangent_y;        // the same of the tangents: where neighbours lie in a line, all of one
    double slope_x, slope_y, height;  // of the fitted plane, and m over it
  };
  struct Tangents {
    Vec3 x, y, normal;  // normal: not of unit length
  };
  Tangents findTangents(Index s, const Points& simulation_now) const;
  void listCells(Index num_cells);
  double findSpread(Index cell, const Points& simulation) const;

  Index k_ = 0;
  std::vector<Entry> rows_;   // (s x k)
  std::vector<Frame> frame_;  // (s)
  std::vector<Index> cell_, begin_;
  std::vector<double> share_;            // (s)
  std::vector<double> radius_, height_;  // (m)
  std::vector<double> spread_;           // (m) m, at rest, from the simulation point of the cell to the farthest of its sources
  Lists sources_;                        // (m)
};

}  // namespace deformable_surface::transfer
