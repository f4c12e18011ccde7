// Membranes under pressure: the clamped disc of Hencky and the balloon.
#include "experiment.h"
#include "references.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::physics {
namespace {

// The pressure is so low that Hencky's membrane is within 0.1 % of the exact one.
Answer blowDisc(const Variant& variant, double spacing) {
  const double radius = 0.5, share = 1e-4;
  simulation::SceneParams scene = makeStaticScene();
  scene.material.young_modulus = 1e5;
  scene.material.thickness = 1e-3;
  scene.material.poisson_ratio = variant.membrane == model::Membrane::kSprings ? 1.0 / 3.0 : 0.3;
  const double stiffness = scene.material.young_modulus * scene.material.thickness;
  scene.pressure = share * stiffness / radius;
  Experiment disc(scene, sampleDisc(radius, spacing, variant.sampling), variant);
  disc.hold([&](const Vec3& rest) { return rest.norm() > radius * (1.0 - 1e-6); });
  disc.settle();
  Answer answer;
  answer.points = static_cast<Index>(disc.rest().size());
  for (const Vec3& p : disc.cloudNow()) answer.value = std::max(answer.value, std::abs(p.z()));
  answer.reference = radius * std::cbrt(share) * solveHencky(scene.material.poisson_ratio);
  answer.error = std::abs(answer.value / answer.reference - 1.0);
  return answer;
}

// Springs are asked for the law of the equilateral mesh, which is that of co-rotated triangles at Poisson's ratio 1/3.
Answer blowBalloon(const Variant& variant, double spacing) {
  const double radius = 0.3, stretch = 1.3;
  simulation::SceneParams scene = makeStaticScene();
  scene.material.young_modulus = 1e5;
  scene.material.thickness = 1e-3;
  scene.material.poisson_ratio = variant.membrane == model::Membrane::kSprings ? 1.0 / 3.0 : 0.2;
  const double stiffness = scene.material.young_modulus * scene.material.thickness;
  scene.pressure = 2.0 * stiffness * (stretch - 1.0) / ((1.0 - scene.material.poisson_ratio) * radius * stretch * stretch);
  Experiment balloon(scene, sampleSphere(radius, spacing, variant.sampling), variant);
  balloon.settle();
  Vec3 centre = Vec3::Zero();
  const Points now = balloon.now();
  for (const Vec3& p : now) centre += p / static_cast<double>(now.size());
  Answer answer;
  answer.points = static_cast<Index>(now.size());
  for (const Vec3& p : now) answer.value += (p - centre).norm() / radius / static_cast<double>(now.size());
  answer.reference = stretch;
  answer.error = std::abs(answer.value - stretch) / (stretch - 1.0);
  return answer;
}

}  // namespace

std::vector<Problem> listMembranes() {
  Problem disc;
  disc.name = "clamped disc";
  disc.value = "height of the middle, m";
  disc.scale = "height";
  disc.source = "Hencky 1915, corrected: recurrence of the series";
  disc.variants = listAll(model::Bending::kNone);
  disc.sizes = {0.1, 0.05, 0.025};
  disc.run = blowDisc;
  Problem balloon;
  balloon.name = "balloon";
  balloon.value = "stretch";
  balloon.scale = "stretch - 1";
  balloon.source = "p = 2 E h (s - 1) / ((1 - nu) R s^2)";
  balloon.variants = listAll(model::Bending::kNone);
  balloon.sizes = {0.1, 0.06, 0.035};
  balloon.run = blowBalloon;
  return {disc, balloon};
}

}  // namespace deformable_surface::physics
