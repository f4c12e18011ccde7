// Tools that came over ROS: from the messages to the simulation's tools, and where these go until the next message. Apart from
// the other commands because tools that follow a frame or go on with a velocity need a look before every step. The node and
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

/// The tool of a command, without a path or a window in time. Throws InputError for what is not accepted.
tool::ToolParams readTool(const Tool& command);
tool::WaypointParams makeWaypoint(double time, const tool::Pose& pose);

/// Whether an id can be a part of a topic's name: up to 64 letters, digits and '_', the first a letter.
bool isToolId(const std::string& id);

/// The tool of that id; null: there is none.
const tool::ToolParams* findTool(const simulation::Simulation& simulation, const std::string& id);
/// Carries out a DELETE or DELETEALL; false: the command is an ADD. Throws InputError for other actions, for the DELETE of a tool
/// that is not there, and for the ADD of one that has no proper id or is one too many.
bool removeTools(const Tool& command, simulation::Simulation& simulation);

class ToolCommands {
  static constexpr double kNever = 1e300;  // s

  /// What a tool's last message says of its motion, in the frame of its header.
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
    /// Where the tool is to be at a time, in the surface's frame.
    tool::Pose predict(double time) const;
  };

 public:
  /// timeout: s without a message for its velocity, or a transform of its frame, after which a tool is silent; 0 = never.
  explicit ToolCommands(const tf2::BufferCore& transforms, double timeout = 0.0) : transforms_(transforms), timeout_(timeout) {}

  /// Carries out a command at the beginning of a step. A tool that is new is at its pose at once. One that is there already moves
  /// from where it is to where the message has it, over the time since the message before, but at least a step and at most
  /// kLongestMove or a step. Throws InputError, and changes nothing, for values, frames and ids that are not accepted, and for
  /// what is not built. seen: the transform that a command without a stamp uses, or null.
  void apply(const Tool& command, simulation::Simulation& simulation, const std::string& surface_frame,
             const SeenTransform* seen = nullptr);

  /// To be called before each step: gives tools that follow a frame, or have a velocity, their way through it. stamp: of the end
  /// of the step, when a tool is where tf has its frame then. A frame that tf does not know as late is approached where it was
  /// last seen, within the time between that and the time it was seen before, but at least a step and at most kLongestMove or a
  /// step. A tool whose frame is not known stays where it is, and so does one that is silent. Returns a sentence for each of the
  /// former, and for each that falls silent.
  std::vector<std::string> move(const ros::Time& stamp, simulation::Simulation& simulation, const std::string& surface_frame);

  /// Pins the points in a region and has the header's frame of tf carry them, as it carries tools. Returns how many; throws
  /// InputError for a frame that is not known.
  Index pinToFrame(const std_msgs::Header& header, const geometry::Region& region, simulation::Simulation& simulation,
                   const std::string& surface_frame);

  /// Tools that are there without anybody sending them: each is added as soon as its frame is known, and again after forget();
  /// one that is deleted stays away until then.
  void setStanding(std::vector<Tool> tools) { standing_ = std::move(tools); }

  /// Whether move() may have something to do.
  bool isMoving() const;
  /// A frame that a tool follows and tf does not know as late as the stamp; empty: there is none.
  std::string missingFrame(const ros::Time& stamp, const std::string& surface_frame) const;
  /// Ids of the tools that are silent.
  std::set<std::string> silent() const;

  /// The surface is another or at rest again: the tools of before are gone.
  void forget() {
    courses_.clear();
    pins_.clear();
    stand_.clear();
  }

  /// What a snapshot needs: where tools are going, by id, and which of those that stand have been added.
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

  // Longer pauses between messages are no motion, but a tool that was put elsewhere.
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
  std::set<std::string> stand_;  // ids of those that have been added
};

}  // namespace deformable_surface::node
