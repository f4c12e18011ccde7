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
inline bool isInTarget(const AccuracyParams& params, const Vec3& rest) {
  const auto holds = [&](const PlacesParams& places) { return places.region.contains(rest); };
  return params.regions.empty() || std::any_of(params.regions.begin(), params.regions.end(), holds);
}

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
inline std::vector<std::string> expectQuantities() {
  std::vector<std::string> names;
  // A hash is not a quantity, and does not fit a double.
  visitFields(Statistics{}, [&](const std::string& name, const auto& value) {
    if (std::is_arithmetic<std::decay_t<decltype(value)>>::value && name != "state_hash") names.push_back(name);
  });
  for (const char* name : {"max_displacement",
                           "mean_displacement",
                           "rms_displacement",
                           "min_x",
                           "max_x",
                           "min_y",
                           "max_y",
                           "min_z",
                           "max_z",
                           "volume_ratio",
                           "components",
                           "boundary_loops",
                           "euler_characteristic",
                           "isolated",
                           "plastic_dissipation",
                           "spacing_mean",
                           "spacing_cv",
                           "spacing_max",
                           "added",
                           "removed",
                           "principal_angle_mean",
                           "distance_to_shape_max",
                           "distance_to_shape_rms",
                           "distance_to_input_max",
                           "distance_to_input_rms",
                           "distance_to_sphere_max",
                           "distance_to_sphere_rms",
                           "sphere_radius",
                           "distance_to_torus_max",
                           "distance_to_torus_rms",
                           "torus_radius",
                           "torus_tube_radius",
                           "distance_to_tools_min",
                           "guide_distance_max",
                           "guide_distance_rms",
                           "touching"}) {
    names.emplace_back(name);
  }
  return names;
}

inline void visit(Fields& fields, CloudParams& p) {
  using Shape = CloudParams::Shape;
  fields.text(
      "file", p.file,
      "a .pcd, .ply, .obj, .off or .xyz file: path or package://PACKAGE/PATH. A path is relative to the working directory of the "
      "program, not to the scene");
  fields.choice("shape", p.shape,
                {{"none", Shape::kNone},
                 {"sheet", Shape::kSheet},
                 {"strip", Shape::kStrip},
                 {"lattice", Shape::kLattice},
                 {"chain", Shape::kChain},
                 {"sine", Shape::kSine},
                 {"sphere", Shape::kSphere},
                 {"cap", Shape::kCap},
                 {"two_bars", Shape::kTwoBars},
                 {"bar", Shape::kBar}},
                "generated cloud, if there is no file");
  fields.require(p.file.empty() || p.shape == Shape::kNone, "shape", "found beside a file; accepted: one of the two");
  fields.integer("points", p.points, "", between(4, kMaxPoints),
                 "shapes: approximate number of points; the actual number is printed");
  fields.vector(
      "size", p.size, "m", between(1e-6, kMaxLength),
      "sheet, sine, lattice (hexagonal): extent in x and y; strip: length and width; chain: length along x; two_bars: length and "
      "height of one bar; bar (filled with points): extent in x, from x = 0, and in y");
  fields.number("height", p.height, "m", between(1e-6, kMaxLength), "bar: extent in z");
  fields.number("radius", p.radius, "m", between(1e-6, kMaxLength), "sphere and cap: radius");
  fields.number("angle", p.angle, "rad", between(1e-3, 3.1),
                "cap (the lower part of a sphere): polar angle from its lowest point to its rim");
  fields.number("amplitude", p.amplitude, "m", between(0.0, kMaxLength), "sine: height of the crests; one crest is at x = 0");
  fields.number("wavelength", p.wavelength, "m", between(1e-6, kMaxLength), "sine: wavelength along x");
  fields.number("gap", p.gap, "m", between(1e-9, kMaxLength), "two_bars: gap between the bars");
  fields.number("jitter", p.jitter, "", between(0.0, 0.5),
                "shapes: random displacement within the surface, as a fraction of the spacing");
  fields.integer("seed", p.seed, "", between(0, std::numeric_limits<Index>::max()), "shapes: random seed of jitter");
  fields.number("scale", p.scale, "", between(1e-9, 1e9), "file: metres per file unit");
}

