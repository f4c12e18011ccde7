// The world: one surface, what pushes on it, and the order of a step. The node and `simulate` drive this and nothing below it.
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

/// The result of one step. Numbers that went wrong never throw: the state is then as it was before the step.
struct StepOutcome {
  bool ok = true;
  std::string problem;  // one sentence: which quantity, at which point, at which time
  std::string notice;   // what a user should know though all is well (the integrator that auto fell back to, a force that begins
                        // where it cannot do what was meant); else empty
};

/// The deformed surface: one row per input point in the input's order, then the inserted ones.
struct Surface {
  Points positions;                      // m; NaN for holes
  std::vector<Eigen::Vector3f> normals;  // unit; NaN for holes; empty if not wanted
  std::vector<float> displacement;       // m, distance from rest; NaN for holes
  std::vector<Index> source;  // the input point whose extra fields each inserted row takes; empty without inserted rows
  Index num_input = 0;
};

/// Everything that a simulation needs to go on from where it was, bit for bit: positions, velocities, steps, pins, gravity,
/// forces with the points they took, what the integrator and the energy account remember, inserted points, the error estimate
/// with its copies. Copies of a snapshot share it.
class Snapshot {
 public:
  Snapshot() = default;  // of nothing

  /// What it holds in memory, but for a few small lists.
  std::size_t bytes() const;
  /// s since rest; 0 of nothing.
  double time() const;

 private:
  friend class Simulation;
  struct Contents;
  std::shared_ptr<const Contents> contents_;
};

class Simulation {
 public:
  /// Builds the surface. Throws InputError naming each problem: fewer than three distinct points, a pin that holds no point, a
  /// value or mode that is not accepted.
  Simulation(const SceneParams& params, cloud::PointCloud input);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Advances by exactly params.integrator.time_step.
  StepOutcome step();
  /// Once this is true, a step that is under way ends soon, between two evaluations of the forces or within one, as one that
  /// failed: everything is as before it. Null = never. It must outlive the simulation; forks have none.
  void setInterrupt(const std::atomic<bool>* interrupt);
  double time() const;  // s since rest
  std::uint64_t stepCount() const;
  const SceneParams& params() const;
  const cloud::PointCloud& input() const;

  /// Back to rest at time 0; pins, forces and tools of the scene stay, those added since go.
  void reset();

  Snapshot snapshot() const;
  /// Back to the snapshot's moment. Throws InputError, and changes nothing, if it is not of this surface in this scene (another
  /// cloud, material or way to step; a simulation made anew from the same cloud and scene is the same).
  void restore(const Snapshot& snapshot);
  /// Another simulation in the state of this one, which goes on as this one would, bit for bit, and takes commands of its own.
  /// They share the cloud and what was made from it at rest, so that it costs next to nothing beside building one, and each may
  /// be used by a thread of its own; making a fork is a matter of the thread that steps this one. Throws InputError if the model
  /// cannot be copied.
  Simulation fork() const;
  /// A fork that takes no steps (step() fails) but shows, in a thread of its own, what this one was: restore() of each sight()
  /// gives it everything that is there to be seen. It has no error estimate of its own and tells that of the sight.
  Simulation viewer() const;
  /// A snapshot for viewers alone, without what only steps need: it costs a copy of the state. The scene's output.normals and
  /// publish_rate are not in it.
  Snapshot sight() const;

  /// Places the simulation points and gives them velocities, pinned ones included; time and loads stay. Of a solid that flows it
  /// takes what has flowed as well, unless the state leaves that empty; orientations and traits stay. What the energy was before
  /// is forgotten, and the error estimate begins anew at zero, for the state that was given. Throws InputError, and changes
  /// nothing, on another number of points, on values that are not finite or beyond any surface's (more than kMaxLength, a third
  /// of the speed of light), on a velocity of a pinned point, and on what cannot have flowed.
  void setState(const model::State& state);

