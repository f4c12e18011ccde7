// Input of `simulate` from a bag: clouds, forces, wrenches and tools in the order of their stamps, and the transforms that
// these need.
#pragma once

#include "deformable_surface/PointForce.h"
#include "deformable_surface/ros/convert/cloud_decoder.h"
#include "deformable_surface/ros/convert/frames.h"
#include "deformable_surface/ros/convert/tool_decoder.h"

#include <geometry_msgs/WrenchStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2/buffer_core.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace deformable_surface::node {

class InputBag {
 public:
  /// topics: from cloud_in, force, wrench, tools to topics, with or without a leading slash here and in the bag; required: the
  /// names whose topics must exist; the topic of the clouds always must. Throws InputError, naming the file and the topic, for
  /// a bag that cannot be read, lacks a required topic, or has messages of another type there.
  /// time_step: ns. find_frame: the surface's frame, from that of a cloud; replaces: whether later clouds make new surfaces.
  InputBag(const std::string& file, const std::map<std::string, std::string>& topics, std::set<std::string> required,
           const DecodeLimits& limits, std::int64_t time_step,
           const std::function<std::string(const std::string& cloud_frame)>& find_frame, bool replaces);

  struct Event {
    // ns; of the message. If that is zero: for a cloud, when it was recorded; for a command, as if it arrived then
    // (stampOfArrival()).
    std::int64_t stamp = 0;
    std::variant<DecodedCloud, PointForce, geometry_msgs::WrenchStamped, DecodedTools> message;  // of tools one, or a problem
    // For a command without a stamp: the transform that tf knew when it was recorded, or the frame that tf did not know then and
    // for a while after.
    std::optional<SeenTransform> seen;
    std::string unknown_frame;
  };
  /// The places of the events, by stamp; equal stamps in the order of the bag. Each tool of a message is an event of its own.
  struct Entry {
    rosbag::MessageInstance instance;
    std::size_t tool = 0;  // which of the message's
    std::optional<SeenTransform> seen;
    std::string unknown_frame;
  };
  const std::multimap<std::int64_t, Entry>& entries() const { return entries_; }
  /// One event. Clouds are decoded here, so that only one is in memory.
  Event read(std::int64_t stamp, const Entry& entry) const;

  /// All transforms of the bag, for events with a stamp.
  const tf2::BufferCore& transforms() const { return *transforms_; }

 private:
  // A command without a stamp whose transform tf did not know yet, found while the bag is read in the order of its recording.
  struct Unknown {
    std::int64_t recorded;  // ns
    std::string frame;
    Entry entry;
    bool has_waited = false;  // for tf, not only for the surface's frame
  };

  void index(const std::map<std::string, std::string>& topics, std::set<std::string> required);
  void read();
  void addEntries(const rosbag::MessageInstance& instance);
  void addCommand(std::int64_t recorded, const std_msgs::Header& header, bool has_frame, Entry entry);
  void addTransforms(const rosbag::MessageInstance& instance);
  void seeAgain(std::int64_t recorded);
  void giveUp(const Unknown& unknown);

  std::string file_;
  DecodeLimits limits_;
  std::int64_t time_step_;  // ns
  rosbag::Bag bag_;
  std::unique_ptr<rosbag::View> view_;
  std::multimap<std::int64_t, Entry> entries_;
  std::unique_ptr<tf2::BufferCore> transforms_;
  std::function<std::string(const std::string&)> find_frame_;
  bool replaces_;
  std::string surface_frame_;  // empty before the first cloud
  std::vector<Unknown> unknown_;
};

}  // namespace deformable_surface::node
