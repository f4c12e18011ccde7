// Interactive markers in RViz to pull, pin and move tools on a surface. The program uses the public topics and services of a
// running node. The node does not depend on it.
#pragma once

#include "marker_params.h"
#include "marker_shapes.h"
#include "marker_way.h"

#include "deformable_surface/Statistics.h"
#include "deformable_surface/ToolArray.h"
#include "deformable_surface/ToolWrenchArray.h"

#include <interactive_markers/interactive_marker_server.h>
#include <interactive_markers/menu_handler.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace deformable_surface::node {

class MarkerServer {
 public:
  /// The markers come below the private name of the node: ~update and ~feedback.
  explicit MarkerServer(const MarkerParams& params);

 private:
  using Feedback = visualization_msgs::InteractiveMarkerFeedbackConstPtr;
  /// A pull in progress: a tool that moves what it grips.
  struct Grip {
    std::string handle;    // the marker that is dragged
    Vec3 from, start;      // m: the place that was gripped, and where the handle was then
    bool is_sent = false;  // a mere click grips nothing
    ros::WallTime heard;   // last feedback; RViz sends it several times a second while the button is down
    bool holds = false;    // according to the tool wrenches
  };
  struct HeldTool {
    MarkedTool tool;  // its pose is that of the marker
    /// Where the surface has it.
    geometry_msgs::Pose pose() const { return way ? makePose(way->pose()) : tool.pose; }

    bool is_warm_hand = false;  // the user says when it takes hold; while it moves, it heats what is behind it
    bool acts = true;           // false: only its marker exists
    bool is_warm = false;       // the surface has its heat
    double spacing = 0.0;       // m, of the surface when it was made: the sizes of a hand do not change while particles are added
    std::optional<std::uint32_t> num_told;  // of the particles that it holds, the number that was told
    ros::WallTime held_since;
    std::optional<MarkerWay> way;  // of one that acts and has a largest speed
    ros::WallTime sent;
    int repeats = 0;  // sent again because the surface did not have it
  };

  // From the surface.
  void takePoints(const sensor_msgs::PointCloud2& message);
  void takeWrenches(const ToolWrenchArray& message);
  void takeStatistics(const Statistics& message);
  void noticeSlip(const ToolWrenchArray& message);
  void measure();
  void refresh();
  void followSurface();

  // From the user.
  void onPull(const Feedback& feedback);
  void onTool(const Feedback& feedback);
  void moveGrip(const Vec3& handle);
  void endGrip();
  void chooseSpot(const Vec3& point);
  std::size_t findSpot() const;
  Vec3 normalAt(std::size_t row) const;

  // Menus.
  void makeMenus();
  void addTool(std::uint8_t mode, const shape_msgs::SolidPrimitive& primitive);
  void addWarmHand();
  std::string makeId();
  void takeHold(HeldTool& hand);
  void letGo(HeldTool& hand);
  void release(HeldTool& hand);
  void drop(const std::string& id);
  void dropUnwanted();
  static std::string warmthOf(const std::string& hand) { return hand + "_warmth"; }
  MarkedTool makeWarmth(const HeldTool& hand) const;
  void removeTool(HeldTool& held);
  void pin(const char* service);
  void spray();
  void edit(std::uint8_t action, double reach);
  void pause(bool paused);
  void takeSteps(std::uint32_t count);

  void showTool(HeldTool& held);
  void showPanel();
  void follow(HeldTool& held, double elapsed);
  double limitOf(const HeldTool& held) const;
  void makeWay(HeldTool& held);
  void sendHeld(HeldTool& held, bool begins_anew = false);
  Tool makeMessage(const MarkedTool& tool, std::uint8_t action);
  void send(const MarkedTool& tool, std::uint8_t action);
  template <class Service>
  void call(const char* name, Service& service);
  void showAnswer(const std::string& sentence, bool is_good);

  bool isOfParticles() const { return !ids_.empty(); }
  double radius() const { return params_.radius.valueOr(kRadiusShare * spacing_); }

  // The tool that grips the surface; added tools have a number.
  static constexpr char kGripId[] = "hand";
  // Holds the nearest points and not only one.
  static constexpr double kRadiusShare = 1.5;
  // s: by then the surface has answered a command.
  static constexpr double kRepeatPeriod = 1.0;

  const MarkerParams params_;
  const std::string surface_;
  ros::NodeHandle node_;
  ros::Publisher tools_;
  ros::Subscriber points_subscriber_, wrenches_subscriber_, statistics_subscriber_;
  ros::WallTimer timer_;
  interactive_markers::InteractiveMarkerServer server_;
  interactive_markers::MenuHandler spot_menu_, panel_menu_, tool_menu_, hand_menu_;
  bool has_menus_ = false;

  // The surface as of its last message, and as it was shown last.
  std_msgs::Header header_;
  Points points_, normals_, shown_;
  std::vector<std::uint32_t> ids_;       // of oriented particles, else empty
  std::size_t num_measured_ = 0;         // points of which the next two are
  double spacing_ = 0.0, extent_ = 0.0;  // m
  TextPlace text_place_;

  std::uint32_t spot_ = 0;  // a row of points_, or the id of a particle
  std::optional<Grip> grip_;
  std::map<std::string, HeldTool> held_;
  std::set<std::string> there_;          // tools that the surface has, according to the tool wrenches
  ros::Time there_stamp_, began_stamp_;  // of these wrenches; of the first statistics since the surface began anew
  // Of warm hands that hold nothing, also of those without a marker: when each was last deleted; zero: not yet. A command on its
  // way during a reset, or a snapshot, can bring them back.
  std::map<std::string, ros::WallTime> unwanted_;
  std::optional<double> time_;  // s, of the surface, since the cloud with the number
  std::uint32_t cloud_ = 0;
  int num_made_ = 0;  // tools and sprays so far, for unique names
  std::uint32_t num_commands_ = 0;
  std::string sentence_;
};

}  // namespace deformable_surface::node
