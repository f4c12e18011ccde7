#include "deformable_surface/ros/convert/contacts.h"

namespace deformable_surface::node {
namespace {

template <class Message>
void write(const Vec3& v, Message& message) {
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
}

}  // namespace

ContactArray makeContacts(const std_msgs::Header& header, const std::vector<tool::ToolParams>& tools,
                          const std::vector<simulation::Contact>& contacts, const std::vector<simulation::SelfTouch>& touches) {
  ContactArray message;
  message.header = header;
  const auto add = [&](const auto& touch) -> Contact& {
    message.contacts.emplace_back();
    Contact& contact = message.contacts.back();
    write(touch.position, contact.position);
    write(touch.normal, contact.normal);
    contact.depth = touch.depth;
    write(touch.force, contact.force);
    return contact;
  };
  for (const simulation::Contact& touch : contacts) {
    Contact& contact = add(touch);
    contact.tool = tools[touch.tool].id;
    contact.points = {static_cast<std::uint32_t>(touch.point)};
    contact.weights = {1.0};
  }
  for (const simulation::SelfTouch& touch : touches) {
    Contact& contact = add(touch);
    contact.points.assign(std::begin(touch.points), std::end(touch.points));
    contact.weights.assign(std::begin(touch.weights), std::end(touch.weights));
  }
  return message;
}

}  // namespace deformable_surface::node
