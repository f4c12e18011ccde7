// Elastic solids in space: a bar that sinks under its weight, and balls pressed into layers.
#include "deformable_surface/simulation/simulation.h"
#include "problem.h"

#include <cmath>
#include <random>
#include <stdexcept>

namespace deformable_surface::physics {
namespace {

constexpr double kJitter = 0.2;  // of the spacing
constexpr double kYoung = 1e5, kPoisson = 0.3, kDensity = 1000.0;

/// A box of points from low to high, with as many as the spacing asks for, an odd number along x and y so that one column is in
/// the middle. Jittered points on faces and edges stay on them.
cloud::PointCloud sampleBox(const Vec3& low, const Vec3& high, double spacing, Sampling sampling) {
  std::mt19937 generator(1);
  const auto draw = [&] { return sampling == Sampling::kRegular ? 0.0 : kJitter * (generator() / 2147483648.0 - 1.0); };
  Index counts[3];
  Vec3 steps;
  for (int c = 0; c < 3; ++c) {
    const double across = (high[c] - low[c]) / spacing;
    counts[c] = 1 + (c == 2 ? static_cast<Index>(std::lround(across)) : 2 * static_cast<Index>(std::lround(0.5 * across)));
    steps[c] = (high[c] - low[c]) / (counts[c] - 1);
  }
  cloud::PointCloud cloud;
  for (Index x = 0; x < counts[0]; ++x)
    for (Index y = 0; y < counts[1]; ++y)
      for (Index z = 0; z < counts[2]; ++z) {
        const Index at[3] = {x, y, z};
        Vec3 p;
        for (int c = 0; c < 3; ++c) {
          const double shift = draw();
          const bool is_end = at[c] == 0 || at[c] == counts[c] - 1;
          p[c] = low[c] + steps[c] * (at[c] + (is_end ? 0.0 : shift));
        }
        cloud.positions.push_back(p);
      }
  cloud.width = static_cast<std::uint32_t>(cloud.positions.size());
  return cloud;
}

simulation::SceneParams makeScene(double damping) {
  simulation::SceneParams scene;
  scene.model = "elastic_solid";
  scene.material.young_modulus = kYoung;
  scene.material.poisson_ratio = kPoisson;
  scene.material.density = kDensity;
  scene.material.damping = damping;
  scene.simplification.method = cloud::SimplificationMethod::kNone;
  scene.neighbors.geodesic_exponent = OrAuto<double>(1.0);  // there are no gaps
  scene.gravity.setZero();
  scene.integrator.time_step = 0.01;
  return scene;
}

simulation::PinParams pinBox(const Vec3& low, const Vec3& high) {
  simulation::PinParams pin;
  pin.region.min = low;
  pin.region.max = high;
  return pin;
}

void step(simulation::Simulation& simulation, int steps) {
  for (int k = 0; k < steps; ++k) {
    const simulation::StepOutcome outcome = simulation.step();
    if (!outcome.ok) throw std::runtime_error(outcome.problem);
  }
}

/// A bar 1 : 5, clamped at one end, under a weight that bends it by a thousandth of its length: Timoshenko's beam,
///   w = q L^4 / (8 E I) + q L^2 / (2 k G A),  k = 10 (1 + nu) / (12 + 11 nu) [Cowper 1966],
/// whose clamp does not keep the end from contracting.
Answer bendBar(const Variant& variant, double spacing) {
  constexpr double kLength = 0.5, kHeight = 0.1;
  const double area = kHeight * kHeight, inertia = area * area / 12.0, shear = kYoung / (2.0 * (1.0 + kPoisson));
  const double factor = 10.0 * (1.0 + kPoisson) / (12.0 + 11.0 * kPoisson);
  const double per_weight = std::pow(kLength, 4) / (8.0 * kYoung * inertia) + kLength * kLength / (2.0 * factor * shear * area);
  Answer answer;
  answer.reference = 1e-3 * kLength;
  const double frequency = 3.516 * std::sqrt(kYoung * inertia / (kDensity * area * std::pow(kLength, 4)));
  simulation::SceneParams scene = makeScene(2.0 * frequency);  // of the first mode: critical
  scene.gravity.z() = -answer.reference / (per_weight * kDensity * area);
  scene.pins = {pinBox(Vec3(-1.0, -1.0, -1.0), Vec3(1e-9, 1.0, 1.0))};
  simulation::Simulation simulation(scene, sampleBox(Vec3(0.0, -0.5 * kHeight, -0.5 * kHeight),
                                                     Vec3(kLength, 0.5 * kHeight, 0.5 * kHeight), spacing, variant.sampling));
  step(simulation, static_cast<int>(std::ceil(18.0 / frequency / scene.integrator.time_step)));  // what is left is a millionth
  double sum = 0.0, count = 0.0;
  const Points& now = simulation.state().positions;
  for (std::size_t i = 0; i < now.size(); ++i)
    if (simulation.input().positions[i].x() == kLength) {
      sum += simulation.input().positions[i].z() - now[i].z();
      count += 1.0;
    }
  answer.points = static_cast<Index>(now.size());
  answer.value = sum / count;
  answer.error = std::abs(answer.value / answer.reference - 1.0);
  return answer;
}

/// F over that on a half-space, 4/3 E / (1 - nu^2) R^(1/2) d^(3/2) [Hertz 1881], of a layer of height h that is held below
/// [dimitriadis2002, eq. 10 and 12]; x = (R d)^(1/2) / h.
double correctForLayer(double x, double nu) {
  const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu);
  const double b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1.0 - nu);
  return 1.0 - 2.0 * a / kPi * x + 4.0 * a * a / (kPi * kPi) * x * x -
         8.0 / std::pow(kPi, 3) * (std::pow(a, 3) + 4.0 * kPi * kPi / 15.0 * b) * std::pow(x, 3) +
         16.0 * a / std::pow(kPi, 4) * (std::pow(a, 3) + 3.0 * kPi * kPi / 5.0 * b) * std::pow(x, 4);
}

