// Everything a scene file or the node's parameters can state, as plain values. The functions that visit these structs hold the
// schema (names, units, ranges, meaning); docs/parameters.md is made from them.
#pragma once

#include "deformable_surface/base/params.h"
#include "deformable_surface/cloud/neighbors_params.h"
#include "deformable_surface/cloud/simplification_params.h"
#include "deformable_surface/geometry/region_params.h"
#include "deformable_surface/model/material_params.h"
#include "deformable_surface/simulation/contact_params.h"
#include "deformable_surface/simulation/input_filter_params.h"
#include "deformable_surface/simulation/model_params.h"
#include "deformable_surface/simulation/sleep_params.h"
#include "deformable_surface/simulation/statistics.h"
#include "deformable_surface/solve/integrator_params.h"
#include "deformable_surface/tool/robot_params.h"
#include "deformable_surface/tool/tool_params.h"
#include "deformable_surface/transfer/transfer_params.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

namespace deformable_surface::simulation {

/// A field of a tool and what is wrong with it: "found ...; accepted: ...".
struct ToolProblem {
  std::string field, sentence;
};
/// Problems of a tool for a model: a mode that the model does not have, and fields that the mode does not use.
std::vector<ToolProblem> findToolProblems(const std::string& model, const tool::ToolParams& tool);

/// Where `simulate` takes its cloud from; the node takes ~cloud_in and ignores this.
struct CloudParams {
  enum class Shape { kNone, kSheet, kStrip, kLattice, kChain, kSine, kSphere, kCap, kTwoBars, kBar };
  std::string file;            // path or package://deformable_surface/...; .pcd .ply .obj .off .xyz
  Shape shape = Shape::kNone;  // a generated one instead of a file
  Index points = 4096;         // >= 4
  // m: sheet, lattice and sine [x, y], strip [length, width], chain [x, -], two_bars [length, height of one bar]
  Vec2 size{1.0, 1.0};
  double height = 0.1;      // m, bar: along z
  double radius = 0.5;      // m, sphere and cap
  double angle = 1.0;       // rad, cap: from its lowest point to its rim
  double amplitude = 0.1;   // m, sine
  double wavelength = 1.0;  // m, sine
  double gap = 0.015;       // m, two_bars
  double jitter = 0.0;      // 0 .. 0.5 of the spacing
  Index seed = 1;           // >= 0
  double scale = 1.0;       // > 0, file units to metres
};

/// Points that lie in the region at rest.
struct PlacesParams {
  geometry::Region region;
};

struct AccuracyParams {
  double position_error = 0.0;        // m, >= 0; 0 = not controlled
  std::vector<PlacesParams> regions;  // where position_error counts: in any of these; none: everywhere
  double step_budget = 0.0;           // s of wall time per step, >= 0; 0 = not controlled
  bool estimate = true;               // estimate the error in every step
  bool remember = true;               // what trials for a position_error chose, on disk
  double patience = 5.0;              // s of wall time, >= 0: how long a node waits for them before another surface begins
};

/// Whether the position error counts at a point with this rest position.
bool isInTarget(const AccuracyParams& params, const Vec3& rest);

/// Holds the points whose rest position lies in the region.
struct PinParams {
  geometry::Region region;
  bool orientation = false;  // also clamp the tangent plane (models with orientation)
  /// The path of a frame that carries them rigidly, ascending times; empty: they stay in place.
  std::vector<tool::WaypointParams> path;
};

/// Particles whose rest position lies in the region are not smooth: only their spacing is maintained, so that the surface can
/// bend there.
struct CreaseParams {
  geometry::Region region;
};

/// Values of the material that differ from the general ones; auto: no difference.
struct MaterialChangeParams {
  OrAuto<double> young_modulus;     // Pa, > 0
  OrAuto<double> bending_rigidity;  // N m, > 0; auto also follows young_modulus where that of the material is auto
  OrAuto<double> density;           // kg/m^3, > 0

