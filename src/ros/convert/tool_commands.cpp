#include "deformable_surface/ros/convert/tool_commands.h"

#include "deformable_surface/base/error.h"
#include "deformable_surface/base/step_time.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/ros/convert/tool_decoder.h"

#include <algorithm>
#include <cmath>

namespace deformable_surface::node {
namespace {

using geometry::Solid;
using shape_msgs::SolidPrimitive;
using tool::Mode;
using tool::ToolParams;

// Its tree is rebuilt for every message that adds or moves the tool: about ten milliseconds.
constexpr std::size_t kMaxMeshTriangles = 20000, kMinMeshTriangles = 4;  // fewer enclose nothing
constexpr std::size_t kShownId = 64;                                     // letters of an id that is wrong

Vec3 toVec3(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }

Solid toSolid(const SolidPrimitive& primitive) {
  Solid solid;
  const std::vector<double>& sizes = primitive.dimensions;
  const auto require = [&](std::size_t count, const char* meaning) {
    if (sizes.size() != count) {
      throw InputError("primitive.dimensions: found " + std::to_string(sizes.size()) +
                       " numbers; accepted: " + std::to_string(count) + ", " + meaning);
    }
  };
  switch (primitive.type) {
    case SolidPrimitive::BOX:
      require(3, "the edges of the box");
      solid.kind = Solid::Kind::kBox;
      solid.size = Vec3(sizes[SolidPrimitive::BOX_X], sizes[SolidPrimitive::BOX_Y], sizes[SolidPrimitive::BOX_Z]);
      return solid;
    case SolidPrimitive::SPHERE:
      require(1, "the radius");
      solid.kind = Solid::Kind::kSphere;
      solid.radius = sizes[SolidPrimitive::SPHERE_RADIUS];
      return solid;
    case SolidPrimitive::CYLINDER:
      require(2, "height and radius");
      solid.kind = Solid::Kind::kCylinder;
      solid.height = sizes[SolidPrimitive::CYLINDER_HEIGHT];
      solid.radius = sizes[SolidPrimitive::CYLINDER_RADIUS];
      return solid;
    case SolidPrimitive::CONE:
      require(2, "height and radius");
      solid.kind = Solid::Kind::kCone;
      solid.height = sizes[SolidPrimitive::CONE_HEIGHT];
      solid.radius = sizes[SolidPrimitive::CONE_RADIUS];
      return solid;
    default:
      throw InputError("primitive.type: found " + std::to_string(primitive.type) +
                       "; accepted: 1 (box), 2 (sphere), 3 (cylinder), 4 (cone)");
  }
}

// a x + b y + c z + d = 0, solid where the left side is negative.
Solid toSolid(const shape_msgs::Plane& plane) {
  Solid solid;
  solid.kind = Solid::Kind::kPlane;
  solid.normal = Vec3(plane.coef[0], plane.coef[1], plane.coef[2]);
  // A zero normal is refused with the other values of a tool.
  const double length = solid.normal.norm();
  solid.offset = length > 0.0 ? -plane.coef[3] / length : 0.0;
  return solid;
}

Solid toSolid(const shape_msgs::Mesh& mesh) {
  if (mesh.triangles.size() < kMinMeshTriangles || mesh.triangles.size() > kMaxMeshTriangles)
    throw InputError("mesh.triangles: found " + std::to_string(mesh.triangles.size()) +
                     "; accepted: " + std::to_string(kMinMeshTriangles) + " to " + std::to_string(kMaxMeshTriangles));
  Points vertices, triangles;
  for (const geometry_msgs::Point& v : mesh.vertices) vertices.emplace_back(v.x, v.y, v.z);
  for (const shape_msgs::MeshTriangle& t : mesh.triangles)
    triangles.emplace_back(t.vertex_indices[0], t.vertex_indices[1], t.vertex_indices[2]);
  Solid solid;
  solid.kind = Solid::Kind::kMesh;
  const std::string problem = geometry::setMesh(vertices, triangles, solid);
  if (!problem.empty()) throw InputError("mesh: " + problem);
  return solid;
}

Solid readShape(const Tool& command) {
  if (command.shape == Tool::PRIMITIVE) return toSolid(command.primitive);
  if (command.shape == Tool::PLANE) return toSolid(command.plane);
  if (command.shape == Tool::MESH) return toSolid(command.mesh);
  throw InputError("shape: found " + std::to_string(command.shape) + "; accepted: 0 (PRIMITIVE), 1 (PLANE), 2 (MESH)");
}

static_assert(tool::infoOf(Mode::kSolid).code == Tool::SOLID && tool::infoOf(Mode::kAttract).code == Tool::ATTRACT &&
                  tool::infoOf(Mode::kMove).code == Tool::MOVE && tool::infoOf(Mode::kErase).code == Tool::ERASE &&
                  tool::infoOf(Mode::kCut).code == Tool::CUT && tool::infoOf(Mode::kHeat).code == Tool::HEAT,
              "the table of modes has the codes of the message");

// "0 (SOLID), 1 (ATTRACT), ...".
std::string listModeCodes() {
  std::string all;
  for (const tool::ModeInfo& info : tool::kModes)
    all += (all.empty() ? "" : ", ") + std::to_string(info.code) + " (" + tool::messageName(info) + ")";
  return all;
}

double findReach(const Solid& solid) {
  if (solid.kind == Solid::Kind::kPlane)
    throw InputError("shape: found a PLANE that is to ATTRACT, whose reach would be without end; accepted: PRIMITIVE, MESH");
  return geometry::findLargestExtent(solid);
}

Vec3 requireFinite(const std::string& name, const Vec3& v) {
  if (!v.allFinite()) throw InputError(name + ": found a value that is not finite; accepted: finite numbers");
  return v;
}

}  // namespace

const ToolParams* findTool(const simulation::Simulation& simulation, const std::string& id) {
  for (const ToolParams& tool : simulation.tools())
    if (tool.id == id) return &tool;
  return nullptr;
}

bool removeTools(const Tool& command, simulation::Simulation& simulation) {
  if (command.action == Tool::DELETEALL) {
    while (!simulation.tools().empty()) simulation.removeTool(simulation.tools().back().id);
    return true;
  }
  if (command.action == Tool::DELETE) {
    if (!simulation.removeTool(command.id))
      throw InputError("found a DELETE, but there is no such tool; accepted: ids of tools that are there");
    return true;
  }
  if (command.action != Tool::ADD) {
    throw InputError("action: found " + std::to_string(command.action) +
                     "; accepted: 0 (ADD, which modifies too), 2 (DELETE), 3 (DELETEALL)");
  }
  if (!isToolId(command.id))
    throw InputError("id: found " + (command.id.empty() ? "none" : quote(command.id.substr(0, kShownId))) +
                     "; accepted: up to 64 letters, digits and '_', the first a letter, since it becomes a topic's name");
  if (simulation.tools().size() >= kMaxTools && !findTool(simulation, command.id))
    throw InputError("found " + std::to_string(simulation.tools().size()) + " tools at a time already; accepted: no more");
  return false;
}

ToolParams readTool(const Tool& command) {
  ToolParams tool;
  tool.id = command.id;
  const tool::ModeInfo* const mode = tool::findMode(command.mode);
  if (!mode) throw InputError("mode: found " + std::to_string(command.mode) + "; accepted: " + listModeCodes());
  tool.mode = mode->mode;
  tool.shape = readShape(command);
  tool.friction = command.friction;
  if (command.kinetic_friction != 0.0) tool.kinetic_friction = command.kinetic_friction;
  tool.strength = command.strength;
  if (tool.mode == Mode::kAttract) tool.reach = findReach(tool.shape);
  return tool;
}

tool::WaypointParams makeWaypoint(double time, const tool::Pose& pose) {
  return {time, pose.position, Vec4(pose.orientation.x(), pose.orientation.y(), pose.orientation.z(), pose.orientation.w())};
}

bool isToolId(const std::string& id) {
  constexpr std::size_t kLongest = 64;
  const auto isLetter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto isPart = [&](char c) { return isLetter(c) || (c >= '0' && c <= '9') || c == '_'; };
  return !id.empty() && id.size() <= kLongest && isLetter(id[0]) && std::all_of(id.begin(), id.end(), isPart);
}

tool::Pose ToolCommands::Course::predict(double time) const {
  const double moving = std::min(time, ends) - given;
  const Vec3 turn = moving * spin;
  const double angle = turn.norm();
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(angle, angle > 0.0 ? Vec3(turn / angle) : Vec3(Vec3::UnitZ())));
  const Eigen::Quaterniond frame(T_surface_frame.linear());
  return {T_surface_frame * (pose.position + moving * velocity), (frame * turned * pose.orientation).normalized()};
}

