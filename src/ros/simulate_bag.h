// What `simulate` takes from a bag: clouds, forces, wrenches and tools in the order of their stamps, and the transforms that
// these need.
#pragma once

#include "deformable_surface/PointForce.h"
#include "deformable_surface/ros/cloud_decoder.h"
#include "deformable_surface/ros/tool_decoder.h"

#include <geometry_msgs/WrenchStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2/buffer_core.h>

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <variant>

namespace deformable_surface::node {

class InputBag {
 public:
  /// topics: from cloud_in, force, wrench, tools to topics, with or without a leading slash here and in the bag; required: the
  /// names whose topics must be there, as that of the clouds always must. Throws InputError, naming the file and the topic, for
  /// a bag that cannot be read, lacks a topic that it must have, or has messages of another type there.
  /// time_step: ns.
  InputBag(const std::string& file, const std::map<std::string, std::string>& topics, std::set<std::string> required,
           const DecodeLimits& limits, std::int64_t time_step);

  struct Event {
    // ns; that of the message. If it is zero: of a cloud, when it was recorded; of a command, as of one that arrived then
    // (stampOfArrival()).
    std::int64_t stamp = 0;
    std::variant<DecodedCloud, PointForce, geometry_msgs::WrenchStamped, DecodedTools> message;  // of tools one, or a refusal
  };
  /// Where the events are, by stamp; equal stamps in the order of the bag. Each tool of a message is an event of its own.
  struct Entry {
    rosbag::MessageInstance instance;
    std::size_t tool = 0;  // which of the message's
  };
  const std::multimap<std::int64_t, Entry>& entries() const { return entries_; }
  /// One event. A cloud is decoded here, so that only one is in memory.
  Event read(std::int64_t stamp, const Entry& entry) const;

  /// All transforms of the bag.
  const tf2::BufferCore& transforms() const { return *transforms_; }

 private:
  void index(const std::map<std::string, std::string>& topics, std::set<std::string> required);
  void addEntries(const rosbag::MessageInstance& instance);
  void readTransforms();

  std::string file_;
  DecodeLimits limits_;
  std::int64_t time_step_;  // ns
  rosbag::Bag bag_;
  std::unique_ptr<rosbag::View> view_;
  std::multimap<std::int64_t, Entry> entries_;
  std::unique_ptr<tf2::BufferCore> transforms_;
};

}  // namespace deformable_surface::node
