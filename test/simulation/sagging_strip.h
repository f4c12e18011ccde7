// A smooth scene in which coarse points have a large error, and its true result, for tests of estimates and accuracy choices.
#pragma once

#include "clouds.h"
#include "deformable_surface/io/shapes.h"
#include "deformable_surface/simulation/simulation.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::test {

// A stiff strip, clamped at one end and sagging under its weight: smooth, with large errors of coarse points.
inline simulation::SceneParams saggingStrip(solve::IntegratorType type) {
  simulation::SceneParams p;
  p.material.young_modulus = 1e6;
  p.material.thickness = 0.001;
  p.material.density = 300.0;
  p.material.bending_rigidity.is_auto = false;
  p.material.bending_rigidity.value = 0.02;
  p.material.damping = 2.0;
  p.integrator.type = type;
  p.duration = 0.3;
  p.accuracy.remember = false;  // each run makes its own trials
  simulation::PinParams pin;
  pin.region.min = Vec3(-1.0, -1.0, -1.0);
  pin.region.max = Vec3(0.08, 1.0, 1.0);
  p.pins.push_back(pin);
  return p;
}

inline cloud::PointCloud strip() {
  simulation::CloudParams c;
  c.shape = simulation::CloudParams::Shape::kStrip;
  c.points = 700;
  c.size = Vec2(0.5, 0.25);
  c.jitter = 0.3;
  return io::makeShape(c);
}

inline Points runToShape(simulation::SceneParams p, const cloud::PointCloud& cloud) {
  simulation::Simulation s(p, cloud);
  run(s, static_cast<int>(std::lround(p.duration / p.integrator.time_step)));
  return s.surface(false).positions;
}

inline Points findTruth(simulation::SceneParams p, const cloud::PointCloud& cloud) {
  p.accuracy = simulation::AccuracyParams();
  p.accuracy.estimate = false;
  p.output.error = false;
  p.simplification = cloud::SimplificationParams();
  p.simplification.method = cloud::SimplificationMethod::kNone;
  if (p.integrator.type == solve::IntegratorType::kImplicit) p.integrator.type = solve::IntegratorType::kVerlet;
  return runToShape(p, cloud);
}

inline double findLargestDistance(const Points& a, const Points& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

}  // namespace deformable_surface::test
