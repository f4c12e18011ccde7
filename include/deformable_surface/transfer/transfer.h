// From the few simulation points to the many dense ones: displacement and normals as a precomputed sparse operator.
#pragma once

#include "deformable_surface/transfer/transfer_params.h"

#include <functional>

namespace deformable_surface::transfer {

struct PassOutput;

/// Least-squares plane through the displacements of the k nearest simulation points, on the tangent plane of each dense point
/// [Su 2007, eq. 7-8], kept as the rows of value and gradient: u = sum_j w_j u_j, du/dx = sum_j gx_j u_j, du/dy = sum_j gy_j u_j.
/// Departure from the paper: the height of a dense point over the plane fitted to its simulation points turns with the surface
/// instead of keeping its direction in space. Rigid motions are then exact on curved surfaces too. The normal follows from
/// the gradient rows instead of a new covariance analysis.
/// Nine or more simulation points for ten dense ones: a dense point at the place of one takes its displacement, not that of the
/// plane.
/// Degenerate neighbourhoods: if the projected neighbours are collinear the displacement is linear along their line and constant
/// across. If they coincide or there is one, it is their weighted mean. Without neighbours the point stays. Weights are float
/// (their error is 1e-7 of the displacement), positions double.
class Transfer {
 public:
  Transfer() = default;

  /// dense (n x 3), normals (n x 3, unit), simulation (m x 3): all at rest. Only simulation points with usable[j] != 0 are
  /// taken. InputError if arrays do not fit, points are not finite or an option is out of range. Parallel; O(n (log m + k)).
  /// followed: (n) the simulation points that each dense point follows, at most k, nearest first, all usable; if null, they are
  /// the k nearest in space.
  Transfer(const Points& dense, const Points& normals, const Points& simulation, const std::vector<char>& usable,
           const TransferParams& params, const Lists* followed = nullptr);

  /// The row of a dense point. Rows that follow fewer than k points are filled up with weights of zero.
  struct PointRow {
    std::vector<Index> source;                          // (k)
    std::vector<double> value, gradient_x, gradient_y;  // (k) weights; gradients in 1/m
    Vec3 rest, normal, tangent_x, tangent_y;            // m; unit; of the fitted plane, see above
    double slope_x, slope_y, height;                    // of that plane against the surface's, and m over it
  };
  PointRow rowOf(Index dense) const;
  Index numNeighbors() const { return k_; }  // k
  /// The simulation points that a dense point follows, nearest first.
  std::vector<Index> sourcesOf(Index dense) const;
  /// Makes some dense points (ascending) follow other simulation points: followed (as many lists as points), as in the
  /// constructor. The rest of the operator stays bit for bit. normals (n x 3) and params as there.
  void refit(const std::vector<Index>& dense, const Lists& followed, const Points& normals, const TransferParams& params);

  /// positions (m x 3) of the simulation points now -> dense positions (n x 3) and, if wanted, unit normals (n x 3 float).
  /// A normal whose transferred tangents are parallel keeps its rest direction. At rest the positions are the rest positions to
  /// the bit. Parallel, nothing is allocated after the first call; may be called from several threads.
  void apply(const Points& simulation_now, Points& dense_now) const;
  void apply(const Points& simulation_now, Points& dense_now, std::vector<Eigen::Vector3f>& normals_now) const;

  /// The motion of the last update(), which the next one compares with.
  class Frame {
   public:
    /// The next update computes everything.
    void forget() { is_made_ = false; }

   private:
    friend class Transfer;
    bool is_made_ = false, has_normals_ = false;
    Vec3 reference_ = Vec3::Zero(), next_reference_ = Vec3::Zero();
    std::vector<float> displacements_, next_displacements_;
    std::vector<char> moved_;   // (m)
    std::vector<Index> stale_;  // tiles
  };
  /// Dense points that are computed together, consecutive in memory.
  static constexpr Index kTilePoints = 1024;
  Index numTiles() const { return static_cast<Index>(tile_sources_.size()); }
  /// The same as apply(), bit for bit, if dense_now and normals_now (null: none) are as the last update of this frame left
  /// them: only tiles that follow a simulation point which has moved since are computed. after(begin, end) is called for each of
  /// them, in parallel, while its points are in the cache. Returns how many tiles were computed. The operator must be that of the
  /// last update.
  Index update(const Points& simulation_now, Frame& frame, Points& dense_now, std::vector<Eigen::Vector3f>* normals_now,
               const std::function<void(Index begin, Index end)>& after) const;

  /// Local change of area, |t1' x t2'| / |t1 x t2|, of each dense point (n).
  void areaRatio(const Points& simulation_now, std::vector<float>& ratio) const;

  /// The largest of the values (m) of the simulation points that each dense point follows (n).
  void findLargest(const std::vector<float>& values, std::vector<float>& largest) const;

  Index numDense() const;
  Index numSimulation() const;
  Index numDegenerate() const;        // dense points whose neighbourhood has no plane
  std::size_t bytesPerPoint() const;  // of the operator, for the benchmark

 private:
  // Fills row i of the operator from the neighbours of dense point i; true if they span its plane.
  bool fitRow(Index i, const Vec3& normal, const Points& simulation, const std::vector<Index>& found,
              const TransferParams& params);

  // Displacements (max(m, 1) x 4) less a reference near their mean; the reference is zero for small motions of few points.
  void findDisplacements(const Points& simulation_now, Vec3& reference, std::vector<float>& displacements) const;
  void findTileSources(Index tile);

  void run(Index begin, Index end, const float* displacements, const Vec3& reference, const PassOutput& output) const;
  void runAll(const Points& simulation_now, const PassOutput& output) const;

  // All arrays are in the user's order of the dense points, so that everything streams except the displacements, which are few.
  // Within a group of points, the values of each quantity lie side by side (the last group is padded with zeros).
  Index k_ = 0;  // row length
  Index num_degenerate_ = 0;
  std::vector<Index> index_;   // (groups x k x lanes) simulation points; rows with fewer are filled up with weight zero
  std::vector<float> weight_;  // (groups x k x 3 x lanes) weight in the value row and in the two gradient rows (1/m)
  std::vector<float> frame_;   // (groups x 12 x lanes) fitted tangents, normal, slopes and height over the fitted plane
  Points rest_;                // (n x 3) m
  Points simulation_rest_;     // (m x 3) m
  std::vector<char> usable_;   // (m)
  Index num_usable_ = 0;
  std::vector<std::vector<Index>> tile_sources_;  // (tiles) simulation points that any point of a tile follows
};

}  // namespace deformable_surface::transfer
