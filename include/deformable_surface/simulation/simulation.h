// The simulation: one surface, its loads, and the order of a step. The node and `simulate` use this class and nothing below it.
#pragma once

#include "deformable_surface/cloud/point_cloud.h"
#include "deformable_surface/simulation/accuracy_choice.h"
#include "deformable_surface/simulation/commands.h"
#include "deformable_surface/simulation/scene_params.h"
#include "deformable_surface/simulation/statistics.h"
#include "deformable_surface/simulation/tool_reaction.h"

#include <atomic>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::simulation {

class Dynamics;
struct RestSurface;

/// The result of one step. Numbers that are not finite never throw: the state is then as it was before the step.
struct StepOutcome {
  bool ok = true;
  std::string problem;        // one sentence: which quantity, at which point, at which time
  std::string notice;         // for the user of a step that succeeded (auto chose another integrator, a force begins where it
                              // cannot act as meant); else empty. What lasts is reported in its first and after its last step
  bool has_converged = true;  // implicit and static steps: the forces were balanced
  bool was_retried = false;   // the step was not sound at first
};

/// The deformed surface: one row per input point in the input's order, then the inserted points.
struct Surface {
  Points positions;                      // m; NaN for holes
  std::vector<Eigen::Vector3f> normals;  // unit; NaN for holes; empty if not wanted
  std::vector<float> displacement;       // m, distance from rest; NaN for holes
  std::vector<float> error;              // m, estimate of the position error; NaN for holes; empty without output.error
  std::vector<Index> source;  // the input point whose extra fields each inserted row takes; empty without inserted rows
  Index num_input = 0;
};

/// Everything that a simulation needs to continue from a state, bit for bit: positions, velocities, steps, pins, gravity, forces
/// with their points, the memory of the integrator and of the energy account, inserted points, the error estimate
/// with its copies. Copies of a snapshot share the data.
class Snapshot {
 public:
  Snapshot() = default;  // empty

  /// Memory in use, except for a few small lists.
  std::size_t bytes() const;
  /// s since rest; 0 if empty.
  double time() const;

 private:
  friend class Simulation;
  struct Contents;
  std::shared_ptr<const Contents> contents_;
};

class Simulation {
 public:
  /// Builds the surface. Throws InputError naming each problem: a value that a scene file would be refused for, in the same
  /// words, fewer than three distinct points, a pin that holds no point.
  Simulation(const SceneParams& params, cloud::PointCloud input);
  /// The same from what prepareSurface() made of this cloud and a scene that shares it (prepared_surface.h).
  Simulation(const SceneParams& params, cloud::PointCloud input, RestSurface&& prepared);
  /// The same without the trials of params.accuracy.position_error: as many points as without it, for which it counts as not met.
  static Simulation untried(const SceneParams& params, cloud::PointCloud input);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Advances by exactly params.integrator.time_step.
  StepOutcome step();
  /// Once this is true, a running step ends soon, between two evaluations of the forces or within one, as a failed step:
  /// everything is as before it. Null = never. It must outlive the simulation; forks have none.
  void setInterrupt(const std::atomic<bool>* interrupt);
  /// The lasting conditions whose beginning a notice has reported since the last reset, but not yet their end, with the number of
  /// steps of each. Empty: none. For the end of a run.
  std::string lastingNotices() const;
  double time() const;  // s since rest
  std::uint64_t stepCount() const;
  const SceneParams& params() const;
  const cloud::PointCloud& input() const;

  /// Back to rest at time 0. Pins, forces and tools of the scene stay; later ones are removed.
  void reset();

  Snapshot snapshot() const;
  /// Back to the state of the snapshot. Throws InputError, and changes nothing, if it is not of this surface in this scene (a new
  /// cloud, material or way to step; a simulation built again from the same cloud and scene counts as the same).
  void restore(const Snapshot& snapshot);
  /// Another simulation in the state of this one. It continues as this one would, bit for bit, and takes commands of its own.
  /// They share the cloud and everything made from it at rest: a fork costs almost nothing compared with building one. Another
  /// thread may use the fork. Only the thread that steps this simulation may make one. Throws InputError if the model
  /// cannot be copied.
  Simulation fork() const;
  /// A read-only fork for another thread: step() fails. restore() of each sight() gives it everything that can be shown of this
  /// simulation. It has no error estimate of its own and reports that of the sight.
  Simulation viewer() const;
  /// A snapshot for viewers only, without what steps need: it costs a copy of the state. The scene's output.normals and
  /// publish_rate are not in it.
  Snapshot sight() const;

  /// Sets positions and velocities of the simulation points, pinned ones included; time and loads stay. In a solid that flows it
  /// also sets the plastic flow, unless the state leaves it empty; orientations and traits stay. The energy account starts
  /// again, and so does the error estimate, at zero for the given state. Throws InputError, and changes nothing, on another
  /// number of points, on values that are not finite or beyond any surface's (more than kMaxLength, a third of the speed of
  /// light), on a velocity of a pinned point, and on impossible plastic flow.
  void setState(const model::State& state);

