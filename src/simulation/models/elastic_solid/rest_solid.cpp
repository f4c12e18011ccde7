// From a cloud to an elastic solid: a body has neither rings nor tangent planes.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/notice.h"
#include "deformable_surface/cloud/farthest_points.h"
#include "deformable_surface/cloud/geodesic_cells.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/elastic_solid/elastic_solid.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "../../behind_noise.h"
#include "../../rest_steps.h"
#include "rest.h"

namespace deformable_surface::simulation {
namespace {

constexpr Index kAutoPoints = 5000;  // simulation points of auto: a soft bar of them moves in real time on one core
constexpr Index kSolidRatio = 8, kFewestOfSolid = 100;  // of copies: doubled spacing in space; fewer carry no shape of a body
constexpr double kFlat = 0.02;  // of the spacing: rms distance from a plane below which a cloud lies in it
constexpr Index kLocal = 12;    // neighbours that show whether a point lies in a body or on a surface
constexpr double kThin = 0.25;  // their spread across over that along: a curved surface has less, the face of a body about a half
constexpr double kLoneSide = 0.25;  // how far the neighbours' middle lies off a point on the outside, over their distance

struct Spread {
  Vec3 middle, normal;   // the normal of the plane that fits best, with its largest part positive
  double across, along;  // rms, m: across it, and along its second direction
};

template <class At>
Spread measureSpread(Index n, const At& at) {
  Spread s;
  s.middle.setZero();
  for (Index k = 0; k < n; ++k) s.middle += at(k) / static_cast<double>(n);
  Mat3 covariance = Mat3::Zero();
  for (Index k = 0; k < n; ++k) covariance += (at(k) - s.middle) * (at(k) - s.middle).transpose() / static_cast<double>(n);
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance);
  s.across = std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
  s.along = std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
  s.normal = solver.eigenvectors().col(0);
  constexpr double kRounding = 1e-12;  // of a direction: a plane across an axis is that
  s.normal = (s.normal.array().abs() < kRounding).select(0.0, s.normal).normalized();
  int largest = 0;
  s.normal.cwiseAbs().maxCoeff(&largest);
  if (s.normal[largest] < 0.0) s.normal = -s.normal;
  return s;
}

// The normal of a planar cloud, or zero for one that fills space. Refuses other clouds.
Vec3 findAcross(const SceneParams& params, const RestSurface& s) {
  const Points& x = s.dense.positions;
  const Index n = static_cast<Index>(x.size());
  std::vector<double> spacing, thinness;
  for (Index i = 0; i < n; ++i) {
    const Index count = std::min(kLocal, s.dense_neighbors.count(i));
    if (count == 0) continue;
    const Index* near = s.dense_neighbors.begin(i);
    spacing.push_back((x[near[0]] - x[i]).norm());
    const Spread local = measureSpread(count + 1, [&](Index k) { return k < count ? x[near[k]] : x[i]; });
    thinness.push_back(local.along > 0.0 ? local.across / local.along : 1.0);
  }
  const Spread all = measureSpread(n, [&](Index k) { return x[k]; });
  const bool is_flat = all.across <= kFlat * findMedian(spacing);
  const model::SolidDimension wanted = params.elastic_solid.dimension;
  if (!(all.along > kFlat * findMedian(spacing)))
    throw InputError("cloud: its " + formatCount(n, "points lie on a line; accepted: those of a body, or of a part of a plane"));
  if (wanted == model::SolidDimension::kPlanar && !is_flat)
    throw InputError("elastic_solid.dimension: found planar, but the points lie " + formatShort(all.across) +
                     " m (rms) off the plane that fits them best; accepted: points in a plane, or volume");
  if (wanted == model::SolidDimension::kVolume && is_flat)
    throw InputError(
        "elastic_solid.dimension: found volume, but all points lie in a plane; accepted: points that fill space, or planar");
  if (is_flat) return all.normal;
  if (findMedian(thinness) < kThin)
    throw InputError(
        "cloud: its " +
        formatCount(
            n,
            "points lie on a curved surface; elastic_solid accepts those that fill a body, or a part of a plane, and with "
            "elastic_solid.fill: true those of a closed surface (if they are layers of a body, farther apart than the points "
            "along them: neighbors.geodesic_exponent: 1)"));
  return Vec3::Zero();
}

// Given normals; else points on the outside get the direction away from their neighbours, inner ones none. Planar solids have
// their own.
void completeNormals(const Vec3& across, RestSurface& s) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  if (!s.dense.normals.empty()) return;
  s.dense.normals.assign(n, across);
  if (!across.isZero(0.0)) return;
  for (Index i = 0; i < n; ++i) {
    Vec3 sum = Vec3::Zero();
    double distance = 0.0;
    for (const Index* j = s.dense_neighbors.begin(i); j != s.dense_neighbors.end(i); ++j) {
      sum += s.dense.positions[*j] - s.dense.positions[i];
      distance += (s.dense.positions[*j] - s.dense.positions[i]).norm();
    }
    if (sum.norm() > kLoneSide * distance) s.dense.normals[i] = -sum.normalized();
  }
}

