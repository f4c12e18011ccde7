// The part of a model beside its mechanics (model/deformable_model.h): rules for scenes, rest state, copies of fewer points, the
// motion of the full cloud, and changes beside the motion. Each model derives one class from ModelKind, in its folder below
// src/simulation/models. The registry lists them; no other file names a model. How to add one:
// docs/extending.md.
#pragma once

#include "deformable_surface/simulation/prepared_surface.h"
#include "deformable_surface/simulation/scene_params.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace deformable_surface::simulation {

class CloudFollower;
class Evolution;
class Simulation;

/// What scenes and commands may ask of a model.
struct ModelTraits {
  // Factors on the stiffness of contact; more costs sub-steps while parts touch:
  double contact_stiffening = 1.0;       // with tools, which is then always damped
  double self_contact_stiffening = 1.0;  // of the body with itself
  bool is_surface = false;               // its points have sides: pressure, drag, clouds to track, inserted points
  bool is_oriented = false;              // its points have orientations: pins hold them, creases leave their forces out
  bool has_population = false;           // commands add and remove points
  bool has_springs = false;              // material.spring_damping
  bool meets_itself = false;             // its triangles may touch: contact.self
  bool has_regions = false;              // the material may differ from point to point
  bool has_estimate = false;             // makeCopies() gives the copies of the error estimate
  bool has_local_estimate = false;       // and the cloud follows by RestSurface::transfer: output.error
  bool is_tuned = false;                 // trials choose points, membrane stiffness and integrator for an accuracy target
  bool is_timed = false;                 // accuracy.step_budget chooses the number of points
  bool can_snap = false;                 // it may rest without loads in another shape than its own
  bool is_prepared = false;              // its makeRest() is prepare() and finishRest(), so that scenes may share the first
};

/// The order of removal is recorded down to this many points, for the coarser copies: fewer carry no shape.
constexpr Index kCoarsestPoints = 16;
/// The copies have one point for so many of the simulation's: doubled spacing, an eighth of the cost of explicit steps.
constexpr Index kCoarserRatio = 4;

/// A surface of fewer points for the error estimate, and its relation to the level that it copies.
struct CoarserLevel {
  RestSurface surface;  // without dense points
  /// (m) the point of the level that each of its points is; -1: none. Empty: it has points of its own, and distances are those of
  /// the level's points from where refine moves them.
  std::vector<Index> common;
  /// Moves the level's points as they would follow the points of the copy, m.
  std::function<void(const Points& coarse, Points& level)> refine;
  bool is_body = false;        // the level's points fill a body; they are not the surface of a cloud
  bool is_simplified = false;  // the level has fewer points than the surface
  double unresolved = 1.0;     // share of the surface's points that are no simulation points
};

class ModelKind {
 public:
  virtual ~ModelKind() = default;
  /// Its name in scenes.
  virtual const char* name() const = 0;
  virtual ModelTraits traits() const { return {}; }

  // Scenes.
  /// The section of its options, with the rules that concern them, in scenes of every model.
  virtual void visitOptions(Fields& /*fields*/, SceneParams& /*scene*/) const {}
  /// Further rules for scenes of this model.
  virtual void checkScene(Fields& /*fields*/, const SceneParams& /*scene*/) const {}
  /// Which fields a tool mode uses; by default those that it uses with every model.
  virtual tool::ModeUse useOf(const tool::ModeInfo& mode) const { return mode.everywhere; }
  /// Problems of a tool whose mode the model has.
  virtual std::vector<ToolProblem> findToolProblems(const tool::ToolParams& /*tool*/) const { return {}; }
  /// Why this tool is refused on a surface of this scene; empty if it is accepted. The sentence begins with "tool ID ".
  virtual std::string refuseTool(const SceneParams& /*scene*/, const tool::ToolParams& /*tool*/) const { return ""; }
  /// For models with has_regions: why a scene cannot have this change; empty if it can.
  virtual std::string findMaterialProblem(const SceneParams& /*scene*/, const MaterialChangeParams& /*change*/) const {
    return "";
  }
  /// Whether the surface bends with material.bendingRigidity(), so that pins of several rows of points clamp it.
  virtual bool isPlate(const SceneParams& /*scene*/) const { return false; }
  /// Whether dents may grow that are too short to show in the points.
  virtual bool mayDent(const SceneParams& /*scene*/) const { return false; }
  /// Why this scene has no error estimate, as the end of "model NAME ..."; empty if it has one.
  virtual std::string refuseEstimate(const SceneParams& scene) const;
  /// Whether a trial may choose a lower membrane stiffness.
  virtual bool maySoften(const SceneParams& /*scene*/) const { return false; }