inline void visit(Fields& fields, PlacesParams& p) { geometry::visitRegion(fields, p.region); }

inline void visit(Fields& fields, AccuracyParams& p) {
  fields.number("position_error", p.position_error, "m", between(0.0, kMaxLength),
                "accuracy target for the position error. Chooses the fewest points, then the softest membrane, that meet it over "
                "`duration`. Needs `simplification.threshold: auto`; 0 = off");
  fields.list("regions", p.regions,
              "The position_error counts at points that lie in any of these boxes and spheres at rest. None: at all points.");
  fields.require(p.regions.empty() || p.position_error > 0.0, "regions",
                 "found regions without a position_error; accepted: none, or a position_error that counts in them");
  fields.number("step_budget", p.step_budget, "s", between(0.0, 1e6),
                "target for the wall time per step. Chooses the most points that meet it. Runs are then not bit-identical. Needs "
                "`simplification.threshold: auto`; 0 = off");
  fields.require(!(p.position_error > 0.0 && p.step_budget > 0.0), "step_budget",
                 "found beside a position_error; accepted: one of the two");
  fields.flag("estimate", p.estimate,
              "estimate the error in every step, with coarser copies of the simulation. Trials for a position_error always "
              "estimate it");
  fields.flag("remember", p.remember,
              "keep what a position_error has chosen in a folder (docs/accuracy_control.md), so that the next run of the same "
              "scene needs no trials. It chooses the same");
  fields.number(
      "patience", p.patience, "s", between(0.0, 1e9),
      "how long the node waits for the trials of a position_error. After this wall time the surface begins with as many "
      "points as without a target, and the trials go on in the background. With `input.policy: replace` another cloud ends the "
      "wait. With a simulated clock, in a pause and with `input.lockstep` the node waits to their end");
}

/// Why an accuracy target cannot choose the number of simulation points: the keys that state it, and the remedy. Empty if it can.
inline std::string describeStatedNumber(const cloud::SimplificationParams& how) {
  std::string keys, values;
  const auto add = [&](const std::string& key, const std::string& found, const std::string& free) {
    keys += (keys.empty() ? "" : ", ") + ("simplification." + key) + " " + found;
    values += " --set simplification." + key + "=" + free;
  };
  if (how.method != cloud::SimplificationMethod::kDelaunay) add("method", "none", "delaunay");
  if (how.target_points != 0) add("target_points", std::to_string(how.target_points), "0");
  if (!how.threshold.is_auto) add("threshold", formatReal(how.threshold.value), "auto");
  if (keys.empty()) return "";
  return "found an accuracy target beside " + keys +
         ", which states the number of simulation points; accepted: one of the two; leave out what states it, or give" + values;
}

inline void visit(Fields& fields, PinParams& p) {
  geometry::visitRegion(fields, p.region);
  fields.flag("orientation", p.orientation,
              "oriented particles: also constrain the tangent plane. On a mass-spring surface a pin of one row of points is a "
              "hinge. A wider pin clamps up to the boundary of its region; free points closer to that boundary than 0.35 "
              "spacings move with the pin");
  tool::visitPath(fields, p.path,
                  "Poses of a frame that moves the points rigidly, relative to its pose at time 0. Interpolated between the "
                  "times, constant outside. None: the points are fixed.");
  const bool turns = std::any_of(p.path.begin(), p.path.end(), [&](const tool::WaypointParams& waypoint) {
    return waypoint.orientation != p.path.front().orientation;
  });
  fields.require(!p.orientation || !turns, "orientation",
                 "found true with a path that turns; accepted: false, or a path with one orientation");
}

inline void visit(Fields& fields, CreaseParams& p) { geometry::visitRegion(fields, p.region); }