std::vector<Index> choosePoints(const SceneParams& params, RestSurface& s) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  const cloud::SimplificationParams& how = params.simplification;
  const bool by_threshold =
      how.method == cloud::SimplificationMethod::kDelaunay && how.target_points == 0 && !how.threshold.is_auto;
  const Index target = findSolidTarget(how, n);
  s.order.num_points = n;
  const Index last = by_threshold ? Index{4} : target;
  if (last < n)
    s.order = cloud::orderByDistance(s.dense.positions, s.dense_neighbors, last, choosePinPoints(params, s.dense.positions));
  return by_threshold ? s.order.keepDiameter(how.threshold.value) : s.order.keepCount(target);
}

// The simulation points that each dense point follows.
Lists findFollowed(const SceneParams& params, const cloud::GeodesicCells& cells, const Points& dense, const Points& simulation) {
  if (!params.neighbors.areEuclidean()) return cloud::findChosenNear(cells, dense, 2 * params.transfer.k);
  Lists followed;
  const cloud::KdTree tree(simulation);
  std::vector<cloud::Neighbor> near;
  for (const Vec3& x : dense) {
    tree.nearest(x, 2 * params.transfer.k, near);
    for (const cloud::Neighbor& other : near) followed.items.push_back(other.index);
    followed.offsets.push_back(static_cast<Index>(followed.items.size()));
  }
  return followed;
}

std::vector<Index> findFirst(const Lists& lists) {
  std::vector<Index> first;
  for (Index i = 0; i < lists.size(); ++i) first.push_back(*lists.begin(i));
  return first;
}

// In space there are more directions than in a plane.
Index countNeighbors(const SceneParams& params, const Vec3& across) {
  return across.isZero(0.0) ? 2 * params.neighbors.k : params.neighbors.k;
}

void noteGravityAcross(const SceneParams& params, const Vec3& across, RestSurface& s) {
  constexpr double kRounding = 1e-9;
  const auto leaves = [&](const Vec3& v) { return std::abs(across.dot(v)) > kRounding * v.norm(); };
  if (leaves(params.gravity))
    s.warnings.push_back("the solid is planar and moves in its plane only: gravity perpendicular to it is ignored");
}

}  // namespace

Index findSolidTarget(const cloud::SimplificationParams& how, Index of) {
  if (how.method == cloud::SimplificationMethod::kNone) return of;
  return how.target_points > 0 ? how.target_points : kAutoPoints;
}