  bool isEmpty() const { return young_modulus.is_auto && bending_rigidity.is_auto && density.is_auto; }
};

/// Another material for points that lie in the region at rest.
struct RegionParams {
  geometry::Region region;
  MaterialChangeParams material;
};

/// A spring to a fixed place [Su 2007, eq. 5]: F = stiffness (target - s) on the simulation point nearest to point at rest.
struct AnchorParams {
  Vec3 point = Vec3::Zero(), target = Vec3::Zero();  // m
  double stiffness = 0.0;                            // N/m, >= 0
};

/// A named force; acts in the steps that begin at start <= t < end.
struct ForceParams {
  std::string id;
  Vec3 point = Vec3::Zero();  // m
  Vec3 force = Vec3::Zero();  // N, the total
  double radius = 0.0;        // m, >= 0; 0 = nearest simulation point
  double start = 0.0;         // s
  double end = 1e300;         // s
};

struct WrenchParams {
  double radius = 0.0;   // m, >= 0
  double timeout = 0.5;  // s, > 0
};

enum class OutputStamp { kClock, kSimulation };

struct OutputParams {
  OutputStamp stamp = OutputStamp::kClock;
  bool normals = true;
  bool resample = false;        // insert points where the surface is stretched
  bool error = false;           // estimate the error of each point; needs accuracy.estimate
  double publish_rate = 30.0;   // Hz, > 0
  double contacts_rate = 30.0;  // Hz, 0 = after every step
  Index pieces_per_edge = 1;    // >= 1: of the drawn triangles; with more they are cubic patches
};

enum class InputPolicy { kIgnore, kReplace, kTrack };  // a cloud on a running surface

enum class UnconstrainedParts { kKeep, kFreeze, kDrop };  // what happens to parts that nothing holds

struct InputParams {
  InputPolicy policy = InputPolicy::kReplace;
  Index max_points = 20000000;  // >= 3
  InputFilterParams filter;
  Index largest_parts = 0;  // >= 0; 0 = all
  OrAuto<double> noise;     // m, >= 0
  double min_gap = 0.0;     // m, >= 0
  UnconstrainedParts unconstrained_parts = UnconstrainedParts::kKeep;
  double tracking_gain = 400.0;      // 1/s^2, > 0: half of a distance is gone in about a tenth of a second
  OrAuto<double> tracking_distance;  // m, > 0; auto = three spacings of the simulation points
  double delay = 0.0;                // s, >= 0: the node's steps stay this far behind the clock, so that messages arrive in time
  double tool_timeout = 0.5;         // s, >= 0: a tool is silent after this long without news; 0 = never
  std::string lockstep;              // topics that each step waits for; empty = steps follow the clock
};

/// The bounds that a test checks after the run, by name, e.g. max_displacement: [0.01, 0.02].
struct ExpectParams {
  std::string quantity;
  double min = 0.0, max = 0.0;
};

struct SceneParams : ModelOptions {
  std::string model = kDefaultModel;  // the name of one of the registry (model_kind.h)
  std::string frame_id;
  CloudParams cloud;
  model::MaterialParams material;
  cloud::NeighborsParams neighbors;
  cloud::SimplificationParams simplification;
  transfer::TransferParams transfer;
  solve::IntegratorParams integrator;
  AccuracyParams accuracy;
  SleepParams sleep;
  ContactParams contact;
  Vec3 gravity{0.0, 0.0, -9.81};  // m/s^2, in gravity_frame
  std::string gravity_frame;      // empty = frame_id
  double viscous_drag = 0.0;      // N s/m per m^2, >= 0
  double pressure = 0.0;          // Pa
  std::vector<PinParams> pins;
  std::vector<CreaseParams> creases;
  std::vector<RegionParams> regions;
  std::vector<AnchorParams> anchors;
  std::vector<ForceParams> forces;
  std::vector<tool::ToolParams> tools;
  tool::RobotParams robot;
  WrenchParams force;     // for ~wrench
  double duration = 2.0;  // s, > 0
  Index threads = 0;      // 0 = all cores
  OutputParams output;
  InputParams input;
  std::string save_directory;
  bool diagnostics = true;
  std::vector<ExpectParams> expect;
  std::vector<std::string> notices;  // from the reader of the scene, such as keys under old names; no key
};

/// The names that `expect` may bound: the numbers of Statistics and what the final cloud shows.
std::vector<std::string> expectQuantities();

/// The names in a text, separated by spaces or commas.
std::vector<std::string> splitNames(const std::string& text);

/// Why a scene's model cannot have this change; empty if it can.
std::string findMaterialProblem(const SceneParams& p, const MaterialChangeParams& change);

void visitGravity(Fields& fields, Vec3& gravity);

// Rules of the registered models for a scene (src/simulation/scene_rules.cpp).
void visitModelName(Fields& fields, std::string& model);
void visitModelOptions(Fields& fields, SceneParams& p);
/// Problems of features that the scene asks for and its model does not have.
void requireModel(Fields& fields, const SceneParams& p);

void visit(Fields& fields, CloudParams& p);
void visit(Fields& fields, PlacesParams& p);
void visit(Fields& fields, AccuracyParams& p);
void visit(Fields& fields, PinParams& p);
void visit(Fields& fields, CreaseParams& p);
void visit(Fields& fields, MaterialChangeParams& p);
void visit(Fields& fields, RegionParams& p);
void visit(Fields& fields, AnchorParams& p);
void visit(Fields& fields, ForceParams& p);
void visit(Fields& fields, WrenchParams& p);
void visit(Fields& fields, OutputParams& p);
void visit(Fields& fields, InputParams& p);
void visit(Fields& fields, SceneParams& p);

}  // namespace deformable_surface::simulation
