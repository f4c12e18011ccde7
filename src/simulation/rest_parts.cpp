#include "rest_parts.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/near_points.h"
#include "deformable_surface/cloud/space_order.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "unconstrained_parts.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kPinPoints = 3;  // that hold a pinned region: fewer would let it turn

constexpr double kBandOfRows = 0.8;  // spacings of the points from which on a pinned band is of several rows

constexpr double kClose = 0.01;  // spacings: nearer points are almost the same; even a cloud at random has one in 3000

constexpr double kClearMargin = 1.3;  // of geodesic neighbours: below it the coupling across a gap may be some per cent
constexpr Index kGapShare = 1000;     // fewer points at gaps than this part of all are holes of the sampling

constexpr double kFar = 1e6;  // m: farther points count as not finite, as in clean()

// For coordinates of maps.
std::string adviseOffset(const cloud::PointCloud& input) {
  const Index num_far = std::count_if(input.positions.begin(), input.positions.end(),
                                      [](const Vec3& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() > kFar; });
  if (num_far == 0) return "";
  return ", within 1e6 m along each axis; " + std::to_string(num_far) +
         " points are beyond: subtract an offset from their coordinates";
}

double findLargest(const Eigen::AlignedBox3d& box) { return box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff(); }

// The step, m, of single precision at the largest coordinate.
double findSingleStep(const Eigen::AlignedBox3d& box) {
  const float at = static_cast<float>(findLargest(box));
  return std::nextafter(at, std::numeric_limits<float>::infinity()) - at;
}

// Of outputs, which are in single precision. The spacing takes time to find, and is only needed far from the origin.
std::string warnOfCoarseOutput(const Points& positions) {
  constexpr double kCoarse = 0.1;  // spacings
  Eigen::AlignedBox3d box;
  for (const Vec3& p : positions) box.extend(p);
  Vec3 sizes = box.sizes();
  std::sort(sizes.data(), sizes.data() + 3);
  const double step = findSingleStep(box);
  if (!(step > kCoarse * std::sqrt(sizes[1] * sizes[2] / static_cast<double>(positions.size())))) return "";
  const double spacing = cloud::findTypicalSpacing(positions);
  if (!(step > kCoarse * spacing)) return "";
  return "messages and files of points are in single precision, in which coordinates near " + formatShort(findLargest(box)) +
         " m go in steps of " + formatShort(step) + " m, where the spacing of the points is " + formatShort(spacing) +
         " m: subtract an offset from the cloud, or give it in a frame near the surface";
}

// The step, m, of single precision at the largest coordinate, if it is why points coincide: all coordinates are of single
// precision, and the step is above half the spacing that these and the lost points have in the box around them; else 0.
double findLostStep(const Points& positions, Index num_lost) {
  constexpr double kCoarse = 0.5;
  Eigen::AlignedBox3d box;
  for (const Vec3& p : positions) {
    const Eigen::Vector3f stored = p.cast<float>();
    if (p != stored.cast<double>()) return 0.0;
    box.extend(p);
  }
  const double step = findSingleStep(box);
  const double all = static_cast<double>(positions.size()) + static_cast<double>(num_lost);
  return step > kCoarse * box.sizes().maxCoeff() / std::sqrt(all) ? step : 0.0;
}

}  // namespace

RestSurface cleanInput(const cloud::PointCloud& input) {
  RestSurface s;
  s.dense = cloud::clean(input);
  const cloud::NearPoints near = cloud::mergeNearPoints(s.dense);
  const Index n = static_cast<Index>(s.dense.positions.size());
  if (n < 3)
    throw InputError("cloud: found " + formatCount(n, "finite distinct points among ") + std::to_string(input.size()) +
                     "; accepted: at least 3" + adviseOffset(input));
  if (cloud::orderInSpace(s.dense))
    s.notes.push_back(
        "neighbours are far apart in the order of the cloud, so that its points are sorted internally (outputs keep the input's "
        "order)");
  // So readers of text name what they do not take for normals.
  const auto isFourth = [](const cloud::ExtraField& field) { return field.name == "column_4"; };
  if (std::any_of(input.extra_fields.begin(), input.extra_fields.end(), isFourth))
    s.notes.push_back(
        "columns 4 to 6 of the file are no normals, since most are not of about unit length (0.9 to 1.1): they are passed on as "
        "fields");
  if (s.dense.num_not_finite > 0)
    s.notes.push_back(
        formatCount(s.dense.num_not_finite, "input points are not finite, or beyond 1e6 m along an axis, and become NaN"));
  if (s.dense.num_coincident > 0) {
    const std::string coincide = formatCount(s.dense.num_coincident, "input points coincide with others and move with them");
    const double step = findLostStep(s.dense.positions, s.dense.num_coincident);
    if (step > 0.0)
      s.warnings.push_back(coincide + ": in single precision, coordinates as large as these are only told apart in steps of " +
                           formatShort(step) + " m; subtract an offset from them before they are stored");
    else
      s.notes.push_back(coincide);
  }
  if (s.warnings.empty())
    if (std::string coarse = warnOfCoarseOutput(s.dense.positions); !coarse.empty()) s.warnings.push_back(std::move(coarse));
  if (near.num_merged > 0)
    s.notes.push_back(formatCount(near.num_merged, "points are at most ") + formatShort(near.distance) +
                      " m from others, where the spacing is " + formatShort(near.spacing) +
                      " m: they are taken for the same points and move with them");
  return s;
}

