// Scenes drawn at random from a seed, of other families than those of random_scene.h, on which the constants of the error
// estimate were fitted: other shapes and samplings, and clamps, grips, tools, drag, anchors, regions and moving pins in any
// combination. The same seed gives the same scene everywhere.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "random_scene.h"

namespace deformable_surface::test {

class VariedSceneMaker {
 public:
  explicit VariedSceneMaker(std::uint32_t seed) : engine_(seed) {}

  /// Scenes of about this many points, unless 0: 400 to 1400 then.
  RandomScene make(std::uint32_t family, Index points = 0) {
    length_ = drawLogarithmic(0.2, 2.0);
    makeCloud(family % kFamilies, points > 0 ? points : static_cast<Index>(drawLogarithmic(400.0, 1400.0)));
    makeMaterial();
    hold();
    load();
    makeTime();
    const Index n = scene_.cloud.size();
    const double share = drawLogarithmic(1.0 / 16.0, 0.6);
    scene_.params.simplification.target_points = std::min(n, std::max(Index{64}, static_cast<Index>(share * n)));
    return scene_;
  }

  static constexpr std::uint32_t kFamilies = 12;

 private:
  static constexpr double kPi = 3.14159265358979324;

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

  // Places of a grid of about so many cells in the unit square, with jitter; rows and columns are as far apart where the square
  // becomes a rectangle of this aspect ratio. place: of u and v, or a point that is not finite where there is no surface.
  void sample(Index points, double aspect, double covered, bool is_closed_u, bool is_closed_v,
              const std::function<Vec3(double u, double v)>& place) {
    const double cells = points / covered;
    const Index columns = std::max(Index{4}, static_cast<Index>(std::lround(std::sqrt(cells * aspect))));
    const Index rows = std::max(Index{4}, static_cast<Index>(std::lround(cells / columns)));
    const double jitter = happens(0.2) ? 0.0 : draw(0.05, 0.45);
    // Uneven: denser towards one side, by up to a factor of three; or points left out at random.
    const double bend = happens(0.3) ? draw(0.2, 0.5) : 0.0;
    const double kept = happens(0.25) ? draw(0.6, 0.9) : 1.0;
    if (bend > 0.0) say("graded");
    if (kept < 1.0) say("thinned");
    for (Index j = 0; j < rows; ++j)
      for (Index i = 0; i < columns; ++i) {
        double u = (i + (is_closed_u ? 0.0 : 0.5) + jitter * draw(-1.0, 1.0)) / columns;
        double v = (j + (is_closed_v ? 0.0 : 0.5) + jitter * draw(-1.0, 1.0)) / rows;
        if (!is_closed_u) u = std::min(1.0, std::max(0.0, u));
        if (!is_closed_v) v = std::min(1.0, std::max(0.0, v));
        if (!is_closed_v) v += bend * v * (v - 1.0);
        const bool stays = happens(kept);
        const Vec3 p = place(u, v);
        if (stays && p.allFinite()) scene_.cloud.positions.push_back(p);
      }
    scene_.cloud.width = static_cast<std::uint32_t>(scene_.cloud.positions.size());
  }

