// Some of the dense points, evaluated one by one. Transfer evaluates all of them at once; contact needs few of them, in every
// sub-step, and applies forces to them.
#pragma once

#include "deformable_surface/transfer/transfer.h"

#include <vector>

namespace deformable_surface::transfer {

/// Dense points in the cells of simulation points. Each is where Transfer places it: p = sum_j w_j x_j + h n, with x_j the
/// simulation points that it follows, n the unit normal of the transferred tangents and h its height over the fitted plane.
/// Results are those of Transfer except for its float rounding.
class SampledPoints {
 public:
  SampledPoints() = default;
  /// rows: an operator for the sampled points alone. simulation (m x 3): at rest, m. cell (s): the simulation point of the cell
  /// of each sample, ascending. is_spare (s): samples that are used only where the others do not suffice; empty: none.
  SampledPoints(const Transfer& rows, const Points& simulation, const std::vector<Index>& cell, std::vector<char> is_spare = {});

  Index size() const { return static_cast<Index>(cell_.size()); }
  /// The samples of a cell are consecutive.
  Index begin(Index cell) const { return begin_[cell]; }
  Index end(Index cell) const { return begin_[cell + 1]; }
  Index cellOf(Index s) const { return cell_[s]; }
  bool isSpare(Index s) const { return !is_spare_.empty() && is_spare_[s]; }
  /// Largest distance, m, at rest, of the samples of a cell from its simulation point.
  double radius(Index cell) const { return radius_[cell]; }
  /// Bound of the distance of a sample from the simulation point of its cell, as a fraction of findReach().
  double share(Index s) const { return share_[s]; }
  /// Largest distance, m, of the samples of the cell from the planes fitted through the simulation points at rest.
  double height(Index cell) const { return height_[cell]; }
  /// Largest present distance, m, of the samples of the cell from its simulation point: that at rest times the local stretch of
  /// the surface, and what a sharp bend can add, which the samples do not follow.
  double findReach(Index cell, const Points& simulation_now) const;

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
      if (rows_[e].value != 0.0) visit(rows_[e].point, rows_[e].value);
  }

  /// The samples whose sources are all kept, for fewer simulation points: new_index (of the former points) or -1. old receives
  /// the former index of each kept sample.
  SampledPoints takePart(const std::vector<Index>& new_index, Index new_size, std::vector<Index>& old) const;

 private:
  struct Entry {
    Index point;
    double value, gradient_x, gradient_y;  // weights of the value row and, 1/m, of the gradient rows
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
  void listCells(Index num_cells);
  double findSpread(Index cell, const Points& simulation) const;

  Index k_ = 0;
  std::vector<Entry> rows_;   // (s x k)
  std::vector<Frame> frame_;  // (s)
  std::vector<Index> cell_, begin_;
  std::vector<char> is_spare_;           // (s), or empty
  std::vector<double> share_;            // (s)
  std::vector<double> radius_, height_;  // (m)
  std::vector<double> spread_;           // (m) m, at rest, from the simulation point of the cell to the farthest of its sources
  Lists sources_;                        // (m)
};

}  // namespace deformable_surface::transfer