void ToolCommands::apply(const Tool& command, simulation::Simulation& simulation, const std::string& surface_frame,
                         const SeenTransform* seen) {
  const ToolParams* const before = findTool(simulation, command.id);
  const double now = simulation.time(), step = simulation.params().integrator.time_step;
  ToolParams tool;
  Course course;
  try {
    if (removeTools(command, simulation)) {
      if (command.action == Tool::DELETEALL) {
        courses_.clear();
      } else {
        courses_.erase(command.id);
      }
      return;
    }
    tool = readTool(command);
    course.given = now;
    course.frame = command.header.frame_id;
    course.follows_frame = command.follow_frame;
    const Eigen::Isometry3d pose = readPose(command.pose);
    course.pose = {pose.translation(), Eigen::Quaterniond(pose.linear())};
    course.velocity = requireFinite("twist.linear", toVec3(command.twist.linear));
    course.spin = requireFinite("twist.angular", toVec3(command.twist.angular));
    // A quarter of a turn between two waypoints, at most two steps apart, so that the shorter rotation is the intended one.
    const double fastest = 0.5 * kPi / std::max(kLongestMove, 2.0 * step);
    if (!(course.spin.norm() <= fastest)) {
      throw InputError("twist.angular: found " + formatReal(course.spin.norm()) + "; accepted: up to " + formatReal(fastest) +
                       " (rad/s)");
    }
    if (timeout_ > 0.0 && course.hasVelocity()) course.ends = now + timeout_;
    course.T_surface_frame =
        findTransform("header.frame_id", command.header.frame_id, surface_frame, command.header.stamp, transforms_, seen);
  } catch (const FrameError& error) {
    throw FrameError("tool " + quote(command.id.substr(0, kShownId)) + " " + error.what());
  } catch (const InputError& error) {
    throw InputError("tool " + quote(command.id.substr(0, kShownId)) + " " + error.what());
  }

  if (before) {
    // A tool that continues to grip keeps its points.
    if (before->mode == tool.mode && tool::isActive(*before, now)) tool.start = before->start;
    const auto last = courses_.find(command.id);
    const double longest = std::max(kLongestMove, step);
    const double way = last == courses_.end() ? longest : std::min(std::max(now - last->second.given, step), longest);
    course.arrives = now + way;
    if (last != courses_.end() && last->second.follows_frame && last->second.frame == course.frame)
      course.frame_stamp = last->second.frame_stamp;
    tool.path = {makeWaypoint(now, tool::interpolate(before->path, now)),
                 makeWaypoint(course.arrives, course.predict(course.arrives))};
  } else {
    tool.start = now;
    course.arrives = now;
    tool.path = {makeWaypoint(now, course.predict(now))};
  }
  simulation.setTool(tool);
  courses_[command.id] = course;
}