inline void visit(Fields& fields, MaterialChangeParams& p) {
  fields.number("young_modulus", p.young_modulus, "Pa", between(1e-6, 1e15), "`auto` = the value of `material`");
  fields.number("bending_rigidity", p.bending_rigidity, "N m", between(1e-20, 1e20),
                "`auto` = the value of `material`; if `material.bending_rigidity` is `auto`, it follows young_modulus. Poisson's "
                "ratio of bending is always that of the whole surface");
  fields.number("density", p.density, "kg/m^3", between(1e-6, 1e9), "`auto` = the value of `material`");
  fields.require(!p.isEmpty(), "", "found none of young_modulus, bending_rigidity, density; accepted: at least one");
}

inline void visit(Fields& fields, RegionParams& p) {
  geometry::visitRegion(fields, p.region);
  visit(fields, p.material);
}

inline void visit(Fields& fields, AnchorParams& p) {
  fields.required().vector("point", p.point, "m", between(-kMaxLength, kMaxLength),
                           "place on the surface at rest. The spring acts on the nearest simulation point; for mass_spring this "
                           "is the nearest point of the cloud");
  fields.required().vector("target", p.target, "m", between(-kMaxLength, kMaxLength), "fixed end of the spring");
  fields.required().number("stiffness", p.stiffness, "N/m", between(0.0, 1e15), "force = stiffness * (target - position)");
}

inline void visit(Fields& fields, ForceParams& p) {
  fields.required().text("id", p.id, "unique name, not empty");
  fields.require(!p.id.empty(), "id", "found empty text; accepted: a name");
  fields.required().vector("point", p.point, "m", between(-kMaxLength, kMaxLength),
                           "centre of the force; the points within radius share the force");
  fields.required().vector("force", p.force, "N", between(-1e12, 1e12), "total force");
  fields.number("radius", p.radius, "m", between(0.0, kMaxLength),
                "0 = the nearest simulation point; for mass_spring this is the nearest point of the cloud at rest");
  fields.number("start", p.start, "s", anyFinite(), "active in the steps that begin at start <= t < end");
  fields.number("end", p.end, "s", anyFinite(), "end of the active time; the default never ends");
  fields.require(p.start < p.end, "end",
                 "found " + formatReal(p.end) + ", which is not after start, " + formatReal(p.start) + "; accepted: start < end");
}

inline void visit(Fields& fields, WrenchParams& p) {
  fields.number("radius", p.radius, "m", between(0.0, kMaxLength),
                "the points within this radius share the force; 0 = the nearest simulation point");
  fields.number("timeout", p.timeout, "s", between(1e-3, 1e9), "the force ends this long after the last message");
}

inline void visit(Fields& fields, OutputParams& p) {
  fields.choice("stamp", p.stamp, {{"clock", OutputStamp::kClock}, {"simulation", OutputStamp::kSimulation}},
                "header stamps of the node: `clock` = ROS time of the state; `simulation` = the cloud's stamp plus simulation "
                "time. The latter falls behind the clock with every pause and jumps back at `~reset`");
  fields.flag("normals", p.normals, "compute normals of the full cloud");
  fields.flag("resample", p.resample, "insert points where the surface is stretched");
  fields.flag("error", p.error,
              "estimate the position error of each point, as the field `error` (m) of clouds (docs/accuracy_control.md); needs "
              "accuracy.estimate");
  fields.number("publish_rate", p.publish_rate, "Hz", between(1e-3, 1e4), "the node: largest rate of clouds and markers");
  fields.number("contacts_rate", p.contacts_rate, "Hz", between(0.0, 1e4),
                "the node: largest rate of `~contacts`; 0 = after every step");
  fields.integer("pieces_per_edge", p.pieces_per_edge, "", between(1, 8),
                 "each triangle of `~markers` between oriented particles is drawn as a cubic patch of the square of so many "
                 "triangles; 1 = flat");
}

/// The names in a text, separated by spaces or commas.
inline std::vector<std::string> splitNames(const std::string& text) {
  std::vector<std::string> names(1);
  for (const char c : text) {
    if (c != ' ' && c != ',') {
      names.back() += c;
    } else if (!names.back().empty()) {
      names.emplace_back();
    }
  }
  if (names.back().empty()) names.pop_back();
  return names;
}