  void makeCloud(std::uint32_t family, Index points) {
    const double l = length_;
    const Vec3 none = Vec3::Constant(std::nan(""));
    const auto flat = [&](double u, double v) { return Vec3(l * (u - 0.5), l * (v - 0.5), 0.0); };
    switch (family) {
      case 0: {
        scene_.name = "torus";
        const double ring = 0.5 * l, tube = ring * draw(0.25, 0.45);
        is_curved_ = true;
        sample(points, ring / tube, 1.0, true, true, [=](double u, double v) {
          const double a = 2.0 * kPi * u, b = 2.0 * kPi * v, r = ring + tube * std::cos(b);
          return Vec3(r * std::cos(a), r * std::sin(a), tube * std::sin(b));
        });
        break;
      }
      case 1: {
        scene_.name = "cylinder";
        const double radius = l * draw(0.15, 0.4);
        is_curved_ = true;
        sample(points, 2.0 * kPi * radius / l, 1.0, true, false, [=](double u, double v) {
          return Vec3(radius * std::cos(2.0 * kPi * u), radius * std::sin(2.0 * kPi * u), l * (v - 0.5));
        });
        break;
      }
      case 2: {
        scene_.name = "saddle";
        const double rise = draw(0.2, 0.8);
        is_curved_ = true;
        sample(points, 1.0, 1.0, false, false, [=](double u, double v) {
          const Vec3 p = flat(u, v);
          return Vec3(p.x(), p.y(), rise * (p.x() * p.x() - p.y() * p.y()) / l);
        });
        break;
      }
      case 3: {
        scene_.name = "l_shape";
        const double leg = draw(0.3, 0.6);
        sample(points, 1.0, 1.0 - (1.0 - leg) * (1.0 - leg), false, false,
               [=](double u, double v) { return u > leg && v > leg ? none : flat(u, v); });
        break;
      }
      case 4: {
        scene_.name = "ring";
        const double hole = draw(0.1, 0.3);
        sample(points, 1.0, 0.785 - kPi * hole * hole, false, false, [=](double u, double v) {
          const double r = std::hypot(u - 0.5, v - 0.5);
          return r > 0.5 || r < hole ? none : flat(u, v);
        });
        break;
      }
      case 5: {
        scene_.name = "gutter";
        const double radius = l * draw(0.15, 0.4), opening = draw(0.3, 0.9) * kPi;
        is_curved_ = true;
        sample(points, 2.0 * opening * radius / l, 1.0, false, false, [=](double u, double v) {
          const double a = opening * (2.0 * u - 1.0);
          return Vec3(radius * std::sin(a), l * (v - 0.5), -radius * std::cos(a));
        });
        break;
      }
      case 6: {
        // As a camera above sees an ellipsoid: rays on a grid, so that points are rare where the surface turns away.
        scene_.name = "scan";
        const double high = l * draw(0.25, 0.5), seen = draw(0.75, 0.95);
        is_curved_ = true;
        sample(points, 1.0, 0.785, false, false, [=](double u, double v) {
          const double x = 2.0 * u - 1.0, y = 2.0 * v - 1.0, r = x * x + y * y;
          return r > 1.0 ? none : Vec3(0.5 * l * seen * x, 0.5 * l * seen * y, high * std::sqrt(1.0 - seen * seen * r));
        });
        break;
      }
      case 7: {
        scene_.name = "frustum";
        const double wide = l * draw(0.3, 0.5), narrow = wide * draw(0.3, 0.7);
        is_curved_ = true;
        sample(points, kPi * (wide + narrow) / l, 1.0, true, false, [=](double u, double v) {
          const double r = wide + (narrow - wide) * v, a = 2.0 * kPi * u;
          return Vec3(r * std::cos(a), r * std::sin(a), l * (v - 0.5));
        });
        break;
      }
      case 8: {
        scene_.name = "bumps";
        const double high = draw(0.05, 0.15), one = draw(0.2, 0.5), two = draw(0.5, 0.8);
        is_curved_ = true;
        sample(points, 1.0, 1.0, false, false, [=](double u, double v) {
          Vec3 p = flat(u, v);
          for (const double at : {one, two})
            p.z() += high * l * std::exp(-30.0 * ((u - at) * (u - at) + (v - 1.0 + at) * (v - 1.0 + at)));
          return p;
        });
        break;
      }
      case 9: {
        scene_.name = "curl";
        const double turn = draw(0.5, 2.0) * kPi, width = draw(0.15, 0.4);
        sample(points, 1.0 / width, 1.0, false, false, [=](double u, double v) {
          return Vec3(l * std::sin(turn * u) / turn, width * l * (v - 0.5), l * (1.0 - std::cos(turn * u)) / turn);
        });
        break;
      }
      case 10: {
        scene_.name = "triangle";
        sample(points, 1.0, 0.5, false, false, [=](double u, double v) { return u + v > 1.0 ? none : flat(u, v); });
        break;
      }
      default: {
        scene_.name = "arch";
        const double rise = draw(0.1, 0.3), width = draw(0.3, 0.7);
        is_curved_ = true;
        sample(points, 1.0 / width, 1.0, false, false,
               [=](double u, double v) { return Vec3(l * (u - 0.5), width * l * (v - 0.5), 4.0 * rise * l * u * (1.0 - u)); });
        break;
      }
    }
    // Turned in space, so that nothing is along an axis.
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(draw(0.0, kPi), drawDirection()));
    if (happens(0.5))
      for (Vec3& p : scene_.cloud.positions) p = turn * p;
    low_ = high_ = scene_.cloud.positions.front();
    for (const Vec3& p : scene_.cloud.positions) {
      low_ = low_.cwiseMin(p);
      high_ = high_.cwiseMax(p);
    }
  }