void ToolCommands::lookAtFrame(const std::string& what, const ros::Time& stamp, double now, double step,
                               const std::string& surface_frame, Course& course) const {
  const LatestTransform seen = findTransformUntil(what, course.frame, surface_frame, stamp, transforms_);
  const double since = course.frame_stamp.isZero() ? 0.0 : (seen.stamp - course.frame_stamp).toSec();
  if (seen.stamp != course.frame_stamp) {
    const bool is_of_then = seen.stamp == stamp;
    const double way = is_of_then ? step : std::min(std::max(since, step), std::max(kLongestMove, step));
    course.arrives = std::max(course.arrives, now + way);
  }
  course.T_surface_frame = seen.transform;
  course.frame_stamp = seen.stamp;
}

// When a velocity has ended, the tool stays where it was then.
std::string ToolCommands::endVelocity(double now, double step, Course& course) const {
  if (!(now >= course.ends - kTimeRounding * step)) return "";
  const double moved = course.ends - course.given;
  const double angle = moved * course.spin.norm();
  course.pose.position += moved * course.velocity;
  if (angle > 0.0) course.pose.orientation = Eigen::AngleAxisd(angle, course.spin.normalized()) * course.pose.orientation;
  course.velocity = course.spin = Vec3::Zero();
  course.ends = kNever;
  course.is_silent = true;
  return "no message for " + formatReal(timeout_) + " s; its twist has ended, and its wrench is marked silent";
}

std::string ToolCommands::noticeSilence(const ros::Time& stamp, Course& course) const {
  const bool was_silent = course.is_silent;
  // A stamp of 0 means a frame that never changes.
  course.is_silent = timeout_ > 0.0 && !course.frame_stamp.isZero() && (stamp - course.frame_stamp).toSec() > timeout_;
  if (was_silent || !course.is_silent) return "";
  return "no transform of frame " + quote(course.frame) + " for " + formatReal(timeout_) +
         " s; it stays where it is, and its wrench is marked silent";
}