  // Commands. They take effect at the next step. Each throws InputError, and changes nothing, on values that are not finite or
  // out of range.
  /// Carries out a command. Each function below makes one.
  Changes apply(const Command& command);
  void setForce(const ForceParams& force);  // replaces the force of that id; a zero force removes it
  void removeForce(const std::string& id);
  /// The ids of all forces, ascending, including those that have not begun.
  std::vector<std::string> forceIds() const;
  void setTool(const tool::ToolParams& tool);  // replaces the tool of that id
  /// Gives an existing tool another path. It may be called in every step at almost no cost.
  void moveTool(const std::string& id, const std::vector<tool::WaypointParams>& path);
  bool removeTool(const std::string& id);  // false: there is none
  const std::vector<tool::ToolParams>& tools() const;
  /// The contact wrench of the surface on each tool now, in the order of tools().
  std::vector<ToolReaction> toolReactions() const;
  /// Every contact of tools of mode solid, cut and attract now, tool by tool, points ascending.
  std::vector<Contact> contacts() const;
  /// The contacts of the surface with itself now, in a scene with contact.self.
  std::vector<SelfTouch> selfTouches() const;
  /// The wrench of the surface on its pins now: the scene's regions in order (a point of several belongs to the first), then
  /// kOtherPins, if commands have pinned any. Particles added in a pinned region do not count.
  std::vector<PinReaction> pinReactions() const;
  /// Fixes (or frees) the simulation points whose current position lies in the region; orientation: also their
  /// orientations, if they have any. Returns how many.
  Index pin(const geometry::Region& region, bool orientation = false);
  /// The same; from then on a frame carries the points rigidly. path: its poses, as of a tool. id: a name for movePin(), not in
  /// use by another pin. Throws InputError for a path that is not accepted.
  Index pinAlong(const std::string& id, const geometry::Region& region, const std::vector<tool::WaypointParams>& path);
  /// Gives such a pin another path. It continues from where it is. Throws InputError where findPinPath() gives null.
  void movePin(const std::string& id, const std::vector<tool::WaypointParams>& path);
  /// The path of a pin of pinAlong(); null if there is none, or all of its points are free again.
  const std::vector<tool::WaypointParams>* findPinPath(const std::string& id) const;
  Index unpin(const geometry::Region& region);
  void setGravity(const Vec3& gravity);  // m/s^2, in the surface's frame
  /// Changes the material of the simulation points that lie in the region now (null: all of them) until the next
  /// reset. Velocities stay, even where masses change. The stable step is estimated again. Throws InputError, changing nothing,
  /// if the scene's model has no such values. Returns how many points.
  Index setMaterial(const geometry::Region* region, const MaterialChangeParams& change);
  /// Number of simulation points with a material of their own, by the scene's regions or by setMaterial().
  Index numOwnMaterial() const;
  /// 1/s, damping of all points, until the next reset.
  void setDamping(double damping);
  /// Tracks a cloud: draws the surface towards it from now on, where it was seen, with input.tracking_gain (track_load.h). It
  /// replaces the cloud before. In the surface's frame. Ends with a reset, and when particles are added or removed. Throws
  /// InputError, and changes nothing, for clouds of fewer than three points.
  void observe(const cloud::PointCloud& cloud);
  /// The same for a cloud that was prepared before, which is most of the work.
  void observe(std::shared_ptr<const ObservedCloud> cloud);
  /// Sets the values that may change at run time (run_time_params.h), from the next step on and through resets. Points
  /// with a Young's modulus of their own keep it. Throws InputError, and changes nothing, for values that are not accepted and
  /// if any other value differs from params().
  void setParams(const SceneParams& params);
  // For oriented particles only. They take effect at once, wholly or not at all; InputError gives the reason.
  /// Returns the ids of the particles that were added.
  std::vector<Index> editParticles(const ParticleEdit& edit);
  /// Grows a surface through the present particles (sec. 7 of [Szeliski 1991]); growth.chain is set by the model. Returns a
  /// sentence with the result.
  std::string growSurface(const model::GrowthParams& growth);

  /// Whether a command came or a snapshot was restored since rest.
  bool wasCommanded() const;
  double membraneShare() const;                  // of the stated membrane stiffness, that acts now
  solve::IntegratorType lastIntegrator() const;  // of the last step; the one that auto took

  /// revision() changes whenever anything that can be asked for may have changed, except the time and the cost of a step.
  /// surfaceRevision() changes whenever the positions may have changed.
  std::uint64_t revision() const;
  std::uint64_t surfaceRevision() const;

  /// The full surface now. normals are computed if wanted and params.output.normals.
  const Surface& surface(bool with_normals);
  Statistics statistics() const;
  /// J, by which kinetic, elastic and load energy have grown since their lowest sum beyond the work put in: the method's own
  /// oscillation, if nothing creates energy. The account starts again with each command and when contact sets in or ends.
  double energyExcess() const;
  std::uint64_t stateHash() const;

  // For display and simulation_points output.
  const model::State& state() const;
  const model::DeformableModel& model() const;
  bool isAwake(Index simulation_point) const;  // false: it is left out of the steps, see docs/sleep.md
  bool isAsleep() const;                       // all of it: steps pass in no time
  bool isLeftAlone() const;                    // asleep, without forces and tools: only a command can wake it
  /// Whether the unloaded surface rests in another shape than its own: asleep, stretched, without gravity, pressure, forces,
  /// anchors, touching tools and pins that hold it elsewhere than at rest.
  bool hasSnapped() const;
  Index numFirst() const;                                // simulation points at time 0
  const std::vector<char>& pinned() const;               // (m)
  void computeSimulationNormals(Points& normals) const;  // (m x 3)
  /// Named forces acting now: point of attack (mean of the loaded points) and force.
  std::vector<std::pair<Vec3, Vec3>> activeForces() const;

  /// Notes of the construction: counts of dropped, coincident and degenerate points, rules used, choices of auto.
  const std::vector<std::string>& buildNotes() const;
  /// What will differ from the scene, or not go well.
  const std::vector<std::string>& buildWarnings() const;
  /// The choice made from params().accuracy, and its reason.
  const AccuracyChoice& accuracyChoice() const;

  /// The mechanics below (src/simulation/dynamics.h): for tests and benchmarks.
  Dynamics& dynamics();
  const Dynamics& dynamics() const;

 private:
  struct Impl;
  explicit Simulation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace deformable_surface::simulation
