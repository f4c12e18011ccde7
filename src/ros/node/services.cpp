#include "services.h"

#include "names.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/geometry/region.h"
#include "deformable_surface/io/pending_file.h"
#include "deformable_surface/io/point_files.h"
#include "deformable_surface/ros/convert/frames.h"
#include "deformable_surface/ros/convert/surface_output.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace deformable_surface::node {
namespace {

using shape_msgs::SolidPrimitive;

// A box turned by less than this is off by less than the rounding of its messages.
constexpr double kAxesTolerance = 1e-6;
// A call with this many steps holds the node for a long time already.
constexpr std::uint32_t kMaxSteps = 1000000;

// For any request with a header, a primitive and a pose.
template <class Request>
geometry::Region readRegion(const Request& request, const std::string& surface_frame, const tf2::BufferCore& transforms) {
  const SolidPrimitive& primitive = request.primitive;
  const bool is_box = primitive.type == SolidPrimitive::BOX;
  const std::size_t num_sizes = is_box ? 3 : 1;
  if (!is_box && primitive.type != SolidPrimitive::SPHERE)
    throw InputError("primitive.type: found " + std::to_string(primitive.type) + "; accepted: 1 (box), 2 (sphere)");
  if (primitive.dimensions.size() != num_sizes)
    throw InputError("primitive.dimensions: found " + std::to_string(primitive.dimensions.size()) +
                     " numbers; accepted: " + std::to_string(num_sizes));
  for (const double size : primitive.dimensions) {
    if (!(size >= 0.0 && std::isfinite(size)))
      throw InputError("primitive.dimensions: found " + formatReal(size) + "; accepted: finite numbers >= 0 (m)");
  }

  const Eigen::Isometry3d pose =
      findTransform("header.frame_id", request.header.frame_id, surface_frame, request.header.stamp, transforms) *
      readPose(request.pose);
  geometry::Region region;
  if (!is_box) {
    region.kind = geometry::Region::Kind::kSphere;
    region.center = pose.translation();
    region.radius = primitive.dimensions[SolidPrimitive::SPHERE_RADIUS];
    return region;
  }
  if (!pose.linear().isIdentity(kAxesTolerance))
    throw InputError(
        "pose.orientation: found a box that is turned against the surface's frame; accepted: boxes parallel to its axes");
  const Vec3 half = 0.5 * Vec3(primitive.dimensions[0], primitive.dimensions[1], primitive.dimensions[2]);
  region.min = pose.translation() - half;
  region.max = pose.translation() + half;
  return region;
}

simulation::ParticleEdit readEdit(const EditParticlesRequest& request, const std::string& surface_frame,
                                  const tf2::BufferCore& transforms) {
  using Action = simulation::ParticleAction;
  // In the order of the constants of the service.
  constexpr Action kActions[] = {Action::kAdd,    Action::kMove, Action::kDelete, Action::kCrease,
                                 Action::kOrient, Action::kFix,  Action::kFree};
  if (request.action > EditParticlesRequest::FREE)
    throw InputError("action: found " + std::to_string(request.action) + "; accepted: 0 (ADD) to 6 (FREE)");
  simulation::ParticleEdit edit;
  edit.action = kActions[request.action];
  const bool adds = edit.action == Action::kAdd, moves = edit.action == Action::kMove, turns = edit.action == Action::kOrient;
  if (!(adds || moves || turns) && !request.poses.empty())
    throw InputError("poses: found " + std::to_string(request.poses.size()) + "; accepted: none but with ADD, MOVE and ORIENT");
  const Eigen::Isometry3d transform =
      findTransform("header.frame_id", request.header.frame_id, surface_frame, request.header.stamp, transforms);
  for (const std::uint32_t id : request.ids) {
    if (id > static_cast<std::uint32_t>(std::numeric_limits<Index>::max()))
      throw InputError("ids: found " + std::to_string(id) + "; accepted: ids of particles that are there");
    edit.ids.push_back(static_cast<Index>(id));
  }
  for (const geometry_msgs::Pose& given : request.poses) {
    const Eigen::Isometry3d pose = transform * readPose(given);
    if (adds || moves) edit.positions.push_back(pose.translation());
    if (adds || turns) edit.orientations.push_back(Quaternion(pose.linear()).normalized());
  }
  return edit;
}

// damping: the value of that name, if any.
simulation::MaterialChangeParams readMaterial(const SetMaterialRequest& request, std::optional<double>& damping) {
  if (request.names.empty() || request.names.size() != request.values.size())
    throw InputError("names: found " + std::to_string(request.names.size()) + " and " + std::to_string(request.values.size()) +
                     " values; accepted: as many of each, at least one");
  Value::Map map;
  std::set<std::string> known;
  model::MaterialParams with_damping;
  const std::set<std::string> accepted{"bending_rigidity", "damping", "density", "young_modulus"};
  for (std::size_t k = 0; k < request.names.size(); ++k) {
    if (accepted.count(request.names[k]) == 0)
      throw InputError("names: found " + quote(request.names[k]) + "; accepted, on a surface that is there: " +
                       std::accumulate(std::next(accepted.begin()), accepted.end(), *accepted.begin(),
                                       [](const std::string& a, const std::string& b) { return a + ", " + b; }));
    if (!known.insert(request.names[k]).second)
      throw InputError("names: found " + quote(request.names[k]) + " a second time; accepted: each once");
    if (request.names[k] == "damping") {
      damping = with_damping.damping = request.values[k];
    } else {
      map.emplace_back(request.names[k], Value(request.values[k]));
    }
  }
  simulation::MaterialChangeParams change;
  std::vector<std::string> problems = checkParams(with_damping);
  if (!map.empty())
    for (std::string& problem : readParams(Value(map), change)) problems.push_back(std::move(problem));
  if (!problems.empty()) throw InputError(std::move(problems));
  return change;
}

void checkSaveName(const std::string& name) {
  if (!isBareName(name))
    throw InputError("name: found " + quote(name) + "; accepted: " + kBareNames + ", ending in .ply or .pcd");
  io::checkPointFileName(name);
}

}  // namespace

