#include "experiment.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/notice.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace deformable_surface::physics {
namespace {

constexpr int kStaticSteps = 10;  // each as many iterations as the scene allows, before an equilibrium counts as not found
constexpr double kOnEdge = 1e-6;  // m: what counts as on an edge

simulation::SceneParams prepare(simulation::SceneParams scene, const Sampled& cloud, const Variant& variant,
                                const Mat3& rotation) {
  scene.accuracy.estimate = false;  // the error is known here
  scene.mass_spring.membrane = variant.membrane;
  scene.mass_spring.bending = variant.bending;
  scene.simplification.method = cloud.keep > 0 ? cloud::SimplificationMethod::kDelaunay : cloud::SimplificationMethod::kNone;
  scene.simplification.target_points = cloud.keep;
  scene.gravity = rotation * scene.gravity;
  for (simulation::PinParams& pin : scene.pins) pin.region.center = rotation * pin.region.center;
  for (tool::ToolParams& tool : scene.tools)
    for (tool::WaypointParams& waypoint : tool.path) {
      const Eigen::Quaterniond turned = Eigen::Quaterniond(rotation) * Eigen::Quaterniond(waypoint.orientation);
      waypoint.position = rotation * waypoint.position;
      waypoint.orientation = turned.coeffs();
    }
  for (simulation::AnchorParams& anchor : scene.anchors) {
    anchor.point = rotation * anchor.point;
    anchor.target = rotation * anchor.target;
  }
  return scene;
}

cloud::PointCloud makeCloud(const Points& points, const Mat3& rotation) {
  cloud::PointCloud cloud;
  for (const Vec3& p : points) cloud.positions.push_back(rotation * p);
  cloud.width = static_cast<std::uint32_t>(points.size());
  return cloud;
}

Points turn(const Mat3& rotation, const Points& points) {
  Points turned;
  for (const Vec3& p : points) turned.push_back(rotation * p);
  return turned;
}

// The least sum of squared differences between the record and A cos(w t) + B sin(w t) + C, times exp(-decay t) but for C.
double misfit(const std::vector<double>& record, double step, double frequency, double decay) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  double sum = 0.0;
  for (std::size_t k = 0; k < record.size(); ++k) {
    const double t = step * static_cast<double>(k), fade = std::exp(-decay * t);
    const Vec3 row(fade * std::cos(frequency * t), fade * std::sin(frequency * t), 1.0);
    normal += row * row.transpose();
    right += record[k] * row;
    sum += record[k] * record[k];
  }
  return sum - right.dot(normal.ldlt().solve(right));
}

}  // namespace

Experiment::Experiment(simulation::SceneParams scene, const Sampled& cloud, const Variant& variant)
    : rotation_(variant.rotated ? someRotation() : Mat3(Mat3::Identity())),
      simulation_(prepare(std::move(scene), cloud, variant, rotation_), makeCloud(cloud.points, rotation_)),
      rest_(turn(rotation_.transpose(), simulation_.state().positions)),
      cloud_rest_(cloud.points) {}

Points Experiment::now() const { return turn(rotation_.transpose(), simulation_.state().positions); }

Points Experiment::cloudNow() { return turn(rotation_.transpose(), simulation_.surface(false).positions); }

void Experiment::hold(const std::function<bool(const Vec3&)>& accepts) {
  geometry::Region region;
  region.kind = geometry::Region::Kind::kSphere;
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    if (!accepts(rest_[i])) continue;
    region.center = simulation_.state().positions[i];
    simulation_.pin(region);
  }
}

void Experiment::push(Index point, const Vec3& force) {
  simulation::ForceParams params;
  params.id = std::to_string(point);
  params.point = simulation_.state().positions[point];
  params.force = rotation_ * force;
  simulation_.setForce(params);
}

void Experiment::setGravity(const Vec3& gravity) { simulation_.setGravity(rotation_ * gravity); }

void Experiment::place(const Points& positions) {
  model::State state = simulation_.state();
  state.positions = turn(rotation_, positions);
  state.velocities.assign(positions.size(), Vec3::Zero());
  simulation_.setState(state);
}

Vec3 Experiment::forceOn(Index point) const {
  Points forces(rest_.size(), Vec3::Zero());
  simulation_.model().addForces(simulation_.state(), forces);
  return rotation_.transpose() * forces[point];
}

void Experiment::step() {
  const simulation::StepOutcome outcome = simulation_.step();
  if (!outcome.ok) throw std::runtime_error(outcome.problem);
}

