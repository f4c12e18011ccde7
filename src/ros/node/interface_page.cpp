#include "interface_page.h"

#include "deformable_surface/DeformedUpdate.h"
#include "deformable_surface/EditParticles.h"
#include "deformable_surface/FitSurface.h"
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

// Definitions of the types that a message is made of follow its own behind such a line.
constexpr char kRule[] = "================";

using Definitions = std::vector<Definition>;

std::string trimEnd(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

/// The message file, with the files of this package that it uses behind it.
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

/// One behind the other, with the line between them that services and actions have.
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
      {Kind::kSubscribed, "cloud_in", "sensor_msgs/PointCloud2",
       "the surface at rest: any layout with x, y, z as float32 or float64, organised or not", {}},
      {Kind::kSubscribed, "force", "deformable_surface/PointForce",
       "a named force near a point; the same id replaces it, a zero force removes it", define<PointForce>()},
      {Kind::kSubscribed, "wrench", "geometry_msgs/WrenchStamped",
       "its force acts at the origin of its frame over `force.radius`, and ends `force.timeout` after the last message; its "
       "torque is not applied",
       {}},
      {Kind::kSubscribed, "tools", "deformable_surface/ToolArray",
       "rigid tools that push, draw, carry, cut, heat or erase: add, move, delete ([tools](tools.md))", define<ToolArray>()},
      {Kind::kSubscribed, "rollout/goal", "deformable_surface/RolloutActionGoal",
       "the action `~rollout`: what becomes of the surface with other tools and forces, on a copy ([run-time "
       "control](run_time_control.md)). Below: goal, result and feedback",
       joinParts({define<RolloutGoal>(), define<RolloutResult>(), define<RolloutFeedback>()})},
      {Kind::kSubscribed, "rollout/cancel", "actionlib_msgs/GoalID", "of the same action", {}},
      {Kind::kPublished, "deformed", "sensor_msgs/PointCloud2",
       "latched; every input point in its order: x y z, normal_x normal_y normal_z, displacement (m), then the input's other "
       "fields; what is gone is NaN, what was born comes behind; sent when it has changed, and for who comes new",
       {}},
      {Kind::kPublished, "deformed_update", "deformable_surface/DeformedUpdate",
       "the same in less: only the rows that have changed; sent when any has, whole for who comes new", define<DeformedUpdate>()},
      {Kind::kPublished, "simulation_points", "sensor_msgs/PointCloud2",
       "the points that move by physics: x y z, normal, mass (kg), strain, awake, pinned, and of particles temperature (K above "
       "ambient) and id; sent when anything has changed, and for who comes new",
       {}},
      {Kind::kPublished, "markers", "visualization_msgs/MarkerArray",
       "latched; for RViz ([rviz](rviz.md)): all of them in every message; sent when anything has changed, once a second, and "
       "for who comes new",
       {}},
      {Kind::kPublished, "statistics", "deformable_surface/Statistics", "what the last step did and cost", define<Statistics>()},
      {Kind::kPublished, "tool_wrenches", "deformable_surface/ToolWrenchArray",
       "after every step: what the surface does to each tool; `~tools/<id>/wrench`, a geometry_msgs/WrenchStamped, has it of one",
       define<ToolWrenchArray>()},
      {Kind::kPublished, "tool_status", "deformable_surface/ToolStatusArray",
       "latched; what became of the last command to each tool: it waits, was accepted or was refused, and why",
       define<ToolStatusArray>()},
      {Kind::kPublished, "rollout/feedback", "deformable_surface/RolloutActionFeedback", "how far a rollout is", {}},
      {Kind::kPublished, "rollout/result", "deformable_surface/RolloutActionResult", "what became of it", {}},
      {Kind::kPublished, "rollout/status", "actionlib_msgs/GoalStatusArray", "of all goals", {}},
      {Kind::kPublished, "parameter_descriptions", "dynamic_reconfigure/ConfigDescription",
       "latched; the parameters that may change while the node runs, for rqt_reconfigure", {}},
      {Kind::kPublished, "parameter_updates", "dynamic_reconfigure/Config", "latched; their values", {}},
      {Kind::kPublished, "/diagnostics", "diagnostic_msgs/DiagnosticArray",
       "rate, real-time factor, dropped input, last complaint; `diagnostics: false` turns it off", {}},
      {Kind::kService, "reset", "std_srvs/Trigger",
       "back to the rest state of the last cloud at time 0; pins, tools and forces of the scene stay, those that came over ROS "
       "go",
       {}},
      {Kind::kService, "pause", "std_srvs/SetBool", "true stops stepping, false goes on; nothing is caught up", {}},
      {Kind::kService, "step", "deformable_surface/Step", "takes steps while paused", defineService<Step>()},
      {Kind::kService, "pin", "deformable_surface/SelectRegion", "holds the points inside a shape where they are",
       defineService<SelectRegion>()},
      {Kind::kService, "unpin", "deformable_surface/SelectRegion", "lets go of the points inside a shape", {}},
      {Kind::kService, "save", "deformable_surface/SaveCloud", "writes the surface as it is now to a file",
       defineService<SaveCloud>()},
      {Kind::kService, "edit", "deformable_surface/EditParticles", "changes single oriented particles",
       defineService<EditParticles>()},
      {Kind::kService, "fit", "deformable_surface/FitSurface", "grows a surface through the oriented particles there are",
       defineService<FitSurface>()},
      {Kind::kService, "snapshot", "deformable_surface/Snapshot", "keeps the state under a name", defineService<Snapshot>()},
      {Kind::kService, "restore", "deformable_surface/Restore", "goes back to a state that was kept", defineService<Restore>()},
      {Kind::kService, "list", "deformable_surface/List", "the tools, forces, pins, regions and snapshots there are",
       defineService<List>()},
      {Kind::kService, "set_material", "deformable_surface/SetMaterial",
       "gives a region, or everything, other values of its material", defineService<SetMaterial>()},
      {Kind::kService, "set_parameters", "dynamic_reconfigure/Reconfigure",
       "changes parameters while the node runs; what is refused stays as it was", {}},
  };
}

std::string nameOf(const InterfaceEntry& entry) { return entry.name[0] == '/' ? entry.name : "~" + entry.name; }

/// Message types that are those of a topic, and its name.
std::map<std::string, std::string> findOwners() {
  const std::string ours = "deformable_surface/";
  std::map<std::string, std::string> owners;
  for (const InterfaceEntry& entry : interfaceTable())
    if (entry.kind != Kind::kService && !entry.definitions.empty() && entry.type.compare(0, ours.size(), ours) == 0)
      owners[entry.type.substr(ours.size())] = nameOf(entry);
  return owners;
}

/// Every type once on the page. printed: where each stands, or will stand.
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
      "Of `deformable_surface_node` and its nodelet. This page is printed by `rosrun deformable_surface interface_page`; a test "
      "fails when it is stale.\nNames are private to the node, so that several surfaces run side by side; their parameters are "
      "in [parameters.md](parameters.md).\n";
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