namespace {

// Model, pins and notes on the simulation points.
void finishSolid(const SceneParams& params, model::Outline outline, RestSurface& s) {
  if (!s.across.isZero(0.0) && params.elastic_solid.law == model::SolidLaw::kNeoHookean &&
      params.elastic_solid.plane == model::PlaneKind::kStress)
    throw InputError(
        "elastic_solid.law: found neo_hookean for a plate; accepted: corotated or linear, or elastic_solid.plane: strain");
  auto solid = std::make_unique<model::ElasticSolid>(s.points, s.solid_neighbors, s.detours, s.across, params.material,
                                                     params.elastic_solid, outline, s.point_volumes);
  if (solid->numDeficient() > 0)
    s.notes.push_back(
        formatCount(solid->numDeficient(), "points have neighbours in a plane or on a line only; across it they have no strain"));
  s.point_volumes = solid->volumes();
  const double volume = std::accumulate(s.point_volumes.begin(), s.point_volumes.end(), 0.0);
  s.model = std::move(solid);
  applyPins(params, s);
  const bool is_planar = !s.across.isZero(0.0);
  if (is_planar)
    for (double& v : s.point_volumes) v /= params.material.thickness;
  if (is_planar) noteGravityAcross(params, s.across, s);
  const Index m = static_cast<Index>(s.points.size());
  // The area of a surface with as many points at that spacing: lengths are measured relative to it.
  const double spacing = is_planar ? std::sqrt(volume / (params.material.thickness * m)) : std::cbrt(volume / m);
  s.area = m * spacing * spacing;
  s.notes.push_back(std::string(is_planar ? "a planar solid" : "a solid") + " of " + formatShort(volume) +
                    " m^3: " + formatCount(static_cast<Index>(s.dense.positions.size()), "points, ") +
                    formatCount(m, "simulation points, ") +
                    formatCount(static_cast<Index>(std::count(s.pinned.begin(), s.pinned.end(), 1)), "pinned"));
}

// Simulation points, their neighbours and the transfer.
void prepareBody(const SceneParams& params, RestSurface& s) {
  const Index n = static_cast<Index>(s.dense.positions.size());
  s.dense_neighbors = cloud::nearestNeighbors(s.dense.positions, *cloud::findTree(s.dense), 2 * params.neighbors.k);
  std::vector<double> detours = keepNearOverBody(params.neighbors, s.dense.positions, s.dense_neighbors, s);
  s.across = findAcross(params, s);
  const bool is_planar = !s.across.isZero(0.0);
  completeNormals(s.across, s);
  s.dense_index = choosePoints(params, s);
  const Index m = static_cast<Index>(s.dense_index.size());
  for (Index i : s.dense_index) {
    s.points.push_back(s.dense.positions[i]);
    s.normals.push_back(s.dense.normals[i]);
  }

  if (m == n && !is_planar) {
    s.solid_neighbors = s.dense_neighbors;
    s.detours = std::move(detours);
    return;
  }
  const bool is_euclidean = params.neighbors.areEuclidean();
  const Index k = countNeighbors(params, s.across);
  cloud::GeodesicCells cells;
  if (!is_euclidean) cells = cloud::findGeodesicCells(s.dense.positions, s.dense_neighbors, s.dense_index, k);
  s.solid_neighbors = is_euclidean ? cloud::nearestNeighbors(s.points, k) : cells.neighbors;
  if (m == n) return;
  const Lists followed = findFollowed(params, cells, s.dense.positions, s.points);
  s.point_volumes = model::measureAround(s.dense.positions, s.dense_neighbors, s.across, findFirst(followed), m);
  s.solid_transfer = transfer::SolidTransfer(s.dense.positions, s.dense.normals, s.points, followed);
}

// Uses the farthest of the simulation points; its dense_index and solid_transfer refer to these. InputError if these span no
// body.
RestSurface buildCoarserSolid(const SceneParams& params, const RestSurface& of, Index target) {
  RestSurface s;
  s.dense_index =
      cloud::orderByDistance(of.points, of.solid_neighbors, target, choosePinPoints(params, of.points)).keepCount(target);
  for (const Index i : s.dense_index) {
    s.points.push_back(of.points[i]);
    s.normals.push_back(of.normals[i]);
  }
  const Index k = countNeighbors(params, of.across);
  cloud::GeodesicCells cells;
  if (!params.neighbors.areEuclidean()) cells = cloud::findGeodesicCells(of.points, of.solid_neighbors, s.dense_index, k);
  s.solid_neighbors = params.neighbors.areEuclidean() ? cloud::nearestNeighbors(s.points, k) : cells.neighbors;
  s.across = of.across;
  const Lists followed = findFollowed(params, cells, of.points, s.points);
  const std::vector<Index> owner = findFirst(followed);
  s.point_volumes.assign(s.points.size(), 0.0);
  for (std::size_t i = 0; i < owner.size(); ++i) s.point_volumes[owner[i]] += of.point_volumes[i];
  finishSolid(params, model::Outline::kRough, s);
  s.solid_transfer = transfer::SolidTransfer(of.points, of.normals, s.points, followed);
  return s;
}

}  // namespace

CoarserLevel makeSolidCopies(const SceneParams& params, const RestSurface& level) {
  const Index n = static_cast<Index>(level.points.size());
  const bool is_planar = !level.across.isZero(0.0);
  const Index points = std::max(n / (is_planar ? kCoarserRatio : kSolidRatio), std::min(kFewestOfSolid, n / kCoarserRatio));
  if (points < kCoarsestPoints)
    throw InputError("found " + std::to_string(n) + " simulation points; accepted: at least " +
                     std::to_string(kCoarserRatio * kCoarsestPoints));
  CoarserLevel copies;
  copies.is_body = true;
  copies.is_simplified = !level.solid_transfer.isEmpty();
  copies.unresolved = 1.0 - static_cast<double>(level.dense_index.size()) / static_cast<double>(level.dense.positions.size());
  copies.surface = buildCoarserSolid(params, level, points);
  copies.common = copies.surface.dense_index;
  copies.refine = [transfer = std::move(copies.surface.solid_transfer)](const Points& coarse, Points& fine) {
    transfer.apply(coarse, fine, nullptr);
  };
  return copies;
}

RestSurface prepareSolid(const SceneParams& params, const cloud::PointCloud& input) {
  RestSurface s = cleanInput(input);
  if (params.elastic_solid.fill) {
    const std::optional<Vec3> viewpoint = moveOntoSurface(params.input, input, s);
    leaveOutParts(params, findNeighbors, s);
    Points estimated = findNeighbors(params, s).normals;
    completeNormals(viewpoint, params.neighbors.k, std::move(estimated), s);
    buildFilledSolid(params, s);
  } else {
    warnOfNoisyBody(params.input, input, s);
    leaveOutParts(params, findBodyNeighbors, s);
    prepareBody(params, s);
  }
  return s;
}

RestSurface finishSolidRest(const SceneParams& params, RestSurface s) {
  const bool is_rough = !params.elastic_solid.fill && s.points.size() < s.dense.positions.size();
  finishSolid(params, is_rough ? model::Outline::kRough : model::Outline::kSurface, s);
  return s;
}

}  // namespace deformable_surface::simulation
