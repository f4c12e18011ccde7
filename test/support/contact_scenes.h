// Scenes in which a surface touches itself: folded, dropped, twisted, crushed. A seed draws counts, jitter, sizes, speeds and
// stiffness.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/scene_params.h"

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::test {

struct ContactScene {
  simulation::SceneParams params;
  cloud::PointCloud cloud;
};

class ContactSceneMaker {
 public:
  /// across: points along the side of a sheet; 0 = drawn, 12 to 20.
  explicit ContactSceneMaker(std::uint32_t seed, Index across = 0) : engine_(seed) {
    auto& p = scene_.params;
    p.contact.self = true;
    p.simplification.method = cloud::SimplificationMethod::kNone;
    p.material.young_modulus = drawLogarithmic(1e5, 1e6);
    p.material.thickness = draw(0.5e-3, 2e-3);
    p.material.density = 250.0;
    p.material.poisson_ratio = 0.3;
    p.material.bending_rigidity.is_auto = false;
    p.material.bending_rigidity.value = drawLogarithmic(5e-6, 1e-4);
    p.material.damping = draw(0.5, 2.0);
    p.integrator.time_step = 0.005;
    p.accuracy.estimate = false;
    p.duration = 1.0;
    across_ = 12 + static_cast<Index>(draw(0.0, 9.0));
    if (across > 0) across_ = across;
    jitter_ = draw(0.0, 0.3);
  }

  /// An edge of a towel on a table is carried over to the opposite one.
  ContactScene fold() {
    layTowel();
    carryEdge("edge", Vec3(1.0, 0.5, 0.0), Vec3(0.08, 0.5, 0.0), 0.0, draw(0.4, 0.9));
    return finish();
  }
  /// Folded once, and once more across.
  ContactScene foldTwice() {
    layTowel();
    carryEdge("edge", Vec3(1.0, 0.5, 0.0), Vec3(0.05, 0.5, 0.0), 0.0, 0.5);
    carryEdge("side", Vec3(0.25, 1.0, 0.0), Vec3(0.25, 0.08, 0.0), 0.6, 1.1, 0.25);
    scene_.params.duration = 1.4;
    return finish();
  }
  /// A sheet falls on its lower edge and crumples.
  ContactScene drop() {
    addSheet(side_, side_, draw(0.0, 0.3), Eigen::AngleAxisd(draw(1.2, 1.57), Vec3::UnitY()).toRotationMatrix(),
             Vec3(0.0, 0.0, side_ + 0.01));
    addTable();
    return finish();
  }
  /// A strip between two ends. One of them turns and approaches.
  ContactScene twist() {
    addSheet(side_, 0.4 * side_, 0.0, Mat3::Identity(), Vec3::Zero());
    scene_.params.gravity.setZero();
    const double turns = draw(1.5, 3.0), end = 1.0;
    addPin(0.0, {});
    std::vector<tool::WaypointParams> path;
    for (int k = 0; k <= 20; ++k) {
      const double t = end * k / 20.0, half = M_PI * turns * k / 20.0;
      path.push_back({t, Vec3(side_ * (1.0 - 0.35 * k / 20.0), 0.0, 0.0), Vec4(std::sin(half), 0.0, 0.0, std::cos(half))});
    }
    addPin(side_, path);
    return finish();
  }
  /// Sheets that fall on each other, each with its own orientation.
  ContactScene heap() {
    across_ = 9 + across_ % 4;  // five sheets of so few points
    for (int k = 0; k < 5; ++k)
      addSheet(0.7 * side_, 0.7 * side_, 0.0, Eigen::AngleAxisd(draw(0.0, 1.5), Vec3::UnitZ()).toRotationMatrix(),
               Vec3(draw(0.0, 0.03), draw(0.0, 0.03), 0.01 + 0.08 * k));
    addTable();
    return finish();
  }
  /// A ball comes down on sheets that lie on each other.
  ContactScene ballIntoStack() {
    heap();
    tool::ToolParams ball = makeTool("ball", geometry::Solid::Kind::kSphere);
    ball.shape.radius = draw(0.03, 0.06);
    const double top = 0.4 + ball.shape.radius;
    ball.path = {{0.3, Vec3(0.1, 0.0, top), kUpright},
                 {0.3 + draw(0.1, 0.5), Vec3(0.1, 0.0, ball.shape.radius + 4.0 * scene_.params.material.thickness), kUpright}};
    scene_.params.tools.push_back(ball);
    return std::move(scene_);
  }
  /// A cloth over a box's edge, pulled off by one side.
  ContactScene tableCloth() {
    addSheet(side_, side_, 0.0, Mat3::Identity(), Vec3(-0.5 * side_, 0.0, 0.12));
    addTable();
    tool::ToolParams box = makeTool("box", geometry::Solid::Kind::kBox);
    box.shape.size = Vec3(0.6 * side_, 0.6 * side_, 0.1);
    box.path = {{0.0, Vec3(0.0, 0.0, 0.05), kUpright}};
    box.friction = 0.3;
    scene_.params.tools.push_back(box);
    const double speed = drawLogarithmic(0.5, 8.0);
    tool::ToolParams hand = makeTool("hand", geometry::Solid::Kind::kBox);
    hand.mode = tool::Mode::kMove;
    hand.shape.size = Vec3(0.04, 1.2 * side_, 0.04);
    hand.start = 0.4;
    hand.path = {{0.4, Vec3(0.5 * side_, 0.0, 0.1), kUpright}, {0.4 + side_ / speed, Vec3(1.5 * side_, 0.0, 0.1), kUpright}};
    grip(hand);
    return finish();
  }
  /// Opposite corners are brought together in the air, then fall.
  ContactScene closeCorners() {
    addSheet(side_, side_, 0.0, Mat3::Identity(), Vec3(-0.5 * side_, 0.0, 0.3));
    addTable();
    for (const double sx : {-1.0, 1.0}) {
      for (const double sy : {-1.0, 1.0}) {
        const Vec3 corner(0.5 * side_ * sx, 0.5 * side_ * sy, 0.3);
        tool::ToolParams hand = makeTool("hand" + std::to_string(static_cast<int>(2 * sx + sy)), geometry::Solid::Kind::kSphere);
        hand.mode = tool::Mode::kMove;
        hand.shape.radius = 0.03;
        hand.end = 0.6;
        hand.path = {{0.0, corner, kUpright}, {0.5, Vec3(0.08 * corner.x(), 0.08 * corner.y(), 0.32), kUpright}};
        grip(hand);
      }
    }
    return finish();
  }
  /// Boxes come together from all sides.
  ContactScene crush() {
    addSheet(side_, side_, draw(0.0, 0.2), Mat3::Identity(), Vec3(-0.5 * side_, 0.0, 0.03));
    addTable();
    for (const double angle : {0.0, 0.5 * M_PI, M_PI, 1.5 * M_PI}) {
      tool::ToolParams wall = makeTool("wall" + std::to_string(static_cast<int>(angle * 10)), geometry::Solid::Kind::kBox);
      wall.shape.size = Vec3(0.05, 3.0 * side_, 0.6);
      const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
      const Vec4 turned(0.0, 0.0, std::sin(0.5 * angle), std::cos(0.5 * angle));
      wall.path = {{0.1, (0.5 * side_ + 0.05) * out, turned}, {0.8, 0.45 * side_ * out, turned}};
      scene_.params.tools.push_back(wall);
    }
    return finish();
  }
  /// A tube that is pressed flat.
  ContactScene flattenTube() {
    const double radius = 0.04;
    addTube(radius, 0.24, Mat3::Identity(), Vec3(0.0, 0.0, 0.05));
    scene_.params.gravity.setZero();
    for (const double side : {-1.0, 1.0}) {
      tool::ToolParams plate = makeTool(side > 0 ? "upper" : "lower", geometry::Solid::Kind::kBox);
      plate.shape.size = Vec3(1.0, 1.0, 0.02);
      const Vec3 middle(0.1, 0.0, 0.05);
      plate.path = {
          {0.0, middle + side * (radius + 0.012) * Vec3::UnitZ(), kUpright},
          {0.7, middle + side * (0.01 + 0.5 * M_PI * radius / across_ + 2.5 * scene_.params.material.thickness) * Vec3::UnitZ(),
           kUpright}};
      scene_.params.tools.push_back(plate);
    }
    return finish();
  }
  /// A cloth falls on a rotating ball that carries it along.
  ContactScene turningBall() {
    addSheet(side_, side_, 0.0, Mat3::Identity(), Vec3(-0.5 * side_, 0.0, 0.16));
    addTable();
    tool::ToolParams ball = makeTool("ball", geometry::Solid::Kind::kSphere);
    ball.shape.radius = 0.07;
    ball.friction = draw(0.3, 1.0);
    const double speed = draw(2.0, 6.0);
    for (int k = 0; k <= 40; ++k) {
      const double t = 1.5 * k / 40.0, half = 0.5 * speed * std::max(0.0, t - 0.3);
      ball.path.push_back({t, Vec3(0.0, 0.0, 0.08), Vec4(0.0, 0.0, std::sin(half), std::cos(half))});
    }
    scene_.params.tools.push_back(ball);
    return finish();
  }
  /// Thin rods go down into a folded towel.
  ContactScene needles() {
    foldTwice();
    for (int k = 0; k < 3; ++k) {
      tool::ToolParams rod = makeTool("needle" + std::to_string(k), geometry::Solid::Kind::kCylinder);
      rod.shape.radius = 0.75 * side_ / (across_ - 1);  // tools touch points: a thinner one would pass between them
      rod.shape.height = 0.2;
      const Vec3 at(draw(0.03, 0.1), draw(-0.13, -0.08), 0.0);
      // Down to half the height of the four layers.
      const double end = 0.5 * rod.shape.height + 2.0 * scene_.params.material.thickness;
      rod.path = {{1.0, at + 0.25 * Vec3::UnitZ(), kUpright}, {1.3, at + end * Vec3::UnitZ(), kUpright}};
      scene_.params.tools.push_back(rod);
    }
    return std::move(scene_);
  }
  /// A sheet falls on its lower edge while two knives cut it into four, one across and one downwards.
  ContactScene cutAndDrop() {
    drop();
    for (const bool is_across : {false, true}) {
      tool::ToolParams knife = makeTool(is_across ? "across" : "down", geometry::Solid::Kind::kBox);
      knife.mode = tool::Mode::kCut;
      knife.shape.size = is_across ? Vec3(1.0, 0.05, 0.002) : Vec3(1.0, 0.002, 0.05);
      const double height = 0.01 + side_ * draw(0.4, 0.6), off = side_ * draw(-0.2, 0.2), time = draw(0.0, 0.4);
      const Vec3 from = is_across ? Vec3(0.0, -side_, height) : Vec3(0.0, off, 2.0 * side_);
      const Vec3 to = is_across ? Vec3(0.0, side_, 0.6 * height) : Vec3(0.0, off, -0.1);
      knife.path = {{time, from, kUpright}, {time + draw(0.1, 0.3), to, kUpright}};
      scene_.params.tools.push_back(knife);
    }
    return std::move(scene_);
  }
  /// A twisted strip that tears where it is stretched.
  ContactScene tearTwisted() {
    twist();
    scene_.params.mass_spring.tear_strain = draw(0.1, 0.3);
    scene_.params.gravity = Vec3(0.0, 0.0, -9.81);
    return std::move(scene_);
  }
  /// A tube, as of a shirt, falls flat on a table.
  ContactScene garment() {
    addTube(0.06, 0.25, Eigen::AngleAxisd(draw(-0.3, 0.3), Vec3::UnitY()).toRotationMatrix(), Vec3(0.0, 0.0, 0.18));
    addTable();
    return finish();
  }
  /// One end of a sleeve is pulled through it and out of the other end, which is held: it turns inside out.
  ContactScene sleeve() {
    const double radius = 0.045, length = 0.22;
    addTube(radius, length, Mat3::Identity(), Vec3::Zero());
    scene_.params.gravity.setZero();
    addPin(length, {});
    tool::ToolParams hand = makeTool("hand", geometry::Solid::Kind::kSphere);
    hand.mode = tool::Mode::kMove;
    hand.shape.radius = draw(0.02, 0.03);
    hand.path = {{0.0, Vec3(0.0, 0.0, radius), kUpright},
                 {0.2, Vec3(0.0, 0.0, 0.0), kUpright},
                 {0.2 + draw(0.5, 0.9), Vec3(0.9 * length, 0.0, 0.0), kUpright}};
    grip(hand);
    scene_.params.duration = 1.2;
    return finish();
  }
  /// An end of a strip is led around the strip and through the loop, then pulled.
  ContactScene knot() {
    const double length = 0.6;
    addSheet(length, 0.03, 0.0, Mat3::Identity(), Vec3::Zero(), 3 * across_, 4);
    scene_.params.gravity.setZero();
    addPin(0.0, {});
    const double speed = draw(0.8, 1.2);
    const Vec3 corners[] = {{length, 0.0, 0.0},   {0.42, 0.22, 0.0},  {0.2, 0.2, 0.05}, {0.14, 0.05, 0.06}, {0.14, -0.07, 0.03},
                            {0.16, -0.07, -0.05}, {0.2, 0.05, -0.06}, {0.22, 0.1, 0.0}, {0.25, 0.1, 0.08},  {0.45, 0.05, 0.08}};
    std::vector<tool::WaypointParams> path;
    double time = 0.0;
    for (const Vec3& corner : corners) {
      if (!path.empty()) time += (corner - path.back().position).norm() / speed;
      path.push_back({time, corner, kUpright});
    }
    addPin(length, path);
    scene_.params.duration = 0.005 * std::ceil((time + 0.2) / 0.005);
    return finish();
  }
  /// Two stacks of stiff cards fall into each other, and a box pushes them together.
  ContactScene cards() {
    across_ = 7;
    scene_.params.material.bending_rigidity.value = drawLogarithmic(1e-4, 1e-3);
    for (int k = 0; k < 6; ++k) {
      const double side = k % 2 == 0 ? -1.0 : 1.0;
      const Mat3 turn = Eigen::AngleAxisd(side * draw(0.05, 0.2), Vec3::UnitY()).toRotationMatrix();
      addSheet(0.08, 0.08, 0.0, turn, Vec3(side * 0.03 - 0.04, draw(-0.005, 0.005), 0.04 + 0.05 * k));
    }
    addTable();
    tool::ToolParams box = makeTool("box", geometry::Solid::Kind::kBox);
    box.shape.size = Vec3(0.02, 0.2, 0.06);
    box.path = {{0.4, Vec3(-0.2, 0.0, 0.03), kUpright}, {0.4 + draw(0.2, 0.5), Vec3(-0.055, 0.0, 0.03), kUpright}};
    scene_.params.tools.push_back(box);
    return finish();
  }
  /// A tube around a sphere that turns, as a shirt on a body.
  ContactScene turningBody() {
    const double radius = 0.06, speed = draw(2.0, 6.0);
    addTube(1.1 * radius, 0.2, Eigen::AngleAxisd(-0.5 * M_PI, Vec3::UnitY()).toRotationMatrix(), Vec3(0.0, 0.0, 0.05));
    addTable();
    tool::ToolParams ball = makeTool("ball", geometry::Solid::Kind::kSphere);
    ball.shape.radius = radius;
    ball.friction = draw(0.3, 1.0);
    for (int k = 0; k <= 40; ++k) {
      const double t = 1.2 * k / 40.0, half = 0.5 * speed * std::max(0.0, t - 0.2);
      ball.path.push_back({t, Vec3(0.0, 0.0, 0.12), Vec4(0.0, std::sin(half), 0.0, std::cos(half))});
    }
    scene_.params.tools.push_back(ball);
    return finish();
  }
  /// A hand pulls the middle of a sheet down through a funnel of four boxes.
  ContactScene funnel() {
    addSheet(side_, side_, 0.0, Mat3::Identity(), Vec3(-0.5 * side_, 0.0, 0.42));
    for (int k = 0; k < 4; ++k) {
      const double angle = 0.5 * M_PI * k, tilt = 0.9;
      tool::ToolParams wall = makeTool("wall" + std::to_string(k), geometry::Solid::Kind::kBox);
      wall.shape.size = Vec3(0.02, 0.6, 0.3);
      wall.friction = 0.2;
      const Eigen::Quaterniond turn =
          Eigen::AngleAxisd(angle, Vec3::UnitZ()) * Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
      const Vec3 place = Eigen::AngleAxisd(angle, Vec3::UnitZ()) *
                         Vec3(0.035 + 0.01 / std::cos(tilt) + 0.15 * std::sin(tilt), 0.0, 0.3 + 0.15 * std::cos(tilt));
      wall.path = {{0.0, place, Vec4(turn.x(), turn.y(), turn.z(), turn.w())}};
      scene_.params.tools.push_back(wall);
    }
    tool::ToolParams hand = makeTool("hand", geometry::Solid::Kind::kSphere);
    hand.mode = tool::Mode::kMove;
    hand.shape.radius = 0.025;
    hand.path = {{0.1, Vec3(0.0, 0.0, 0.42), kUpright}, {0.1 + draw(0.3, 0.8), Vec3(0.0, 0.0, 0.18), kUpright}};
    grip(hand);
    return finish();
  }
  /// Pins pull two layers, one to three spacings apart, to and fro between two cylinders.
  ContactScene pulledLayers() {
    scene_.params.gravity.setZero();
    scene_.params.material.thickness = draw(0.05, 0.4) * side_ / (across_ - 1.0);
    const double gap = draw(1.2, 3.0) * side_ / (across_ - 1.0);
    jitter_ = draw(0.2, 0.4);
    for (const double side : {-1.0, 1.0}) {
      addSheet(side_, 0.5 * side_, 0.0, Mat3::Identity(), Vec3(0.0, 0.0, 0.5 * side * gap));
      tool::ToolParams roll = makeTool(side > 0.0 ? "upper" : "lower", geometry::Solid::Kind::kCylinder);
      roll.shape.radius = draw(0.015, 0.03);
      roll.shape.height = side_;
      roll.friction = 0.2;
      const Vec4 lies(std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5));
      const Vec3 middle(draw(0.4, 0.6) * side_, 0.0, 0.0), out = side * Vec3::UnitZ();
      roll.path = {{0.0, middle + (roll.shape.radius + gap) * out, lies},
                   {0.1, middle + (roll.shape.radius + draw(0.0, 0.6) * scene_.params.material.thickness) * out, lies}};
      scene_.params.tools.push_back(roll);
      for (const double end : {0.0, side_}) {
        const Vec3 way(draw(-0.05, 0.15) * (end > 0.0 ? 1.0 : -1.0), 0.0, draw(-0.05, 0.05)), at(end, 0.0, 0.0);
        addPin(end, {{0.1, at, kUpright}, {0.1 + way.norm() / drawLogarithmic(0.1, 1.0), at + way, kUpright}});
        (side > 0.0 ? scene_.params.pins.back().region.min : scene_.params.pins.back().region.max).z() = 0.0;
      }
    }
    scene_.params.duration = 0.4;
    return finish();
  }

 private:
  static inline const Vec4 kUpright{0.0, 0.0, 0.0, 1.0};

  // The standard fixes the engine but not its distributions.
  double draw(double low, double high) { return low + (high - low) * (engine_() / 4294967296.0); }
  double drawLogarithmic(double low, double high) { return low * std::pow(high / low, draw(0.0, 1.0)); }

  ContactScene finish() {
    scene_.cloud.positions = points_;
    scene_.cloud.width = static_cast<std::uint32_t>(points_.size());
    return scene_;
  }

  // From x = 0 and about y = 0, arched by a share of its length, then rotated and moved.
  void addSheet(double length, double width, double arch, const Mat3& turn, const Vec3& to) {
    addSheet(length, width, arch, turn, to, across_, std::max<Index>(6, std::lround(across_ * width / length)));
  }
  void addSheet(double length, double width, double arch, const Mat3& turn, const Vec3& to, Index along, Index beside) {
    for (Index i = 0; i < along; ++i)
      for (Index j = 0; j < beside; ++j) {
        const bool is_edge = i == 0 || i == along - 1 || j == 0 || j == beside - 1;
        const double u = (i + (is_edge ? 0.0 : jitter_ * draw(-1.0, 1.0))) / (along - 1.0);
        const double v = (j + (is_edge ? 0.0 : jitter_ * draw(-1.0, 1.0))) / (beside - 1.0) - 0.5;
        points_.push_back(turn * Vec3(length * u, width * v, arch * length * 0.25 * std::sin(M_PI * u)) + to);
      }
  }

  // Along x from 0, then rotated and moved. Two points around for one along a sheet's side.
  void addTube(double radius, double length, const Mat3& turn, const Vec3& to) {
    const Index around = 2 * across_, along = across_;
    for (Index i = 0; i < along; ++i)
      for (Index j = 0; j < around; ++j) {
        const double angle = 2.0 * M_PI * (j + 0.5 * (i % 2) + jitter_ * draw(-0.5, 0.5)) / around;
        points_.push_back(turn * Vec3(length * i / (along - 1.0), radius * std::cos(angle), radius * std::sin(angle)) + to);
      }
  }

  void layTowel() {
    addSheet(side_, side_, 0.0, Mat3::Identity(), Vec3(0.0, 0.0, 1e-4));
    addTable();
  }

  tool::ToolParams makeTool(const std::string& id, geometry::Solid::Kind kind) {
    tool::ToolParams t;
    t.id = id;
    t.shape.kind = kind;
    return t;
  }

  void addTable() {
    tool::ToolParams table = makeTool("table", geometry::Solid::Kind::kPlane);
    table.friction = draw(0.2, 0.6);
    table.path = {{0.0, Vec3::Zero(), kUpright}};
    scene_.params.tools.push_back(table);
  }

  void grip(tool::ToolParams hand) { scene_.params.tools.push_back(std::move(hand)); }

  // Places in units of the side, y from the lower to the upper edge.
  void carryEdge(const std::string& id, const Vec3& from, const Vec3& to, double start, double end, double half_span = 0.6) {
    tool::ToolParams hand = makeTool(id, geometry::Solid::Kind::kBox);
    hand.mode = tool::Mode::kMove;
    const bool is_end = from.x() > 0.9;
    hand.shape.size = is_end ? Vec3(0.02, 2.0 * half_span * side_, 0.04) : Vec3(2.0 * half_span * side_, 0.02, 0.06);
    hand.start = start;
    hand.end = end + 0.1;
    const auto place = [&](const Vec3& p) { return Vec3(side_ * p.x(), side_ * (p.y() - 0.5), 0.0); };
    for (int k = 0; k <= 10; ++k) {
      const double s = k / 10.0;
      hand.path.push_back({start + (end - start) * s,
                           place(from + s * (to - from)) + Vec3(0.0, 0.0, 0.015 * s + 0.35 * side_ * std::sin(M_PI * s)),
                           kUpright});
    }
    grip(hand);
  }

  void addPin(double x, std::vector<tool::WaypointParams> path) {
    simulation::PinParams pin;
    pin.region.min = Vec3(x - 1e-6, -1.0, -1.0);
    pin.region.max = Vec3(x + 1e-6, 1.0, 1.0);
    pin.path = std::move(path);
    scene_.params.pins.push_back(pin);
  }

  ContactScene scene_;
  Points points_;
  std::mt19937 engine_;
  Index across_ = 0;
  double jitter_ = 0.0, side_ = 0.3;  // m
};

