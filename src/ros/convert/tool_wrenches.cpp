#include "deformable_surface/ros/convert/tool_wrenches.h"

namespace deformable_surface::node {
namespace {

geometry_msgs::Vector3 toMessage(const Vec3& v) {
  geometry_msgs::Vector3 message;
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
  return message;
}

}  // namespace

ToolWrenchArray makeToolWrenches(const std_msgs::Header& header, const std::vector<simulation::ToolReaction>& reactions,
                                 const std::vector<simulation::PinReaction>& pins, const std::set<std::string>& silent) {
  ToolWrenchArray message;
  message.header = header;
  for (const simulation::ToolReaction& reaction : reactions) {
    ToolWrench wrench;
    wrench.id = reaction.id;
    wrench.wrench.force = toMessage(reaction.force);
    wrench.wrench.torque = toMessage(reaction.torque);
    wrench.contacts = static_cast<std::uint32_t>(reaction.contacts);
    wrench.penetration = reaction.penetration;
    wrench.silent = wrench.stale = silent.count(reaction.id) > 0;
    message.wrenches.push_back(wrench);
  }
  for (const simulation::PinReaction& reaction : pins) {
    PinWrench wrench;
    wrench.id = reaction.id;
    wrench.wrench.force = toMessage(reaction.force);
    wrench.wrench.torque = toMessage(reaction.torque);
    wrench.points = static_cast<std::uint32_t>(reaction.points);
    message.pins.push_back(wrench);
  }
  return message;
}

geometry_msgs::WrenchStamped makeToolWrench(const std_msgs::Header& header, const simulation::ToolReaction& reaction,
                                            const tool::Pose& pose) {
  geometry_msgs::WrenchStamped message;
  message.header = header;
  message.wrench.force = toMessage(pose.orientation * reaction.force);
  message.wrench.torque = toMessage(pose.orientation * reaction.torque);
  return message;
}

}  // namespace deformable_surface::node
