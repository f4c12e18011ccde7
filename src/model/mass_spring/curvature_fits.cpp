// Chooses the neighbours of each fit of curvature, and solves its least squares, one-sided at the edges of clamps. The evaluation
// of the fits at a state is in curvature_bending.cpp.
#include "curvature_fits.h"

#include "deformable_surface/base/parallel.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_surface::model {
namespace {

constexpr Index kFitPoints = CurvatureBending::kFitPoints;
constexpr Index kSlots = kFitPoints + 1;
constexpr Index kBlock = 64;     // fits per task: about a millisecond
constexpr double kReach = 1.05;  // kernel support over the farthest neighbour's distance, so that it still counts
// Moments change fast beside clamps, where smaller fits smooth less. Elsewhere smaller fits would reveal that membranes of few
// curved triangles are too stiff (docs/decisions/0007-balanced-bending.md).
constexpr Index kFitPointsAtClamps = 12;
constexpr double kSteepness = 1.5;       // exponent of a weight's root
constexpr int kRingsAtClamps = 3;        // from the edge
constexpr double kRankTolerance = 1e-3;  // smallest pivot over the largest for a fit to count as determined

// The nearest points, up to a number, among the first, second and, if these are too few, third ring.
void chooseFitPoints(Index i, const PlateRest& plate, Index most, std::vector<Index>& found) {
  const Points& rest = plate.points;
  found.assign(1, i);
  std::size_t level = 0;
  for (int depth = 0; depth < 3 && (depth < 2 || static_cast<Index>(found.size()) <= most); ++depth) {
    const std::size_t end = found.size();
    for (; level < end; ++level)
      for (const Index* j = plate.ring.begin(found[level]); j != plate.ring.end(found[level]); ++j)
        if (std::find(found.begin(), found.end(), *j) == found.end()) found.push_back(*j);
  }
  found.erase(found.begin());
  std::sort(found.begin(), found.end(), [&](Index a, Index b) {
    const double da = (rest[a] - rest[i]).squaredNorm(), db = (rest[b] - rest[i]).squaredNorm();
    return da != db ? da < db : a < b;
  });
  if (static_cast<Index>(found.size()) > most) found.resize(most);
}

template <int Rows, int Columns>
using Small = Eigen::Matrix<double, Rows == 0 ? Eigen::Dynamic : Rows, Columns == 0 ? Eigen::Dynamic : Columns, 0,
                            Rows == 0 ? kFitPoints : Rows, Columns == 0 ? kFitPoints : Columns>;
using Weights = Small<0, 1>;

// Least squares with weighted rows: for each neighbour the coefficients per unit of its position, and the orthonormal columns
// that span those of the design. False if the rows do not determine it.
template <int Columns>
bool solveLeastSquares(const Small<0, Columns>& design, const Weights& root_weight, Small<Columns, 0>& inverse,
                       Small<0, Columns>& q) {
  if (design.rows() < Columns) return false;
  const Eigen::ColPivHouseholderQR<Small<0, Columns>> solver(design);
  const auto pivots = solver.matrixQR().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > kRankTolerance * pivots.maxCoeff())) return false;
  q = Small<0, Columns>::Identity(design.rows(), Columns);
  q.applyOnTheLeft(solver.householderQ());
  inverse = q.transpose() * root_weight.asDiagonal();
  solver.matrixQR().template topLeftCorner<Columns, Columns>().template triangularView<Eigen::Upper>().solveInPlace(inverse);
  inverse = solver.colsPermutation() * inverse;
  return true;
}

struct Solution {
  Small<5, 0> inverse;
  CurvatureFits::Basis basis;
};

bool solveFree(const Small<0, 5>& design, const Weights& root_weight, Solution& solution) {
  Small<0, 5> q;
  if (!solveLeastSquares<5>(design, root_weight, solution.inverse, q)) return false;
  solution.basis.q.topRows(q.rows()) = q;
  for (Index m = 0; m < q.rows(); ++m) solution.basis.root[m] = root_weight[m];
  return true;
}

// At the edge of a clamp: the curvature, with the slope of the held patch, whose points come after the neighbours.
bool solveClamped(const Small<0, 5>& design, const Weights& root_weight, const EdgePoint& edge, const TangentAxes& axes,
                  double reach, Solution& solution) {
  const Index k = static_cast<Index>(design.rows());
  const Small<0, 3> bent = design.rightCols<3>();
  Small<0, 3> q;
  Small<3, 0> curvatures;
  if (!solveLeastSquares<3>(bent, root_weight, curvatures, q)) return false;
  solution.inverse.setZero(5, k + 3);
  solution.inverse.block(2, 0, 3, k) = curvatures;
  solution.basis.q.topLeftCorner(k, 3) = q;
  for (Index m = 0; m < k; ++m) solution.basis.root[m] = root_weight[m];
  for (int h = 0; h < 3; ++h) {
    const Vec2 slope = reach * Vec2(edge.gradients[h].dot(axes.first), edge.gradients[h].dot(axes.second));
    solution.inverse.col(k + h).head<2>() = slope;
    // Subtracts what the slope alone gives at the neighbours. A row of the design is weighted.
    for (Index m = 0; m < k; ++m)
      solution.inverse.col(k + h).tail<3>() -= curvatures.col(m) * (design.row(m).head<2>().dot(slope) / root_weight[m]);
  }
  return true;
}

}  // namespace

