// Layers of 7 by 7 points that plates or pins press into each other.
#pragma once

#include "clouds.h"

namespace deformable_surface::test {

inline const Vec4 kStill(0.0, 0.0, 0.0, 1.0);
constexpr double kSpacing = 0.01, kGap = 0.02;  // m, of points in a layer and of layers
constexpr int kSide = 7;

inline cloud::PointCloud stackLayers(int layers) {
  cloud::PointCloud cloud;
  for (int layer = 0; layer < layers; ++layer)
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j)
        cloud.positions.emplace_back(kSpacing * (i + 0.3 * layer + 0.1 * ((i * 7 + j * 3) % 3)), kSpacing * j, kGap * layer);
  cloud.width = static_cast<Index>(cloud.positions.size());
  return cloud;
}

inline simulation::SceneParams stackScene(solve::IntegratorType type) {
  simulation::SceneParams p;
  p.material.young_modulus = 3e5;
  p.material.thickness = 1e-3;
  p.material.density = 250.0;
  p.material.bending_rigidity = 1e-5;
  p.material.damping = 1.0;
  p.simplification.method = cloud::SimplificationMethod::kNone;
  p.contact.self = true;
  p.contact.thickness = 0.004;
  p.gravity.setZero();
  p.integrator.type = type;
  p.integrator.time_step = 0.005;
  p.accuracy.estimate = false;
  return p;
}

// Two plates that close on three layers to far less than their thickness, then open.
inline simulation::SceneParams pressedByPlates(solve::IntegratorType type) {
  simulation::SceneParams p = stackScene(type);
  const auto add = [&](const char* id, const std::vector<tool::WaypointParams>& path) {
    tool::ToolParams plate;
    plate.id = id;
    plate.shape.kind = geometry::Solid::Kind::kBox;
    plate.shape.size = Vec3(0.3, 0.3, 0.02);
    plate.path = path;
    p.tools.push_back(plate);
  };
  const Vec3 middle(0.03, 0.03, 0.0);
  add("lower", {{0.0, middle - 0.012 * Vec3::UnitZ(), kStill}});
  add("upper", {{0.0, middle + 0.055 * Vec3::UnitZ(), kStill},
                {0.3, middle + 0.010 * Vec3::UnitZ(), kStill},
                {0.5, middle + 0.3 * Vec3::UnitZ(), kStill}});
  return p;
}

// One layer is pinned, and the pins of the other press it through the first.
inline simulation::SceneParams pressedByPins(solve::IntegratorType type) {
  simulation::SceneParams p = stackScene(type);
  p.pins.resize(2);
  p.pins[0].region.min = Vec3(-1.0, -1.0, -0.001);
  p.pins[0].region.max = Vec3(1.0, 1.0, 0.001);
  p.pins[1].region.min = Vec3(-1.0, -1.0, kGap - 0.001);
  p.pins[1].region.max = Vec3(1.0, 1.0, kGap + 0.001);
  p.pins[1].path = {{0.0, Vec3::Zero(), kStill}, {0.3, Vec3(0.0, 0.0, -0.03), kStill}, {0.5, Vec3(0.0, 0.0, 0.1), kStill}};
  return p;
}

}  // namespace deformable_surface::test