inline void visit(Fields& fields, InputParams& p) {
  fields.choice("policy", p.policy,
                {{"ignore", InputPolicy::kIgnore}, {"replace", InputPolicy::kReplace}, {"track", InputPolicy::kTrack}},
                "a cloud that arrives while a surface is running: `replace` = new surface; `ignore`; `track` = pull the surface "
                "towards the cloud (docs/run_time_control.md)");
  fields.integer("max_points", p.max_points, "", between(3, kMaxPoints), "larger clouds are refused");
  fields.section("filter", p.filter,
                 "Filters of the input cloud, applied in this order in the surface's frame (docs/camera_clouds.md). Removed "
                 "points become NaN.");
  fields.integer("largest_parts", p.largest_parts, "", between(0, kMaxPoints),
                 "number of the largest connected parts that are kept; 0 = all. Points of the other parts (outliers, loose "
                 "pieces) become NaN");
  fields.number("noise", p.noise, "m", between(0.0, kMaxLength),
                "standard deviation of the sensor noise along the line of sight, at the median depth; `auto` = measured; 0 = "
                "none. Neighbours are searched on the surface without noise. Outputs keep the noise (docs/geodesics.md)");
  fields.number("min_gap", p.min_gap, "m", between(0.0, kMaxLength),
                "of the nearest Euclidean neighbours, those closer than this count as geodesic neighbours, even across a gap");
  fields.choice(
      "unconstrained_parts", p.unconstrained_parts,
      {{"keep", UnconstrainedParts::kKeep}, {"freeze", UnconstrainedParts::kFreeze}, {"drop", UnconstrainedParts::kDrop}},
      "connected parts that no pin, anchor or tool holds at time 0 (docs/run_time_control.md): `keep` = they move, "
      "with a message; `freeze` = they are pinned; `drop` = their points become NaN");
  fields.number("tracking_gain", p.tracking_gain, "1/s^2", between(1e-6, 1e9),
                "for `track`: force = gain * mass * distance from the cloud's local plane, critically damped");
  fields.number(
      "tracking_distance", p.tracking_distance, "m", between(1e-9, kMaxLength),
      "for `track`: points farther from the cloud count as not visible; `auto` = three spacings of the simulation points");
  fields.number("delay", p.delay, "s", between(0.0, 10.0),
                "the node: steps lag the clock by this time, so that messages and transforms arrive before their step");
  fields.number("tool_timeout", p.tool_timeout, "s", between(0.0, 1e9),
                "time after which a tool from ROS or a robot link is silent: no message for its twist, or no transform of its "
                "frame. It then stops, and its wrench is marked silent; 0 = never");
  fields.text("lockstep", p.lockstep,
              "the node: topics (`force`, `wrench`, `tools`) that drive the steps instead of the clock. A step waits until each "
              "topic has delivered a command stamped after the start of the step (docs/ros.md)");
  const auto isTopic = [](const std::string& name) { return name == "force" || name == "wrench" || name == "tools"; };
  const std::vector<std::string> topics = splitNames(p.lockstep);
  fields.require(std::all_of(topics.begin(), topics.end(), isTopic), "lockstep",
                 "found " + quote(p.lockstep) + "; accepted: names out of force, wrench and tools, or nothing");
}

/// Why a scene's model cannot have this change; empty if it can.
std::string findMaterialProblem(const SceneParams& p, const MaterialChangeParams& change);

inline void visitGravity(Fields& fields, Vec3& gravity) {
  fields.vector("gravity", gravity, "m/s^2", between(-1e6, 1e6), "gravity, in gravity_frame");
}

// Rules of the registered models for a scene (src/simulation/scene_rules.cpp).
void visitModelName(Fields& fields, std::string& model);
void visitModelOptions(Fields& fields, SceneParams& p);
/// Problems of features that the scene asks for and its model does not have.
void requireModel(Fields& fields, const SceneParams& p);

