// The graph for geodesics: its links and their costs.
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/median.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/cloud/geodesics.h"
#include "trust_radii.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace deformable_surface::cloud {
namespace {

constexpr Index kBlock = 1024;  // points per task: about a millisecond of work

// How fast the cost grows beyond the trust radius. A gap is then so expensive that detours up to several times the distance still
// count as the same surface, like those around holes and over noise.
constexpr double kCostSlope = 18.0;
// From this exponent on a path over a point inside the ball on a link as diameter never costs more than the link: a^2 + b^2 <=
// c^2 gives a^g + b^g <= c^g for g >= 2.
constexpr double kBallExponent = 2.0;

double findMedianSpacing(const Points& positions, const Lists& neighbors) {
  std::vector<double> nearest;
  for (Index i = 0; i < neighbors.size(); ++i) {
    if (neighbors.count(i) > 0) nearest.push_back((positions[neighbors.begin(i)[0]] - positions[i]).norm());
  }
  const double median = nearest.empty() ? 0.0 : findMedian(std::move(nearest));
  return median > 0.0 ? median : 1.0;
}

// The links for which keep(i, j, cost) is true, made symmetric: those of a point, then those that only their other ends keep.
template <class Keep>
void collectLinks(const Lists& neighbors, const Keep& keep, GeodesicGraph& graph) {
  const Index n = neighbors.size();
  struct Missing {
    Index from, to;
    double cost;
  };
  // Of a block of points.
  struct Part {
    std::vector<Index> items;
    std::vector<double> cost;
    std::vector<Missing> missing;  // opposite links
  };
  std::vector<Part> parts((n + kBlock - 1) / kBlock);
  std::vector<Index> first(n), count(n);  // in the part
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    Part& part = parts[begin / kBlock];
    for (Index i = begin; i < end; ++i) {
      first[i] = static_cast<Index>(part.items.size());
      for (const Index* j = neighbors.begin(i); j != neighbors.end(i); ++j) {
        double cost;
        if (!keep(i, *j, cost)) continue;
        part.items.push_back(*j);
        part.cost.push_back(cost);
      }
      count[i] = static_cast<Index>(part.items.size()) - first[i];
    }
  });
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    Part& part = parts[begin / kBlock];
    for (Index i = begin; i < end; ++i) {
      for (Index e = first[i]; e < first[i] + count[i]; ++e) {
        const Index j = part.items[e];
        const Index* const of_j = parts[j / kBlock].items.data() + first[j];
        if (std::find(of_j, of_j + count[j], i) == of_j + count[j]) part.missing.push_back({j, i, part.cost[e]});
      }
    }
  });

  std::vector<Index> num_missing(n);
  for (const Part& part : parts)
    for (const Missing& link : part.missing) ++num_missing[link.from];
  graph.links.offsets.resize(n + 1);
  for (Index i = 0; i < n; ++i) graph.links.offsets[i + 1] = graph.links.offsets[i] + count[i] + num_missing[i];
  graph.links.items.resize(graph.links.offsets[n]);
  graph.cost.resize(graph.links.offsets[n]);
  std::vector<Index> next(n);
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    const Part& part = parts[begin / kBlock];
    for (Index i = begin; i < end; ++i) {
      const Index to = graph.links.offsets[i];
      std::copy_n(part.items.begin() + first[i], count[i], graph.links.items.begin() + to);
      std::copy_n(part.cost.begin() + first[i], count[i], graph.cost.begin() + to);
      next[i] = to + count[i];
    }
  });
  for (const Part& part : parts)
    for (const Missing& link : part.missing) {
      const Index to = next[link.from]++;
      graph.links.items[to] = link.to;
      graph.cost[to] = link.cost;
    }
}

}  // namespace

GeodesicGraph buildGeodesicGraph(const Points& positions, const SurfaceSides& sides, const Lists& neighbors,
                                 const OrAuto<double>& geodesic_exponent, double min_gap, bool of_body) {
  const Index n = neighbors.size();
  if (static_cast<Index>(positions.size()) != n || (!sides.normals.empty() && static_cast<Index>(sides.normals.size()) != n)) {
    throw InputError("buildGeodesicGraph: found " + std::to_string(positions.size()) + " positions, " +
                     std::to_string(sides.normals.size()) + " normals and " + std::to_string(n) +
                     " neighbour lists; accepted: equally many, or no normals");
  }
  if (!sides.at_creases.empty() && sides.at_creases.size() != sides.normals.size()) {
    throw InputError("buildGeodesicGraph: found " + std::to_string(sides.at_creases.size()) + " normals at creases and " +
                     std::to_string(sides.normals.size()) + " normals; accepted: as many, or none at creases");
  }
  if (!geodesic_exponent.is_auto && !(geodesic_exponent.value >= 1.0)) {
    throw InputError("buildGeodesicGraph: geodesic_exponent: found " + formatShort(geodesic_exponent.value) +
                     "; accepted: at least 1");
  }

  GeodesicGraph graph;
  if (!geodesic_exponent.is_auto) {
    const double gamma = geodesic_exponent.value, spacing = findMedianSpacing(positions, neighbors);
    collectLinks(
        neighbors,
        [&](Index i, Index j, double& cost) {
          const double squared = (positions[j] - positions[i]).squaredNorm();
          cost = std::pow(std::sqrt(squared) / spacing, gamma);
          if (!std::isfinite(cost)) return false;
          if (gamma < kBallExponent) return true;
          for (const Index* m = neighbors.begin(i); *m != j; ++m) {
            const double way = (positions[*m] - positions[i]).squaredNorm() + (positions[*m] - positions[j]).squaredNorm();
            if (way < squared) return false;
          }
          return true;
        },
        graph);
    return graph;
  }

  graph.cost_is_distance = true;
  TrustRadii trusted = findTrustRadii(positions, sides, neighbors, of_body);
  graph.trust_radius = std::move(trusted.radius);
  graph.is_directional = trusted.is_directional;
  const std::vector<double>& radius = graph.trust_radius;
  std::vector<double> reach(n, 0.0);  // m, of the lists
  parallelFor(n, kBlock, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      if (neighbors.count(i) > 0) reach[i] = (positions[neighbors.end(i)[-1]] - positions[i]).norm();
  });
  collectLinks(
      neighbors,
      [&](Index i, Index j, double& cost) {
        const double trust = std::max(radius[i], radius[j]), most = kLongestDetour * std::max(reach[i], reach[j]);
        const auto measureCost = [&](double squared_length) {
          return std::sqrt(squared_length) * (1.0 + kCostSlope * std::max(0.0, squared_length / (trust * trust) - 1.0));
        };
        const double squared = (positions[j] - positions[i]).squaredNorm();
        if (squared <= min_gap * min_gap) {
          cost = std::sqrt(squared);
          return true;
        }
        // No link is shorter than in space, where most are too expensive already.
        if (!(measureCost(squared) <= most)) return false;
        cost = measureCost(measureSquaredLength(positions, sides, i, j));
        return cost <= most;
      },
      graph);
  return graph;
}

}  // namespace deformable_surface::cloud
