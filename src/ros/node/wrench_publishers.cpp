#include "wrench_publishers.h"

#include "deformable_surface/ros/convert/contacts.h"
#include "deformable_surface/ros/convert/tool_commands.h"
#include "deformable_surface/ros/convert/tool_wrenches.h"

#include <ros/master.h>
#include <boost/make_shared.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace deformable_surface::node {
namespace {

// Messages are small, and controllers need all of them.
constexpr std::uint32_t kQueue = 100;
// How often to retry while the master is away.
constexpr std::chrono::seconds kMasterPatience(1);

}  // namespace

WrenchPublishers::WrenchPublishers(ros::NodeHandle& node, const std::function<void()>& on_subscriber)
    : node_(node),
      all_(node.advertise<ToolWrenchArray>("tool_wrenches", kQueue,
                                           [on_subscriber](const ros::SingleSubscriberPublisher&) { on_subscriber(); })),
      contacts_(node.advertise<ContactArray>("contacts", kQueue,
                                             [on_subscriber](const ros::SingleSubscriberPublisher&) { on_subscriber(); })),
      statuses_(node.advertise<ToolStatusArray>("tool_status", 1, true)) {}

bool WrenchPublishers::hasSubscribers() const {
  const auto hasOne = [](const auto& entry) { return entry.second.getNumSubscribers() > 0; };
  return all_.getNumSubscribers() > 0 || contacts_.getNumSubscribers() > 0 ||
         std::any_of(of_tool_.begin(), of_tool_.end(), hasOne);
}

void WrenchPublishers::publish(const simulation::Simulation& simulation, std::int64_t stamp, const std::string& frame,
                               const std::set<std::string>& silent) {
  const std::vector<tool::ToolParams>& tools = simulation.tools();
  advertise(tools);
  std_msgs::Header header;
  header.stamp.fromNSec(static_cast<std::uint64_t>(stamp));
  header.frame_id = frame;
  for (const tool::ToolParams& tool : tools)
    if (silent.count(tool.id) == 0) last_stamps_[tool.id] = header.stamp;
  if (!hasSubscribers()) return;
  if (contacts_.getNumSubscribers() > 0 && isContactsDue(simulation.params().output.contacts_rate, stamp))
    contacts_.publish(
        boost::make_shared<ContactArray>(makeContacts(header, tools, simulation.contacts(), simulation.selfTouches())));
  const std::vector<simulation::ToolReaction> reactions = simulation.toolReactions();
  if (all_.getNumSubscribers() > 0)
    all_.publish(boost::make_shared<ToolWrenchArray>(makeToolWrenches(header, reactions, simulation.pinReactions(), silent)));
  for (std::size_t t = 0; t < tools.size(); ++t) {
    const auto found = of_tool_.find(tools[t].id);
    if (found == of_tool_.end() || found->second.getNumSubscribers() == 0) continue;
    const tool::Pose pose = tool::interpolate(tools[t].path, simulation.time());
    std_msgs::Header own = header;
    own.stamp = last_stamps_[tools[t].id];
    found->second.publish(boost::make_shared<geometry_msgs::WrenchStamped>(makeToolWrench(own, reactions[t], pose)));
  }
}

// At most at this rate in the time of the surface; after every step if the rate is 0, and after a jump back.
bool WrenchPublishers::isContactsDue(double rate, std::int64_t stamp) {
  if (!(rate > 0.0)) return true;
  const std::int64_t turn = static_cast<std::int64_t>(std::floor(1e-9 * static_cast<double>(stamp) * rate + 1e-6));
  return std::exchange(contacts_turn_, turn) != turn;
}

// A topic for each tool. Tools of a scene with ids that are no names have none.
void WrenchPublishers::advertise(const std::vector<tool::ToolParams>& tools) {
  const auto isGone = [&](const std::string& id) {
    return std::none_of(tools.begin(), tools.end(), [&](const tool::ToolParams& tool) { return tool.id == id; });
  };
  for (auto entry = of_tool_.begin(); entry != of_tool_.end();)
    entry = isGone(entry->first) ? of_tool_.erase(entry) : std::next(entry);
  for (auto entry = last_stamps_.begin(); entry != last_stamps_.end();)
    entry = isGone(entry->first) ? last_stamps_.erase(entry) : std::next(entry);
  for (const tool::ToolParams& tool : tools) {
    if (of_tool_.count(tool.id) > 0 || !isToolId(tool.id)) continue;
    // roscpp would wait for an absent master, and no step could be taken.
    if (std::chrono::steady_clock::now() < next_try_) return;
    if (!ros::master::check()) {
      next_try_ = std::chrono::steady_clock::now() + kMasterPatience;
      return;
    }
    of_tool_[tool.id] = node_.advertise<geometry_msgs::WrenchStamped>("tools/" + tool.id + "/wrench", kQueue);
  }
}

}  // namespace deformable_surface::node