inline void visit(Fields& fields, SceneParams& p) {
  visitModelName(fields, p.model);
  fields.text("frame_id", p.frame_id, "frame of the outputs; empty = the cloud's frame");
  fields.section("cloud", p.cloud, "The cloud of `simulate`. The node subscribes to `~cloud_in` instead.");
  fields.section("material", p.material, "Material in SI units.");
  fields.section("neighbors", p.neighbors, "How neighbours are chosen.");
  fields.section("simplification", p.simplification, "Number of simulation points. All other points follow them.");
  visitModelOptions(fields, p);
  fields.section("transfer", p.transfer, "Interpolation from the simulation points to the full cloud.");
  fields.section("integrator", p.integrator, "Time integration.");
  fields.section("accuracy", p.accuracy, "Accuracy target or step budget; at most one of the two (docs/accuracy_control.md).");
  fields.section("sleep", p.sleep, "Sleeping: regions at rest are not computed (docs/sleep.md).");
  fields.section("contact", p.contact, "Contact of the surface with itself (docs/contact.md).");
  const std::string stated = describeStatedNumber(p.simplification);
  fields.require(stated.empty() || !(p.accuracy.position_error > 0.0 || p.accuracy.step_budget > 0.0), "accuracy", stated);
  visitGravity(fields, p.gravity);
  fields.text("gravity_frame", p.gravity_frame, "frame of `gravity`; empty = frame_id; the node looks other frames up in tf");
  fields.number("viscous_drag", p.viscous_drag, "N s/m^3", between(0.0, 1e9),
                "viscous drag: force per current area and normal velocity, against the motion");
  fields.number("pressure", p.pressure, "Pa", between(-1e12, 1e12), "pressure on the current area, along the outward normal");
  fields.list("pins", p.pins, "Each pin constrains the simulation points whose rest position lies in a closed box or sphere.");
  fields.list("creases", p.creases, "Particles in these regions at rest keep their spacing but have no smoothness forces.");
  fields.list("regions", p.regions, "Regions with another material, by rest position. A later region overrides an earlier one.");
  fields.list("anchors", p.anchors, "Springs between a point of the surface and a fixed target.");
  fields.list("forces", p.forces, "Named forces on the surface near a point.");
  std::set<std::string> ids;
  for (std::size_t i = 0; i < p.forces.size(); ++i) {
    const std::string& id = p.forces[i].id;
    fields.require(id.empty() || ids.insert(id).second, "forces[" + std::to_string(i) + "].id",
                   "found " + quote(id) + " a second time; accepted: a name of its own");
  }
  fields.section("force", p.force, "The force of `~wrench`.");
  fields.list("tools", p.tools, "Rigid tools.");
  fields.section("robot", p.robot, "Links of a robot as tools (docs/tools.md).");
  ids.clear();
  for (std::size_t i = 0; i < p.tools.size(); ++i) {
    const std::string& id = p.tools[i].id;
    fields.require(id.empty() || ids.insert(id).second, "tools[" + std::to_string(i) + "].id",
                   "found " + quote(id) + " a second time; accepted: a name of its own");
  }
  fields.number("duration", p.duration, "s", between(1e-9, 1e9), "for `simulate`: simulated time, a multiple of the time step");
  fields.integer("threads", p.threads, "", between(0, 1024),
                 "number of threads; 0 = all cores. Results do not depend on it. Nodelets of one manager have a number each");
  fields.section("output", p.output, "Published clouds.");
  fields.section("input", p.input, "Input clouds.");
  fields.text("save_directory", p.save_directory, "directory for `~save`; empty = `~save` is off");
  requireModel(fields, p);
  fields.flag("diagnostics", p.diagnostics, "publish `/diagnostics`");
  std::vector<NamedBounds> bounds;
  for (const ExpectParams& expect : p.expect) bounds.push_back({expect.quantity, expect.min, expect.max});
  fields.bounds("expect", bounds, expectQuantities(), "bounds that a test checks after the run");
  p.expect.clear();
  for (const NamedBounds& bound : bounds) p.expect.push_back({bound.name, bound.min, bound.max});
}

}  // namespace deformable_surface::simulation