Services::Services(ros::NodeHandle& node, ros::NodeHandle& reset_node, Inbox& inbox, Stepper& stepper,
                   const tf2::BufferCore& transforms, WarningLog& warnings, std::string save_directory)
    : inbox_(inbox), stepper_(stepper), transforms_(transforms), warnings_(warnings), save_directory_(std::move(save_directory)) {
  const auto advertiseOn = [&](ros::NodeHandle& on, const char* name, auto request, auto response, auto call) {
    using Request = decltype(request);
    using Response = decltype(response);
    servers_.push_back(on.advertiseService<Request, Response>(
        name, boost::function<bool(Request&, Response&)>([call](Request& q, Response& r) { return call(q, r); })));
  };
  const auto advertise = [&](auto... what) { advertiseOn(node, what...); };
  advertiseOn(reset_node, "reset", std_srvs::TriggerRequest(), std_srvs::TriggerResponse(),
              [this](auto&, auto& r) { return reset(r); });
  advertise("pause", std_srvs::SetBoolRequest(), std_srvs::SetBoolResponse(),
            [this](auto& q, auto& r) { return pause(q.data, r); });
  advertise("step", StepRequest(), StepResponse(), [this](auto& q, auto& r) { return step(q.count, r); });
  advertise("pin", SelectRegionRequest(), SelectRegionResponse(), [this](auto& q, auto& r) { return select(q, true, r); });
  advertise("unpin", SelectRegionRequest(), SelectRegionResponse(), [this](auto& q, auto& r) { return select(q, false, r); });
  advertise("edit", EditParticlesRequest(), EditParticlesResponse(), [this](auto& q, auto& r) { return edit(q, r); });
  advertise("save", SaveCloudRequest(), SaveCloudResponse(), [this](auto& q, auto& r) { return save(q.name, r); });
  advertise("snapshot", SnapshotRequest(), SnapshotResponse(), [this](auto& q, auto& r) { return keep(q, r); });
  advertise("restore", RestoreRequest(), RestoreResponse(), [this](auto& q, auto& r) { return restore(q.name, r); });
  advertise("list", ListRequest(), ListResponse(), [this](auto&, auto& r) { return list(r); });
  advertise("set_material", SetMaterialRequest(), SetMaterialResponse(), [this](auto& q, auto& r) { return setMaterial(q, r); });
}