void growRings(const Lists& ring, int rings, std::vector<char>& marked) {
  std::vector<Index> found;
  for (Index i = 0; i < ring.size(); ++i)
    if (marked[i]) found.push_back(i);
  std::size_t next = 0;
  for (int depth = 0; depth < rings; ++depth)
    for (const std::size_t end = found.size(); next < end; ++next)
      for (Index k = 0; k < ring.count(found[next]); ++k) {
        const Index j = ring.begin(found[next])[k];
        if (!std::exchange(marked[j], 1)) found.push_back(j);
      }
}

std::vector<char> markBesideClamps(const ClampedPlate& clamped) {
  std::vector<char> marked(clamped.plate.ring.size(), 0);
  std::fill(marked.begin() + clamped.num_points, marked.end(), char{1});
  growRings(clamped.plate.ring, kRingsAtClamps, marked);
  return marked;
}

CurvatureFits fitCurvatures(const ClampedPlate& clamped, const std::vector<Index>& points) {
  const PlateRest& plate = clamped.plate;
  const Index n = static_cast<Index>(points.size());
  CurvatureFits fits;
  fits.reach.assign(n, 0.0);
  fits.bases.resize(n);
  // Each fit writes to its own slots; the lists are made from these.
  std::vector<Index> slots(kSlots * n);
  std::vector<CurvatureRow> rows(kSlots * n);
  std::vector<Index> counts(n, 1);
  const std::vector<char> beside_clamp = markBesideClamps(clamped);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    std::vector<Index> fit;
    for (Index f = begin; f < end; ++f) {
      const Index i = points[f];
      slots[kSlots * f] = i;
      rows[kSlots * f] = {Vec2::Zero(), Vec3::Zero()};
      fits.bases[f].root.fill(0.0);
      fits.bases[f].q.setZero();
      const EdgePoint* const edge = clamped.isEdge(i) ? &clamped.edge_points[i - clamped.num_points] : nullptr;
      if (!edge && clamped.is_inner[i]) continue;
      const bool is_beside = beside_clamp[i];
      chooseFitPoints(i, plate, edge ? kFitPoints - 3 : (is_beside ? kFitPointsAtClamps : kFitPoints), fit);
      const Index k = static_cast<Index>(fit.size());
      if (k < 5) continue;
      // The weighted quadratic in tangent coordinates scaled by the reach.
      const TangentAxes axes(plate.normals[i]);
      const double reach = kReach * (plate.points[fit.back()] - plate.points[i]).norm();
      Small<0, 5> design(k, 5);
      Weights root_weight(k);
      for (Index m = 0; m < k; ++m) {
        const Vec3 d = (plate.points[fit[m]] - plate.points[i]) / reach;
        const double a = d.dot(axes.first), b = d.dot(axes.second);
        const double near = 1.0 - d.squaredNorm(), q = is_beside ? std::pow(near, kSteepness) : near;
        root_weight[m] = q;
        design.row(m) << q * a, q * b, 0.5 * q * a * a, q * a * b, 0.5 * q * b * b;
      }
      Solution solution;
      solution.basis = fits.bases[f];
      if (edge ? !solveClamped(design, root_weight, *edge, axes, reach, solution) : !solveFree(design, root_weight, solution))
        continue;
      if (edge) fit.insert(fit.end(), edge->points, edge->points + 3);
      fits.bases[f] = solution.basis;
      fits.reach[f] = reach;
      counts[f] = static_cast<Index>(fit.size()) + 1;
      CurvatureRow& own = rows[kSlots * f];
      for (Index m = 0; m < static_cast<Index>(fit.size()); ++m) {
        CurvatureRow& row = rows[kSlots * f + 1 + m];
        row = {solution.inverse.block<2, 1>(0, m) / reach, solution.inverse.block<3, 1>(2, m) / (reach * reach)};
        own.first -= row.first;
        own.second -= row.second;
        slots[kSlots * f + 1 + m] = fit[m];
      }
    }
  });
  for (Index f = 0; f < n; ++f) {
    fits.points.items.insert(fits.points.items.end(), &slots[kSlots * f], &slots[kSlots * f] + counts[f]);
    fits.rows.insert(fits.rows.end(), &rows[kSlots * f], &rows[kSlots * f] + counts[f]);
    fits.points.offsets.push_back(static_cast<Index>(fits.points.items.size()));
  }
  return fits;
}

}  // namespace deformable_surface::model