/// A rigid ball on a square layer. Lengths in m.
struct Indentation {
  double radius, depth;
  double half, height;    // of the layer: half of its width
  double young, poisson;  // young in Pa
  model::SolidLaw law = model::SolidLaw::kCorotated;
};

/// The force on the ball, N, at rest: in equilibrium, or a quarter of a second after it was pressed in within 0.1 s. Nothing is
/// subtracted for the depth of points in the ball.
double findForce(const Indentation& given, const Variant& variant, double spacing, bool in_motion, Index& points) {
  simulation::SceneParams scene = makeScene(in_motion ? 60.0 : 0.0);
  if (!in_motion) {
    scene.integrator.type = solve::IntegratorType::kStatic;
    scene.integrator.time_step = 0.05;
  }
  scene.material.young_modulus = given.young;
  scene.material.poisson_ratio = given.poisson;
  scene.elastic_solid.law = given.law;
  scene.pins = {pinBox(Vec3(-1.0, -1.0, -1.0), Vec3(1.0, 1.0, 1e-9 - given.height))};
  tool::ToolParams ball;
  ball.id = "ball";
  ball.shape.radius = given.radius;
  tool::WaypointParams from, to;
  from.position = Vec3(0.0, 0.0, given.radius);
  to.position = Vec3(0.0, 0.0, given.radius - given.depth);
  to.time = 0.1;
  ball.path = {from, to};
  scene.tools = {ball};
  simulation::Simulation simulation(scene, sampleBox(Vec3(-given.half, -given.half, -given.height),
                                                     Vec3(given.half, given.half, 0.0), spacing, variant.sampling));
  step(simulation, in_motion ? 35 : 2);
  points = simulation.state().size();
  return simulation.toolReactions().front().force.z();
}

Answer pressBall(const Indentation& given, const Variant& variant, double spacing) {
  Answer answer;
  answer.value = findForce(given, variant, spacing, false, answer.points);
  answer.reference = 4.0 / 3.0 * given.young / (1.0 - given.poisson * given.poisson) * std::sqrt(given.radius) *
                     std::pow(given.depth, 1.5) *
                     correctForLayer(std::sqrt(given.radius * given.depth) / given.height, given.poisson);
  answer.error = std::abs(answer.value / answer.reference - 1.0);
  return answer;
}

/// What the penalty of contact in motion takes of the force.
Answer pressBallInMotion(const Indentation& given, const Variant& variant, double spacing) {
  Answer answer;
  answer.value = findForce(given, variant, spacing, true, answer.points);
  answer.reference = findForce(given, variant, spacing, false, answer.points);
  answer.error = std::abs(answer.value / answer.reference - 1.0);
  return answer;
}

}  // namespace

std::vector<Problem> listSolids() {
  const model::Bending none = model::Bending::kNone;
  const std::vector<Variant> variants = {{model::Membrane::kTriangles, none, Sampling::kRegular, false},
                                         {model::Membrane::kTriangles, none, Sampling::kJittered, false}};
  Problem bar;
  bar.name = "solid bar under its weight";
  bar.value = "mean deflection of the end, m";
  bar.scale = "deflection";
  bar.source = "Timoshenko's beam";
  bar.other_law = true;
  bar.variants = variants;
  bar.sizes = {0.025, 0.02, 0.0125, 0.01};
  bar.run = bendBar;
  Problem ball;
  ball.name = "ball pressed into a solid layer";
  ball.value = "force, N";
  ball.scale = "force";
  ball.source = "Hertz 1881; Dimitriadis et al. 2002 for the layer's height";
  ball.variants = variants;
  ball.sizes = {0.025, 0.02, 0.015, 0.01};
  ball.run = [](const Variant& variant, double spacing) {
    return pressBall({0.8, 0.005, 0.2, 0.12, kYoung, kPoisson}, variant, spacing);
  };
  Problem finger = ball;  // soft tissue under a fingertip
  finger.name = "solid palpated by a ball";
  finger.sizes = {0.003, 0.002, 0.0015};
  finger.run = [](const Variant& variant, double spacing) {
    return pressBall({0.015, 0.002, 0.03, 0.03, 20e3, 0.45}, variant, spacing);
  };
  Problem rubber = finger;
  rubber.name = "neo-Hookean solid palpated by a ball";
  rubber.run = [](const Variant& variant, double spacing) {
    return pressBall({0.015, 0.002, 0.03, 0.03, 20e3, 0.3, model::SolidLaw::kNeoHookean}, variant, spacing);
  };
  Problem moving = finger;
  moving.name = "solid palpated by a ball, in motion";
  moving.source = "the same in equilibrium";
  moving.sizes = {0.003};
  moving.run = [](const Variant& variant, double spacing) {
    return pressBallInMotion({0.015, 0.002, 0.03, 0.03, 20e3, 0.3}, variant, spacing);
  };
  bar.is_solid = ball.is_solid = finger.is_solid = rubber.is_solid = moving.is_solid = true;
  return {bar, ball, finger, rubber, moving};
}

}  // namespace deformable_surface::physics
