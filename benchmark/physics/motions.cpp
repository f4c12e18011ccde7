// What holds for every material: free fall, and momentum, angular momentum and energy of a free sheet. These are refined in time.
#include "experiment.h"

#include <cmath>

namespace deformable_surface::physics {
namespace {

constexpr double kGravity = 9.81;   // m/s^2
constexpr double kDuration = 0.48;  // s, a multiple of all time steps

simulation::SceneParams makeFreeScene(solve::IntegratorType integrator, double step) {
  simulation::SceneParams scene;
  scene.accuracy.estimate = false;
  scene.gravity.setZero();
  scene.output.normals = false;
  scene.material.young_modulus = 1e4;
  scene.material.thickness = 1e-3;
  scene.integrator.type = integrator;
  scene.integrator.time_step = step;
  return scene;
}

Sampled sampleSheet(const Variant& variant) { return sampleRectangle(Vec2(-0.5, -0.25), Vec2(0.5, 0.25), 0.1, variant.sampling); }

Answer fall(solve::IntegratorType integrator, const Variant& variant, double step) {
  simulation::SceneParams scene = makeFreeScene(integrator, step);
  scene.gravity = Vec3(0.0, 0.0, -kGravity);
  // Sub-steps finer than the step would hide its error.
  scene.material.young_modulus = 10.0;
  Experiment sheet(scene, sampleSheet(variant), variant);
  while (sheet.simulation().time() < kDuration - 0.5 * step) sheet.step();
  Answer answer;
  answer.points = static_cast<Index>(sheet.rest().size());
  answer.value = meanDisplacement(sheet, [](const Vec3&) { return true; }).z();
  answer.reference = -0.5 * kGravity * kDuration * kDuration;
  answer.error = std::abs(answer.value / answer.reference - 1.0);
  return answer;
}

enum class Kept { kMomentum, kAngularMomentum, kEnergy };

// A sheet thrown with a spin, bent and stretched by the throw.
Answer tumble(Kept kept, const Variant& variant, double step) {
  Experiment sheet(makeFreeScene(solve::IntegratorType::kVerlet, step), sampleSheet(variant), variant);
  const auto measure = [&](double& energy) {
    Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
    const model::State& state = sheet.simulation().state();
    energy = sheet.simulation().model().elasticEnergy(state);
    for (std::size_t i = 0; i < state.positions.size(); ++i) {
      const Vec3 p = sheet.masses()[i] * state.velocities[i];
      momentum += p;
      angular += state.positions[i].cross(p);
      energy += 0.5 * p.dot(state.velocities[i]);
    }
    return kept == Kept::kMomentum ? momentum : angular;
  };
  for (Index i = 0; i < static_cast<Index>(sheet.rest().size()); ++i) {
    const Vec3& r = sheet.rest()[i];
    const Vec3 velocity = Vec3(1.0, 0.5, 0.25) + Vec3(2.0, 3.0, 1.0).cross(r) + Vec3(r.x(), 0.0, 4.0 * r.x() * r.x());
    sheet.push(i, sheet.masses()[i] / step * velocity);
  }
  sheet.step();
  for (Index i = 0; i < static_cast<Index>(sheet.rest().size()); ++i) sheet.push(i, Vec3::Zero());
  double first_energy, energy;
  const Vec3 first = measure(first_energy);
  Answer answer;
  answer.points = static_cast<Index>(sheet.rest().size());
  while (sheet.simulation().time() < kDuration - 0.5 * step) {
    sheet.step();
    const Vec3 now = measure(energy);
    if (kept == Kept::kEnergy) {
      answer.error = std::max(answer.error, std::abs(energy / first_energy - 1.0));
      answer.value = energy;
      answer.reference = first_energy;
    } else {
      answer.error = std::max(answer.error, (now - first).norm() / first.norm());
      answer.value = now.norm();
      answer.reference = first.norm();
    }
  }
  return answer;
}

Problem makeProblem(const std::string& name, const std::string& value, const std::string& source) {
  Problem p;
  p.name = name;
  p.value = value;
  p.scale = "value";
  p.source = source;
  p.in_time = true;
  p.variants = {{model::Membrane::kTriangles, model::Bending::kCurvature, Sampling::kJittered, true}};
  p.sizes = {0.002, 0.001, 0.0005};
  return p;
}

}  // namespace

std::vector<Problem> listMotions() {
  std::vector<Problem> list;
  using solve::IntegratorType;
  const std::pair<const char*, IntegratorType> integrators[] = {{"verlet", IntegratorType::kVerlet},
                                                                {"symplectic_euler", IntegratorType::kSymplecticEuler},
                                                                {"implicit", IntegratorType::kImplicit}};
  for (const auto& [name, integrator] : integrators) {
    Problem p = makeProblem(std::string("free fall, ") + name, "z, m", "g t^2 / 2");
    p.sizes = {0.02, 0.01, 0.005};
    p.run = [type = integrator](const Variant& variant, double step) { return fall(type, variant, step); };
    list.push_back(p);
  }
  const std::pair<const char*, Kept> conserved[] = {
      {"momentum", Kept::kMomentum}, {"angular momentum", Kept::kAngularMomentum}, {"energy", Kept::kEnergy}};
  for (const auto& [name, kept] : conserved) {
    Problem p = makeProblem(std::string(name) + " of a tumbling sheet", kept == Kept::kEnergy ? "J" : "SI", "conserved");
    if (kept != Kept::kEnergy) p.variants = listSamplings(model::Membrane::kTriangles, model::Bending::kCurvature);
    p.run = [which = kept](const Variant& variant, double step) { return tumble(which, variant, step); };
    list.push_back(p);
  }
  return list;
}

}  // namespace deformable_surface::physics
