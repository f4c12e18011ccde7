#include "deformable_surface/simulation/expectations.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/cloud/normals.h"
#include "deformable_surface/geometry/fitted_shape.h"
#include "deformable_surface/simulation/model_kind.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "parts.h"
#include "quantities.h"

namespace deformable_surface::simulation {
namespace {

std::optional<double> findStatistic(const std::string& name, const Statistics& statistics) {
  std::optional<double> found;
  visitFields(statistics, [&](const std::string& field, const auto& value) {
    if constexpr (std::is_arithmetic<std::decay_t<decltype(value)>>::value) {
      if (field == name && name != "state_hash") found = static_cast<double>(value);
    }
  });
  // A bound is expected, and none can be given.
  if (name == "error_estimate" && *found >= 0.0 && !statistics.error_bounded) found = std::numeric_limits<double>::infinity();
  // Nothing was watched.
  if ((name == "may_buckle" || name == "error_bounded") && std::isnan(statistics.error_estimate))
    found = statistics.error_estimate;
  return found;
}

double computeVolumeRatio(const Simulation& simulation) {
  if (!isClosed(simulation.model())) {
    throw InputError("volume_ratio: found a surface with a boundary, which encloses no volume; accepted: a closed surface");
  }
  // The rest state is not stored; the same input builds it again.
  const Simulation rest(simulation.params(), simulation.input());
  return simulation.model().sides()->enclosedVolume(simulation.state()) / rest.model().sides()->enclosedVolume(rest.state());
}

// How far a point is from the surface that the scene's cloud was made on, m.
double findDistanceToShape(const CloudParams& cloud, const Vec3& p) {
  using Shape = CloudParams::Shape;
  switch (cloud.shape) {
    case Shape::kSheet:
    case Shape::kStrip:
    case Shape::kLattice: return std::abs(p.z());
    case Shape::kSphere:
    case Shape::kCap: return std::abs(p.norm() - cloud.radius);
    default: throw InputError("distance_to_shape: found a cloud of another shape; accepted: sheet, strip, lattice, sphere, cap");
  }
}

// The largest or the root mean square distance of the simulation points from the shape, or from the tangent planes of the nearest
// points of the input: how accurate a grown surface is where nothing was sampled.
std::optional<double> findDistanceQuantity(const std::string& name, const Simulation& simulation) {
  const bool to_shape = name.rfind("distance_to_shape_", 0) == 0, to_input = name.rfind("distance_to_input_", 0) == 0;
  if (!to_shape && !to_input) return std::nullopt;
  Points input, normals;
  if (to_input) {
    input = cloud::clean(simulation.input()).positions;
    normals = cloud::estimateNormals(input, cloud::nearestNeighbors(input, simulation.params().neighbors.k));
  }
  const cloud::KdTree tree(input);
  std::vector<cloud::Neighbor> nearest;
  double largest = 0.0, squares = 0.0;
  const Points& points = simulation.state().positions;
  for (const Vec3& p : points) {
    double distance;
    if (to_shape) {
      distance = findDistanceToShape(simulation.params().cloud, p);
    } else {
      tree.nearest(p, 1, nearest);
      const Index at = nearest.front().index;
      distance = std::abs(normals[at].dot(p - input[at]));
    }
    largest = std::max(largest, distance);
    squares += distance * distance;
  }
  return name.compare(name.size() - 3, 3, "max") == 0 ? largest : std::sqrt(squares / static_cast<double>(points.size()));
}

// Of the sphere or torus fitted to the simulation points.
std::optional<double> findFittedQuantity(const std::string& name, const Simulation& simulation) {
  using geometry::FittedShape;
  struct Quantity {
    const char* name;
    FittedShape (*fit)(const Points&);
    double FittedShape::*value;
  };
  static const Quantity kQuantities[] = {{"distance_to_sphere_max", geometry::fitSphere, &FittedShape::largest},
                                         {"distance_to_sphere_rms", geometry::fitSphere, &FittedShape::root_mean_square},
                                         {"sphere_radius", geometry::fitSphere, &FittedShape::radius},
                                         {"distance_to_torus_max", geometry::fitTorus, &FittedShape::largest},
                                         {"distance_to_torus_rms", geometry::fitTorus, &FittedShape::root_mean_square},
                                         {"torus_radius", geometry::fitTorus, &FittedShape::radius},
                                         {"torus_tube_radius", geometry::fitTorus, &FittedShape::tube_radius}};
  for (const Quantity& quantity : kQuantities)
    if (name == quantity.name) return quantity.fit(simulation.state().positions).*quantity.value;
  return std::nullopt;
}

void require(const std::string& name, const Simulation& simulation) {
  const Quantity* const quantity = findQuantity(name);
  if (!quantity) throw InputError("expect: found the quantity " + quote(name) + "; accepted: those listed in docs/parameters.md");
  if (quantity->needs_particles && !findModel(simulation.params().model).traits().has_population)
    throw InputError(name + ": found a model without particles; accepted: model: " + listModels(&ModelTraits::has_population));
  if (simulation.state().size() < quantity->least_points)
    throw InputError(name + ": found " + std::to_string(simulation.state().size()) + " simulation points; accepted: at least " +
                     std::to_string(quantity->least_points));
}

// Of the solid tools that there are now: the distances of the simulation points from the nearest, m.
std::optional<double> findContactQuantity(const std::string& name, const Simulation& simulation) {
  if (name != "distance_to_tools_min") return std::nullopt;
  const std::vector<double> nearest = findToolDistances(name, simulation);
  return *std::min_element(nearest.begin(), nearest.end());
}

// Counts of points without a link, and of parts that links connect.
std::optional<double> findLinkQuantity(const std::string& name, const Simulation& simulation) {
  if (name != "components" && name != "isolated") return std::nullopt;
  const Parts parts = findParts(simulation.state().size(), stretchLinksOf(simulation.model()));
  const std::ptrdiff_t isolated = std::count(parts.size.begin(), parts.size.end(), 1);
  return static_cast<double>(name == "isolated" ? isolated : parts.count() - isolated);
}

}  // namespace

std::vector<double> findToolDistances(const std::string& name, const Simulation& simulation) {
  std::vector<double> nearest(simulation.state().positions.size(), std::numeric_limits<double>::infinity());
  bool has_tool = false;
  for (const tool::ToolParams& tool : simulation.tools()) {
    if (tool.mode != tool::Mode::kSolid || !tool::isActive(tool, simulation.time())) continue;
    has_tool = true;
    const tool::Pose pose = tool::interpolate(tool.path, simulation.time());
    for (std::size_t i = 0; i < nearest.size(); ++i)
      nearest[i] = std::min(nearest[i], tool::findSignedDistance(tool.shape, pose, simulation.state().positions[i]).distance);
  }
  if (!has_tool) throw InputError(name + ": found no solid tool at the end; accepted: one at least");
  return nearest;
}

double computeQuantity(const std::string& name, Simulation& simulation) {
  if (const std::optional<double> statistic = findStatistic(name, simulation.statistics())) return *statistic;
  require(name, simulation);
  if (name == "volume_ratio") return computeVolumeRatio(simulation);
  if (name == "plastic_dissipation") return simulation.state().dissipated;

  if (const std::optional<double> distance = findDistanceQuantity(name, simulation)) return *distance;
  if (const std::optional<double> fitted = findFittedQuantity(name, simulation)) return *fitted;
  if (const std::optional<double> contact = findContactQuantity(name, simulation)) return *contact;
  if (const std::optional<double> own = findModel(simulation.params().model).findQuantity(name, simulation)) return *own;
  if (const std::optional<double> linked = findLinkQuantity(name, simulation)) return *linked;

  const Surface& surface = simulation.surface(false);
  double max_displacement = 0.0, sum = 0.0, sum_of_squares = 0.0, count = 0.0;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    if (!surface.positions[i].allFinite()) continue;
    low = low.cwiseMin(surface.positions[i]);
    high = high.cwiseMax(surface.positions[i]);
    const double displacement = surface.displacement[i];
    if (std::isnan(displacement)) continue;  // a particle that was born has no rest
    max_displacement = std::max(max_displacement, displacement);
    sum += displacement;
    sum_of_squares += displacement * displacement;
    count += 1.0;
  }
  if (name == "max_displacement") return max_displacement;
  if (name == "mean_displacement") return sum / count;
  if (name == "rms_displacement") return std::sqrt(sum_of_squares / count);
  const int axis = name.back() - 'x';  // min_x to max_z
  return name.rfind("min_", 0) == 0 ? low[axis] : high[axis];
}

std::vector<std::string> checkExpectations(Simulation& simulation) {
  std::vector<std::string> violations;
  for (const ExpectParams& expect : simulation.params().expect) {
    const double value = computeQuantity(expect.quantity, simulation);
    if (value >= expect.min && value <= expect.max) continue;
    const Statistics now = simulation.statistics();
    const bool has_number = expect.quantity == "error_estimate" && !now.error_bounded && std::isfinite(now.error_estimate);
    const std::string why =
        has_number ? " (error_bounded is false: the estimate, " + formatReal(now.error_estimate) + " m, is no bound)" : "";
    violations.push_back("expect." + expect.quantity + ": found " + formatReal(value) + why + " at " +
                         formatReal(simulation.time()) + " s; accepted: " + formatReal(expect.min) + " to " +
                         formatReal(expect.max));
  }
  return violations;
}

}  // namespace deformable_surface::simulation
