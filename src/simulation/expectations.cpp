#include "deformable_surface/simulation/expectations.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace deformable_surface::simulation {
namespace {

std::optional<double> findStatistic(const std::string& name, const Statistics& statistics) {
  std::optional<double> found;
  visitFields(statistics, [&](const std::string& field, const auto& value) {
    if constexpr (std::is_arithmetic<std::decay_t<decltype(value)>>::value) {
      if (field == name && name != "state_hash") found = static_cast<double>(value);
    }
  });
  return found;
}

double computeVolumeRatio(const Simulation& simulation) {
  if (!simulation.model().isClosed()) {
    throw InputError("volume_ratio: found a surface with a boundary, which encloses no volume; accepted: a closed surface");
  }
  // The rest state is not kept apart; the same input builds it again.
  const Simulation rest(simulation.params(), simulation.input());
  return simulation.model().enclosedVolume(simulation.state()) / rest.model().enclosedVolume(rest.state());
}

// What oriented particles make: kind of surface, distances to the nearest other particle, who came and went.
std::optional<double> findParticleQuantity(const std::string& name, const Simulation& simulation) {
  static const char* const kNames[] = {"components", "boundary_loops", "euler_characteristic", "isolated", "spacing_mean",
                                       "spacing_cv", "spacing_max", "born", "gone"};
  if (std::find(std::begin(kNames), std::end(kNames), name) == std::end(kNames)) return std::nullopt;
  const model::OrientedParticles* particles = simulation.particles();
  if (!particles) throw InputError(name + ": found a model without particles; accepted: model: oriented_particles");
  const model::State& state = simulation.state();
  const Index first = simulation.numFirst();
  if (name == "born") return state.next_id - first;
  if (name == "gone") return state.next_id - state.size();
  if (name.rfind("spacing", 0) == 0) {
    double sum = 0.0, squares = 0.0, largest = 0.0;
    const Lists nearest = cloud::nearestNeighbors(state.positions, 1);
    for (Index i = 0; i < nearest.size(); ++i) {
      const double d = (state.positions[*nearest.begin(i)] - state.positions[i]).norm();
      sum += d;
      squares += d * d;
      largest = std::max(largest, d);
    }
    const double n = nearest.size(), mean = sum / n;
    if (name == "spacing_mean") return mean;
    return name == "spacing_max" ? largest : std::sqrt(std::max(0.0, squares / n - mean * mean)) / mean;
  }
  particles->refreshDisplay(state);
  const bool chains = particles->params().mode == model::ParticleMode::kPlane;
  const model::ParticleTopology topology = chains ? model::measureTopology(state.size(), particles->stretchLinks())
                                                  : model::measureTopology(state.size(), particles->triangles());
  if (name == "components") return topology.components;
  if (name == "boundary_loops") return topology.boundary_loops;
  return name == "isolated" ? topology.isolated : topology.euler_characteristic;
}

}  // namespace

double computeQuantity(const std::string& name, Simulation& simulation) {
  if (const std::optional<double> statistic = findStatistic(name, simulation.statistics())) return *statistic;
  if (name == "volume_ratio") return computeVolumeRatio(simulation);

  if (const std::optional<double> particles = findParticleQuantity(name, simulation)) return *particles;

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
  for (int axis = 0; axis < 3; ++axis) {
    const char letter = "xyz"[axis];
    if (name == std::string("min_") + letter) return low[axis];
    if (name == std::string("max_") + letter) return high[axis];
  }
  throw InputError("expect: found the quantity " + quote(name) + "; accepted: those listed in docs/parameters.md");
}

std::vector<std::string> checkExpectations(Simulation& simulation) {
  std::vector<std::string> violations;
  for (const ExpectParams& expect : simulation.params().expect) {
    const double value = computeQuantity(expect.quantity, simulation);
    if (value >= expect.min && value <= expect.max) continue;
    violations.push_back("expect." + expect.quantity + ": found " + formatReal(value) + " at " + formatReal(simulation.time()) +
                         " s; accepted: " + formatReal(expect.min) + " to " + formatReal(expect.max));
  }
  return violations;
}

}  // namespace deformable_surface::simulation
