// The menus of the handles and their actions: calls of the surface's services, and adding and deleting tools.
#include "marker_server.h"

#include "deformable_surface/EditParticles.h"
#include "deformable_surface/GrowSurface.h"
#include "deformable_surface/SelectRegion.h"
#include "deformable_surface/Step.h"
#include "deformable_surface/ToolArray.h"
#include "deformable_surface/simulation/model_kind.h"
#include "deformable_surface/tool/tool_modes.h"

#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <random>
#include <tuple>

namespace deformable_surface::node {
namespace {

using shape_msgs::SolidPrimitive;

// Sizes as shares of the surface's extent.
constexpr double kToolShare = 0.1, kBladeShare = 0.02;
constexpr double kLarger = 1.25;
// A handful of particles in a ball about as large as the second ring of neighbours, above the surface; nearer ones would push
// each other away.
constexpr int kSprayTries = 100;
constexpr double kSprayShare = 2.5, kSprayApart = 0.8;  // spacings
constexpr double kSprayHeight = 1.5;                    // in that reach

}  // namespace

/// Calls a service of the surface and shows the result.
template <class Service>
void MarkerServer::call(const char* name, Service& service) {
  const std::string full = surface_ + "/" + name;
  if (!ros::service::call(full, service)) return showAnswer("no answer from " + full, false);
  showAnswer(service.response.message, service.response.success);
}

void MarkerServer::makeMenus() {
  has_menus_ = true;
  const auto add = [](interactive_markers::MenuHandler& menu, const char* title, auto work) {
    menu.insert(title, [work](const Feedback&) { work(); });
  };
  // RViz shows the marker of a tool that is gone until the next refresh, for which the surface must be there.
  const auto ofTool = [this](auto work) {
    return [this, work](const Feedback& feedback) {
      const auto found = held_.find(feedback->marker_name);
      if (found != held_.end()) work(found->second);
    };
  };
  add(spot_menu_, "Pin here", [this] { pin("pin"); });
  add(spot_menu_, "Unpin here", [this] { pin("unpin"); });
  if (isOfParticles()) {
    add(spot_menu_, "Spray points here", [this] { spray(); });
    add(spot_menu_, "Take away here", [this] { edit(EditParticlesRequest::DELETE, radius()); });
    add(spot_menu_, "Crease here", [this] { edit(EditParticlesRequest::CREASE, radius()); });
  }

  const auto mode_menu = tool_menu_.insert("Mode");
  for (const tool::ModeInfo& info : tool::kModes) {
    // A surface that is not of particles may be of any other model.
    const auto hasIt = [&](const simulation::ModelKind* kind) {
      return kind->traits().has_population != isOfParticles() || kind->useOf(info).is_known;
    };
    const std::vector<const simulation::ModelKind*>& kinds = simulation::modelKinds();
    if (!std::all_of(kinds.begin(), kinds.end(), hasIt)) continue;
    std::string title = info.name;
    title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
    tool_menu_.insert(mode_menu, title, ofTool([this, mode = info.code](HeldTool& held) {
                        held.tool.mode = mode;
                        showTool(held);
                      }));
  }
  hand_menu_.insert("Take hold", ofTool([this](HeldTool& hand) { takeHold(hand); }));
  hand_menu_.insert("Let go", ofTool([this](HeldTool& hand) { letGo(hand); }));
  const auto scale = [&](double factor) {
    return ofTool([this, factor](HeldTool& held) {
      for (double& size : held.tool.primitive.dimensions) size *= factor;
      showTool(held);
    });
  };
  for (interactive_markers::MenuHandler* menu : {&tool_menu_, &hand_menu_}) {
    menu->insert("Larger", scale(kLarger));
    menu->insert("Smaller", scale(1.0 / kLarger));
    menu->insert("Delete", ofTool([this](HeldTool& held) { removeTool(held); }));
  }

  const double size = kToolShare * extent_, blade = kBladeShare * extent_;
  std::vector<std::tuple<const char*, std::uint8_t, SolidPrimitive>> kinds = {
      {"Ball", Tool::SOLID, makePrimitive(SolidPrimitive::SPHERE, {size})},
      {"Box", Tool::SOLID, makePrimitive(SolidPrimitive::BOX, {2.0 * size, 2.0 * size, 2.0 * size})},
      {"Rod", Tool::SOLID, makePrimitive(SolidPrimitive::CYLINDER, {4.0 * size, 0.5 * size})},
      {"Attractor", Tool::ATTRACT, makePrimitive(SolidPrimitive::SPHERE, {size})}};
  if (isOfParticles()) {
    kinds.emplace_back("Knife", Tool::CUT, makePrimitive(SolidPrimitive::BOX, {3.0 * size, blade, 3.0 * size}));
    kinds.emplace_back("Heater", Tool::HEAT, makePrimitive(SolidPrimitive::SPHERE, {size}));
    kinds.emplace_back("Eraser", Tool::ERASE, makePrimitive(SolidPrimitive::SPHERE, {size}));
  }
  const auto tools_menu = spot_menu_.insert("Add a tool");
  for (const auto& [name, mode, primitive] : kinds) {
    spot_menu_.insert(tools_menu, name,
                      [this, mode = mode, primitive = primitive](const Feedback&) { addTool(mode, primitive); });
  }
  if (isOfParticles()) spot_menu_.insert(tools_menu, "Warm hand", [this](const Feedback&) { addWarmHand(); });

  add(panel_menu_, "Pause", [this] { pause(true); });
  add(panel_menu_, "Go on", [this] { pause(false); });
  add(panel_menu_, "One step", [this] { takeSteps(1); });
  add(panel_menu_, "Ten steps", [this] { takeSteps(10); });
  add(panel_menu_, "Reset", [this] {
    std_srvs::Trigger service;
    call("reset", service);
  });
  if (!isOfParticles()) return;
  constexpr double kEverywhere = std::numeric_limits<double>::infinity();
  add(panel_menu_, "Freeze", [this] { edit(EditParticlesRequest::FIX, kEverywhere); });
  add(panel_menu_, "Melt", [this] { edit(EditParticlesRequest::FREE, kEverywhere); });
  add(panel_menu_, "Grow a surface", [this] {
    GrowSurface service;
    call("grow_surface", service);
  });
}

std::string MarkerServer::makeId() { return std::string(kGripId) + "_" + std::to_string(++num_made_); }

/// Beside the spot, not in it: a solid tool there would throw the surface off.
void MarkerServer::addTool(std::uint8_t mode, const SolidPrimitive& primitive) {
  const std::size_t spot = findSpot();
  MarkedTool tool;
  tool.id = makeId();
  tool.mode = mode;
  tool.primitive = primitive;
  tool.pose = makePose(points_[spot] + (0.5 * findExtent(primitive) + spacing_) * normalAt(spot));
  HeldTool& held = held_[tool.id];
  held.tool = tool;
  held.spacing = spacing_;
  makeWay(held);
  showTool(held);
}

void MarkerServer::removeTool(HeldTool& held) {
  if (held.is_warm_hand) {
    letGo(held);
  } else {
    send(held.tool, Tool::DELETE);
  }
  const std::string id = held.tool.id;
  held_.erase(id);
  server_.erase(id);
}

void MarkerServer::pin(const char* service) {
  SelectRegion select;
  select.request.header.frame_id = header_.frame_id;
  select.request.primitive = makePrimitive(SolidPrimitive::SPHERE, {radius()});
  select.request.pose = makePose(points_[findSpot()]);
  call(service, select);
}

/// At random in a ball above the spot, none too near to another.
void MarkerServer::spray() {
  const std::size_t spot = findSpot();
  const Vec3 normal = normalAt(spot);
  const double reach = kSprayShare * spacing_;
  const Vec3 center = points_[spot] + kSprayHeight * reach * normal;
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), normal);
  std::mt19937 random(static_cast<std::uint32_t>(++num_made_));
  const auto draw = [&random] { return 2.0 * random() / static_cast<double>(std::mt19937::max()) - 1.0; };
  Points taken = points_;
  EditParticles service;
  service.request.action = EditParticlesRequest::ADD;
  service.request.header.frame_id = header_.frame_id;
  for (int tries = 0; tries < kSprayTries; ++tries) {
    const Vec3 offset(draw(), draw(), draw());
    const Vec3 point = center + reach * offset;
    const auto isNear = [&](const Vec3& other) { return (other - point).norm() < kSprayApart * spacing_; };
    if (offset.norm() > 1.0 || std::any_of(taken.begin(), taken.end(), isNear)) continue;
    taken.push_back(point);
    service.request.poses.push_back(makePose(tool::Pose{point, turn}));
  }
  call("edit", service);
}

/// Edits everything within reach (m) of the spot.
void MarkerServer::edit(std::uint8_t action, double reach) {
  const Vec3 center = points_[findSpot()];
  EditParticles service;
  service.request.action = action;
  for (std::size_t i = 0; i < points_.size(); ++i)
    if ((points_[i] - center).norm() <= reach) service.request.ids.push_back(ids_[i]);
  call("edit", service);
}

void MarkerServer::pause(bool paused) {
  std_srvs::SetBool service;
  service.request.data = paused;
  call("pause", service);
}

void MarkerServer::takeSteps(std::uint32_t count) {
  Step service;
  service.request.count = count;
  call("step", service);
}

}  // namespace deformable_surface::node
