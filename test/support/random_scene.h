// Scenes drawn at random from a seed, for calibrating the error estimate and for testing it: materials over four decades, shapes,
// samplings and loads. The same seed gives the same scene everywhere.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/scene_params.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

namespace deformable_surface::test {

/// A scene with a target number of simulation points, its cloud, and a short description.
struct RandomScene {
  simulation::SceneParams params;
  cloud::PointCloud cloud;
  std::string name;
};

class RandomSceneMaker {
 public:
  explicit RandomSceneMaker(std::uint32_t seed) : seed_(seed), engine_(seed) {}

  RandomScene make() {
    using Shape = simulation::CloudParams::Shape;
    static const std::pair<Shape, const char*> kShapes[] = {{Shape::kSheet, "sheet"},
                                                            {Shape::kStrip, "strip"},
                                                            {Shape::kSine, "sine"},
                                                            {Shape::kSphere, "sphere"},
                                                            {Shape::kCap, "cap"}};
    const auto shape = kShapes[static_cast<int>(draw(0.0, 5.0))];
    scene_.name = shape.second;
    length_ = drawLogarithmic(0.3, 2.0);
    makeCloud(shape.first);
    makeMaterial();
    if (shape.first == Shape::kSphere) {
      loadSphere();
    } else if (shape.first == Shape::kCap) {
      loadCap();
    } else {
      loadSheet();
    }
    makeTime();
    const double share = drawLogarithmic(1.0 / 16.0, 0.6);
    const Index n = scene_.cloud.size();
    scene_.params.simplification.target_points = std::min(n, std::max(Index{128}, static_cast<Index>(share * n)));
    // Without simplification only the time steps cause an error, and an equilibrium has none.
    if (scene_.params.integrator.type != solve::IntegratorType::kStatic && happens(0.08)) {
      scene_.params.simplification.method = cloud::SimplificationMethod::kNone;
      say("all");
    }
    return scene_;
  }

 private:
  // The standard fixes the engine but not its distributions.
  double draw(double low, double high) { return low + (high - low) * (engine_() / 4294967296.0); }
  double drawLogarithmic(double low, double high) { return low * std::pow(high / low, draw(0.0, 1.0)); }
  bool happens(double probability) { return draw(0.0, 1.0) < probability; }
  Vec3 drawDirection() {
    for (;;) {
      Vec3 v;
      for (int axis = 2; axis >= 0; --axis) v[axis] = draw(-1.0, 1.0);
      if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
    }
  }
  void say(const std::string& word) { scene_.name += " " + word; }

  void makeCloud(simulation::CloudParams::Shape shape) {
    using Shape = simulation::CloudParams::Shape;
    simulation::CloudParams& c = scene_.params.cloud;
    c.shape = shape;
    c.points = static_cast<Index>(drawLogarithmic(500.0, 1200.0));
    c.seed = static_cast<Index>(seed_ & 0xffff);
    c.jitter = happens(0.25) ? 0.0 : draw(0.0, 0.5);
    width_ = length_ * draw(0.6, 1.0);
    if (shape == Shape::kStrip) width_ = length_ * draw(0.12, 0.4);
    c.size = Vec2(length_, width_);
    c.radius = 0.5 * length_;
    c.angle = draw(0.4, 1.4);
    c.amplitude = length_ * draw(0.02, 0.12);
    c.wavelength = length_ / std::round(draw(0.6, 2.4));
    scene_.cloud = io::makeShape(c);
    if (happens(0.4)) thin();
  }

  // An irregular sampling: points are left out at random, more of them on one side.
  void thin() {
    say("irregular");
    Points kept;
    const double least = draw(0.3, 0.9);
    for (const Vec3& p : scene_.cloud.positions) {
      const double along = std::min(1.0, std::max(0.0, p.y() / width_ + 0.5));
      if (happens(least + (1.0 - least) * along)) kept.push_back(p);
    }
    scene_.cloud.positions = kept;
    scene_.cloud.width = static_cast<std::uint32_t>(kept.size());
  }

  void makeMaterial() {
    model::MaterialParams& m = scene_.params.material;
    m.thickness = 0.001;
    stretching_ = drawLogarithmic(10.0, 1e5);
    m.young_modulus = stretching_ / m.thickness;
    areal_density_ = drawLogarithmic(0.1, 3.0);
    m.density = areal_density_ / m.thickness;
    m.poisson_ratio = draw(0.0, 0.45);
    m.damping = happens(0.3) ? 0.0 : draw(0.0, 4.0);
  }

  void setRigidity(double rigidity) {
    // A plate thicker than a tenth of its length does not count as one.
    rigidity_ = std::min(rigidity, stretching_ * length_ * length_ / 1200.0);
    scene_.params.material.bending_rigidity.is_auto = false;
    scene_.params.material.bending_rigidity.value = rigidity_;
  }

  void addPin(const Vec3& min, const Vec3& max) {
    simulation::PinParams pin;
    pin.region.min = min;
    pin.region.max = max;
    scene_.params.pins.push_back(pin);
  }

  void addForce(const Vec3& point, double size) {
    simulation::ForceParams force;
    force.id = "pull";
    force.point = point;
    force.force = size * drawDirection();
    force.radius = length_ * draw(0.12, 0.35);
    scene_.params.forces.push_back(force);
    say("force");
  }