  // Commands; they take effect at the next step. Each throws InputError, and changes nothing, on values that are not finite or
  // out of range.
  /// Each of the functions below gives one of these values.
  Changes apply(const Command& command);
  void setForce(const ForceParams& force);  // replaces the force of that id; a zero force removes it
  void removeForce(const std::string& id);
  /// Of all forces there are, ascending; those that wait for their time too.
  std::vector<std::string> forceIds() const;
  void setTool(const tool::ToolParams& tool);  // replaces the tool of that id
  /// Gives a tool that is there another path: what happens in every step must cost next to nothing.
  void moveTool(const std::string& id, const std::vector<tool::WaypointParams>& path);
  bool removeTool(const std::string& id);  // false: there is none
  const std::vector<tool::ToolParams>& tools() const;
  /// What the surface does to each tool now, in the order of tools().
  std::vector<ToolReaction> toolReactions() const;
  /// Every touch of solid, cut and attract now, tool by tool, points ascending.
  std::vector<Contact> contacts() const;
  /// The contacts of the surface with itself now, of a scene with contact.self.
  std::vector<SelfTouch> selfTouches() const;
  /// What the surface does to its pins now: the scene's regions in their order, a point of several to the first; then kOtherPins,
  /// if commands have pinned any. Particles that were born in a pinned region are no part of it.
  std::vector<PinReaction> pinReactions() const;
  /// Fixes (or frees) the simulation points whose current position lies in the region, where they are; orientation: and their
  /// orientations, where they have any. Returns how many.
  Index pin(const geometry::Region& region, bool orientation = false);
  /// The same, and from then on a frame carries them along rigidly; path: its poses, as of a tool. id: a name for movePin(); a
  /// pin of that name must not be there. Throws InputError for a path that is not accepted.
  Index pinAlong(const std::string& id, const geometry::Region& region, const std::vector<tool::WaypointParams>& path);
  /// Gives such a pin another path, on which it goes on from where it is.
  void movePin(const std::string& id, const std::vector<tool::WaypointParams>& path);
  /// The path of a pin of pinAlong(); null: there is none, or all of its points are free again.
  const std::vector<tool::WaypointParams>* findPinPath(const std::string& id) const;
  Index unpin(const geometry::Region& region);
  void setGravity(const Vec3& gravity);  // m/s^2, in the surface's frame
  /// Gives the simulation points that lie in the region now (null: all of them) other values of their material, until the next
  /// reset. Velocities stay, also where masses change. The stable step is measured anew. Throws InputError, and changes nothing,
  /// if the scene's model has no such values. Returns how many points.
  Index setMaterial(const geometry::Region* region, const MaterialChangeParams& change);
  /// Simulation points with values of their own, by the scene's regions or by setMaterial().
  Index numOwnMaterial() const;
  /// 1/s, of everything, until the next reset.
  void setDamping(double damping);
  /// Draws the surface towards this cloud from now on, where it was seen, with input.tracking_gain (track_load.h); instead of the
  /// cloud before. In the surface's frame. Ends with a reset, and where particles are born or go. Throws InputError, and changes
  /// nothing, for clouds of fewer than three points.
  void observe(const cloud::PointCloud& cloud);
  /// The same of one that was made ready before, which is most of the work.
  void observe(std::shared_ptr<const ObservedCloud> cloud);
  /// Takes the values that may change while a surface runs (run_time_params.h), from the next step on and through resets; points
  /// with a Young's modulus of their own keep it. Throws InputError, and changes nothing, for values that are not accepted and
  /// where any other value is not as in params().
  void setParams(const SceneParams& params);
  // Of oriented particles only; at once, and wholly or not at all: InputError says why not.
  /// Returns the ids of the particles that were added.
  std::vector<Index> editParticles(const ParticleEdit& edit);
  /// Grows a surface through the particles that there are (sec. 7 of [Szeliski 1991]); growth.chain is the model's. Returns what
  /// it did as a sentence.
  std::string growSurface(const model::GrowthParams& growth);

  double membraneShare() const;                  // of the stated membrane stiffness, that acts now
  solve::IntegratorType lastIntegrator() const;  // of the last step; the one that auto took

  /// Other numbers whenever anything that can be asked for may be another but the time and what a step costs; and whenever the
  /// positions may: what was made of them before is good as long as they stay.
  std::uint64_t revision() const;
  std::uint64_t surfaceRevision() const;

  /// The full surface now. normals are computed if wanted and params.output.normals.
  const Surface& surface(bool with_normals);
  Statistics statistics() const;
  std::uint64_t stateHash() const;

  // For display and simulation_points output.
  const model::State& state() const;
  const model::DeformableModel& model() const;
  bool isAwake(Index simulation_point) const;  // false: it is left out of the steps, see docs/sleep.md
  bool isAsleep() const;                       // all of it: steps pass in no time
  bool isLeftAlone() const;                    // asleep, without forces and tools: only a command can wake it
  /// Whether the surface rests in another shape than its own though nothing loads it: asleep, stretched, without
  /// gravity, pressure, forces, anchors, touching tools and pins that hold it elsewhere than at rest.
  bool hasSnapped() const;
  Index numFirst() const;                                // simulation points at time 0
  const std::vector<char>& pinned() const;               // (m)
  void computeSimulationNormals(Points& normals) const;  // (m x 3)
  /// Named forces acting now: point of attack (mean of the loaded points) and force.
  std::vector<std::pair<Vec3, Vec3>> activeForces() const;

  /// Lines worth telling after construction: counts of dropped, coincident and degenerate points, rules used, choices of auto.
  const std::vector<std::string>& buildNotes() const;
  /// What will not be as the scene says, or not go well.
  const std::vector<std::string>& buildWarnings() const;
  /// What was chosen from params().accuracy, and why.
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
