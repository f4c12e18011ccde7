#include "wavy_sheet.h"

#include "deformable_surface/cloud/geodesics.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/io/shapes.h"
#include "measure.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>

namespace deformable_surface::benchmark {
namespace {

constexpr double kAmplitude = 0.05;  // m: slopes up to about a third, as on scans of folded cloth
const double kWaveNumber = 2.0 * kPi;
constexpr double kJitter = 0.3;   // irregular, but no two points coincide
constexpr Index kNeighbors = 16;  // the default of scenes
constexpr Index kKeptShare = 50;
constexpr Index kSamples = 100;  // of neighbour lists checked against all pairs
constexpr double kBend = 0.05;   // m, amplitude of the displacement that the transfer must reproduce

double wavyHeight(double x, double y) { return kAmplitude * std::sin(kWaveNumber * x) * std::cos(kWaveNumber * y); }

Vec3 bend(const Vec3& p) { return p + Vec3(0.0, 0.0, kBend * std::sin(kPi * p.x())); }

double sumOf(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

double areaError(const cloud::Rings& rings) { return std::abs(sumOf(rings.area) / findWavyArea() - 1.0); }

// Share of sampled points whose list of neighbours differs from that of a comparison of all pairs.
double neighborError(const Preparation& p) {
  const Points& points = p.cloud.positions;
  const Index n = p.cloud.size();
  Index wrong = 0;
  std::vector<cloud::Neighbor> all(n);
  for (Index s = 0; s < kSamples; ++s) {
    const Index i = static_cast<Index>(static_cast<std::int64_t>(s) * n / kSamples);
    for (Index j = 0; j < n; ++j) all[j] = {(points[j] - points[i]).squaredNorm(), j};
    const Index count = p.neighbors.count(i);
    std::partial_sort(all.begin(), all.begin() + count + 1, all.end());
    for (Index k = 0; k < count; ++k)
      if (all[k + 1].index != p.neighbors.begin(i)[k]) {
        ++wrong;
        break;
      }
  }
  return static_cast<double>(wrong) / kSamples;
}

double meanNormalError(const Preparation& p) {
  double sum = 0.0;
  for (std::size_t i = 0; i < p.normals.size(); ++i) {
    const double along = std::abs(p.normals[i].dot(findWavyNormal(p.cloud.positions[i])));
    sum += std::acos(std::min(1.0, along));
  }
  return 180.0 / kPi * sum / static_cast<double>(p.normals.size());
}

double boundaryError(const Preparation& p) {
  Index wrong = 0;
  for (std::size_t i = 0; i < p.cloud.positions.size(); ++i) {
    const Vec3& x = p.cloud.positions[i];
    const bool on_edge = std::max(std::abs(x.x()), std::abs(x.y())) > 0.5 - 1e-9;
    if (on_edge != (p.boundary.is_boundary[i] != 0)) ++wrong;
  }
  return static_cast<double>(wrong);
}

double orientationError(const Preparation& p) {
  return static_cast<double>(std::count_if(p.normals.begin(), p.normals.end(), [](const Vec3& n) { return !(n.z() > 0.0); }));
}

double spacingVariation(const Preparation& p) {
  Points kept;
  for (Index i : p.simplification.keepCount(p.target)) kept.push_back(p.cloud.positions[i]);
  const Lists nearest = cloud::nearestNeighbors(kept, 1);
  double sum = 0.0, squares = 0.0;
  for (Index i = 0; i < nearest.size(); ++i) {
    const double distance = (kept[*nearest.begin(i)] - kept[i]).norm();
    sum += distance;
    squares += distance * distance;
  }
  const double mean = sum / nearest.size();
  return std::sqrt(std::max(0.0, squares / nearest.size() - mean * mean)) / mean;
}

double transferError(const Preparation& p) {
  Points bent, expected, found;
  for (const Vec3& x : p.points) bent.push_back(bend(x));
  for (const Vec3& x : p.cloud.positions) expected.push_back(bend(x));
  p.transfer.apply(bent, found);
  return rmsDistance(found, expected) / kBend;
}

// Also the normals that separate the sides, as the simulation estimates them first.
void keepOverSurface(Preparation& p) {
  const Points& positions = p.cleaned.positions;
  Lists lists = p.neighbors;
  cloud::SurfaceSides sides;
  sides.normals = cloud::estimateNormals(positions, lists);
  const cloud::GeodesicGraph graph = cloud::buildGeodesicGraph(positions, sides, lists, {});
  cloud::GeodesicNeighbors found = cloud::keepGeodesicNeighbors(graph, positions, sides, std::move(lists));
  p.num_at_gaps = found.num_at_gaps;
  p.are_nearest.clear();
  for (const char is_changed : found.is_changed) p.are_nearest.push_back(!is_changed);
  p.neighbors = std::move(found.lists);
}

void estimateNormals(Preparation& p) { p.normals = cloud::estimateNormals(p.cloud.positions, p.neighbors); }

}  // namespace

Index countKept(Index n) { return n / kKeptShare; }

Vec3 findWavyNormal(const Vec3& p) {
  const double kx = kWaveNumber * p.x(), ky = kWaveNumber * p.y(), slope = kAmplitude * kWaveNumber;
  return Vec3(-slope * std::cos(kx) * std::cos(ky), slope * std::sin(kx) * std::sin(ky), 1.0).normalized();
}

double findWavyArea() {
  // The integrand is smooth and periodic, so the midpoint rule is exact to rounding.
  constexpr int kCells = 200;
  double sum = 0.0;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      const Vec3 p((i + 0.5) / kCells - 0.5, (j + 0.5) / kCells - 0.5, 0.0);
      sum += 1.0 / findWavyNormal(p).z();
    }
  return sum / (kCells * kCells);
}

cloud::PointCloud makeWavySheet(Index n, PointOrder order) {
  simulation::CloudParams params;
  params.shape = simulation::CloudParams::Shape::kSheet;
  params.points = n;
  params.jitter = kJitter;
  cloud::PointCloud cloud = io::makeShape(params);
  for (Vec3& p : cloud.positions) p.z() = wavyHeight(p.x(), p.y());
  if (order == PointOrder::kShuffled) {
    std::mt19937 generator(1);
    for (Index i = cloud.size() - 1; i > 0; --i)
      std::swap(cloud.positions[i], cloud.positions[generator() % static_cast<std::uint32_t>(i + 1)]);
    cloud.width = static_cast<std::uint32_t>(cloud.size());
    cloud.height = 1;
  }
  return cloud;
}

std::vector<Stage> listStages() {
  return {
      {"clean", "points lost", [](Preparation& p) { p.cleaned = cloud::clean(p.cloud); },
       [](const Preparation& p) { return static_cast<double>(p.cloud.size() - p.cleaned.positions.size()); },
       [](const Preparation& p) { return hashValues(p.cleaned.positions); }},
      {"neighbours", "share of lists that are wrong",
       [](Preparation& p) { p.neighbors = cloud::nearestNeighbors(p.cleaned.positions, 2 * kNeighbors); }, neighborError,
       [](const Preparation& p) { return hashValues(p.neighbors.items); }},
      {"geodesic neighbours", "points at gaps, of which there are none", keepOverSurface,
       [](const Preparation& p) { return static_cast<double>(p.num_at_gaps); },
       [](const Preparation& p) { return hashValues(p.neighbors.items); }},
      {"normals", "mean error, degrees", estimateNormals, meanNormalError,
       [](const Preparation& p) { return hashValues(p.normals); }},
      {"boundary", "points wrong",
       [](Preparation& p) { p.boundary = cloud::findBoundary(p.cloud.positions, p.normals, p.neighbors, kNeighbors); },
       boundaryError, [](const Preparation& p) { return hashValues(p.boundary.is_boundary); }},
      {"orientation", "points wrong",
       [](Preparation& p) {
         cloud::orientNormals(p.cloud.positions, p.neighbors, p.boundary.is_boundary, {}, std::nullopt, p.normals);
       },
       orientationError, [](const Preparation& p) { return hashValues(p.normals); }},
      {"simplification", "variation of spacing",
       [](Preparation& p) {
         p.simplification =
             cloud::simplify(p.cloud.positions, p.normals, kNeighbors, p.target, {}, p.neighbors, p.boundary.is_corner, true);
         p.kept = p.simplification.keepCount(p.target);
       },
       spacingVariation, [](const Preparation& p) { return hashValues(p.simplification.removed); }},
      {"cells", "points without one",
       [](Preparation& p) { p.cells = cloud::findGeodesicCells(p.cloud.positions, p.neighbors, p.kept, kNeighbors); },
       [](const Preparation& p) { return static_cast<double>(std::count(p.cells.owner.begin(), p.cells.owner.end(), -1)); },
       [](const Preparation& p) { return hashValues(p.cells.neighbors.items); }},
      {"rings of simulation points", "relative error of area",
       [](Preparation& p) {
         p.points.clear();
         p.point_normals.clear();
         for (Index i : p.kept) {
           p.points.push_back(p.cloud.positions[i]);
           p.point_normals.push_back(p.normals[i]);
         }
         p.rings = cloud::buildRings(p.points, p.point_normals, p.cells.neighbors);
       },
       [](const Preparation& p) { return areaError(p.rings); }, [](const Preparation& p) { return hashValues(p.rings.area); }},
      {"area of all points", "relative error",
       [](Preparation& p) { p.area = cloud::measureArea(p.cloud.positions, p.normals, p.neighbors, p.are_nearest); },
       [](const Preparation& p) { return std::abs(p.area / findWavyArea() - 1.0); },
       [](const Preparation& p) { return hashBytes(&p.area, sizeof p.area); }},
      {"model", "relative error of mass",
       [](Preparation& p) {
         p.model = std::make_unique<model::MassSpring>(p.points, p.point_normals, p.rings, p.area, false, model::MaterialParams{},
                                                       model::MassSpringParams{});
       },
       [](const Preparation& p) {
         return std::abs(sumOf(p.model->masses()) / (model::MaterialParams{}.arealDensity() * findWavyArea()) - 1.0);
       },
       [](const Preparation& p) { return hashValues(p.model->masses()); }},
      {"transfer weights", "rms error of a bend / its amplitude",
       [](Preparation& p) {
         const transfer::TransferParams params;
         const Lists followed = cloud::findChosenNear(p.cells, p.cloud.positions, params.k);
         p.transfer =
             transfer::Transfer(p.cloud.positions, p.normals, p.points, std::vector<char>(p.points.size(), 1), params, &followed);
       },
       transferError,
       [](const Preparation& p) {
         Points now;
         p.transfer.apply(p.points, now);
         return hashValues(now);
       }},
  };
}

}  // namespace deformable_surface::benchmark
