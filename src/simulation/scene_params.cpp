// The schema of a scene: what its structs are read, printed and checked by.
#include "deformable_surface/simulation/scene_params.h"

#include "deformable_surface/simulation/statistics.h"

#include <algorithm>
#include <limits>
#include <set>
#include <type_traits>

#include "quantities.h"

namespace deformable_surface::simulation {
namespace {

// Why an accuracy target cannot choose the number of simulation points: the keys that state it, and the remedy. Empty if it can.
std::string describeStatedNumber(const cloud::SimplificationParams& how) {
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

}  // namespace

bool isInTarget(const AccuracyParams& params, const Vec3& rest) {
  const auto holds = [&](const PlacesParams& places) { return places.region.contains(rest); };
  return params.regions.empty() || std::any_of(params.regions.begin(), params.regions.end(), holds);
}

std::vector<std::string> expectQuantities() {
  std::vector<std::string> names;
  // A hash is not a quantity, and does not fit a double.
  visitFields(Statistics{}, [&](const std::string& name, const auto& value) {
    if (std::is_arithmetic<std::decay_t<decltype(value)>>::value && name != "state_hash") names.push_back(name);
  });
  for (const Quantity& quantity : quantities()) names.emplace_back(quantity.name);
  return names;
}

void visit(Fields& fields, CloudParams& p) {
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

void visit(Fields& fields, PlacesParams& p) { geometry::visitRegion(fields, p.region); }

void visit(Fields& fields, AccuracyParams& p) {
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

void visit(Fields& fields, PinParams& p) {
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

void visit(Fields& fields, CreaseParams& p) { geometry::visitRegion(fields, p.region); }

void visit(Fields& fields, MaterialChangeParams& p) {
  fields.number("young_modulus", p.young_modulus, "Pa", between(1e-6, 1e15), "`auto` = the value of `material`");
  fields.number("bending_rigidity", p.bending_rigidity, "N m", between(1e-20, 1e20),
                "`auto` = the value of `material`; if `material.bending_rigidity` is `auto`, it follows young_modulus. Poisson's "
                "ratio of bending is always that of the whole surface");
  fields.number("density", p.density, "kg/m^3", between(1e-6, 1e9), "`auto` = the value of `material`");
  fields.require(!p.isEmpty(), "", "found none of young_modulus, bending_rigidity, density; accepted: at least one");
}

void visit(Fields& fields, RegionParams& p) {
  geometry::visitRegion(fields, p.region);
  visit(fields, p.material);
}

void visit(Fields& fields, AnchorParams& p) {
  fields.required().vector("point", p.point, "m", between(-kMaxLength, kMaxLength),
                           "place on the surface at rest. The spring acts on the nearest simulation point; for mass_spring this "
                           "is the nearest point of the cloud");
  fields.required().vector("target", p.target, "m", between(-kMaxLength, kMaxLength), "fixed end of the spring");
  fields.required().number("stiffness", p.stiffness, "N/m", between(0.0, 1e15), "force = stiffness * (target - position)");
}

void visit(Fields& fields, ForceParams& p) {
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

void visit(Fields& fields, WrenchParams& p) {
  fields.number("radius", p.radius, "m", between(0.0, kMaxLength),
                "the points within this radius share the force; 0 = the nearest simulation point");
  fields.number("timeout", p.timeout, "s", between(1e-3, 1e9), "the force ends this long after the last message");
}

void visit(Fields& fields, OutputParams& p) {
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

std::vector<std::string> splitNames(const std::string& text) {
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

void visit(Fields& fields, InputParams& p) {
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

void visitGravity(Fields& fields, Vec3& gravity) {
  fields.vector("gravity", gravity, "m/s^2", between(-1e6, 1e6), "gravity, in gravity_frame");
}

void visit(Fields& fields, SceneParams& p) {
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