std::vector<std::string> Services::names() const {
  std::vector<std::string> names;
  for (const ros::ServiceServer& server : servers_) names.push_back(server.getService());
  return names;
}

template <class Response, class Work>
bool Services::perform(Response& response, const Work& work, bool ends_step) {
  try {
    inbox_.perform([&] { response.message = work(); }, ends_step);
    response.success = true;
  } catch (const std::exception& error) {
    response.success = false;
    response.message = toOneLine(error.what());
  }
  stepper_.waitForResult();
  if (!response.success) warnings_.report(Warning::kCallRefused, "call refused: " + std::string(response.message));
  return true;
}

bool Services::reset(std_srvs::TriggerResponse& response) {
  const auto work = [&] {
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    const std::size_t before = stepper_.snapshots().all().size();
    stepper_.reset();
    stepper_.showResult();
    const std::size_t dropped = before - stepper_.snapshots().all().size();
    return "the surface is at rest at time 0" +
           (dropped > 0 ? "; it is another one, which trials chose, and the snapshots of the one before (" +
                              std::to_string(dropped) + ") are dropped"
                        : std::string());
  };
  return perform(response, work, true);
}

bool Services::pause(bool paused, std_srvs::SetBoolResponse& response) {
  return perform(response, [&] {
    stepper_.setPaused(paused);
    if (paused) stepper_.showStop();
    return paused ? "paused" : "running";
  });
}

bool Services::step(std::uint32_t count, StepResponse& response) {
  return perform(response, [&] {
    if (!(count >= 1 && count <= kMaxSteps))
      throw InputError("count: found " + std::to_string(count) + "; accepted: 1 to " + std::to_string(kMaxSteps));
    stepper_.requireFree();
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    if (!stepper_.isPaused()) throw InputError("the simulation is running; accepted: ~step while it is paused (~pause true)");
    const std::string obstacle = stepper_.obstacle();
    if (!obstacle.empty()) throw InputError(obstacle);
    const std::uint32_t taken = stepper_.takeSteps(count);
    stepper_.showResult();
    const simulation::Statistics statistics = stepper_.simulation()->statistics();
    response.simulation_time = statistics.simulation_time;
    response.energy = statistics.kinetic_energy + statistics.elastic_energy + statistics.potential_energy;
    response.state_hash = statistics.state_hash;
    const std::string sentence = "took " + std::to_string(taken) + " of " + std::to_string(count) + " steps";
    if (taken < count)
      throw InputError(sentence + "; the last one failed, or ~reset or the end of the node ended them, see /diagnostics");
    return sentence;
  });
}

bool Services::select(const SelectRegionRequest& request, bool pinned, SelectRegionResponse& response) {
  return perform(response, [&] {
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    stepper_.requireFree();
    if (request.orientation && !(pinned && isOriented(stepper_.simulation()->model())))
      throw InputError("orientation: found true; accepted: with ~pin of oriented particles");
    if (request.follow_frame && (!pinned || request.orientation || request.header.frame_id.empty()))
      throw InputError("follow_frame: found true; accepted: with ~pin, a header.frame_id to follow and orientation false");
    geometry::Region region = readRegion(request, stepper_.frame(), transforms_);
    region.outside = request.outside;
    simulation::Simulation& surface = *stepper_.simulation();
    response.count = static_cast<std::uint32_t>(request.follow_frame ? stepper_.pinToFrame(request.header, region)
                                                : pinned             ? surface.pin(region, request.orientation)
                                                                     : surface.unpin(region));
    if (response.count == 0)
      throw InputError(std::string("no ") + (pinned ? "" : "pinned ") + "simulation point lies " +
                       (request.outside ? "outside of" : "in") + " the shape; nothing was changed");
    stepper_.showResult();
    return std::to_string(response.count) + " simulation points " + (pinned ? "pinned" : "freed");
  });
}

bool Services::edit(const EditParticlesRequest& request, EditParticlesResponse& response) {
  return perform(response, [&] {
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    stepper_.requireFree();
    const simulation::ParticleEdit edit = readEdit(request, stepper_.frame(), transforms_);
    for (const Index id : stepper_.simulation()->editParticles(edit)) response.added.push_back(static_cast<std::uint32_t>(id));
    stepper_.showResult();
    return std::to_string(std::max(edit.ids.size(), response.added.size())) + " particles edited, " +
           std::to_string(stepper_.simulation()->state().size()) + " are there";
  });
}

