#include "interface_page.h"

#include "deformable_surface/ContactArray.h"
#include "deformable_surface/DeformedUpdate.h"
#include "deformable_surface/EditParticles.h"
#include "deformable_surface/FitSurface.h"
#include "deformable_surface/GrowSurface.h"
#include "deformable_surface/List.h"
#include "deformable_surface/PointForce.h"
#include "deformable_surface/Restore.h"
#include "deformable_surface/RolloutFeedback.h"
#include "deformable_surface/RolloutGoal.h"
#include "deformable_surface/RolloutResult.h"
#include "deformable_surface/SaveCloud.h"
#include "deformable_surface/SelectRegion.h"
#include "deformable_surface/SetMaterial.h"
#include "deformable_surface/Snapshot.h"
#include "deformable_surface/Statistics.h"
#include "deformable_surface/Step.h"
#include "deformable_surface/ToolArray.h"
#include "deformable_surface/ToolStatusArray.h"
#include "deformable_surface/ToolWrenchArray.h"

#include <ros/message_traits.h>

#include <map>
#include <utility>

namespace deformable_surface::node {
namespace {

using Kind = InterfaceKind;

// Definitions of the types that a message uses follow its own after such a line.
constexpr char kRule[] = "================";

using Definitions = std::vector<Definition>;

std::string trimEnd(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

/// The message file, followed by the files of this package that it uses.
template <class Message>
Definitions define() {
  const std::string ours = "MSG: deformable_surface/";
  Definitions definitions;
  std::string rest = ros::message_traits::Definition<Message>::value();
  while (!rest.empty()) {
    const std::size_t rule = rest.find(kRule);
    const std::string part = rest.substr(0, rule);
    rest = rule == std::string::npos ? "" : rest.substr(rest.find('\n', rule) + 1);
    if (definitions.empty()) {
      definitions.push_back({"", trimEnd(part)});
    } else if (part.compare(0, ours.size(), ours) == 0) {
      const std::size_t line = part.find('\n');
      definitions.push_back({part.substr(ours.size(), line - ours.size()), trimEnd(part.substr(line + 1))});
    }
  }
  return definitions;
}

/// Joins the parts with the separator of services and actions.
Definitions joinParts(const std::vector<Definitions>& parts) {
  Definitions all;
  for (const Definitions& part : parts)
    for (std::size_t k = 0; k < part.size(); ++k)
      all.push_back({part[k].type, (k == 0 && !all.empty() ? "---\n" : "") + part[k].text});
  return all;
}

template <class Service>
Definitions defineService() {
  return joinParts({define<typename Service::Request>(), define<typename Service::Response>()});
}

std::vector<InterfaceEntry> makeTable() {
  return {
      {Kind::kSubscribed,
       "cloud_in",
       "sensor_msgs/PointCloud2",
       "the surface at rest. Any layout with x, y, z as float32 or float64, organised or not",
       {}},
      {Kind::kSubscribed, "force", "deformable_surface/PointForce",
       "a named force near a point. The same id replaces it, a zero force removes it", define<PointForce>()},
      {Kind::kSubscribed,
       "wrench",
       "geometry_msgs/WrenchStamped",
       "a force at the origin of its frame, shared over `force.radius`. It ends `force.timeout` after the last message. The "
       "torque is not applied",
       {}},
      {Kind::kSubscribed, "tools", "deformable_surface/ToolArray",
       "commands to rigid tools: add, move, delete ([tools](tools.md))", define<ToolArray>()},
      {Kind::kSubscribed, "rollout/goal", "deformable_surface/RolloutActionGoal",
       "action `~rollout`: simulates a copy of the surface with other tools and forces ([run-time "
       "control](run_time_control.md)). Goal, result and feedback",
       joinParts({define<RolloutGoal>(), define<RolloutResult>(), define<RolloutFeedback>()})},
      {Kind::kSubscribed, "rollout/cancel", "actionlib_msgs/GoalID", "cancels a rollout", {}},
      {Kind::kPublished,
       "deformed",
       "sensor_msgs/PointCloud2",
       "the deformed cloud: x y z, normal_x normal_y normal_z, displacement (m), with `output.error` error (m), then the input's "
       "other fields. One point per input point, in the same order. Removed points are NaN. New particles are appended; they "
       "copy "
       "the extra fields of their parent, and their displacement is NaN. Latched. Published on change and to new subscribers",
       {}},
      {Kind::kPublished, "deformed_update", "deformable_surface/DeformedUpdate",
       "incremental version of `~deformed`: only the changed rows. New subscribers get all rows first", define<DeformedUpdate>()},
      {Kind::kPublished,
       "simulation_points",
       "sensor_msgs/PointCloud2",
       "the simulation points: x y z, normal, mass (kg), strain, awake, pinned. Particles also have temperature (K above "
       "ambient) and id. Published on change and to new subscribers",
       {}},
      {Kind::kPublished,
       "markers",
       "visualization_msgs/MarkerArray",
       "markers for RViz ([rviz](rviz.md)). Every message contains all markers. Latched. Published on change, once a second, and "
       "to new subscribers",
       {}},
      {Kind::kPublished, "statistics", "deformable_surface/Statistics",
       "state and cost of the last step, at `output.publish_rate`, and at most about ten times a second while everything rests. "
       "In "
       "a pause it comes after steps, resets and other changes only",
       define<Statistics>()},
      {Kind::kPublished, "tool_wrenches", "deformable_surface/ToolWrenchArray",
       "contact wrenches of tools and pins, after every step. `~tools/<id>/wrench` is a geometry_msgs/WrenchStamped of one tool",
       define<ToolWrenchArray>()},
      {Kind::kPublished, "contacts", "deformable_surface/ContactArray",
       "single contacts with tools and of the surface with itself, at most `output.contacts_rate` times a second",
       define<ContactArray>()},
      {Kind::kPublished, "tool_status", "deformable_surface/ToolStatusArray",
       "result of the last command to each tool: waiting, accepted or refused, with the reason. Latched",
       define<ToolStatusArray>()},
      {Kind::kPublished, "rollout/feedback", "deformable_surface/RolloutActionFeedback", "progress of a rollout", {}},
      {Kind::kPublished, "rollout/result", "deformable_surface/RolloutActionResult", "result of a rollout", {}},
      {Kind::kPublished, "rollout/status", "actionlib_msgs/GoalStatusArray", "status of all goals", {}},
      {Kind::kPublished,
       "parameter_descriptions",
       "dynamic_reconfigure/ConfigDescription",
       "the parameters that can change at run time, for rqt_reconfigure. Latched",
       {}},
      {Kind::kPublished, "parameter_updates", "dynamic_reconfigure/Config", "their values. Latched", {}},
      {Kind::kPublished,
       "/diagnostics",
       "diagnostic_msgs/DiagnosticArray",
       "rate, real-time factor, dropped input, last warning. `diagnostics: false` turns it off",
       {}},
      {Kind::kService,
       "reset",
       "std_srvs/Trigger",
       "returns to the rest state of the last cloud, at time 0. Pins, tools and forces of the scene stay. Those that came over "
       "ROS are deleted",
       {}},
      {Kind::kService,
       "pause",
       "std_srvs/SetBool",
       "true: stop stepping. false: continue. The time between is not caught up",
       {}},
      {Kind::kService, "step", "deformable_surface/Step", "takes steps while paused", defineService<Step>()},
      {Kind::kService, "pin", "deformable_surface/SelectRegion", "constrains the points inside a shape",
       defineService<SelectRegion>()},
      {Kind::kService, "unpin", "deformable_surface/SelectRegion", "releases the points inside a shape", {}},
      {Kind::kService, "save", "deformable_surface/SaveCloud", "writes the current surface to a file",
       defineService<SaveCloud>()},
      {Kind::kService, "edit", "deformable_surface/EditParticles", "changes single oriented particles",
       defineService<EditParticles>()},
      {Kind::kService, "grow_surface", "deformable_surface/GrowSurface",
       "grows a surface through the existing oriented particles", defineService<GrowSurface>()},
      {Kind::kService, "fit", "deformable_surface/FitSurface", "old name of `~grow_surface`", defineService<FitSurface>()},
      {Kind::kService, "snapshot", "deformable_surface/Snapshot", "stores the state under a name", defineService<Snapshot>()},
      {Kind::kService, "restore", "deformable_surface/Restore", "restores a stored state", defineService<Restore>()},
      {Kind::kService, "list", "deformable_surface/List", "lists tools, forces, pins, materials and snapshots",
       defineService<List>()},
      {Kind::kService, "set_material", "deformable_surface/SetMaterial",
       "changes the material of a region or of the whole surface", defineService<SetMaterial>()},
      {Kind::kService,
       "set_parameters",
       "dynamic_reconfigure/Reconfigure",
       "changes parameters at run time. A refused value changes nothing",
       {}},
  };
}  // namespace

std::string nameOf(const InterfaceEntry& entry) { return entry.name[0] == '/' ? entry.name : "~" + entry.name; }

/// Message types of topics, with the topic's name.
std::map<std::string, std::string> findOwners() {
  const std::string ours = "deformable_surface/";
  std::map<std::string, std::string> owners;
  for (const InterfaceEntry& entry : interfaceTable())
    if (entry.kind != Kind::kService && !entry.definitions.empty() && entry.type.compare(0, ours.size(), ours) == 0)
      owners[entry.type.substr(ours.size())] = nameOf(entry);
  return owners;
}

/// Prints every type once on the page. printed: where each is, or will be.
std::string printDefinitions(const InterfaceEntry& entry, std::map<std::string, std::string>& printed) {
  std::string text, elsewhere;
  for (const Definition& part : entry.definitions) {
    if (!part.type.empty() && !printed.emplace(part.type, nameOf(entry)).second) {
      const std::string line = "# " + part.type + ": see " + printed[part.type] + "\n";
      if (printed[part.type] != nameOf(entry) && elsewhere.find(line) == std::string::npos) elsewhere += line;
      continue;
    }
    text += (part.type.empty() ? "" : "\n# " + part.type + "\n") + part.text + "\n";
  }
  return text + (elsewhere.empty() ? "" : "\n" + elsewhere);
}

}  // namespace

const std::vector<InterfaceEntry>& interfaceTable() {
  static const std::vector<InterfaceEntry> table = makeTable();
  return table;
}

std::string interfacePage() {
  std::string page =
      "# Topics and services\n\n"
      "Interface of `deformable_surface_node` and its nodelet. Printed by `rosrun deformable_surface interface_page`; a test "
      "compares the two.\n\n"
      "All names are private to the node, so several surfaces can run side by side. "
      "Parameters: [parameters.md](parameters.md).\n";
  const std::pair<Kind, const char*> parts[] = {
      {Kind::kSubscribed, "Subscribed"}, {Kind::kPublished, "Published"}, {Kind::kService, "Services"}};
  std::map<std::string, std::string> printed = findOwners();
  for (const auto& [kind, title] : parts) {
    page += "\n## " + std::string(title) + "\n";
    for (const InterfaceEntry& entry : interfaceTable()) {
      if (entry.kind != kind) continue;
      page += "\n### " + nameOf(entry) + "\n\n`" + entry.type + "`: " + entry.meaning + ".\n";
      if (!entry.definitions.empty()) page += "\n```\n" + printDefinitions(entry, printed) + "```\n";
    }
  }
  return page;
}

std::string interfaceHelp() {
  std::string help;
  const std::pair<Kind, const char*> parts[] = {
      {Kind::kSubscribed, "Subscribed:"}, {Kind::kPublished, "Published: "}, {Kind::kService, "Services:  "}};
  for (const auto& [kind, title] : parts) {
    std::string lead = title;
    for (const InterfaceEntry& entry : interfaceTable()) {
      if (entry.kind != kind) continue;
      help += lead + " " + nameOf(entry) + " (" + entry.type + ")\n";
      lead.assign(lead.size(), ' ');
    }
  }
  return help;
}

}  // namespace deformable_surface::node
