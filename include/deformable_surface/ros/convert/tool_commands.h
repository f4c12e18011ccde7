// Tools that come over ROS: from the messages to the simulation's tools, and their motion until the next message.
// Tools that follow a frame or continue with a velocity have to be moved before every step. The node and
// `simulate` share it.
#pragma once

#include "frames.h"

#include "deformable_surface/Tool.h"
#include "deformable_surface/simulation/simulation.h"

#include <ros/time.h>
#include <tf2/buffer_core.h>
#include <Eigen/Geometry>

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace deformable_surface::node {

/// The tool of a command, without a path or a time window. Throws InputError for values that are not accepted.
tool::ToolParams readTool(const Tool& command);
tool::WaypointParams makeWaypoint(double time, const tool::Pose& pose);

/// Whether an id can be part of a topic's name: up to 64 letters, digits and '_', the first a letter.
bool isToolId(const std::string& id);

/// The tool of that id; null: there is none.
const tool::ToolParams* findTool(const simulation::Simulation& simulation, const std::string& id);
/// Carries out a DELETE or DELETEALL; false: the command is an ADD. Throws InputError for other actions, for the DELETE of a tool
/// that does not exist, and for an ADD with an invalid id or beyond the largest number of tools.
bool removeTools(const Tool& command, simulation::Simulation& simulation);

class ToolCommands {
  static constexpr double kNever = 1e300;  // s

  /// The motion stated by a tool's last message, in the frame of its header.
  struct Course {
    double given = 0.0;    // s of simulation time: when the message took effect, and the tool was, or was to be, at its pose
    double arrives = 0.0;  // s: when it is where the message has it, or where its frame was last seen
    std::string frame;
    bool follows_frame = false;
    Eigen::Isometry3d T_surface_frame = Eigen::Isometry3d::Identity();
    ros::Time frame_stamp;  // of that, while it follows the frame; 0 = not looked up yet, or it never changes
    tool::Pose pose;
    Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  // m/s of the tool's origin, rad/s
    double ends = kNever;                               // s: no message came until then, and the velocity ends
    bool is_silent = false;

    bool hasVelocity() const { return !velocity.isZero(0.0) || !spin.isZero(0.0); }
    bool isMoving() const { return follows_frame || hasVelocity(); }
    /// The pose of the tool at a time, in the surface's frame.
    tool::Pose predict(double time) const;
  };

 public:
  /// timeout: s without a message for its velocity, or a transform of its frame, after which a tool is silent; 0 = never.
  explicit ToolCommands(const tf2::BufferCore& transforms, double timeout = 0.0) : transforms_(transforms), timeout_(timeout) {}

  /// Carries out a command at the beginning of a step. A new tool is at its pose at once. An existing one moves
  /// from its place to that of the message, over the time since the message before, but at least a step and at most
  /// kLongestMove or a step. Throws InputError, and changes nothing, for values, frames and ids that are not accepted, and for
  /// modes that the model does not have. seen: the transform of a command without a stamp, or null.
  void apply(const Tool& command, simulation::Simulation& simulation, const std::string& surface_frame,
             const SeenTransform* seen = nullptr);

  /// To be called before each step: gives tools that follow a frame, or have a velocity, their path through it. stamp: of the end
  /// of the step; the tool is then where tf has its frame at that time. If tf does not know a frame for that time, the tool moves
  /// to the frame's last known place, within the time between this and the one known before, but at least a step and at most
  /// kLongestMove or a step. A tool whose frame is unknown stays in place, as does a silent one. Returns a sentence for each of
  /// the former, and for each that falls silent.
  std::vector<std::string> move(const ros::Time& stamp, simulation::Simulation& simulation, const std::string& surface_frame);

  /// Pins the points in a region; tf's frame of the header then carries them, as it carries tools. Returns how many; throws
  /// InputError for an unknown frame.
  Index pinToFrame(const std_msgs::Header& header, const geometry::Region& region, simulation::Simulation& simulation,
                   const std::string& surface_frame);

  /// Tools that exist without messages: each is added as soon as its frame is known, and again after forget();
  /// a deleted one stays away until then.
  void setStanding(std::vector<Tool> tools) { standing_ = std::move(tools); }

  /// Whether move() may have something to do.
  bool isMoving() const;
  /// A frame that a tool follows and that tf does not know yet at the stamp; empty if there is none.
  std::string missingFrame(const ros::Time& stamp, const std::string& surface_frame) const;
  /// Ids of the tools that are silent.
  std::set<std::string> silent() const;

  /// The surface is new or at rest again: its former tools are gone.
  void forget() {
    courses_.clear();
    pins_.clear();
    stand_.clear();
  }

  /// What a snapshot needs: the courses of tools, by id, and which of the standing tools have been added.
  struct Memory {
    std::map<std::string, Course> courses, pins;
    std::set<std::string> stand;
  };
  Memory memory() const { return {courses_, pins_, stand_}; }
  void setMemory(const Memory& memory) {
    courses_ = memory.courses;
    pins_ = memory.pins;
    stand_ = memory.stand;
  }

  // After a longer pause between messages a tool counts as put elsewhere, not as moved.
  static constexpr double kLongestMove = 0.1;  // s

 private:
  void lookAtFrame(const std::string& what, const ros::Time& stamp, double now, double step, const std::string& surface_frame,
                   Course& course) const;
  void movePins(const ros::Time& stamp, simulation::Simulation& simulation, const std::string& surface_frame,
                std::vector<std::string>& problems);

  std::string endVelocity(double now, double step, Course& course) const;
  std::string noticeSilence(const ros::Time& stamp, Course& course) const;

  const tf2::BufferCore& transforms_;
  const double timeout_;                   // s
  std::map<std::string, Course> courses_;  // by id
  std::map<std::string, Course> pins_;     // that follow a frame, by their name in the simulation
  std::vector<Tool> standing_;
  std::set<std::string> stand_;  // ids of the standing tools that have been added
};

}  // namespace deformable_surface::node