void Experiment::settle() {
  std::string notice;
  for (int i = 0; i < kStaticSteps; ++i) {
    const simulation::StepOutcome outcome = simulation_.step();
    if (!outcome.ok) throw std::runtime_error(outcome.problem);
    if (outcome.has_converged) return;
    appendNotice(notice, outcome.notice);
  }
  throw std::runtime_error(notice);
}

simulation::PinParams pinBehind(const Vec3& point, const Vec3& forward, double size) {
  constexpr double kFlat = 1e4;  // radius over size: the ball's face departs from a plane by half the inverse of that
  simulation::PinParams pin;
  pin.region.kind = geometry::Region::Kind::kSphere;
  pin.region.radius = kFlat * size;
  pin.region.center = point + (size / kFlat - pin.region.radius) * forward;
  return pin;
}

simulation::SceneParams makeStaticScene() {
  simulation::SceneParams scene;
  scene.gravity.setZero();
  scene.output.normals = false;
  scene.integrator.type = solve::IntegratorType::kStatic;
  // Errors to be measured are above a ten-thousandth; the equilibrium must not add to them.
  scene.integrator.tolerance = 1e-7;
  scene.integrator.max_iterations = 200;
  return scene;
}

Vec3 meanDisplacement(Experiment& experiment, const std::function<bool(const Vec3&)>& accepts) {
  const Points now = experiment.cloudNow();
  Vec3 sum = Vec3::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i)
    if (accepts(experiment.cloudRest()[i])) {
      sum += now[i] - experiment.cloudRest()[i];
      count += 1.0;
    }
  return sum / count;
}

void pushEdge(Experiment& experiment, double edge, const Vec3& force) {
  std::vector<std::pair<double, Index>> places;
  for (std::size_t i = 0; i < experiment.rest().size(); ++i)
    if (std::abs(experiment.rest()[i].x() - edge) < kOnEdge) places.emplace_back(experiment.rest()[i].y(), static_cast<Index>(i));
  if (places.size() < 2) throw std::runtime_error("fewer than two simulation points lie on the edge");
  std::sort(places.begin(), places.end());
  const double length = places.back().first - places.front().first;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const double before = k == 0 ? places[k].first : places[k - 1].first;
    const double after = k + 1 == places.size() ? places[k].first : places[k + 1].first;
    experiment.push(places[k].second, 0.5 * (after - before) / length * force);
  }
}

double measureFrequency(Experiment& experiment, const std::function<Vec3(const Vec3&)>& kick, double settle, double duration,
                        double guess) {
  const double step = experiment.simulation().params().integrator.time_step;
  const double damping = experiment.simulation().params().material.damping;
  while (experiment.simulation().time() < settle) experiment.step();
  const Points mean = experiment.now();
  // A velocity field is given by forces that act during one step.
  for (Index i = 0; i < static_cast<Index>(mean.size()); ++i)
    experiment.push(i, experiment.masses()[i] / step * kick(experiment.rest()[i]));
  experiment.step();
  for (Index i = 0; i < static_cast<Index>(mean.size()); ++i) experiment.push(i, Vec3::Zero());
  std::vector<double> record;
  for (double t = 0.0; t < duration; t += step) {
    experiment.step();
    const Points now = experiment.now();
    double sum = 0.0;
    for (std::size_t i = 0; i < now.size(); ++i) sum += experiment.masses()[i] * kick(experiment.rest()[i]).dot(now[i] - mean[i]);
    record.push_back(sum);
  }
  // The damped frequency: scanned, then by golden section about the best.
  const double low = 0.66 * guess, high = 1.5 * guess;
  constexpr int kScan = 400;
  double best = low, least = misfit(record, step, low, 0.5 * damping);
  for (int k = 1; k <= kScan; ++k) {
    const double w = low + (high - low) * k / kScan;
    const double value = misfit(record, step, w, 0.5 * damping);
    if (value < least) {
      least = value;
      best = w;
    }
  }
  double a = best - (high - low) / kScan, b = best + (high - low) / kScan;
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  for (int k = 0; k < 60; ++k) {
    const double c = b - golden * (b - a), d = a + golden * (b - a);
    if (misfit(record, step, c, 0.5 * damping) < misfit(record, step, d, 0.5 * damping)) {
      b = d;
    } else {
      a = c;
    }
  }
  const double damped = 0.5 * (a + b);
  return std::sqrt(damped * damped + 0.25 * damping * damping);
}

}  // namespace deformable_surface::physics
