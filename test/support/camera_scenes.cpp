#include "camera_scenes.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::test {
namespace {

constexpr double kFineCell = 0.001;  // m: of bends of a few millimetres

// The plane of a table: x to the right in the picture, y down, and a height towards the camera.
using OnTable = std::function<Vec3(const Vec2&)>;

class Builder {
 public:
  Builder(std::string name, double distance, double tilt_degrees, const Vec2& field) {
    tilt_ = Eigen::AngleAxisd(tilt_degrees * M_PI / 180.0, Vec3::UnitX()).toRotationMatrix();
    scene_.name = std::move(name);
    scene_.distance = distance;
    scene_.field = field;
  }
  void add(std::vector<Vec2> outline, const OnTable& on_table, double cell = 0.0) {
    const auto place = [tilt = tilt_, distance = scene_.distance, on_table](const Vec2& at) {
      const Vec3 p = on_table(at);
      return Vec3(tilt * Vec3(p.x(), p.y(), -p.z()) + Vec3(0.0, 0.0, distance));
    };
    scene_.sheets.push_back({std::move(outline), place, cell});
  }
  // Places are on the unfolded plane of the sheet added last.
  void hold(double u, double v) { scene_.held.push_back(scene_.sheets.back().place(Vec2(u, v))); }
  void pull(double u, double v) {
    scene_.pulled = scene_.sheets.back().place(Vec2(u, v));
    scene_.direction = tilt_ * Vec3(0.0, 0.0, -1.0);
  }
  CameraScene finish() { return std::move(scene_); }

 private:
  Mat3 tilt_;
  CameraScene scene_;
};

std::vector<Vec2> makeRectangle(double x0, double x1, double y0, double y1) { return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}; }

OnTable liftBy(double height) {
  return [height](const Vec2& at) { return Vec3(at.x(), at.y(), height); };
}

// Gentle wrinkles about zero, a decimetre wide.
double wave(double x, double y) { return 0.6 * std::sin(52.0 * x + 16.0 * y) + 0.4 * std::sin(60.0 * y - 15.0 * x + 1.0); }

// The part of the plane beyond the line normal . at = offset is turned over it, along a half circle as wide as the gap.
OnTable fold(const Vec2& normal, double offset, double gap, double waves) {
  return [=](const Vec2& at) {
    const double radius = 0.5 * gap, beyond = normal.dot(at) - offset, arc = M_PI * radius;
    Vec3 p(at.x(), at.y(), 0.0);
    if (beyond > 0.0) {
      const double angle = std::min(beyond, arc) / radius;
      p.head<2>() += normal * (radius * std::sin(angle) - beyond - std::max(0.0, beyond - arc));
      p.z() = radius * (1.0 - std::cos(angle));
    }
    p.z() += waves * wave(p.x(), p.y());
    return p;
  };
}

void addTable(const Vec2& field, Builder& builder) {
  const double x = field.x(), y = field.y();
  builder.add(makeRectangle(-x, x, -y, y), liftBy(0.0));
  for (const double u : {-0.45, 0.45})
    for (const double v : {-0.42, 0.42}) builder.hold(u * x, v * y);
}

std::string nameHeight(const std::string& name, double height) {
  return name + " " + std::to_string(static_cast<int>(std::lround(1e3 * height))) + " mm";
}

constexpr double kTowelWaves = 0.002;  // m

}  // namespace

CameraScene makeTowel(double distance, double tilt_degrees) {
  const std::string how = tilt_degrees == 0.0 ? "flat" : std::to_string(static_cast<int>(tilt_degrees)) + " deg";
  Builder builder("towel " + how, distance, tilt_degrees, Vec2(0.36, 0.26));
  builder.add(makeRectangle(-0.15, 0.15, -0.11, 0.11), liftBy(0.0));
  for (const double v : {-0.08, 0.0, 0.08}) builder.hold(-0.13, v);
  builder.pull(0.12, 0.0);
  return builder.finish();
}

CameraScene makeFoldedTowel(double distance, double gap, double tilt_degrees) {
  const std::string tilted = tilt_degrees == 0.0 ? "" : ", " + std::to_string(static_cast<int>(tilt_degrees)) + " deg";
  Builder builder(nameHeight("towel folded", gap) + tilted, distance, tilt_degrees, Vec2(0.36, 0.26));
  constexpr double kLine = 0.05, kEnd = 0.17;
  builder.add(makeRectangle(-0.16, kEnd, -0.11, 0.11), fold(Vec2::UnitX(), kLine, gap, kTowelWaves), kFineCell);
  for (const double v : {-0.08, 0.0, 0.08}) builder.hold(-0.14, v);
  for (const double v : {-0.08, 0.0, 0.08}) builder.hold(kLine + 0.5 * M_PI * gap + 0.01, v);
  builder.pull(kEnd - 0.03, 0.0);
  return builder.finish();
}

