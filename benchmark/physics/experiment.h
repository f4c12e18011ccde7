// One simulation in the hands of a problem: everything goes in and comes out in the problem's own frame, whether or not the
// surface is turned in space; and the two ways to get numbers from it, equilibria and frequencies.
#pragma once

#include "deformable_surface/simulation/simulation.h"
#include "problem.h"
#include "samplings.h"

namespace deformable_surface::physics {

class Experiment {
 public:
  /// scene: material, loads, pins (balls), tools and integrator in the problem's frame; membrane and bending are the variant's.
  Experiment(simulation::SceneParams scene, const Sampled& cloud, const Variant& variant);

  const Points& rest() const { return rest_; }             // of the simulation points, m
  const Points& cloudRest() const { return cloud_rest_; }  // of all points, m
  Points now() const;
  Points cloudNow();
  const std::vector<double>& masses() const { return simulation_.model().masses(); }
  simulation::Simulation& simulation() { return simulation_; }

  /// Fixes the simulation points whose rest position is accepted.
  void hold(const std::function<bool(const Vec3& rest)>& accepts);
  /// The force on one simulation point, N; replaces the one before.
  void push(Index point, const Vec3& force);
  void setGravity(const Vec3& gravity);
  /// Puts the simulation points there, at rest, held ones too.
  void place(const Points& positions);
  /// What the surface itself does to one of them, N.
  Vec3 forceOn(Index point) const;
  /// One step; throws std::runtime_error if it goes wrong.
  void step();
  /// Static steps until the loads are balanced; throws std::runtime_error if they are not.
  void settle();

 private:
  Mat3 rotation_;
  simulation::Simulation simulation_;
  Points rest_, cloud_rest_;
};

/// Pins what lies at or behind the plane through the point: a ball so large that it is flat over a surface of the given size, m.
/// forward: unit normal of the plane, towards what stays free.
simulation::PinParams pinBehind(const Vec3& point, const Vec3& forward, double size);

/// A scene for equilibria, without gravity.
simulation::SceneParams makeStaticScene();

/// Mean displacement of the points of the cloud that are accepted at rest, m.
Vec3 meanDisplacement(Experiment& experiment, const std::function<bool(const Vec3& rest)>& accepts);

/// A force spread evenly along the edge x = edge: each simulation point there carries its share of the edge's length.
void pushEdge(Experiment& experiment, double edge, const Vec3& force);

/// The angular frequency, 1/s, of the undamped mode: the surface has settled for `settle` s, is given the velocity field `kick`
/// (m/s at rest position, as an acceleration during one step) and is then recorded for `duration` s by its projection on the
/// kick; a decaying sinusoid is fitted by least squares. guess, 1/s: within a third of the answer. damping, 1/s: the scene's.
double measureFrequency(Experiment& experiment, const std::function<Vec3(const Vec3& rest)>& kick, double settle, double duration,
                        double guess);

}  // namespace deformable_surface::physics