/// By name, in the order of the class.
inline std::vector<std::pair<std::string, std::function<ContactScene(ContactSceneMaker&)>>> listContactScenes() {
  return {{"fold", &ContactSceneMaker::fold},
          {"fold_twice", &ContactSceneMaker::foldTwice},
          {"drop", &ContactSceneMaker::drop},
          {"twist", &ContactSceneMaker::twist},
          {"heap", &ContactSceneMaker::heap},
          {"ball_into_stack", &ContactSceneMaker::ballIntoStack},
          {"table_cloth", &ContactSceneMaker::tableCloth},
          {"close_corners", &ContactSceneMaker::closeCorners},
          {"crush", &ContactSceneMaker::crush},
          {"flatten_tube", &ContactSceneMaker::flattenTube},
          {"turning_ball", &ContactSceneMaker::turningBall},
          {"needles", &ContactSceneMaker::needles},
          {"cut_and_drop", &ContactSceneMaker::cutAndDrop},
          {"tear_twisted", &ContactSceneMaker::tearTwisted},
          {"garment", &ContactSceneMaker::garment},
          {"sleeve", &ContactSceneMaker::sleeve},
          {"knot", &ContactSceneMaker::knot},
          {"cards", &ContactSceneMaker::cards},
          {"turning_body", &ContactSceneMaker::turningBody},
          {"funnel", &ContactSceneMaker::funnel},
          {"pulled_layers", &ContactSceneMaker::pulledLayers}};
}

}  // namespace deformable_surface::test
