#include "simulate_bag.h"

#include "deformable_surface/ToolArray.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/ros/convert/frames.h"
#include "deformable_surface/ros/convert/step_schedule.h"

#include <ros/serialization.h>
#include <tf2/exceptions.h>
#include <tf2_msgs/TFMessage.h>

#include <chrono>
#include <utility>

namespace deformable_surface::node {
namespace {

std::vector<std::uint8_t> readBytes(const rosbag::MessageInstance& instance) {
  std::vector<std::uint8_t> bytes(instance.size());
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  instance.write(stream);
  return bytes;
}

// The header at the beginning of a message; without the frame's name if it claims more bytes than there are.
std_msgs::Header readHeader(const rosbag::MessageInstance& instance) {
  std::vector<std::uint8_t> bytes = readBytes(instance);
  std_msgs::Header header;
  ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  try {
    stream.next(header);
  } catch (const ros::serialization::StreamOverrunException&) {}
  return header;
}

std::int64_t toNanoseconds(const ros::Time& time) { return static_cast<std::int64_t>(time.toNSec()); }

DecodedTools decode(const rosbag::MessageInstance& instance) {
  const std::vector<std::uint8_t> bytes = readBytes(instance);
  return decodeTools(bytes.data(), bytes.size());
}

struct Type {
  std::string name, md5sum;
};

template <class Message>
Type makeType() {
  return {ros::message_traits::datatype<Message>(), ros::message_traits::md5sum<Message>()};
}

// The type of the messages accepted under a name.
Type findType(const std::string& name) {
  if (name == "cloud_in") return makeType<sensor_msgs::PointCloud2>();
  if (name == "force") return makeType<PointForce>();
  if (name == "wrench") return makeType<geometry_msgs::WrenchStamped>();
  return makeType<ToolArray>();
}

bool isType(const rosbag::ConnectionInfo& connection, const Type& type) {
  return connection.datatype == type.name && connection.md5sum == type.md5sum;
}

// Some recorders write names without the leading slash.
std::string removeSlash(const std::string& topic) { return topic[0] == '/' ? topic.substr(1) : topic; }

}  // namespace

InputBag::InputBag(const std::string& file, const std::map<std::string, std::string>& topics, std::set<std::string> required,
                   const DecodeLimits& limits, std::int64_t time_step,
                   const std::function<std::string(const std::string&)>& find_frame, bool replaces)
    : file_(file), limits_(limits), time_step_(time_step), find_frame_(find_frame), replaces_(replaces) {
  try {
    bag_.open(file, rosbag::bagmode::Read);
    index(topics, std::move(required));
    read();
  } catch (const rosbag::BagException& error) {
    throw InputError(file + ": cannot be read as a bag (" + error.what() + "); accepted: a complete .bag file of ROS 1");
  } catch (const ros::serialization::StreamOverrunException&) {
    throw InputError(file + ": found a message shorter than its type; accepted: a complete .bag file of ROS 1");
  }
}

void InputBag::index(const std::map<std::string, std::string>& topics, std::set<std::string> required) {
  std::map<std::string, std::string> name_of;  // by the topic without its slash
  for (const auto& [name, topic] : topics) {
    const auto [same, is_new] = name_of.emplace(removeSlash(topic), name);
    if (!is_new) {
      throw InputError("--topic: found " + quote(topic) + " for both " + same->second + " and " + name +
                       "; accepted: different topics");
    }
  }

  required.insert("cloud_in");
  std::vector<std::string> wanted;  // as the bag writes them
  rosbag::View all(bag_);
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    const auto found = name_of.find(removeSlash(connection->topic));
    if (found == name_of.end()) continue;
    const std::string& name = found->second;
    const Type type = findType(name);
    if (!isType(*connection, type)) {
      throw InputError(file_ + ": found messages of type " + quote(connection->datatype) + " (md5sum " +
                       quote(connection->md5sum) + ") on " + quote(connection->topic) + "; accepted for " + name + ": " +
                       type.name + " of this version");
    }
    wanted.push_back(connection->topic);
    required.erase(name);
  }
  if (!required.empty()) {
    const std::string& name = *required.begin();
    const Type type = findType(name);
    std::set<std::string> others;
    for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
      if (isType(*connection, type)) others.insert(quote(connection->topic));
    }
    std::string list;
    for (const std::string& topic : others) list += " " + topic;
    throw InputError(file_ + ": found no messages on " + quote(topics.at(name)) + "; accepted: --topic " + name +
                     "=TOPIC with one of" +
                     (list.empty() ? " those that have " + type.name + ", of which this bag has none" : list));
  }

  view_ = std::make_unique<rosbag::View>(bag_, rosbag::TopicQuery(wanted));
}

