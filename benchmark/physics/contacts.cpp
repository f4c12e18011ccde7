// Surfaces in contact: a ring that pressure from outside presses flat until its halves meet, a heavy sheet folded over itself on
// a table, a strip pulled over a cylinder.
#include "experiment.h"
#include "references.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace deformable_surface::physics {
namespace {

const double kPi = std::acos(-1.0);

// Points of a grid on a band around the y axis.
Sampled sampleRing(double radius, double width, double spacing) {
  const int around = 4 * static_cast<int>(std::lround(0.5 * kPi * radius / spacing));
  const int across = static_cast<int>(std::lround(width / spacing));
  Sampled ring;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j <= across; ++j) {
      const double angle = 2.0 * kPi * i / around;
      ring.points.emplace_back(radius * std::cos(angle), width * j / across, radius * std::sin(angle));
    }
  return ring;
}

// A ring of radius and rigidity 1 whose halves come no nearer than the gap. The pressure is then P.
class PressedRing {
 public:
  static constexpr double kGap = 0.02;           // m
  static constexpr double kFirstPressure = 3.7;  // of the shape from which all begin

  PressedRing(const Variant& variant, double spacing) : ring_(makeScene(), sampleRing(1.0, kWidth, spacing), variant) {
    // One line of points is a hinge.
    ring_.hold([](const Vec3& rest) { return rest.x() > 1.0 - 1e-9; });
    // The same buckled shape for all pressures.
    const std::vector<Vec2> quarter = solveRing(kFirstPressure, kGap).quarter;
    Points buckled = ring_.rest();
    for (Vec3& p : buckled) {
      const double at = 2.0 / kPi * std::atan2(std::abs(p.z()), std::abs(p.x())) * static_cast<double>(quarter.size() - 1);
      const std::size_t k = std::min(quarter.size() - 2, static_cast<std::size_t>(at));
      const Vec2 place = quarter[k] + (at - static_cast<double>(k)) * (quarter[k + 1] - quarter[k]);
      p = Vec3(std::copysign(place.x(), p.x()) + 1.0 - quarter[0].x(), p.y(), std::copysign(place.y(), p.z()));
    }
    ring_.place(buckled);
    std::vector<double> arc;
    for (const Vec3& p : ring_.rest()) arc.push_back(std::atan2(p.x(), std::abs(p.z())));
    for (std::size_t i = 0; i < arc.size(); ++i)
      if (std::abs(arc[i]) < kFitted * spacing) near_.push_back({static_cast<Index>(i), std::abs(arc[i])});
  }

  Index size() const { return static_cast<Index>(ring_.rest().size()); }
  void settle(double pressure) {
    simulation::SceneParams params = ring_.simulation().params();
    params.pressure = -pressure;  // along the outward normal
    ring_.simulation().setParams(params);
    ring_.settle();
    now_ = ring_.now();
  }
  double halfHeight() const { return fitMiddle()[0]; }
  /// Of the contact, over the width, N/m.
  double force() {
    double sum = 0.0;
    for (const simulation::SelfTouch& touch : ring_.simulation().selfTouches()) sum += std::abs(touch.force.z());
    return sum / kWidth;
  }

 private:
  static constexpr double kWidth = 0.2;  // m
  // N/m^2, along the ring's long axis: it would swing about its hinge, and its shape move around it, in any balance. Twice the
  // weight changes the pressures of the free ring by 0.05 %.
  static constexpr double kWeight = 4e-3;
  static constexpr double kFitted = 4.5;  // spacings on both sides of the middle

  static simulation::SceneParams makeScene() {
    simulation::SceneParams scene = makeStaticScene();
    scene.integrator.max_iterations = 1000;
    scene.material.thickness = kGap;  // so that the ring hardly becomes shorter
    scene.material.poisson_ratio = 0.0;
    scene.material.young_modulus = 12.0 / std::pow(scene.material.thickness, 3);
    scene.material.bending_rigidity = 1.0;
    scene.gravity.x() = -kWeight / (scene.material.density * scene.material.thickness);
    scene.contact.self = true;
    scene.contact.thickness = kGap;
    return scene;
  }
  // Distance from the plane between the halves, over the arc s from the middle: a + b s^2 + c |s|^3.
  Vec3 fitMiddle() const {
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (const Near& near : near_) {
      const Vec3 row(1.0, near.arc * near.arc, std::pow(near.arc, 3));
      normal += row * row.transpose();
      right += std::abs(now_[near.point].z()) * row;
    }
    return normal.inverse() * right;
  }

  struct Near {
    Index point;
    double arc;  // m
  };
  Experiment ring_;
  std::vector<Near> near_;
  Points now_;
};

