// Sheets under their own weight that only stretch: the hanging strip and the hammock, whose section is an elastic cable.
#include "experiment.h"
#include "references.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::physics {
namespace {

constexpr double kGravity = 9.81;              // m/s^2
constexpr double kLength = 1.0, kWidth = 0.2;  // m
constexpr double kTiny = 1e-9;                 // m

// Rubber of 1 mm. Poisson's ratio 0 where the discretisation has one: then what is held sideways does not matter and the closed
// forms of the cable hold for the sheet.
simulation::SceneParams makeScene(const Variant& variant, double young_modulus) {
  simulation::SceneParams scene = makeStaticScene();
  scene.material.young_modulus = young_modulus;
  scene.material.poisson_ratio = variant.membrane == model::Membrane::kSprings ? 1.0 / 3.0 : 0.0;
  scene.material.thickness = 1e-3;
  scene.material.density = 1000.0;
  scene.pins = {pinBehind(Vec3::Zero(), Vec3::UnitX(), kLength)};
  return scene;
}

Sampled sample(const Variant& variant, double spacing) {
  return sampleRectangle(Vec2(0.0, -0.5 * kWidth), Vec2(kLength, 0.5 * kWidth), spacing, variant.sampling);
}

Answer hangStrip(const Variant& variant, double spacing) {
  simulation::SceneParams scene = makeScene(variant, 1e5);
  scene.gravity = Vec3(kGravity, 0.0, 0.0);
  Experiment strip(scene, sample(variant, spacing), variant);
  strip.settle();
  Answer answer;
  answer.points = static_cast<Index>(strip.rest().size());
  answer.value = meanDisplacement(strip, [](const Vec3& rest) { return rest.x() > kLength - kTiny; }).x();
  answer.reference = scene.material.density * kGravity * kLength * kLength / (2.0 * scene.material.young_modulus);
  answer.error = std::abs(answer.value / answer.reference - 1.0);
  return answer;
}

Answer hangHammock(const Variant& variant, double spacing) {
  simulation::SceneParams scene = makeScene(variant, 2e5);
  scene.gravity = Vec3(0.0, 0.0, -kGravity);
  scene.pins.push_back(pinBehind(Vec3(kLength, 0.0, 0.0), -Vec3::UnitX(), kLength));
  Experiment sheet(scene, sample(variant, spacing), variant);
  sheet.settle();
  const double weight = scene.material.arealDensity() * kGravity * kWidth * kLength;
  const ElasticCable cable{scene.material.young_modulus * scene.material.thickness * kWidth, weight, kLength};
  const double tension = cable.solveTension(kLength);
  // The depth at the middle, by the points about it: each is compared at its own place.
  const Points now = sheet.cloudNow();
  Answer answer;
  answer.points = static_cast<Index>(sheet.rest().size());
  double squares = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const double s = sheet.cloudRest()[i].x();
    squares += std::pow(now[i].x() - cable.x(s, tension), 2) + std::pow(now[i].z() + cable.z(s, tension), 2);
    answer.value = std::min(answer.value, now[i].z());
  }
  answer.reference = -cable.z(0.5 * kLength, tension);
  answer.error = std::sqrt(squares / static_cast<double>(now.size())) / -answer.reference;
  return answer;
}

// The same, square, of 12,100 jittered points, of which fewer are simulated: the largest error over the cloud.
Answer simplifyHammock(const Variant& variant, double spacing) {
  simulation::SceneParams scene = makeScene(variant, 2e5);
  scene.gravity = Vec3(0.0, 0.0, -kGravity);
  scene.pins.push_back(pinBehind(Vec3(kLength, 0.0, 0.0), -Vec3::UnitX(), kLength));
  Sampled cloud = sampleRectangle(Vec2(0.0, -0.5 * kLength), Vec2(kLength, 0.5 * kLength), kLength / 109.0, variant.sampling);
  cloud.keep = static_cast<Index>(std::lround(kLength * kLength / (spacing * spacing)));
  Experiment sheet(scene, cloud, variant);
  sheet.settle();
  const double weight = scene.material.arealDensity() * kGravity * kLength * kLength;
  const ElasticCable cable{scene.material.young_modulus * scene.material.thickness * kLength, weight, kLength};
  const double tension = cable.solveTension(kLength);
  const Points now = sheet.cloudNow();
  Answer answer;
  answer.points = static_cast<Index>(sheet.rest().size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    const double s = sheet.cloudRest()[i].x();
    answer.error = std::max(answer.error, std::hypot(now[i].x() - cable.x(s, tension), now[i].z() + cable.z(s, tension)));
    answer.value = std::min(answer.value, now[i].z());
  }
  answer.reference = -cable.z(0.5 * kLength, tension);
  answer.error /= -answer.reference;
  return answer;
}

}  // namespace

std::vector<Problem> listHanging() {
  Problem strip;
  strip.name = "hanging strip";
  strip.value = "extension, m";
  strip.scale = "extension";
  strip.source = "rho g L^2 / (2 E)";
  strip.variants = listAll(model::Bending::kNone);
  strip.sizes = {0.1, 0.05, 0.025};
  strip.run = hangStrip;
  Problem hammock;
  hammock.name = "hammock";
  hammock.value = "z of the lowest point, m";
  hammock.scale = "sag (rms over all points)";
  hammock.source = "elastic catenary, Irvine 1981";
  hammock.variants = listAll(model::Bending::kNone);
  hammock.sizes = {0.1, 0.05, 0.025};
  hammock.run = hangHammock;
  Problem simplified;
  simplified.name = "hammock of 12,100 points, simplified";
  simplified.value = hammock.value;
  simplified.scale = "sag (largest over all points)";
  simplified.source = hammock.source;
  for (const Sampling sampling : {Sampling::kRegular, Sampling::kJittered})
    simplified.variants.push_back({model::Membrane::kTriangles, model::Bending::kCurvature, sampling, false});
  simplified.sizes = {0.05, 0.025, 0.0125};
  simplified.run = simplifyHammock;
  return {strip, hammock, simplified};
}

}  // namespace deformable_surface::physics
