// Runs a generated scene with a method and judges every step. It measures the energy itself instead of asking the guard in the
// simulation. Its account starts with the run and is never reset.
#pragma once

#include "stability_cases.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace deformable_surface::test {

/// The oscillation of Verlet's energy is up to a quarter of that of its stiffest modes at half the stable step; see
/// docs/stability.md.
constexpr double kSwingOfEnergy = 0.4;

struct StabilityVerdict {
  enum Kind { kPassed, kRefused, kFailed };
  Kind kind = kPassed;
  std::string reason;  // of the cases that did not pass
  double gain = 0.0;   // largest created energy over the largest kinetic + elastic energy until then
  int notices = 0;     // steps with a notice, or in a state of which one told
};

class StabilityJudge {
 public:
  /// Passed: every step was taken, all numbers are finite, the energy never exceeds that of the start plus the work of the loads
  /// by more than the oscillation, and the rest shape is reached where it must be. Refused: a step was refused with a sentence,
  /// and the state is that before it. Failed: anything else.
  static StabilityVerdict judge(const StabilityCase& scene, solve::IntegratorType type) {
    StabilityJudge judge(scene, type);
    judge.run(scene);
    return judge.verdict_;
  }

 private:
  StabilityJudge(const StabilityCase& scene, solve::IntegratorType type)
      : simulation_(withType(scene.params, type), scene.cloud) {
    for (const simulation::AnchorParams& anchor : scene.params.anchors) {
      const Points& x = simulation_.state().positions;
      const auto nearest = std::min_element(x.begin(), x.end(), [&](const Vec3& a, const Vec3& b) {
        return (a - anchor.point).squaredNorm() < (b - anchor.point).squaredNorm();
      });
      anchor_points_.push_back(static_cast<Index>(nearest - x.begin()));
    }
  }

  static simulation::SceneParams withType(simulation::SceneParams params, solve::IntegratorType type) {
    params.integrator.type = type;
    return params;
  }

  void fail(const std::string& reason) { verdict_ = {StabilityVerdict::kFailed, reason, verdict_.gain, verdict_.notices}; }

  struct Energy {
    double moving;  // kinetic + elastic, that of anchors included
    double total;
  };
  Energy measure() const {
    const simulation::Statistics s = simulation_.statistics();
    return {s.kinetic_energy + s.elastic_energy + anchorEnergy(), s.kinetic_energy + s.elastic_energy + s.potential_energy};
  }

  // Work of the pressure on an open surface along a straight way, by the trapezoidal rule in small parts.
  double pressureWork(const model::State& before) const {
    const double pressure = simulation_.params().pressure;
    if (pressure == 0.0 || isClosed(simulation_.model())) return 0.0;
    const model::State& after = simulation_.state();
    constexpr int kParts = 16;
    double work = 0.0;
    for (int part = 0; part <= kParts; ++part) {
      model::State between = before;
      const double weight = (part == 0 || part == kParts ? 0.5 : 1.0) / kParts;
      for (Index i = 0; i < before.size(); ++i)
        between.positions[i] += static_cast<double>(part) / kParts * (after.positions[i] - before.positions[i]);
      Points area;
      computeAreaVectors(simulation_.model(), between, area);
      for (Index i = 0; i < before.size(); ++i) work += weight * pressure * area[i].dot(after.positions[i] - before.positions[i]);
    }
    return work;
  }

  // Energy of the anchors' springs: the third kind that can oscillate, beside kinetic and elastic energy.
  double anchorEnergy() const {
    double energy = 0.0;
    const std::vector<simulation::AnchorParams>& anchors = simulation_.params().anchors;
    for (std::size_t a = 0; a < anchors.size(); ++a)
      energy += 0.5 * anchors[a].stiffness * (anchors[a].target - simulation_.state().positions[anchor_points_[a]]).squaredNorm();
    return energy;
  }

  static bool allFinite(const Points& points) {
    return std::all_of(points.begin(), points.end(), [](const Vec3& p) { return p.allFinite(); });
  }