Answer compare(Index points, double value, double reference) {
  Answer answer;
  answer.points = points;
  answer.value = value;
  answer.reference = reference;
  answer.error = std::abs(value / reference - 1.0);
  return answer;
}

// The exact ring needs that pressure for the height that is found.
Answer pressRing(double half_height, const Variant& variant, double spacing) {
  PressedRing ring(variant, spacing);
  const double pressure = findRingPressure(half_height);
  ring.settle(pressure);
  return compare(ring.size(), findRingPressure(ring.halfHeight()), pressure);
}

// The forces of contact at some pressures, in ascending order.
std::vector<double> findRingForces(PressedRing& ring, const std::vector<double>& pressures) {
  for (const double pressure : {4.3, 4.9, 5.1}) ring.settle(pressure);
  std::vector<double> forces;
  for (const double pressure : pressures) {
    ring.settle(pressure);
    forces.push_back(ring.force());
  }
  return forces;
}

// Where the force of contact, which grows nearly in proportion, would begin.
Answer meetInRing(const Variant& variant, double spacing) {
  PressedRing ring(variant, spacing);
  const std::vector<double> forces = findRingForces(ring, {5.3, 5.4});
  return compare(ring.size(), 5.3 - 0.1 * forces[0] / (forces[1] - forces[0]), findRingPressure(0.5 * PressedRing::kGap));
}

// The exact ring needs that pressure for the force of contact that is found.
Answer pressRingTogether(double pressure, const Variant& variant, double spacing) {
  constexpr double kAside = 0.01;  // the force is almost linear over so little
  PressedRing ring(variant, spacing);
  const double force = findRingForces(ring, {5.4, 6.3, std::min(pressure, 7.8), pressure}).back();
  const double low = solveRing(pressure - kAside, PressedRing::kGap).force;
  const double high = solveRing(pressure + kAside, PressedRing::kGap).force;
  return compare(ring.size(), pressure + kAside * (2.0 * force - low - high) / (high - low), pressure);
}

// A sheet of rigidity and weight per area 1, folded over itself on a table: its layers are the gap apart.
class HeavyFold {
 public:
  /// friction: of the layers and of the table. The lower layer's end is held.
  HeavyFold(double gap, double friction, const Variant& variant, double spacing)
      : gap_(gap),
        fold_(makeScene(gap, friction),
              sampleRectangle(Vec2(-kBelow, 0.0), Vec2(kLoop + kAbove, kWidth), spacing, variant.sampling), variant) {
    fold_.hold([&](const Vec3& rest) { return rest.x() < -kBelow + 1.5 * spacing; });
  }

  Index size() const { return static_cast<Index>(fold_.rest().size()); }
  const Points& rest() const { return fold_.rest(); }
  Points now() const { return fold_.now(); }
  /// Half a circle, then straight down to the lower layer.
  void fold() {
    constexpr double kRadius = 0.5;
    const double ramp = kLoop - kPi * kRadius, fall = std::asin((2.0 * kRadius - 1.2 * gap_) / ramp);
    Points places = fold_.rest();
    for (Vec3& p : places) {
      const double s = p.x(), after = s - kPi * kRadius;
      if (s < 0.0) continue;
      if (after < 0.0) {
        p.x() = kRadius * std::sin(s / kRadius);
        p.z() = kRadius * (1.0 - std::cos(s / kRadius));
      } else {
        const double sloping = std::min(after, ramp);
        p.x() = -sloping * std::cos(fall) - std::max(0.0, after - ramp);
        p.z() = 2.0 * kRadius - sloping * std::sin(fall);
      }
    }
    fold_.place(places);
  }
  void place(const Points& places) { fold_.place(places); }
  void run(double seconds, double damping) {
    fold_.simulation().setDamping(damping);
    for (int k = 0; k < std::lround(seconds / kStep); ++k) fold_.step();
  }
  double height() {
    double height = 0.0;
    for (const Vec3& p : fold_.now()) height = std::max(height, p.z());
    return height;
  }
  /// Mean place along the table of the free end, m.
  double end() const {
    double sum = 0.0, count = 0.0;
    const Points now = fold_.now();
    for (std::size_t i = 0; i < now.size(); ++i)
      if (fold_.rest()[i].x() > kLoop + kAbove - 1e-9) {
        sum += now[i].x();
        count += 1.0;
      }
    return sum / count;
  }

 private:
  static constexpr double kBelow = 5.0, kLoop = 4.68, kAbove = 1.5, kWidth = 0.4;  // m
  static constexpr double kGravity = 9.81, kStep = 0.01;