  void makeMaterial() {
    model::MaterialParams& m = scene_.params.material;
    m.thickness = 0.001;
    stretching_ = drawLogarithmic(20.0, 5e4);
    m.young_modulus = stretching_ / m.thickness;
    areal_density_ = drawLogarithmic(0.1, 3.0);
    m.density = areal_density_ / m.thickness;
    m.poisson_ratio = draw(0.0, 0.45);
    m.damping = happens(0.25) ? 0.0 : draw(0.0, 5.0);
    const double weight = areal_density_ * 9.81 * std::pow(length_, 3);
    double rigidity =
        is_curved_ ? stretching_ * length_ * length_ * drawLogarithmic(3e-6, 6e-4) : weight / drawLogarithmic(0.3, 1000.0);
    // A plate thicker than a tenth of its length is none.
    rigidity_ = std::min(rigidity, stretching_ * length_ * length_ / 1200.0);
    m.bending_rigidity.is_auto = false;
    m.bending_rigidity.value = rigidity_;
    if (happens(0.25)) {
      simulation::RegionParams region;
      region.region.kind = geometry::Region::Kind::kSphere;
      region.region.center = drawPoint();
      region.region.radius = length_ * draw(0.15, 0.35);
      region.material.young_modulus = simulation::SceneParams().material.young_modulus;
      region.material.young_modulus.is_auto = false;
      region.material.young_modulus.value = m.young_modulus * drawLogarithmic(0.2, 5.0);
      region.material.bending_rigidity.is_auto = false;
      region.material.bending_rigidity.value = rigidity_ * drawLogarithmic(0.2, 5.0);
      scene_.params.regions.push_back(region);
      say("region");
    }
  }

  Vec3 drawPoint() {
    const Points& all = scene_.cloud.positions;
    return all[std::min(all.size() - 1, static_cast<std::size_t>(draw(0.0, 1.0) * all.size()))];
  }
  // The point that is farthest from what holds.
  Vec3 findFarthest() const {
    const Points& all = scene_.cloud.positions;
    return *std::max_element(all.begin(), all.end(),
                             [&](const Vec3& a, const Vec3& b) { return (a - held_).norm() < (b - held_).norm(); });
  }

  // Pins of a side, of a ball, of two sides, or a grip; some move.
  void hold() {
    const int kind = static_cast<int>(draw(0.0, 5.0));
    const int axis = (high_ - low_).x() > (high_ - low_).y() ? 0 : 1;
    const double width = (high_[axis] - low_[axis]) * draw(0.1, 0.25);
    simulation::PinParams pin;
    pin.region.min = Vec3::Constant(-100.0);
    pin.region.max = Vec3::Constant(100.0);
    pin.region.max[axis] = low_[axis] + width;
    held_ = 0.5 * (low_ + high_);
    held_[axis] = low_[axis];
    if (kind <= 1) {
      scene_.params.pins.push_back(pin);
      say("side");
    } else if (kind == 2) {
      scene_.params.pins.push_back(pin);
      pin.region.max[axis] = 100.0;
      pin.region.min[axis] = high_[axis] - width;
      if (happens(0.4)) {
        pin.path.resize(2);
        pin.path[1].time = 0.3;
        pin.path[1].position = 0.05 * length_ * drawDirection();
        say("moving");
      }
      scene_.params.pins.push_back(pin);
      say("two_sides");
    } else if (kind == 3) {
      held_ = drawPoint();
      pin.region.kind = geometry::Region::Kind::kSphere;
      pin.region.center = held_;
      pin.region.radius = length_ * draw(0.15, 0.3);
      scene_.params.pins.push_back(pin);
      say("ball");
    } else {
      held_ = drawPoint();
      tool::ToolParams grip;
      grip.id = "grip";
      grip.mode = tool::Mode::kMove;
      grip.shape.kind = geometry::Solid::Kind::kSphere;
      grip.shape.radius = length_ * draw(0.15, 0.3);
      grip.path.resize(2);
      grip.path[0].position = held_;
      grip.path[1] = grip.path[0];
      grip.path[1].time = 0.5;
      if (happens(0.5)) grip.path[1].position += 0.1 * length_ * drawDirection();
      scene_.params.tools.push_back(grip);
      say("grip");
    }
  }

