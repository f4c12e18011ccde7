// Frequencies of a cantilever, a hanging strip and a stretched membrane, from the motion after a kick.
#include "experiment.h"

#include <cmath>

namespace deformable_surface::physics {
namespace {

constexpr double kGravity = 9.81;    // m/s^2
constexpr double kAmplitude = 1e-4;  // of the length: large deflections change a frequency by the square of it
constexpr double kStepsPerPeriod = 100.0;
constexpr double kPeriods = 4.0;  // recorded

simulation::SceneParams makeDynamicScene() {
  simulation::SceneParams scene;
  scene.accuracy.estimate = false;
  scene.gravity.setZero();
  scene.output.normals = false;
  scene.integrator.type = solve::IntegratorType::kVerlet;
  return scene;
}

Answer compare(Experiment& experiment, double measured, double exact) {
  Answer answer;
  answer.points = static_cast<Index>(experiment.rest().size());
  answer.value = measured / (2.0 * kPi);
  answer.reference = exact / (2.0 * kPi);
  answer.error = std::abs(measured / exact - 1.0);
  return answer;
}

// The first bending mode: w = (b L)^2 / L^2 sqrt(D / rho_s), b L = 1.8751041.
Answer swingCantilever(const Variant& variant, double spacing) {
  const double length = 0.2, width = 0.04, root = 1.8751040687;
  simulation::SceneParams scene = makeDynamicScene();
  scene.material.young_modulus = 2e6;
  scene.material.thickness = 5e-3;
  scene.material.density = 500.0;
  scene.material.poisson_ratio = variant.membrane == model::Membrane::kSprings ? 1.0 / 3.0 : 0.0;
  scene.material.bending_rigidity = scene.material.young_modulus * std::pow(scene.material.thickness, 3) / 12.0;
  const double exact = std::pow(root / length, 2) * std::sqrt(scene.material.bendingRigidity() / scene.material.arealDensity());
  scene.integrator.time_step = 2.0 * kPi / exact / kStepsPerPeriod;
  scene.pins = {pinBehind(Vec3::Zero(), Vec3::UnitX(), length)};
  const Vec2 low(-0.2 * length, -0.5 * width), high(length, 0.5 * width);
  Experiment strip(scene, sampleRectangle(low, high, spacing, variant.sampling), variant);
  const double share = (std::cosh(root) + std::cos(root)) / (std::sinh(root) + std::sin(root));
  const auto mode = [&](const Vec3& rest) {
    const double s = root * std::max(0.0, rest.x()) / length;
    const double shape = std::cosh(s) - std::cos(s) - share * (std::sinh(s) - std::sin(s));
    return Vec3(0.0, 0.0, 0.5 * kAmplitude * length * exact * shape);
  };
  return compare(strip, measureFrequency(strip, mode, 0.0, kPeriods * 2.0 * kPi / exact, exact), exact);
}

// The first mode of an inextensible hanging strip: w = (j01 / 2) sqrt(g / L), of the shape J0(j01 sqrt(z / L)) with z from the
// free end. The stretch under the weight is a thousandth; the axial motion that begins when the weight is let go is damped
// away.
Answer swingStrip(const Variant& variant, double spacing) {
  const double length = 0.5, width = 0.1, root = 2.404825558;
  simulation::SceneParams scene = makeDynamicScene();
  scene.material.thickness = 1e-3;
  scene.material.density = 1000.0;
  scene.material.poisson_ratio = variant.membrane == model::Membrane::kSprings ? 1.0 / 3.0 : 0.0;
  scene.material.young_modulus = 500.0 * scene.material.density * kGravity * length;
  scene.material.damping = 0.5;
  scene.material.spring_damping = 2e-4;
  scene.gravity = Vec3(kGravity, 0.0, 0.0);
  const double exact = 0.5 * root * std::sqrt(kGravity / length);
  scene.integrator.time_step = 2.0 * kPi / exact / kStepsPerPeriod;
  scene.pins = {pinBehind(Vec3::Zero(), Vec3::UnitX(), length)};
  const Vec2 low(0.0, -0.5 * width), high(length, 0.5 * width);
  Experiment strip(scene, sampleRectangle(low, high, spacing, variant.sampling), variant);
  const auto mode = [&](const Vec3& rest) {
    const double from_end = std::max(0.0, 1.0 - rest.x() / length);
    return Vec3(0.0, 0.0, kAmplitude * length * exact * std::cyl_bessel_j(0.0, root * std::sqrt(from_end)));
  };
  return compare(strip, measureFrequency(strip, mode, 1.5, kPeriods * 2.0 * kPi / exact, exact), exact);
}

// A square membrane, stretched evenly by world springs along its edges that are drawn so far that the edges come to rest at the
// wanted stretch: w = (pi / a) sqrt(2 T / rho_s), with side, tension and density of the stretched state.
Answer swingMembrane(const Variant& variant, double spacing) {
  const double side = 1.0, strain = 0.05;
  simulation::SceneParams scene = makeDynamicScene();
  scene.material.young_modulus = 1e5;
  scene.material.thickness = 1e-3;
  scene.material.density = 1000.0;
  scene.material.poisson_ratio = variant.membrane == model::Membrane::kSprings ? 1.0 / 3.0 : 0.3;
  scene.material.damping = 0.5;
  scene.material.spring_damping = 2e-3;
  const double stiffness = scene.material.young_modulus * scene.material.thickness;
  const double tension = stiffness * strain / (1.0 - scene.material.poisson_ratio);  // per length at rest
  const double exact = kPi / side * std::sqrt(2.0 * tension / (scene.material.arealDensity() * (1.0 + strain)));
  scene.integrator.time_step = 2.0 * kPi / exact / kStepsPerPeriod;
  const Sampled sampled = sampleRectangle(Vec2(-0.5, -0.5) * side, Vec2(0.5, 0.5) * side, spacing, variant.sampling);
  const double holder = 20.0 * stiffness;  // N/m: its give is put into the target
  const auto isEdge = [&](const Vec3& p, int c) { return std::abs(p[c]) > 0.5 * side - 1e-9; };
  for (const Vec3& p : sampled.points)
    if (isEdge(p, 0) || isEdge(p, 1)) {
      simulation::AnchorParams anchor;
      anchor.point = p;
      anchor.stiffness = holder;
      anchor.target = (1.0 + strain) * p;
      // Half the distance between the neighbours on the edge belongs to a point; in a corner a quarter on each side.
      for (int c = 0; c < 2; ++c)
        if (isEdge(p, c)) anchor.target[c] += std::copysign(tension * (isEdge(p, 1 - c) ? 0.5 : 1.0) * spacing / holder, p[c]);
      scene.anchors.push_back(anchor);
    }
  Experiment membrane(scene, sampled, variant);
  const auto mode = [&](const Vec3& rest) {
    return Vec3(0.0, 0.0, kAmplitude * exact * std::cos(kPi * rest.x() / side) * std::cos(kPi * rest.y() / side));
  };
  return compare(membrane, measureFrequency(membrane, mode, 2.0, kPeriods * 2.0 * kPi / exact, exact), exact);
}

}  // namespace

std::vector<Problem> listVibrations() {
  Problem cantilever;
  cantilever.name = "cantilever, frequency";
  cantilever.value = "first frequency, Hz";
  cantilever.scale = "frequency";
  cantilever.source = "Euler-Bernoulli, (bL)^2 = 3.5160153";
  cantilever.variants = listMost(model::Bending::kCurvature);
  cantilever.sizes = {0.02, 0.0133333, 0.008, 0.005};
  cantilever.run = swingCantilever;
  Problem strip;
  strip.name = "hanging strip, frequency";
  strip.value = "first frequency, Hz";
  strip.scale = "frequency";
  strip.source = "(j01 / 2) sqrt(g / L), j01 = 2.4048256";
  strip.variants = listMost(model::Bending::kNone);
  strip.sizes = {0.05, 0.033333, 0.025, 0.016667};
  strip.run = swingStrip;
  Problem membrane;
  membrane.name = "stretched square, frequency";
  membrane.value = "first frequency, Hz";
  membrane.scale = "frequency";
  membrane.source = "(pi / a) sqrt(2 T / rho_s)";
  // On a simplified scan the springs at the edge do not meet the points that carry them evenly.
  for (const Variant& v : listAll(model::Bending::kNone))
    if (v.sampling != Sampling::kScanned) membrane.variants.push_back(v);
  membrane.sizes = {0.125, 0.0625, 0.04};
  membrane.run = swingMembrane;
  return {cantilever, strip, membrane};
}

}  // namespace deformable_surface::physics