  static simulation::SceneParams makeScene(double gap, double friction) {
    simulation::SceneParams scene = makeStaticScene();
    scene.integrator = solve::IntegratorParams{};
    scene.integrator.type = solve::IntegratorType::kVerlet;
    scene.integrator.time_step = kStep;
    scene.sleep.mode = simulation::Sleep::kNever;
    scene.gravity = Vec3(0.0, 0.0, -kGravity);
    scene.material.poisson_ratio = 0.0;
    scene.material.thickness = 0.05;
    scene.material.young_modulus = 12.0 / std::pow(scene.material.thickness, 3);
    scene.material.bending_rigidity = 1.0;
    scene.material.density = 1.0 / (kGravity * scene.material.thickness);
    scene.contact.self = true;
    scene.contact.thickness = gap;
    scene.contact.friction = friction;
    tool::ToolParams table;
    table.id = "table";
    table.shape.kind = geometry::Solid::Kind::kPlane;
    table.friction = friction;
    table.path = {{0.0, Vec3::Zero(), Vec4(0.0, 0.0, 0.0, 1.0)}};
    scene.tools = {table};
    return scene;
  }

  double gap_;
  Experiment fold_;
};

constexpr double kDamping = 5.0;  // 1/s

// Slowly down, then until the upper layer has slid to where it is in equilibrium.
void settleFold(HeavyFold& fold) {
  fold.fold();
  fold.run(1.5, 6.0 * kDamping);
  fold.run(2.5, kDamping);
}

// Without friction the fold unrolls slowly; its height is that of equilibrium.
Answer measureFoldHeight(double gap, double exact, const Variant& variant, double spacing) {
  HeavyFold fold(gap, 0.0, variant, spacing);
  settleFold(fold);
  return compare(fold.size(), fold.height(), exact);
}

// How far the free end of the same fold moves within a second, once it has settled.
Answer measureUnrolling(double friction, const Variant& variant, double spacing) {
  constexpr double kFoldGap = 0.1;
  HeavyFold free(kFoldGap, 0.0, variant, spacing);
  settleFold(free);
  HeavyFold fold(kFoldGap, friction, variant, spacing);
  fold.place(free.now());
  fold.run(1.0, kDamping);
  const double before = fold.end();
  fold.run(1.0, kDamping);
  Answer answer;
  answer.points = fold.size();
  answer.value = fold.end() - before;
  answer.error = std::abs(answer.value) / kFoldGap;
  return answer;
}

// A strip over half of a cylinder, pulled at both ends: the ratio of the forces at which it begins to slide.
Answer slideOverCylinder(double friction, const Variant& variant, double spacing) {
  constexpr double kRadius = 0.1, kTail = 0.1, kWidth = 0.04, kForce = 1.0;  // m, N
  constexpr double kStep = 2e-3, kRate = 0.1;                                // s; of the ratio expected, 1/s
  constexpr double kSlid = 2e-4;                                             // m, more than the strip stretches
  const double length = kPi * kRadius + 2.0 * kTail;
  simulation::SceneParams scene = makeStaticScene();
  scene.integrator = solve::IntegratorParams{};
  scene.integrator.type = solve::IntegratorType::kVerlet;
  scene.integrator.time_step = kStep;
  scene.sleep.mode = simulation::Sleep::kNever;
  scene.material.poisson_ratio = 0.0;
  scene.material.thickness = 1e-3;
  scene.material.young_modulus = 5e7;
  scene.material.density = 250.0;
  scene.material.bending_rigidity = 1e-6;
  scene.material.damping = 20.0;
  tool::ToolParams cylinder;
  cylinder.id = "cylinder";
  cylinder.shape.kind = geometry::Solid::Kind::kCylinder;
  cylinder.shape.radius = kRadius;
  cylinder.shape.height = 2.0 * kWidth;
  const double half = std::sqrt(0.5);  // its axis along y
  cylinder.path = {{0.0, Vec3::Zero(), Vec4(half, 0.0, 0.0, half)}};
  cylinder.friction = friction;
  scene.tools = {cylinder};
  Experiment strip(scene, sampleRectangle(Vec2(0.0, -0.5 * kWidth), Vec2(length, 0.5 * kWidth), spacing, variant.sampling),
                   variant);
  Points places = strip.rest();
  for (Vec3& p : places) {
    const double s = p.x() - kTail, angle = std::min(kPi, std::max(0.0, s / kRadius));
    const double hanging = std::max(-s, s - kPi * kRadius);
    p = Vec3(-kRadius * std::cos(angle), p.y(), kRadius * std::sin(angle) - std::max(0.0, hanging));
  }
  strip.place(places);
  std::vector<Index> first, last;
  for (Index i = 0; i < static_cast<Index>(strip.rest().size()); ++i) {
    if (strip.rest()[i].x() < 1e-9) first.push_back(i);
    if (strip.rest()[i].x() > length - 1e-9) last.push_back(i);
  }
  const auto pull = [&](const std::vector<Index>& end, double force) {
    for (const Index i : end) strip.push(i, Vec3(0.0, 0.0, -force / static_cast<double>(end.size())));
  };
  const auto run = [&](double from, double to, double seconds) {
    const int steps = static_cast<int>(std::lround(seconds / kStep));
    for (int k = 1; k <= steps; ++k) {
      pull(last, from + (to - from) * k / steps);
      strip.step();
    }
  };
  const double exact = kForce * std::exp(friction * kPi);
  pull(first, kForce);
  run(kForce, kForce, 0.2);
  run(kForce, 0.9 * exact, 0.5);
  run(0.9 * exact, 0.9 * exact, 0.2);
  double now = 0.9 * exact;
  const double before = strip.now()[first[0]].z();
  while (strip.now()[first[0]].z() - before < kSlid && now < 1.2 * exact) {
    now += kRate * exact * kStep;
    pull(last, now);
    strip.step();
  }
  return compare(static_cast<Index>(strip.rest().size()), now / kForce, exact / kForce);
}

