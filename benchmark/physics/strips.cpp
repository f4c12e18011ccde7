// Strips that bend: under their own weight, by a force and by a moment at the end, flat or rolled to an arc (the elastica is
// exact for all); and the weight under which one that stands upright buckles.
#include "experiment.h"
#include "references.h"

#include <cmath>
#include <stdexcept>

namespace deformable_surface::physics {
namespace {

const double kPi = std::acos(-1.0);
constexpr double kGravity = 9.81;  // m/s^2
constexpr double kTiny = 1e-9;     // m

// A strip of which the part before x = 0, a fifth of the free length, is held. The free end is at x = length.
Experiment makeStrip(simulation::SceneParams scene, double length, double width, double spacing, const Variant& variant) {
  scene.pins = {pinBehind(Vec3::Zero(), Vec3::UnitX(), length)};
  const Vec2 low(-0.2 * length, -0.5 * width), high(length, 0.5 * width);
  return Experiment(scene, sampleRectangle(low, high, spacing, variant.sampling), variant);
}

Answer compareTip(Experiment& strip, double length, const Vec3& expected) {
  const Vec3 moved = meanDisplacement(strip, [&](const Vec3& rest) { return rest.x() > length - kTiny; });
  Answer answer;
  answer.points = static_cast<Index>(strip.rest().size());
  answer.value = moved.z();
  answer.reference = expected.z();
  answer.error = (moved - expected).norm() / expected.norm();
  return answer;
}

// A foil of 1 mm: of what modulus it has to be for the gravito-bending number.
Answer bendByWeight(double gamma, const Variant& variant, double spacing) {
  const double length = 0.3, width = 0.06;
  simulation::SceneParams scene = makeStaticScene();
  scene.gravity = Vec3(0.0, 0.0, -kGravity);
  scene.material.thickness = 1e-3;
  scene.material.density = 1000.0;
  scene.material.poisson_ratio = variant.membrane == model::Membrane::kSprings ? 1.0 / 3.0 : 0.0;
  const double rigidity = scene.material.arealDensity() * kGravity * std::pow(length, 3) / gamma;
  scene.material.young_modulus = 12.0 * rigidity / std::pow(scene.material.thickness, 3);
  scene.material.bending_rigidity = rigidity;
  Experiment strip = makeStrip(scene, length, width, spacing, variant);
  strip.settle();
  const ElasticaTip exact = solveElastica(gamma, 0.0);
  return compareTip(strip, length, Vec3((exact.reach - 1.0) * length, 0.0, -exact.droop * length));
}

// The material of [sze2004, 3.1 and 3.2].
simulation::SceneParams makeSzeScene(const Variant& variant) {
  simulation::SceneParams scene = makeStaticScene();
  scene.material.young_modulus = 1.2e6;
  scene.material.poisson_ratio = variant.membrane == model::Membrane::kSprings ? 1.0 / 3.0 : 0.0;
  scene.material.thickness = 0.1;
  scene.material.bending_rigidity = scene.material.young_modulus * std::pow(scene.material.thickness, 3) / 12.0;
  return scene;
}

Answer bendByForce(const Variant& variant, double spacing) {
  const double length = 10.0, width = 1.0;
  const simulation::SceneParams scene = makeSzeScene(variant);
  Experiment strip = makeStrip(scene, length, width, spacing, variant);
  const double force = 4.0 * scene.material.bendingRigidity() * width / (length * length);
  pushEdge(strip, length, Vec3(0.0, 0.0, -force));
  strip.settle();
  const ElasticaTip exact = solveElastica(0.0, 4.0);
  return compareTip(strip, length, Vec3((exact.reach - 1.0) * length, 0.0, -exact.droop * length));
}

// The moment follows the end: a couple of forces along its normal on the points within a band, growing linearly across it. They
// are turned anew until the end no longer turns; the load is raised in steps, as three quarters of a circle are too far from rest
// for one. Such a couple leaves the end free to twist: beyond 333 degrees the circle is no stable equilibrium of a rod that is as
// stiff against twist as this strip, twice as stiff as against bending (docs/accuracy.md).
Answer bendByMoment(double share_of_circle, const Variant& variant, double spacing) {
  const double length = 12.0, width = 1.0, full = 50.0 * kPi / 3.0;
  constexpr int kTurns = 6;           // per load step: the direction converges quadratically
  constexpr double kStep = 0.05;      // of the full circle, as the published table has it
  const double band = 2.2 * spacing;  // holds at least two columns of points in every sampling
  Experiment strip = makeStrip(makeSzeScene(variant), length, width, spacing, variant);
  // Forces m (a + b x + c y) for a moment of one: no net force, and no torsion.
  std::vector<Index> end;
  Mat3 sums = Mat3::Zero();
  const auto place = [&](Index i) { return Vec3(1.0, strip.rest()[i].x() - length, strip.rest()[i].y()); };
  for (Index i = 0; i < static_cast<Index>(strip.rest().size()); ++i)
    if (strip.rest()[i].x() > length - band) {
      end.push_back(i);
      sums += strip.masses()[i] * place(i) * place(i).transpose();
    }
  const Vec3 shares = sums.ldlt().solve(Vec3::UnitY());
  std::vector<double> force;
  for (Index i : end) force.push_back(strip.masses()[i] * place(i).dot(shares));
  const int steps = static_cast<int>(std::lround(share_of_circle / kStep));
  for (int step = 1; step <= steps; ++step)
    for (int turn = 0; turn < kTurns; ++turn) {
      const Points now = strip.now();
      Vec3 along = Vec3::Zero();
      for (std::size_t k = 0; k < end.size(); ++k) along += force[k] * now[end[k]];
      const Vec3 normal = along.normalized().cross(Vec3::UnitY());
      for (std::size_t k = 0; k < end.size(); ++k) strip.push(end[k], kStep * step * full * force[k] * normal);
      strip.settle();
    }
  const double angle = 2.0 * kPi * share_of_circle;
  return compareTip(strip, length, Vec3((std::sin(angle) / angle - 1.0) * length, 0.0, (1.0 - std::cos(angle)) / angle * length));
}

// A strip that is an arc of 2 rad at rest, bent on by a fifth of a radian: constant moment on a curved surface. What the couple
// acts on, the last tenth, is not compared.
Answer bendArc(const Variant& variant, double spacing) {
  const double length = 12.0, width = 3.0, radius = 0.5 * length, turn = 0.2;
  constexpr double kBand = 0.1;  // of the length
  constexpr int kTurns = 4;      // the direction of the couple converges quadratically
  const auto place = [&](double arc, double y, double curvature) {
    return Vec3(std::sin(arc * curvature) / curvature, y, (1.0 - std::cos(arc * curvature)) / curvature);
  };
  simulation::SceneParams scene = makeSzeScene(variant);
  scene.pins = {pinBehind(Vec3::Zero(), Vec3::UnitX(), length)};
  Sampled cloud = sampleRectangle(Vec2(-0.2 * length, -0.5 * width), Vec2(length, 0.5 * width), spacing, variant.sampling);
  for (Vec3& p : cloud.points) p = place(p.x(), p.y(), 1.0 / radius);
  Experiment strip(scene, cloud, variant);
  const auto findArc = [&](const Vec3& rest) { return radius * std::atan2(rest.x(), radius - rest.z()); };
  // Forces m (a + b x + c y) for a moment of one: no net force, and no torsion. x: along the end's tangent.
  const Vec3 end = place(length, 0.0, 1.0 / radius), tangent(std::cos(length / radius), 0.0, std::sin(length / radius));
  std::vector<Index> band;
  Mat3 sums = Mat3::Zero();
  const auto shape = [&](Index i) { return Vec3(1.0, (strip.rest()[i] - end).dot(tangent), strip.rest()[i].y()); };
  for (Index i = 0; i < static_cast<Index>(strip.rest().size()); ++i)
    if (findArc(strip.rest()[i]) > (1.0 - kBand) * length) {
      band.push_back(i);
      sums += strip.masses()[i] * shape(i) * shape(i).transpose();
    }
  const Vec3 shares = sums.ldlt().solve(Vec3::UnitY());
  std::vector<double> force;
  for (Index i : band) force.push_back(strip.masses()[i] * shape(i).dot(shares));
  const double moment = turn / length * scene.material.bendingRigidity() * width;
  for (int k = 0; k < kTurns; ++k) {
    const Points now = strip.now();
    Vec3 along = Vec3::Zero();
    for (std::size_t i = 0; i < band.size(); ++i) along += force[i] * now[band[i]];
    // A couple of forces across `along` whose moment is exact however the band is curved.
    const Vec3 across = along.cross(Vec3::UnitY()).normalized() / along.norm();
    for (std::size_t i = 0; i < band.size(); ++i) strip.push(band[i], moment * force[i] * across);
    strip.settle();
  }
  const Points now = strip.cloudNow();
  double squares = 0.0, moved = 0.0;
  Answer answer;
  answer.points = static_cast<Index>(strip.rest().size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Vec3& rest = strip.cloudRest()[i];
    const double arc = findArc(rest);
    if (arc < 0.0 || arc > (1.0 - kBand) * length) continue;
    const Vec3 exact = place(arc, rest.y(), 1.0 / radius + turn / length);
    squares += (now[i] - exact).squaredNorm();
    moved += (exact - rest).squaredNorm();
    answer.value += (now[i] - rest).dot(exact - rest);
  }
  answer.value /= moved;  // how much more it bends than it should, about
  answer.reference = 1.0;
  answer.error = std::sqrt(squares / moved);
  return answer;
}

// An upright foil, clamped at its foot. A weight that pulls a little sideways as well moves the end by d ~ g / (g_critical - g):
// the root of g / d, linear in g, from two values below it. [greenhill1881]
Answer buckleByWeight(double clamp_share, const Variant& variant, double spacing) {
  const double length = 0.3, width = 0.075, clamp = clamp_share * spacing;
  constexpr double kCritical = 7.8373, kSideways = 2e-4;
  simulation::SceneParams scene = makeStaticScene();
  scene.integrator.tolerance = 1e-10;
  scene.material.thickness = 1e-3;
  scene.material.density = 1000.0;
  scene.material.poisson_ratio = 0.0;
  scene.material.young_modulus = 1e9;
  scene.material.bending_rigidity = scene.material.young_modulus * std::pow(scene.material.thickness, 3) / 12.0;
  scene.pins = {pinBehind(Vec3(clamp, 0.0, 0.0), Vec3::UnitX(), length)};
  const Vec2 low(-0.2 * length, -0.5 * width), high(length, 0.5 * width);
  Experiment strip(scene, sampleRectangle(low, high, spacing, variant.sampling), variant);
  double gamma[2] = {0.9 * kCritical, 0.95 * kCritical}, inverse[2];
  for (int k = 0; k < 2; ++k) {
    const double gravity =
        gamma[k] * scene.material.bendingRigidity() / (scene.material.arealDensity() * std::pow(length - clamp, 3));
    strip.setGravity(gravity * Vec3(-1.0, 0.0, kSideways));
    strip.settle();
    const auto isEnd = [&](const Vec3& rest) { return rest.x() > length - kTiny; };
    inverse[k] = gamma[k] * kSideways * length / meanDisplacement(strip, isEnd).z();
  }
  Answer answer;
  answer.points = static_cast<Index>(strip.rest().size());
  answer.value = gamma[1] - inverse[1] * (gamma[1] - gamma[0]) / (inverse[1] - inverse[0]);
  answer.reference = kCritical;
  answer.error = std::abs(answer.value / answer.reference - 1.0);
  return answer;
}

}  // namespace

std::vector<Problem> listStrips() {
  std::vector<Problem> list;
  for (const double gamma : {0.1, 1.0, 10.0, 100.0, 1000.0}) {
    Problem p;
    char name[64];
    std::snprintf(name, sizeof name, "heavy elastica, gamma %g", gamma);
    p.name = name;
    p.value = "z of the free end, m";
    p.scale = "displacement of the end";
    p.source = "elastica, integrated numerically";
    p.variants = listMost(model::Bending::kCurvature);
    p.sizes = {0.03, 0.02, 0.012, 0.0075};
    // The heaviest turns down within sqrt(D / w L), a thirtieth of its length.
    if (gamma > 500.0) p.sizes = {0.0075, 0.005, 0.0035, 0.0025};
    p.run = [gamma](const Variant& variant, double spacing) { return bendByWeight(gamma, variant, spacing); };
    list.push_back(p);
  }
  Problem force;
  force.name = "end force";
  force.value = "z of the free end, m";
  force.scale = "displacement of the end";
  force.source = "elastica; Sze, Liu, Lo 2004, 3.1, P/Pmax = 1, agrees to 0.1 %";
  force.variants = listMost(model::Bending::kCurvature);
  force.sizes = {0.5, 1.0 / 3.0, 0.25, 0.2};
  force.run = bendByForce;
  list.push_back(force);
  for (const double share : {0.5, 0.75}) {
    Problem moment;
    moment.name = share < 0.75 ? "end moment, half a circle" : "end moment, three quarters of a circle";
    moment.value = "z of the free end, m";
    moment.scale = "displacement of the end";
    moment.source = "circle; Sze, Liu, Lo 2004, 3.2";
    moment.variants = listSamplings(model::Membrane::kTriangles, model::Bending::kCurvature);
    moment.sizes = {0.5, 1.0 / 3.0, 0.25, 0.2};
    moment.run = [share](const Variant& variant, double spacing) { return bendByMoment(share, variant, spacing); };
    list.push_back(moment);
  }
  Problem arc;
  arc.name = "end moment, arc of 2 rad";
  arc.value = "displacement over the exact one";
  arc.scale = "displacement (rms over the points before the couple)";
  arc.source = "circle";
  arc.variants = listSamplings(model::Membrane::kTriangles, model::Bending::kCurvature);
  arc.sizes = {0.6, 0.4, 0.3, 0.15};
  arc.run = bendArc;
  list.push_back(arc);
  for (const double clamp : {0.0, 0.4}) {
    Problem buckling;
    buckling.name = clamp > 0.0 ? "self-buckling, clamp between rows" : "self-buckling, clamp on a row";
    buckling.value = "gamma at which an upright strip buckles";
    buckling.scale = "gamma";
    buckling.source = "Greenhill 1881";
    buckling.variants = listSamplings(model::Membrane::kTriangles, model::Bending::kCurvature);
    buckling.sizes = {0.015, 0.0075, 0.00375};
    buckling.run = [clamp](const Variant& variant, double spacing) { return buckleByWeight(clamp, variant, spacing); };
    list.push_back(buckling);
  }
  return list;
}

}  // namespace deformable_surface::physics
