#include "rest_parts.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/space_order.h"
#include "deformable_surface/model/mass_spring/mass_spring.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

#include "unheld.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kPinPoints = 3;  // that hold a pinned region: fewer would let it turn

// Spacings of the points from which on a pinned band is of several rows, and up to which it is of one.
constexpr double kBandOfRows = 0.8, kBandOfOneRow = 0.5;

constexpr double kClearMargin = 1.3;  // of geodesic neighbours: below it the coupling across a gap may be some per cent
constexpr Index kGapShare = 1000;     // fewer points at gaps than this part of all are holes of the sampling

}  // namespace

std::string count(Index n, const std::string& what) { return std::to_string(n) + " " + what; }

RestSurface cleanInput(const cloud::PointCloud& input) {
  RestSurface s;
  s.dense = cloud::clean(input);
  const Index n = static_cast<Index>(s.dense.positions.size());
  if (n < 3)
    throw InputError("cloud: found " + count(n, "finite distinct points among ") + std::to_string(input.size()) +
                     "; accepted: at least 3");
  if (cloud::orderInSpace(s.dense))
    s.notes.push_back("the cloud's order jumps about in space: inside, its points lie in another (outputs are in the input's)");
  if (s.dense.num_not_finite > 0)
    s.notes.push_back(
        count(s.dense.num_not_finite, "input points are not finite, or beyond 1e6 m along an axis, and become NaN"));
  if (s.dense.num_coincident > 0)
    s.notes.push_back(count(s.dense.num_coincident, "input points coincide with others and move with them"));
  return s;
}

bool hasGaps(const cloud::GeodesicNeighbors& found, const RestSurface& s) {
  return found.num_at_gaps > static_cast<Index>(s.dense.positions.size()) / kGapShare;
}

void noteGaps(const cloud::GeodesicNeighbors& found, RestSurface& s) {
  if (found.num_joined > static_cast<Index>(s.dense.positions.size()) / kGapShare)
    s.warnings.push_back(count(found.num_joined, "points are linked to points in front of them, whose normals face theirs: ") +
                         "a gap is too narrow for the sampling, and its sides stick together");
  if (found.margin < kClearMargin && hasGaps(found, s))
    s.notes.push_back("the sampling hardly resolves the narrowest gap: " + count(found.num_at_gaps, "points lie at gaps, the ") +
                      "narrowest of which are " + formatReal(std::round(100.0 * found.margin) / 100.0) +
                      " times as wide as what counts as surface");
}

std::vector<Index> choosePinPoints(const SceneParams& params, const Points& dense) {
  std::vector<Index> chosen;
  for (std::size_t p = 0; p < params.pins.size(); ++p) {
    std::vector<Index> inside;
    for (Index i = 0; i < static_cast<Index>(dense.size()); ++i)
      if (params.pins[p].region.contains(dense[i])) inside.push_back(i);
    if (inside.empty())
      throw InputError("pins[" + std::to_string(p) + "]: the shape holds none of the " +
                       count(static_cast<Index>(dense.size()), "points at rest; accepted: a shape that holds at least one"));
    // Farthest point sampling, first from the middle.
    Vec3 middle = Vec3::Zero();
    for (Index i : inside) middle += dense[i] / static_cast<double>(inside.size());
    std::vector<double> distance(inside.size());
    for (std::size_t k = 0; k < inside.size(); ++k) distance[k] = (dense[inside[k]] - middle).squaredNorm();
    for (Index c = 0; c < kPinPoints && c < static_cast<Index>(inside.size()); ++c) {
      const std::size_t far = std::max_element(distance.begin(), distance.end()) - distance.begin();
      const Index point = inside[far];
      chosen.push_back(point);
      for (std::size_t k = 0; k < inside.size(); ++k) {
        const double to_point = (dense[inside[k]] - dense[point]).squaredNorm();
        distance[k] = c == 0 ? to_point : std::min(distance[k], to_point);
      }
    }
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

namespace {

// How wide the narrower of the two ways is in which points spread most, m: rows of points side by side have it, a single one has
// next to none.
double measureBand(const Points& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : points) spread += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  // Of an even spread over a length its square is a twelfth of the length's.
  return std::sqrt(12.0 * std::max(0.0, Eigen::SelfAdjointEigenSolver<Mat3>(spread, Eigen::EigenvaluesOnly).eigenvalues()[1]));
}

Points pointsIn(const PinParams& pin, const Points& points) {
  Points inside;
  for (const Vec3& p : points)
    if (pin.region.contains(p)) inside.push_back(p);
  return inside;
}

}  // namespace

bool isBandOfRows(const Points& points, double spacing) { return !(measureBand(points) < kBandOfRows * spacing); }

bool isBandOfRows(const Points& points, const PinParams& pin, double spacing) {
  return isBandOfRows(pointsIn(pin, points), spacing);
}

// Copies of fewer points know no better.
void findHingedPins(const SceneParams& params, const Points& dense, RestSurface& s) {
  if (params.model != ModelKind::kMassSpring || s.points.size() >= dense.size()) return;
  const auto& surface = static_cast<const model::MassSpring&>(*s.model);
  if (surface.hasCurvature() && surface.numHinged() == 0) return;
  const double spacing = std::sqrt(s.area / static_cast<double>(s.points.size()));
  const double full_spacing = std::sqrt(s.area / static_cast<double>(dense.size()));
  for (std::size_t p = 0; p < params.pins.size(); ++p) {
    const double full = measureBand(pointsIn(params.pins[p], dense)), band = measureBand(pointsIn(params.pins[p], s.points));
    if (full < kBandOfRows * full_spacing || band > kBandOfOneRow * spacing) continue;
    s.has_hinged_pins = true;
    s.warnings.push_back("pins[" + std::to_string(p) + "] holds a band " + formatShort(full) +
                         " m wide, which clamps the cloud but is narrower than the spacing of the simulation points, " +
                         formatShort(spacing) +
                         " m, and a hinge to them, by which no error can be estimated: a wider pin or "
                         "more simulation points clamp these, too");
  }
}

void applyPins(const SceneParams& params, RestSurface& s) {
  s.pinned.assign(s.points.size(), 0);
  s.pinned_turns.assign(s.points.size(), 0);
  for (std::size_t p = 0; p < params.pins.size(); ++p) {
    bool holds_any = false;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
      if (!params.pins[p].region.contains(s.points[i])) continue;
      s.pinned[i] = 1;
      if (params.pins[p].orientation) s.pinned_turns[i] = 1;
      holds_any = true;
    }
    if (!holds_any)
      throw InputError("pins[" + std::to_string(p) +
                       "]: the points it holds belong to no surface (they are too far from all others); "
                       "accepted: a shape that holds a point of the surface");
  }
  if (params.input.unheld == Unheld::kFreeze) freezeUnheld(params, s);
  if (std::find(s.pinned.begin(), s.pinned.end(), 0) == s.pinned.end())
    s.warnings.push_back("pins hold every simulation point: nothing can move");
}

}  // namespace deformable_surface::simulation