void warnOfClosePoints(RestSurface& s) {
  if (s.points.size() < 2) return;
  const double spacing = cloud::findTypicalSpacing(s.points);
  const cloud::KdTree tree(s.points);
  std::vector<cloud::Neighbor> near;
  Index num_close = 0;
  double least = kClose * kClose * spacing * spacing;
  const double limit = least;
  for (const Vec3& p : s.points) {
    tree.nearest(p, 2, near);
    if (near.size() < 2 || !(near[1].squared_distance < limit)) continue;
    ++num_close;
    least = std::min(least, near[1].squared_distance);
  }
  if (num_close == 0) return;
  s.warnings.push_back(formatCount(num_close, "simulation points are nearer to another than a hundredth of the spacing, ") +
                       formatShort(spacing) + " m; the nearest two are " + formatShort(std::sqrt(least)) +
                       " m apart: steps may need very many sub-steps; a cloud without such points, or fewer simulation points, "
                       "avoids this");
}

bool hasGaps(const cloud::GeodesicNeighbors& found, const RestSurface& s) {
  return found.num_at_gaps > static_cast<Index>(s.dense.positions.size()) / kGapShare;
}

void noteGaps(const cloud::GeodesicNeighbors& found, RestSurface& s) {
  if (found.num_joined > static_cast<Index>(s.dense.positions.size()) / kGapShare)
    s.warnings.push_back(
        formatCount(found.num_joined, "points are linked to points in front of them, whose normals face theirs: ") +
        "a gap is too narrow for the sampling, and its sides stick together");
  if (found.margin < kClearMargin && hasGaps(found, s))
    s.notes.push_back("the sampling hardly resolves the narrowest gap: " +
                      formatCount(found.num_at_gaps, "points lie at gaps, the ") + "narrowest of which are " +
                      formatReal(std::round(100.0 * found.margin) / 100.0) + " times as wide as what counts as surface");
}

std::vector<double> keepNearOverBody(const cloud::NeighborsParams& params, const Points& points, Lists& neighbors,
                                     RestSurface& s) {
  if (params.areEuclidean()) return {};
  const cloud::GeodesicGraph graph = cloud::buildGeodesicGraph(points, {}, neighbors, params.geodesic_exponent, 0.0, true);
  if (graph.is_directional)
    s.notes.push_back("the body is sampled more densely in one direction than in another: gaps narrower than about " +
                      formatShort(findMedian(graph.trust_radius)) + " m count as part of it");
  cloud::GeodesicNeighbors found = cloud::keepGeodesicNeighbors(graph, points, {}, std::move(neighbors));
  neighbors = std::move(found.lists);
  noteGaps(found, s);
  // Without gaps, detours are those of paths from point to point; weights by them would only make fits narrower.
  if (!hasGaps(found, s)) return {};
  return cloud::geodesicWeights(graph, points, neighbors);
}