  // From a plate that hardly sags to a cloth, in the gravito-bending number.
  void loadSheet() {
    setRigidity(areal_density_ * 9.81 * std::pow(length_, 3) / drawLogarithmic(0.3, 3000.0));
    const double start = scene_.params.cloud.shape == simulation::CloudParams::Shape::kStrip ? 0.0 : -0.5 * length_;
    // A row of points, which is a hinge, or a strip, which is a clamp.
    const bool hinged = happens(0.35);
    const double edge = hinged ? 1e-3 * length_ : length_ * draw(0.12, 0.25), far = 10.0;
    const int kind = static_cast<int>(draw(0.0, 4.0));
    const double side = kind == 2 ? -0.5 * width_ + length_ * draw(0.12, 0.25) : far;
    addPin(Vec3(start - edge, -far, -far), Vec3(start + edge, side, far));
    const bool at_both = kind == 1 || kind == 2 || (hinged && happens(0.5));
    if (at_both) addPin(Vec3(start + length_ - edge, -far, -far), Vec3(start + length_ + edge, side, far));
    say(hinged ? "hinged" : "clamped");
    say(kind == 2 ? "two_corners" : at_both ? "two_edges" : "one_edge");
    if (happens(0.3)) scene_.params.gravity = 9.81 * drawDirection();
    if (happens(0.4)) {
      const double size = rigidity_ / (length_ * length_) * width_ * drawLogarithmic(0.3, 10.0);
      const double y = width_ * draw(-0.4, 0.4), x = start + length_ * draw(0.5, 1.0);
      addForce(Vec3(x, y, 0.0), size);
    }
    if (happens(0.25)) {
      scene_.params.pressure = rigidity_ / std::pow(length_, 3) * drawLogarithmic(0.3, 30.0);
      if (!happens(0.5)) scene_.params.pressure *= -1.0;
      say("pressure");
    }
  }

  void loadSphere() {
    const double radius = 0.5 * length_;
    setRigidity(stretching_ * radius * radius * drawLogarithmic(1e-5, 1e-3));
    addPin(Vec3(-10.0, -10.0, -10.0), Vec3(10.0, 10.0, -radius * draw(0.6, 0.9)));
    scene_.params.gravity = happens(0.5) ? Vec3(0.0, 0.0, -9.81) : Vec3::Zero().eval();
    addForce(Vec3(0.0, 0.0, radius), stretching_ * radius * drawLogarithmic(3e-4, 0.01));
    if (happens(0.3)) {
      scene_.params.pressure = stretching_ / radius * drawLogarithmic(1e-3, 0.05);
      say("pressure");
    }
  }

  void loadCap() {
    const double radius = 0.5 * length_, rim = -radius * std::cos(scene_.params.cloud.angle);
    setRigidity(stretching_ * radius * radius * drawLogarithmic(1e-5, 1e-3));
    addPin(Vec3(-10.0, -10.0, rim - 0.06 * radius), Vec3(10.0, 10.0, 10.0));
    scene_.params.gravity = happens(0.5) ? Vec3(0.0, 0.0, -9.81) : Vec3::Zero().eval();
    scene_.params.pressure = stretching_ / radius * drawLogarithmic(1e-3, 0.05);
    if (!happens(0.8)) scene_.params.pressure *= -1.0;
    say(scene_.params.pressure > 0.0 ? "blown" : "pressed");
    if (happens(0.4)) addForce(Vec3(0.0, 0.0, -radius), stretching_ * radius * drawLogarithmic(3e-4, 0.01));
  }

  void makeTime() {
    solve::IntegratorParams& t = scene_.params.integrator;
    t.max_substeps = 1000000000;
    const double spacing = length_ / std::sqrt(static_cast<double>(scene_.cloud.size()));
    const double substep = 0.4 * spacing * std::sqrt(areal_density_ / stretching_);
    if (happens(0.35)) {
      t.type = solve::IntegratorType::kStatic;
      t.max_iterations = 500;
      t.tolerance = 1e-8;
      t.time_step = 0.05;
      scene_.params.duration = t.time_step;
      say("static");
      return;
    }
    t.type = solve::IntegratorType::kVerlet;
    if (happens(0.12)) {
      t.type = solve::IntegratorType::kImplicit;
      say("implicit");
    }
    // A few swings, as many as are affordable on the full cloud.
    constexpr double kWork = 1.5e7;  // points times sub-steps
    const double swing = std::sqrt(length_ / 9.81) * draw(1.0, 5.0);
    const double duration = std::min(swing, kWork * substep / scene_.cloud.size());
    t.time_step = t.type == solve::IntegratorType::kImplicit ? duration / std::round(draw(24.0, 80.0)) : duration / 48.0;
    scene_.params.duration = duration;
  }

  std::uint32_t seed_;
  std::mt19937 engine_;
  RandomScene scene_;
  double length_ = 1.0, width_ = 1.0;
  double stretching_ = 0.0, areal_density_ = 0.0, rigidity_ = 0.0;  // N/m, kg/m^2, N m
};

/// The scene of a seed.
inline RandomScene makeRandomScene(std::uint32_t seed) { return RandomSceneMaker(seed).make(); }

}  // namespace deformable_surface::test
