#include "command_checks.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

#include <algorithm>

#include "dynamics.h"

namespace deformable_surface::simulation {
namespace {

constexpr double kMaxSpeed = 1e8;  // m/s that a given state may have: a third of that of light is no surface's

bool isWithin(const Vec3& v, double largest) { return (v.array().abs() <= largest).all(); }

void refuse(std::vector<std::string> problems, const std::string& prefix = "") {
  for (std::string& problem : problems) problem = prefix + problem;
  if (!problems.empty()) throw InputError(std::move(problems));
}

// The first value that differs: "integrator.time_step: found 0.01 instead of 0.02". Empty: none does.
std::string findDifference(const std::string& key, const Value& before, const Value& given) {
  const Value::Map *const members = given.asMap(), *const members_before = before.asMap();
  if (members && members_before && members->size() == members_before->size()) {
    for (const auto& [name, value] : *members) {
      const Value* const other = before.find(name);
      const std::string path = key.empty() ? name : key + "." + name;
      const std::string found = other ? findDifference(path, *other, value) : path + ": found a value where there was none";
      if (!found.empty()) return found;
    }
    return "";
  }
  const Value::List *const items = given.asList(), *const items_before = before.asList();
  if (items && items_before && items->size() == items_before->size()) {
    for (std::size_t i = 0; i < items->size(); ++i) {
      const std::string found = findDifference(key + "[" + std::to_string(i) + "]", (*items_before)[i], (*items)[i]);
      if (!found.empty()) return found;
    }
    return "";
  }
  if (toYaml(before) == toYaml(given)) return "";
  const std::string what = given.describe(), what_before = before.describe();
  return key + ": found " + (what == what_before ? "another value" : what + " instead of " + what_before);
}

// Gravity and a region alone, as a scene has them.
struct Gravity {
  Vec3 value;
};
void visit(Fields& fields, Gravity& gravity) { visitGravity(fields, gravity.value); }

struct Shape {
  geometry::Region region;
};
void visit(Fields& fields, Shape& shape) { geometry::visitRegion(fields, shape.region); }

void requirePath(const std::string& whose, const std::vector<tool::WaypointParams>& path) {
  const std::string problem = tool::findProblem(path);
  if (!problem.empty()) throw InputError(whose + " " + problem);
}

void requireParticles(const Dynamics& dynamics) {
  if (!dynamics.kind().traits().has_population)
    throw InputError("model: found one that has no particles to edit or to grow; accepted: " +
                     listModels(&ModelTraits::has_population));
}

void checkCommand(const command::RemoveForce&, const Dynamics&) {}
void checkCommand(const command::RemoveTool&, const Dynamics&) {}
void checkCommand(const command::Pin& c, const Dynamics&) { refuse(checkParams(Shape{c.region}), "region "); }
void checkCommand(const command::Unpin& c, const Dynamics&) { refuse(checkParams(Shape{c.region}), "region "); }
void checkCommand(const command::EditParticles&, const Dynamics& dynamics) { requireParticles(dynamics); }

// The same checks as for the forces of a scene.
void checkCommand(const command::SetForce& c, const Dynamics&) {
  refuse(checkParams(c.force), "force " + quote(c.force.id) + " ");
}

void checkCommand(const command::SetTool& c, const Dynamics& dynamics) {
  std::vector<std::string> problems = checkParams(c.tool);
  for (const ToolProblem& problem : findToolProblems(dynamics.params().model, c.tool))
    problems.push_back(problem.field + ": " + problem.sentence);
  refuse(std::move(problems), "tool " + quote(c.tool.id) + " ");
  dynamics.requireTools({c.tool});
}

void checkCommand(const command::MoveTool& c, const Dynamics& dynamics) {
  requirePath("tool " + quote(c.id), c.path);
  const auto& tools = dynamics.tools();
  if (std::none_of(tools.begin(), tools.end(), [&](const tool::ToolParams& t) { return t.id == c.id; }))
    throw InputError("tool " + quote(c.id) + ": there is none; accepted: one of those there are");
}

void checkCommand(const command::PinAlong& c, const Dynamics& dynamics) {
  refuse(checkParams(Shape{c.region}), "pin " + quote(c.id) + " ");
  requirePath("pin " + quote(c.id), c.path);
  if (dynamics.grips().findPin(c.id))
    throw InputError("pin " + quote(c.id) + ": there is one already; accepted: a name of its own");
}

void checkCommand(const command::MovePin& c, const Dynamics& dynamics) {
  requirePath("pin " + quote(c.id), c.path);
  if (!dynamics.grips().findPin(c.id))
    throw InputError("pin " + quote(c.id) + ": there is none; accepted: one of those there are");
}

void checkCommand(const command::SetGravity& c, const Dynamics&) { refuse(checkParams(Gravity{c.gravity})); }

// Why the material of a running surface cannot change so; empty if it can.
std::string findChangeProblem(const SceneParams& now, const MaterialChangeParams& change) {
  if (findModel(now.model).traits().has_regions) return findMaterialProblem(now, change);
  const char* const name = !change.young_modulus.is_auto      ? "young_modulus"
                           : !change.bending_rigidity.is_auto ? "bending_rigidity"
                                                              : "density";
  return std::string(name) + ": found a change, but of the material of " + now.model +
         " only the damping changes while a surface runs; accepted: changes of damping, or model: " +
         listModels(&ModelTraits::has_regions);
}

void checkCommand(const command::SetMaterial& c, const Dynamics& dynamics) {
  std::vector<std::string> problems = checkParams(c.change);
  if (c.region)
    for (const std::string& problem : checkParams(Shape{*c.region})) problems.push_back("region " + problem);
  const std::string problem = findChangeProblem(dynamics.params(), c.change);
  if (!problem.empty()) problems.push_back(problem);
  refuse(std::move(problems));
}

void checkCommand(const command::SetDamping& c, const Dynamics&) {
  model::MaterialParams checked;
  checked.damping = c.damping;
  refuse(checkParams(checked));
}

void checkCommand(const command::SetParams& c, const Dynamics& dynamics) {
  refuse(checkParams(c.params));
  const SceneParams& now = dynamics.params();
  const std::string changed = findDifference("", printParams(withRunTimeValues(now, c.params)), printParams(c.params));
  if (!changed.empty()) {
    std::string keys;
    for (const std::string& key : runTimeKeys()) keys += (keys.empty() ? "" : ", ") + key;
    throw InputError(changed + ", which cannot change while a surface runs; accepted: other values of " + keys);
  }
  if (c.params.material.young_modulus == now.material.young_modulus) return;
  MaterialChangeParams stiffness;
  stiffness.young_modulus = c.params.material.young_modulus;
  const std::string problem = findChangeProblem(now, stiffness);
  if (!problem.empty()) throw InputError("material." + problem);
}

void checkCommand(const command::Observe& c, const Dynamics& dynamics) {
  if (!c.cloud) throw InputError("cloud: found none; accepted: a cloud that was prepared");
  if (!dynamics.kind().traits().is_surface)
    throw InputError("model: found " + dynamics.params().model +
                     ", which has no sides that a cloud could show; accepted: a surface");
}

void checkCommand(const command::SetState& c, const Dynamics& dynamics) {
  const model::State &state = c.state, &now = dynamics.state();
  const std::size_t n = now.positions.size();
  if (state.positions.size() != n || state.velocities.size() != n)
    throw InputError("state: found " + std::to_string(state.positions.size()) + " positions and " +
                     std::to_string(state.velocities.size()) + " velocities; accepted: " + std::to_string(n) + " of each");
  if (!state.plastic.empty() && state.plastic.size() != now.plastic.size())
    throw InputError("state: found " + std::to_string(state.plastic.size()) +
                     " rest states of flow; accepted: none, or, of a solid that "
                     "flows, one a simulation point");
  for (const Mat3& plastic : state.plastic)
    if (!(plastic.determinant() > 0.0) || !plastic.allFinite() || !(state.dissipated >= 0.0))
      throw InputError(
          "state: found a rest state of flow that turns matter inside out or is not finite, or dissipated energy below 0; "
          "accepted: what this solid came to");
  for (std::size_t i = 0; i < n; ++i) {
    const std::string point = "state of simulation point " + std::to_string(i) + ": ";
    if (!isWithin(state.positions[i], kMaxLength))
      throw InputError(point + "found a coordinate that is not finite or too large; accepted: up to " + formatReal(kMaxLength) +
                       " m");
    if (!isWithin(state.velocities[i], kMaxSpeed))
      throw InputError(point + "found a velocity that is not finite or too large; accepted: up to " + formatReal(kMaxSpeed) +
                       " m/s");
    if (dynamics.pinned()[i] && !dynamics.grips().isOnPin(static_cast<Index>(i)) && !state.velocities[i].isZero(0.0))
      throw InputError(point + "found a velocity though it is pinned; accepted: zero");
  }
}

void checkCommand(const command::GrowSurface& c, const Dynamics& dynamics) {
  requireParticles(dynamics);
  refuse(checkParams(c.growth));
}

}  // namespace

void check(const Command& command, const Dynamics& dynamics) {
  std::visit([&](const auto& c) { checkCommand(c, dynamics); }, command);
}

}  // namespace deformable_surface::simulation