  // From a cloud.
  using Choose = std::function<Index(const RestSurface& full)>;
  /// See buildRestSurface(). By default, of a model that is_prepared, what the next two functions make.
  virtual RestSurface makeRest(const SceneParams& params, const cloud::PointCloud& input, Index coarsest,
                               const Choose& choose) const;
  /// See prepareSurface(). params: the result of keepWhatPrepares().
  virtual RestSurface prepare(const SceneParams& params, const cloud::PointCloud& input, Index coarsest, bool to_choose) const;
  /// Completes a prepared surface. choose: given if the surface was prepared with to_choose.
  virtual RestSurface finishRest(const SceneParams& params, RestSurface prepared, const Choose& choose) const;
  /// See buildTrial(). For models with is_timed.
  virtual RestSurface makeTrial(const SceneParams& params, const RestSurface& full, Index points) const;
  /// See buildCoarser(). By default it throws InputError.
  virtual RestSurface makeCoarser(const SceneParams& params, const RestSurface& of, Index target) const;
  /// For models with has_estimate. Throws InputError if so few points span no surface or body.
  virtual CoarserLevel makeCopies(const SceneParams& params, const RestSurface& level) const;
  /// See copyCoarser(). By default a clone of the model.
  virtual RestSurface copyCoarser(const SceneParams& params, const RestSurface& of) const;

  /// The triangles by which it meets itself (contact.self): by default those of the model.
  virtual std::vector<model::WeightedTriangle> findSkin(const RestSurface& rest, const model::DeformableModel& model) const;
  /// Points between the simulation points that touch tools, too (ContactPoints): of the cloud, or on triangles; null: none. They
  /// are made when the first tool comes. skin: the triangles of the model, or around a body.
  virtual std::shared_ptr<const transfer::SampledPoints> makeBetween(const SceneParams& params, const RestSurface& rest,
                                                                     const std::vector<model::WeightedTriangle>& skin) const;
  /// The points of the cloud that carry forces with a radius; null: the simulation points alone. They are made when the first
  /// such force comes.
  virtual std::shared_ptr<const LoadPoints> makeLoadPoints(const SceneParams& params, const RestSurface& rest) const;

  /// For models whose elements depend on the state: links between the points that share elements when all are at rest.
  virtual std::vector<std::pair<Index, Index>> linkPartners(const model::DeformableModel& /*model*/,
                                                            const Points& /*rest*/) const {
    return {};
  }

  // While it runs; model: one that makeRest() has made, or a clone.
  /// How the full cloud follows the simulation points; null: by the transfer of the rest surface.
  virtual std::unique_ptr<CloudFollower> makeFollower(const RestSurface& rest, const SceneParams& params,
                                                      const model::DeformableModel& model) const;
  /// Changes beside the motion. All arguments are kept by reference.
  virtual std::unique_ptr<Evolution> makeEvolution(model::DeformableModel& model, const RestSurface& rest,
                                                   const SceneParams& params) const;
  /// A quantity of `expect` that only this model has; none if it has no quantity of that name.
  virtual std::optional<double> findQuantity(const std::string& /*name*/, const Simulation& /*simulation*/) const { return {}; }
};

/// All models, in the order of the registry.
const std::vector<const ModelKind*>& modelKinds();
/// Adds a model to the registry; a program calls it before anything else runs. The model is kept by reference.
void registerModel(const ModelKind& kind);
/// The model of that name. Throws InputError if there is none.
const ModelKind& findModel(const std::string& name);
/// "a, b": the models with a trait.
std::string listModels(bool ModelTraits::*trait);

}  // namespace deformable_surface::simulation