std::vector<Variant> listRings() {
  return {{model::Membrane::kTriangles, model::Bending::kCurvature, Sampling::kRegular, false}};
}

}  // namespace

std::vector<Problem> listContacts() {
  std::vector<Problem> list;
  Problem ring;
  ring.variants = listRings();
  ring.sizes = {kPi / 60.0, kPi / 80.0, kPi / 100.0};
  ring.value = "pressure times R^3 / D";
  ring.scale = "pressure";
  ring.source = "elastica; Flaherty, Keller, Rubinow 1972";
  for (const double half_height : {0.8, 0.6, 0.4, 0.2, 0.05}) {
    char name[64];
    std::snprintf(name, sizeof name, "pressed ring, half height %g R", half_height);
    ring.name = name;
    ring.run = [half_height](const Variant& variant, double spacing) { return pressRing(half_height, variant, spacing); };
    list.push_back(ring);
  }
  ring.name = "pressed ring, first contact";
  ring.run = meetInRing;
  list.push_back(ring);
  for (const double pressure : {6.3, 7.8, 9.3, 10.2}) {
    char name[64];
    std::snprintf(name, sizeof name, "pressed ring, force of contact at %g", pressure);
    ring.name = name;
    ring.run = [pressure](const Variant& variant, double spacing) { return pressRingTogether(pressure, variant, spacing); };
    list.push_back(ring);
  }

  Problem fold;
  fold.variants = {{model::Membrane::kTriangles, model::Bending::kCurvature, Sampling::kRegular, false},
                   {model::Membrane::kTriangles, model::Bending::kCurvature, Sampling::kJittered, true}};
  fold.sizes = {0.1, 0.07};
  fold.value = "height over (D / w)^(1/3)";
  fold.scale = "height";
  fold.source = "elastica";
  for (const auto& [gap, height] : {std::pair(0.05, 0.912478), {0.1, 0.918604}, {0.2, 0.931655}}) {
    char name[64];
    std::snprintf(name, sizeof name, "heavy fold, gap %g", gap);
    fold.name = name;
    fold.run = [gap = gap, height = height](const Variant& variant, double spacing) {
      return measureFoldHeight(gap, height, variant, spacing);
    };
    list.push_back(fold);
  }
  fold.value = "way of the free end in a second over (D / w)^(1/3)";
  fold.scale = "gap";
  fold.other_law = true;
  for (const double friction : {0.0, 0.3}) {
    fold.name = friction > 0.0 ? "heavy fold, stays with friction" : "heavy fold, unrolls without friction";
    fold.run = [friction](const Variant& variant, double spacing) { return measureUnrolling(friction, variant, spacing); };
    list.push_back(fold);
  }

  Problem capstan;
  capstan.variants = fold.variants;
  capstan.sizes = {0.02, 0.0125, 0.008};
  capstan.value = "ratio of the forces at both ends of a strip over half a cylinder";
  capstan.scale = "ratio";
  capstan.source = "Euler and Eytelwein";
  for (const double friction : {0.1, 0.3, 0.6}) {
    char name[64];
    std::snprintf(name, sizeof name, "capstan, friction %g", friction);
    capstan.name = name;
    capstan.run = [friction](const Variant& variant, double spacing) { return slideOverCylinder(friction, variant, spacing); };
    list.push_back(capstan);
  }
  return list;
}

}  // namespace deformable_surface::physics