namespace {

// Farthest point sampling among the points inside, first from their middle.
void chooseFarthest(const std::vector<Index>& inside, const Points& dense, std::vector<Index>& chosen) {
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

template <typename Contains>
std::vector<Index> findInside(const Points& dense, const Contains& contains) {
  std::vector<Index> inside;
  for (Index i = 0; i < static_cast<Index>(dense.size()); ++i)
    if (contains(dense[i])) inside.push_back(i);
  return inside;
}

[[noreturn]] void refusePin(std::size_t p, const Points& dense) {
  Vec3 low = dense.front(), high = dense.front();
  for (const Vec3& x : dense) low = low.cwiseMin(x), high = high.cwiseMax(x);
  throw InputError("pins[" + std::to_string(p) + "]: the shape holds none of the " +
                   formatCount(static_cast<Index>(dense.size()), "points at rest, which lie from ") + formatPlace(low) + " to " +
                   formatPlace(high) + " m; accepted: a shape that holds at least one");
}

void sortUnique(std::vector<Index>& points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
}

}  // namespace

std::vector<Index> choosePinPoints(const SceneParams& params, const Points& dense) {
  std::vector<Index> chosen;
  for (std::size_t p = 0; p < params.pins.size(); ++p) {
    const std::vector<Index> inside = findInside(dense, [&](const Vec3& x) { return params.pins[p].region.contains(x); });
    if (inside.empty()) refusePin(p, dense);
    chooseFarthest(inside, dense, chosen);
  }
  sortUnique(chosen);
  return chosen;
}

std::vector<tool::ToolParams> findGripsAtRest(const SceneParams& params) {
  std::vector<tool::ToolParams> grips;
  for (const tool::ToolParams& tool : params.tools)
    if (tool.mode == tool::Mode::kMove && tool::isActive(tool, 0.0)) {
      grips.emplace_back();
      grips.back().mode = tool.mode;
      grips.back().shape = tool.shape;
      const tool::Pose pose = tool::interpolate(tool.path, 0.0);
      grips.back().path = {{0.0, pose.position, pose.orientation.coeffs()}};
    }
  return grips;
}

std::vector<Index> chooseHeldPoints(const SceneParams& params, const Points& dense) {
  std::vector<Index> chosen = choosePinPoints(params, dense);
  for (const tool::ToolParams& grip : findGripsAtRest(params)) {
    const tool::Pose pose = tool::interpolate(grip.path, 0.0);
    chooseFarthest(
        findInside(dense, [&](const Vec3& x) { return tool::findSignedDistance(grip.shape, pose, x, 0.0).distance <= 0.0; }),
        dense, chosen);
  }
  sortUnique(chosen);
  return chosen;
}

namespace {

Points pointsIn(const PinParams& pin, const Points& points) {
  Points inside;
  for (const Vec3& p : points)
    if (pin.region.contains(p)) inside.push_back(p);
  return inside;
}

}  // namespace

double measureBand(const Points& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : points) spread += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  // The variance of an even distribution over a length is a twelfth of the length's square.
  return std::sqrt(12.0 * std::max(0.0, Eigen::SelfAdjointEigenSolver<Mat3>(spread, Eigen::EigenvaluesOnly).eigenvalues()[1]));
}

bool isBandOfRows(const Points& points, double spacing) { return !(measureBand(points) < kBandOfRows * spacing); }

double measureBand(const Points& points, const PinParams& pin) { return measureBand(pointsIn(pin, points)); }

bool isBandOfRows(const Points& points, const PinParams& pin, double spacing) {
  return isBandOfRows(pointsIn(pin, points), spacing);
}

void applyPins(const SceneParams& params, RestSurface& s) {
  s.pinned.assign(s.points.size(), 0);
  s.pinned_turns.assign(s.points.size(), 0);
  s.pin_of.assign(s.points.size(), -1);
  for (std::size_t p = 0; p < params.pins.size(); ++p) {
    bool holds_any = false;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
      if (!params.pins[p].region.contains(s.points[i])) continue;
      s.pinned[i] = 1;
      if (s.pin_of[i] < 0) s.pin_of[i] = static_cast<Index>(p);
      if (params.pins[p].orientation) s.pinned_turns[i] = 1;
      holds_any = true;
    }
    if (holds_any) continue;
    const auto isHeld = [&](const Vec3& x) { return params.pins[p].region.contains(x); };
    if (findInside(s.dense.positions, isHeld).empty()) refusePin(p, s.dense.positions);
    throw InputError("pins[" + std::to_string(p) +
                     "]: the points it holds belong to no surface (they are too far from all others); "
                     "accepted: a shape that holds a point of the surface");
  }
  if (params.input.unconstrained_parts == UnconstrainedParts::kFreeze) freezeUnconstrained(params, s);
  if (std::find(s.pinned.begin(), s.pinned.end(), 0) == s.pinned.end())
    s.warnings.push_back("pins hold every simulation point: nothing can move");
}

}  // namespace deformable_surface::simulation
