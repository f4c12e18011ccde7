#include "deformable_surface/base/error.h"
#include "deformable_surface/base/types.h"
#include "deformable_surface/cloud/kd_tree.h"
#include "deformable_surface/model/oriented_particles/particle_triangles.h"
#include "deformable_surface/model/oriented_particles/rest_shape.h"
#include "deformable_surface/simulation/expectations.h"

#include <algorithm>
#include <cmath>

#include "quantities.h"

namespace deformable_surface::simulation {
namespace {

// Mean angle, rad, between x axes and the principal direction that they should turn to, from the normals of the neighbours.
// Over particles with neighbours all around and different curvatures.
double measurePrincipalAngle(const model::OrientedParticles& particles, const model::State& state) {
  constexpr double kReach = 1.5;       // spacings: the first neighbours
  constexpr Index kAllAround = 5;      // neighbours: at an edge there are fewer
  constexpr double kDifferent = 0.01;  // of a turn of one radian from neighbour to neighbour
  const double spacing = particles.lattice().spacing;
  const bool is_signed = particles.params().principal == model::PrincipalDirection::kSigned;
  const cloud::KdTree tree(state.positions);
  std::vector<cloud::Neighbor> near;
  double sum = 0.0, count = 0.0;
  for (Index i = 0; i < state.size(); ++i) {
    const Vec3 normal = state.orientations[i] * Vec3::UnitZ();
    tree.withinRadius(state.positions[i], kReach * spacing, near);
    if (static_cast<Index>(near.size()) <= kAllAround) continue;  // it is one of them
    model::CurvatureFit fit(state.orientations[i]);
    for (const cloud::Neighbor& j : near)
      fit.add(1.0, state.positions[j.index] - state.positions[i], state.orientations[j.index] * Vec3::UnitZ() - normal);
    const std::optional<Vec3> curvature = fit.solve();
    if (!curvature) continue;
    // Outwards, the least signed height is where the surface falls off most.
    const model::PrincipalCurvatures k = model::findPrincipalCurvatures(*curvature);
    const bool takes_larger = is_signed || std::abs(k.larger) < std::abs(k.smaller);
    const double difference = is_signed ? k.larger - k.smaller : std::abs(std::abs(k.larger) - std::abs(k.smaller));
    if (!(difference * spacing > kDifferent)) continue;
    const double off = state.traits[i].turn - k.angle - (takes_larger ? 0.0 : 0.5 * kPi);
    sum += std::abs(std::remainder(off, kPi));
    count += 1.0;
  }
  return sum / count;
}

// Number of particles that lie on a solid tool, within the share of a spacing by which contact yields.
double countTouching(const model::OrientedParticles& particles, const Simulation& simulation) {
  constexpr double kOnIt = 0.05;
  const std::vector<double> nearest = findToolDistances("touching", simulation);
  const double on_it = kOnIt * particles.lattice().spacing;
  return static_cast<double>(std::count_if(nearest.begin(), nearest.end(), [&](double d) { return std::abs(d) < on_it; }));
}

// How far particles are from the iso-surface that guides them, m.
std::optional<double> measureGuideDistance(const std::string& name, const Simulation& simulation) {
  const model::GuideParams& guide = simulation.params().oriented_particles.guide;
  if (!guide.grid) throw InputError(name + ": found no oriented_particles.guide; accepted: one");
  double largest = 0.0, squares = 0.0;
  for (const Vec3& p : simulation.state().positions) {
    const double d = guide.distance(p);
    largest = std::max(largest, std::abs(d));
    squares += d * d;
  }
  return name == "guide_distance_max" ? largest : std::sqrt(squares / static_cast<double>(simulation.state().size()));
}

}  // namespace

std::optional<double> findParticleQuantity(const std::string& name, const model::OrientedParticles& particles,
                                           const Simulation& simulation) {
  if (name.rfind("guide_distance", 0) == 0) return measureGuideDistance(name, simulation);
  if (name == "touching") return countTouching(particles, simulation);
  const model::State& state = simulation.state();
  const Index first = simulation.numFirst();
  if (name == "added") return state.next_id - first;
  if (name == "removed") return state.next_id - state.size();
  if (name == "principal_angle_mean") return measurePrincipalAngle(particles, state);
  if (name.rfind("spacing_", 0) == 0) {
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
  if (name != "components" && name != "isolated" && name != "boundary_loops" && name != "euler_characteristic")
    return std::nullopt;
  particles.refreshDisplay(state);
  const bool chains = particles.params().mode == model::ParticleMode::kPlane;
  const model::ParticleTopology topology = chains ? model::measureTopology(state.size(), particles.stretchLinks())
                                                  : model::measureTopology(state.size(), particles.triangles());
  if (name == "components") return topology.components;
  if (name == "boundary_loops") return topology.boundary_loops;
  return name == "isolated" ? topology.isolated : topology.euler_characteristic;
}

}  // namespace deformable_surface::simulation