  void run(const StabilityCase& scene) {
    if (scene.start) {
      model::State state = simulation_.state();
      scene.start(simulation_, state);
      for (Index i = 0; i < state.size(); ++i)
        if (simulation_.pinned()[i]) state.positions[i] = simulation_.state().positions[i];
      simulation_.setState(state);
    }
    const double start = measure().moving;
    double gained = 0.0, largest = start, kick = 0.0;
    for (int k = 0; k < scene.steps; ++k) {
      if (k == scene.account_from) gained = 0.0;
      if (scene.command) scene.command(simulation_, k);
      const model::State before = simulation_.state();
      const std::uint64_t hash = simulation_.stateHash();
      const std::size_t forces_before = simulation_.activeForces().size();
      Energy energy_before = measure();
      const simulation::StepOutcome outcome = simulation_.step();
      if (!outcome.notice.empty() || !outcome.has_converged || outcome.was_retried) ++verdict_.notices;
      if (!outcome.ok) {
        if (outcome.problem.empty()) return fail("a step was refused without a sentence");
        if (simulation_.stateHash() != hash) return fail("a refused step changed the state");
        verdict_.kind = StabilityVerdict::kRefused;
        verdict_.reason = outcome.problem;
        return;
      }
      if (!allFinite(simulation_.state().positions) || !allFinite(simulation_.state().velocities))
        return fail("step " + std::to_string(k) + ": the state is not finite");
      // Forces that begin or end with a step change the energy at its start.
      const bool new_loads = simulation_.activeForces().size() != forces_before;
      if (new_loads) energy_before = measureWithForcesNow(before);
      const Energy after = measure();
      if (new_loads || k == 0) kick = std::max(kick, kickOf(before));
      largest = std::max({largest, after.moving, energy_before.moving});
      gained += after.total - energy_before.total - pressureWork(before);
      gained = std::max(gained, 0.0);
      if (k < scene.account_from) continue;
      verdict_.gain = std::max(verdict_.gain, largest > 0.0 ? gained / largest : 0.0);
      if (!(gained <= kSwingOfEnergy * largest + kick + roundingOf(before)))
        return fail("step " + std::to_string(k) + ": " + formatReal(gained) + " J were made of nothing, beside " +
                    formatReal(largest) + " J");
    }
    const simulation::Surface& surface = simulation_.surface(true);
    if (!allFinite(surface.positions)) return fail("the full surface is not finite");
    for (const Eigen::Vector3f& n : surface.normals)
      if (!n.allFinite()) return fail("a normal is not finite");
    if (!scene.recovers) return;
    const simulation::Statistics s = simulation_.statistics();
    if (!(s.kinetic_energy + s.elastic_energy <= 1e-6 * start && s.max_stretch <= 0.01))
      fail("the rest shape is not reached: stretch " + formatReal(s.max_stretch));
  }

  // The energy of an earlier state under the forces that act now.
  Energy measureWithForcesNow(const model::State& earlier) {
    const simulation::Snapshot now = simulation_.snapshot();
    simulation_.setState(earlier);
    const Energy energy = measure();
    simulation_.restore(now);
    return energy;
  }

  // The unavoidable gain of explicit Euler where a load sets in: in its first step nothing moves with the velocity. Points with
  // an anchor get no such allowance, because the anchor's energy counts.
  double kickOf(const model::State& before) const {
    if (simulation_.params().integrator.type != solve::IntegratorType::kExplicitEuler) return 0.0;
    double kick = 0.0;
    for (Index i = 0; i < before.size(); ++i)
      if (std::find(anchor_points_.begin(), anchor_points_.end(), i) == anchor_points_.end())
        kick += 0.5 * simulation_.model().masses()[i] * (simulation_.state().velocities[i] - before.velocities[i]).squaredNorm();
    return kick;
  }

  // Positions are wrong by a unit in the last place: the energy of such a motion against the stiffness and weight of the scene.
  double roundingOf(const model::State& state) const {
    double reach = 1.0, mass = 0.0;
    for (const Vec3& x : state.positions) reach = std::max(reach, x.norm());
    for (double m : simulation_.model().masses()) mass += m;
    return 1e-13 * (mass * 9.81 + simulation_.params().material.young_modulus * simulation_.params().material.thickness) * reach;
  }

  simulation::Simulation simulation_;
  std::vector<Index> anchor_points_;
  StabilityVerdict verdict_;
};

}  // namespace deformable_surface::test