  void load() {
    simulation::SceneParams& p = scene_.params;
    p.gravity = happens(0.7) ? (9.81 * drawDirection()).eval() : Vec3::Zero().eval();
    const double push =
        is_curved_ ? stretching_ * length_ * drawLogarithmic(3e-5, 2e-3) : rigidity_ / length_ * drawLogarithmic(0.3, 8.0);
    bool is_loaded = p.gravity.norm() > 0.0;
    if (happens(0.4) || !is_loaded) {
      simulation::ForceParams force;
      force.id = "pull";
      force.point = findFarthest();
      force.force = push * drawDirection();
      force.radius = happens(0.2) ? 0.0 : length_ * draw(0.1, 0.3);
      p.forces.push_back(force);
      say(force.radius > 0.0 ? "force" : "point_force");
    }
    if (happens(0.2)) {
      p.pressure = (happens(0.5) ? 1.0 : -1.0) * push / (length_ * length_);
      say("pressure");
    }
    if (happens(0.2)) {
      p.viscous_drag = areal_density_ * drawLogarithmic(0.3, 10.0);
      say("drag");
    }
    if (happens(0.15)) {
      simulation::AnchorParams anchor;
      anchor.point = findFarthest();
      anchor.target = anchor.point + 0.1 * length_ * drawDirection();
      anchor.stiffness = push / (0.1 * length_);
      p.anchors.push_back(anchor);
      say("anchor");
    }
    if (happens(0.2)) {
      // A ball that comes from outside and presses in.
      const Vec3 at = findFarthest(), from = (at - 0.5 * (low_ + high_)).normalized();
      tool::ToolParams ball;
      ball.id = "ball";
      ball.shape.kind = geometry::Solid::Kind::kSphere;
      ball.shape.radius = length_ * draw(0.08, 0.2);
      ball.path.resize(2);
      ball.path[0].position = at + (ball.shape.radius + 0.02 * length_) * from;
      ball.path[1] = ball.path[0];
      ball.path[1].time = 0.3;
      ball.path[1].position -= length_ * draw(0.05, 0.12) * from;
      p.tools.push_back(ball);
      say("pushed");
    }
  }

  void makeTime() {
    solve::IntegratorParams& t = scene_.params.integrator;
    t.max_substeps = 1000000000;
    const double spacing = length_ / std::sqrt(static_cast<double>(scene_.cloud.size()));
    const double substep = 0.4 * spacing * std::sqrt(areal_density_ / stretching_);
    const bool may_rest = scene_.params.tools.empty();
    if (may_rest && happens(0.35)) {
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
    constexpr double kWork = 1.5e7;  // points times sub-steps of the full cloud, that it can be paid for
    const double swing = std::sqrt(length_ / 9.81) * draw(0.7, 4.0);
    const double duration = std::min(swing, kWork * substep / scene_.cloud.size());
    t.time_step = t.type == solve::IntegratorType::kImplicit ? duration / std::round(draw(24.0, 80.0)) : duration / 48.0;
    scene_.params.duration = duration;
  }

  std::mt19937 engine_;
  RandomScene scene_;
  bool is_curved_ = false;
  double length_ = 1.0;  // m
  Vec3 low_, high_, held_ = Vec3::Zero();
  double stretching_ = 0.0, areal_density_ = 0.0, rigidity_ = 0.0;  // N/m, kg/m^2, N m
};

/// The scene of a seed; families take turns. points: as of VariedSceneMaker::make().
inline RandomScene makeVariedScene(std::uint32_t seed, Index points = 0) { return VariedSceneMaker(seed).make(seed, points); }

}  // namespace deformable_surface::test