bool Services::save(const std::string& name, SaveCloudResponse& response) {
  return perform(response, [&] {
    if (save_directory_.empty()) throw InputError("~save is off, since the parameter save_directory is not set");
    checkSaveName(name);
    const std::string file = save_directory_ + "/" + name;
    if (io::followLinks(file) != file)
      throw InputError("name: found " + quote(name) + ", a symbolic link; accepted: a new file, or one to be replaced");
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    const simulation::Surface& surface = stepper_.simulation()->surface(true);
    io::writePointFile(file, makeOutputCloud(surface, stepper_.simulation()->input()), surface.displacement);
    return "wrote " + name;
  });
}

bool Services::keep(const SnapshotRequest& request, SnapshotResponse& response) {
  return perform(response, [&] {
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    if (request.remove) {
      stepper_.snapshots().remove(request.name);
      return "dropped " + request.name;
    }
    stepper_.keepSnapshot(request.name);
    const SnapshotShelf::Entry& entry = stepper_.snapshots().find(request.name);
    response.simulation_time = entry.snapshot.time();
    response.state_hash = entry.state_hash;
    response.bytes = entry.snapshot.bytes();
    return "kept " + request.name;
  });
}

bool Services::restore(const std::string& name, RestoreResponse& response) {
  perform(response, [&] {
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    stepper_.restoreSnapshot(name);
    stepper_.showResult();
    response.simulation_time = stepper_.simulation()->time();
    response.state_hash = stepper_.simulation()->stateHash();
    return "the surface is as in " + name;
  });
  if (response.success && on_restore_) on_restore_();
  return true;
}

bool Services::list(ListResponse& response) {
  return perform(response, [&] {
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    const simulation::Simulation& surface = *stepper_.simulation();
    for (const tool::ToolParams& tool : surface.tools()) response.tools.push_back(tool.id);
    response.forces = surface.forceIds();
    const std::set<std::string> acting(response.forces.begin(), response.forces.end());
    for (const std::string& id : stepper_.waitingForces())
      if (acting.count(id) == 0) response.forces.push_back(id);
    response.pinned = static_cast<std::uint32_t>(std::count(surface.pinned().begin(), surface.pinned().end(), 1));
    response.own_material = static_cast<std::uint32_t>(surface.numOwnMaterial());
    for (const auto& [name, entry] : stepper_.snapshots().all()) {
      response.snapshots.push_back(name);
      response.snapshot_times.push_back(entry.snapshot.time());
      response.snapshot_bytes.push_back(entry.snapshot.bytes());
    }
    return std::to_string(response.tools.size()) + " tools, " + std::to_string(response.forces.size()) + " forces, " +
           std::to_string(response.pinned) + " pinned points, " + std::to_string(response.snapshots.size()) + " snapshots" +
           (stepper_.isBuilding() ? "; another surface is being built" : "");
  });
}

bool Services::setMaterial(const SetMaterialRequest& request, SetMaterialResponse& response) {
  return perform(response, [&] {
    if (!stepper_.simulation()) throw InputError(stepper_.obstacle());
    stepper_.requireFree();
    simulation::Simulation& surface = *stepper_.simulation();
    std::optional<double> damping;
    const simulation::MaterialChangeParams change = readMaterial(request, damping);
    std::optional<geometry::Region> region;
    if (request.primitive.type != 0) region = readRegion(request, stepper_.frame(), transforms_);
    if (damping && region)
      throw InputError("names: found damping with a shape; accepted: damping of everything, primitive.type 0");
    if (!change.isEmpty()) {
      const auto is_inside = [&](const Vec3& p) { return !region || region->contains(p); };
      const Points& points = surface.state().positions;
      if (std::none_of(points.begin(), points.end(), is_inside))
        throw InputError("no simulation point lies in the shape; nothing was changed");
      response.count = static_cast<std::uint32_t>(surface.setMaterial(region ? &*region : nullptr, change));
    }
    if (damping) {
      surface.setDamping(*damping);
      response.count = static_cast<std::uint32_t>(surface.state().size());
    }
    return std::to_string(response.count) + " simulation points have another material";
  });
}

}  // namespace deformable_surface::node