// In the order of recording, so that a command without a stamp uses what tf knew when it came.
void InputBag::read() {
  rosbag::View view(bag_, rosbag::TopicQuery(std::vector<std::string>{"/tf", "tf", "/tf_static", "tf_static"}));
  // The buffer holds the whole bag, plus a second for stamps that are older than their recording.
  const ros::Duration length = view.size() == 0 ? ros::Duration(0.0) : view.getEndTime() - view.getBeginTime();
  transforms_ = std::make_unique<tf2::BufferCore>(length + ros::Duration(1.0));
  auto transform = view.begin();
  for (const rosbag::MessageInstance& instance : *view_) {
    for (; transform != view.end() && transform->getTime() <= instance.getTime(); ++transform) addTransforms(*transform);
    addEntries(instance);
  }
  for (; transform != view.end(); ++transform) addTransforms(*transform);
  for (const Unknown& unknown : unknown_) giveUp(unknown);
  unknown_.clear();
}

void InputBag::addTransforms(const rosbag::MessageInstance& instance) {
  const tf2_msgs::TFMessage::ConstPtr message = instance.instantiate<tf2_msgs::TFMessage>();
  if (!message) return;
  for (const geometry_msgs::TransformStamped& transform : message->transforms)
    transforms_->setTransform(transform, "bag", removeSlash(instance.getTopic()) == "tf_static");
  seeAgain(toNanoseconds(instance.getTime()));
}

void InputBag::addEntries(const rosbag::MessageInstance& instance) {
  const std::int64_t recorded = toNanoseconds(instance.getTime());
  if (!instance.isType<ToolArray>()) {
    const std_msgs::Header header = readHeader(instance);
    if (!instance.isType<sensor_msgs::PointCloud2>()) return addCommand(recorded, header, true, {instance, 0, {}, {}});
    entries_.emplace(header.stamp.isZero() ? recorded : toNanoseconds(header.stamp), Entry{instance, 0, {}, {}});
    if (surface_frame_.empty() || replaces_) surface_frame_ = find_frame_(header.frame_id);
    return seeAgain(recorded);
  }
  const DecodedTools decoded = decode(instance);
  if (!decoded.ok()) entries_.emplace(recorded, Entry{instance, 0, {}, {}});
  for (std::size_t i = 0; i < decoded.tools.size(); ++i) {
    const Tool& tool = decoded.tools[i];
    addCommand(recorded, tool.header, tool.action == Tool::ADD, {instance, i, {}, {}});
  }
}

void InputBag::addCommand(std::int64_t recorded, const std_msgs::Header& header, bool has_frame, Entry entry) {
  if (!header.stamp.isZero()) {
    entries_.emplace(toNanoseconds(header.stamp), std::move(entry));
    return;
  }
  unknown_.push_back({recorded, has_frame ? withoutSlash(header.frame_id) : "", std::move(entry), false});
  seeAgain(recorded);
}

// As in the node: a command waits for its frame for a while, and then counts from the step in which the frame came.
void InputBag::seeAgain(std::int64_t recorded) {
  std::vector<Unknown> rest;
  for (Unknown& unknown : unknown_) {
    const std::string& frame = unknown.frame;
    if (unknown.has_waited && std::chrono::nanoseconds(recorded - unknown.recorded) > kTransformPatience) {
      giveUp(unknown);
      continue;
    }
    if (!surface_frame_.empty()) unknown.entry.seen = seeTransform(frame, surface_frame_, *transforms_);
    if (unknown.entry.seen || frame.empty() || frame == withoutSlash(surface_frame_)) {
      entries_.emplace(stampOfArrival(unknown.has_waited ? recorded : unknown.recorded, time_step_), std::move(unknown.entry));
      continue;
    }
    unknown.has_waited = !surface_frame_.empty();
    rest.push_back(std::move(unknown));
  }
  unknown_ = std::move(rest);
}

void InputBag::giveUp(const Unknown& unknown) {
  Entry entry = unknown.entry;
  entry.unknown_frame = unknown.frame;
  entries_.emplace(stampOfArrival(unknown.recorded, time_step_), std::move(entry));
}

InputBag::Event InputBag::read(std::int64_t stamp, const Entry& entry) const {
  const rosbag::MessageInstance& instance = entry.instance;
  Event event;
  event.stamp = stamp;
  event.seen = entry.seen;
  event.unknown_frame = entry.unknown_frame;
  try {
    if (const auto force = instance.instantiate<PointForce>()) {
      event.message = *force;
    } else if (const auto wrench = instance.instantiate<geometry_msgs::WrenchStamped>()) {
      event.message = *wrench;
    } else if (instance.isType<ToolArray>()) {
      DecodedTools decoded = decode(instance);
      if (decoded.ok()) decoded.tools = {decoded.tools[entry.tool]};
      event.message = std::move(decoded);
    } else {
      const std::vector<std::uint8_t> bytes = readBytes(instance);
      event.message = decodeCloud(bytes.data(), bytes.size(), limits_);
    }
  } catch (const rosbag::BagException& error) {
    throw InputError(file_ + ": cannot be read to its end (" + error.what() + "); accepted: a complete .bag file of ROS 1");
  } catch (const ros::serialization::StreamOverrunException&) {
    throw InputError(file_ + ": found a message shorter than its type; accepted: a complete .bag file of ROS 1");
  }
  return event;
}

}  // namespace deformable_surface::node
