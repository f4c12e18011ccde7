#include "simulate_bag.h"

#include "deformable_surface/ToolArray.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/value.h"

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

// A message that begins with a header has its stamp behind the 4 bytes of the sequence number.
std::int64_t readStamp(const rosbag::MessageInstance& instance) {
  const std::vector<std::uint8_t> bytes = readBytes(instance);
  std::uint32_t seconds = 0, nanoseconds = 0;
  if (bytes.size() >= 12) {
    std::memcpy(&seconds, bytes.data() + 4, sizeof seconds);
    std::memcpy(&nanoseconds, bytes.data() + 8, sizeof nanoseconds);
  }
  const std::int64_t stamp = std::int64_t{seconds} * 1000000000 + nanoseconds;
  return stamp != 0 ? stamp : static_cast<std::int64_t>(instance.getTime().toNSec());
}

template <class Message>
bool isType(const rosbag::ConnectionInfo& connection) {
  return connection.datatype == ros::message_traits::datatype<Message>() &&
         connection.md5sum == ros::message_traits::md5sum<Message>();
}

}  // namespace

InputBag::InputBag(const std::string& file, const std::map<std::string, std::string>& topics, const DecodeLimits& limits)
    : file_(file), limits_(limits) {
  try {
    bag_.open(file, rosbag::bagmode::Read);
    index(topics);
    readTransforms();
  } catch (const rosbag::BagException& error) {
    throw InputError(file + ": cannot be read as a bag (" + error.what() + "); accepted: a complete .bag file of ROS 1");
  } catch (const ros::serialization::StreamOverrunException&) {
    throw InputError(file + ": found a message shorter than its type; accepted: a complete .bag file of ROS 1");
  }
}

void InputBag::index(const std::map<std::string, std::string>& topics) {
  std::map<std::string, std::string> name_of;
  std::vector<std::string> wanted;
  for (const auto& [name, topic] : topics) {
    if (!name_of.emplace(topic, name).second) {
      throw InputError("--topic: found " + quote(topic) + " for both " + name_of[topic] + " and " + name +
                       "; accepted: different topics");
    }
    wanted.push_back(topic);
  }
  view_ = std::make_unique<rosbag::View>(bag_, rosbag::TopicQuery(wanted));

  bool has_cloud = false;
  for (const rosbag::ConnectionInfo* connection : view_->getConnections()) {
    const std::string& name = name_of.at(connection->topic);
    if (name == "tools") throw InputError(file_ + ": found rigid tools on " + connection->topic + ", which are not built yet");
    const bool accepted = name == "cloud_in" ? isType<sensor_msgs::PointCloud2>(*connection)
                          : name == "force"  ? isType<PointForce>(*connection)
                                             : isType<geometry_msgs::WrenchStamped>(*connection);
    if (!accepted) {
      throw InputError(file_ + ": found messages of type " + quote(connection->datatype) + " (md5sum " +
                       quote(connection->md5sum) + ") on " + quote(connection->topic) + "; accepted for " + name + ": " +
                       (name == "cloud_in" ? "sensor_msgs/PointCloud2"
                        : name == "force"  ? "deformable_surface/PointForce"
                                           : "geometry_msgs/WrenchStamped") +
                       " of this version");
    }
    has_cloud = has_cloud || name == "cloud_in";
  }
  if (!has_cloud) {
    std::set<std::string> clouds;
    for (const rosbag::ConnectionInfo* connection : rosbag::View(bag_).getConnections()) {
      if (isType<sensor_msgs::PointCloud2>(*connection)) clouds.insert(quote(connection->topic));
    }
    std::string found;
    for (const std::string& topic : clouds) found += " " + topic;
    throw InputError(file_ + ": found no cloud on " + quote(topics.at("cloud_in")) +
                     "; accepted: --topic cloud_in=TOPIC with one of" +
                     (found.empty() ? " those that have sensor_msgs/PointCloud2, of which this bag has none" : found));
  }

  for (const rosbag::MessageInstance& instance : *view_) entries_.emplace(readStamp(instance), instance);
}

void InputBag::readTransforms() {
  rosbag::View view(bag_, rosbag::TopicQuery(std::vector<std::string>{"/tf", "/tf_static"}));
  // The buffer holds the whole bag, and a second more for stamps that are older than their recording.
  const ros::Duration length = view.size() == 0 ? ros::Duration(0.0) : view.getEndTime() - view.getBeginTime();
  transforms_ = std::make_unique<tf2::BufferCore>(length + ros::Duration(1.0));
  for (const rosbag::MessageInstance& instance : view) {
    const tf2_msgs::TFMessage::ConstPtr message = instance.instantiate<tf2_msgs::TFMessage>();
    if (!message) continue;
    for (const geometry_msgs::TransformStamped& transform : message->transforms) {
      transforms_->setTransform(transform, "bag", instance.getTopic() == "/tf_static");
    }
  }
}

InputBag::Event InputBag::read(std::int64_t stamp, const rosbag::MessageInstance& instance) const {
  Event event;
  event.stamp = stamp;
  try {
    if (const auto force = instance.instantiate<PointForce>()) {
      event.message = *force;
    } else if (const auto wrench = instance.instantiate<geometry_msgs::WrenchStamped>()) {
      event.message = *wrench;
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
