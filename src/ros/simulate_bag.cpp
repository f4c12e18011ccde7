#include "simulate_bag.h"

#include "deformable_surface/ToolArray.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/ros/step_schedule.h"

#include <ros/serialization.h>
#include <tf2/exceptions.h>
#include <tf2_msgs/TFMessage.h>

#include <cstring>
#include <set>
#include <vector>

namespace deformable_surface::node {
namespace {

std::vector<std::uint8_t> readBytes(const rosbag::MessageInstance& instance) {
  std::vector<std::uint8_t> bytes(instance.size());
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  instance.write(stream);
  return bytes;
}

// A message that begins with a header has its stamp behind the 4 bytes of the sequence number. Zero if there is none.
std::int64_t readStamp(const rosbag::MessageInstance& instance) {
  const std::vector<std::uint8_t> bytes = readBytes(instance);
  std::uint32_t seconds = 0, nanoseconds = 0;
  if (bytes.size() >= 12) {
    std::memcpy(&seconds, bytes.data() + 4, sizeof seconds);
    std::memcpy(&nanoseconds, bytes.data() + 8, sizeof nanoseconds);
  }
  return std::int64_t{seconds} * 1000000000 + nanoseconds;
}

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

// Of the messages that are taken under a name.
Type findType(const std::string& name) {
  if (name == "cloud_in") return makeType<sensor_msgs::PointCloud2>();
  if (name == "force") return makeType<PointForce>();
  if (name == "wrench") return makeType<geometry_msgs::WrenchStamped>();
  return makeType<ToolArray>();
}

bool isType(const rosbag::ConnectionInfo& connection, const Type& type) {
  return connection.datatype == type.name && connection.md5sum == type.md5sum;
}

// Some recorders write the names without the slash that others begin them with.
std::string removeSlash(const std::string& topic) { return topic[0] == '/' ? topic.substr(1) : topic; }

}  // namespace

InputBag::InputBag(const std::string& file, const std::map<std::string, std::string>& topics, std::set<std::string> required,
                   const DecodeLimits& limits, std::int64_t time_step)
    : file_(file), limits_(limits), time_step_(time_step) {
  try {
    bag_.open(file, rosbag::bagmode::Read);
    index(topics, std::move(required));
    readTransforms();
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
  for (const rosbag::MessageInstance& instance : *view_) addEntries(instance);
}

void InputBag::addEntries(const rosbag::MessageInstance& instance) {
  const auto recorded = static_cast<std::int64_t>(instance.getTime().toNSec());
  const std::int64_t arrived = stampOfArrival(recorded, time_step_);
  if (!instance.isType<ToolArray>()) {
    const std::int64_t stamp = readStamp(instance);
    const bool is_cloud = instance.isType<sensor_msgs::PointCloud2>();
    entries_.emplace(stamp != 0 ? stamp : is_cloud ? recorded : arrived, Entry{instance});
    return;
  }
  const DecodedTools decoded = decode(instance);
  if (!decoded.ok()) entries_.emplace(recorded, Entry{instance});
  for (std::size_t i = 0; i < decoded.tools.size(); ++i) {
    const ros::Time stamp = decoded.tools[i].header.stamp;
    entries_.emplace(stamp.isZero() ? arrived : static_cast<std::int64_t>(stamp.toNSec()), Entry{instance, i});
  }
}

void InputBag::readTransforms() {
  rosbag::View view(bag_, rosbag::TopicQuery(std::vector<std::string>{"/tf", "tf", "/tf_static", "tf_static"}));
  // The buffer holds the whole bag, and a second more for stamps that are older than their recording.
  const ros::Duration length = view.size() == 0 ? ros::Duration(0.0) : view.getEndTime() - view.getBeginTime();
  transforms_ = std::make_unique<tf2::BufferCore>(length + ros::Duration(1.0));
  for (const rosbag::MessageInstance& instance : view) {
    const tf2_msgs::TFMessage::ConstPtr message = instance.instantiate<tf2_msgs::TFMessage>();
    if (!message) continue;
    for (const geometry_msgs::TransformStamped& transform : message->transforms) {
      transforms_->setTransform(transform, "bag", removeSlash(instance.getTopic()) == "tf_static");
    }
  }
}

InputBag::Event InputBag::read(std::int64_t stamp, const Entry& entry) const {
  const rosbag::MessageInstance& instance = entry.instance;
  Event event;
  event.stamp = stamp;
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