CameraScene makeCornerFold(double distance, double gap) {
  Builder builder(nameHeight("towel corner", gap), distance, 0.0, Vec2(0.36, 0.26));
  const Vec2 across = Vec2(1.0, 1.0).normalized(), corner(0.15, 0.11);
  constexpr double kFlap = 0.11;  // m, from the line to the corner
  builder.add(makeRectangle(-0.15, corner.x(), -0.11, corner.y()), fold(across, across.dot(corner) - kFlap, gap, kTowelWaves),
              kFineCell);
  for (const double v : {-0.08, 0.0, 0.08}) builder.hold(-0.13, v);
  const Vec2 along(-across.y(), across.x()), near_line = corner - (kFlap - 0.5 * M_PI * gap - 0.01) * across;
  for (const double t : {-0.04, 0.0, 0.04}) builder.hold((near_line + t * along).x(), (near_line + t * along).y());
  const Vec2 tip = corner - 0.03 * across;
  builder.pull(tip.x(), tip.y());
  return builder.finish();
}

CameraScene makeBlanket(double distance, double height, double waves) {
  const Vec2 field(0.36, 0.27);
  Builder builder(nameHeight(waves > 0.0 ? "wrinkled blanket" : "blanket", height), distance, 0.0, field);
  addTable(field, builder);
  const Mat2 turn = Eigen::Rotation2Dd(0.35).toRotationMatrix();
  builder.add(
      makeRectangle(-0.11, 0.11, -0.075, 0.075),
      [=](const Vec2& at) {
        const Vec2 p = turn * at;
        return Vec3(p.x(), p.y(), height + waves * wave(p.x(), p.y()));
      },
      waves > 0.0 ? 3.0 * kFineCell : 0.0);
  for (const double v : {-0.05, 0.0, 0.05}) builder.hold(-0.09, v);
  builder.pull(0.07, 0.0);
  return builder.finish();
}

CameraScene makeGarment(double distance) {
  const Vec2 field(0.44, 0.34);
  Builder builder("T-shirt", distance, 0.0, field);
  addTable(field, builder);
  const std::vector<Vec2> right{{0.04, -0.13}, {0.1, -0.12}, {0.18, 0.02}, {0.12, 0.045}, {0.1, -0.04}, {0.1, 0.14}};
  std::vector<Vec2> outline = right;
  for (auto corner = right.rbegin(); corner != right.rend(); ++corner) outline.emplace_back(-corner->x(), corner->y());
  builder.add(
      outline, [](const Vec2& at) { return Vec3(at.x(), at.y(), 0.0075 + 0.003 * wave(at.x(), at.y())); }, 3.0 * kFineCell);
  for (const double u : {-0.06, 0.0, 0.06}) builder.hold(u, 0.1);
  builder.pull(0.13, 0.0);
  return builder.finish();
}

CameraScene makeTwoSheets(double distance, double gap) {
  Builder builder(nameHeight("sheets", gap), distance, 0.0, Vec2(0.36, 0.27));
  builder.add(makeRectangle(-0.4, 0.4, -0.3, 0.3), liftBy(0.0));
  for (const double v : {-0.09, 0.0, 0.09}) builder.hold(0.15, v);
  builder.add(makeRectangle(-0.4, 0.0, -0.3, 0.3), liftBy(gap));
  for (const double v : {-0.09, 0.0, 0.09}) builder.hold(-0.15, v);
  builder.pull(-0.04, 0.0);
  return builder.finish();
}

std::vector<CameraScene> makeCameraScenes(double distance) {
  return {makeTowel(distance, 0.0),
          makeTowel(distance, 30.0),
          makeTowel(distance, 60.0),
          makeFoldedTowel(distance, 0.014),
          makeFoldedTowel(distance, 0.014, 30.0),
          makeCornerFold(distance, 0.014),
          makeBlanket(distance, 0.012, 0.0),
          makeBlanket(distance, 0.012, 0.004),
          makeGarment(distance),
          makeTwoSheets(distance, 0.005),
          makeTwoSheets(distance, 0.01),
          makeTwoSheets(distance, 0.02)};
}

DepthCamera aimAt(const CameraScene& scene, DepthCamera camera) {
  camera.width = static_cast<Index>(std::ceil(camera.focal_length * scene.field.x() / scene.distance));
  camera.height = static_cast<Index>(std::ceil(camera.focal_length * scene.field.y() / scene.distance));
  return camera;
}

}  // namespace deformable_surface::test