std::set<std::string> ToolCommands::silent() const {
  std::set<std::string> ids;
  for (const auto& [id, course] : courses_)
    if (course.is_silent) ids.insert(id);
  return ids;
}

std::string ToolCommands::missingFrame(const ros::Time& stamp, const std::string& surface_frame) const {
  for (const auto& [id, course] : courses_)
    if (course.follows_frame && !isKnown(course.frame, surface_frame, stamp, transforms_)) return course.frame;
  return "";
}

Index ToolCommands::pinToFrame(const std_msgs::Header& header, const geometry::Region& region, simulation::Simulation& simulation,
                               const std::string& surface_frame) {
  if (pins_.size() >= kMaxTools)
    throw InputError("found " + std::to_string(pins_.size()) + " pins that follow frames already; accepted: no more");
  Course course;
  course.given = course.arrives = simulation.time();
  course.frame = header.frame_id;
  course.follows_frame = true;
  course.T_surface_frame = findTransform("header.frame_id", header.frame_id, surface_frame, header.stamp, transforms_);
  std::size_t number = 0;
  const auto nameOf = [](std::size_t k) { return "followed pin " + std::to_string(k); };
  while (pins_.count(nameOf(number)) > 0 || simulation.findPinPath(nameOf(number))) ++number;
  const Index count = simulation.pinAlong(nameOf(number), region, {makeWaypoint(course.given, course.predict(course.given))});
  if (count > 0) pins_[nameOf(number)] = course;
  return count;
}

void ToolCommands::movePins(const ros::Time& stamp, simulation::Simulation& simulation, const std::string& surface_frame,
                            std::vector<std::string>& problems) {
  const double now = simulation.time(), step = simulation.params().integrator.time_step;
  for (auto entry = pins_.begin(); entry != pins_.end();) {
    auto& [id, course] = *entry;
    const std::vector<tool::WaypointParams>* const path = simulation.findPinPath(id);
    if (!path) {  // all of its points are free again
      entry = pins_.erase(entry);
      continue;
    }
    ++entry;
    try {
      lookAtFrame("pin", stamp, now, step, surface_frame, course);
      const double end = std::max(course.arrives, now + step);
      simulation.movePin(id, {makeWaypoint(now, tool::interpolate(*path, now)), makeWaypoint(end, course.predict(end))});
    } catch (const InputError& error) {
      problems.push_back(std::string(error.what()) + "; the pinned points stay where they are");
    }
  }
}

bool ToolCommands::isMoving() const {
  return !pins_.empty() || stand_.size() < standing_.size() ||
         std::any_of(courses_.begin(), courses_.end(), [](const auto& entry) { return entry.second.isMoving(); });
}

std::vector<std::string> ToolCommands::move(const ros::Time& stamp, simulation::Simulation& simulation,
                                            const std::string& surface_frame) {
  std::vector<std::string> problems;
  for (Tool& tool : standing_) {
    if (stand_.count(tool.id) > 0) continue;
    try {
      tool.header.stamp = findTransformUntil("header.frame_id", tool.header.frame_id, surface_frame, stamp, transforms_).stamp;
      apply(tool, simulation, surface_frame);
      stand_.insert(tool.id);
    } catch (const InputError& error) {
      problems.push_back(std::string(error.what()) + "; the tool waits for it");
    }
  }
  const double now = simulation.time(), step = simulation.params().integrator.time_step;
  for (auto& [id, course] : courses_) {
    if (!course.isMoving()) continue;
    const auto append = [&](const std::string& problem) {
      if (!problem.empty()) problems.push_back("tool " + quote(id) + ": " + problem);
    };
    append(endVelocity(now, step, course));
    if (!course.follows_frame && now < course.arrives - kTimeRounding * step) continue;
    try {
      if (course.follows_frame) {
        lookAtFrame("tool " + quote(id), stamp, now, step, surface_frame, course);
        append(noticeSilence(stamp, course));
      }
      const ToolParams& tool = *findTool(simulation, id);
      // A velocity lasts beyond the step, so that friction at its end still counts it.
      const double ahead = std::min(now + (course.follows_frame ? 1.0 : 2.0) * step, std::max(course.ends, now + step));
      const double end = std::max(course.arrives, ahead);
      simulation.moveTool(id, {makeWaypoint(now, tool::interpolate(tool.path, now)), makeWaypoint(end, course.predict(end))});
    } catch (const InputError& error) {
      problems.push_back(std::string(error.what()) + "; the tool stays where it is");
      noticeSilence(stamp, course);
    }
  }
  movePins(stamp, simulation, surface_frame, problems);
  return problems;
}

}  // namespace deformable_surface::node
