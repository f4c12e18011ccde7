#include "registration_watchdog.h"

#include <ros/connection_manager.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpcClient.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <chrono>
#include <cstdint>
#include <exception>
#include <utility>

namespace deformable_surface::node {
namespace {

using XmlRpc::XmlRpcValue;

// The first part of an answer of the master or slave API.
constexpr int kSuccess = 1;

// Restarts are rare; each check opens a connection, which would cost a resting node time.
constexpr std::chrono::milliseconds kPeriod(4000);
// A node that shuts down unregisters before it says so: only a lasting absence counts.
constexpr std::chrono::milliseconds kGrace(200);

// A master answers within milliseconds; one that takes longer than this hangs.
constexpr std::chrono::seconds kPatience(5);
// How soon a shutdown is noticed while waiting for an answer, s.
constexpr double kLook = 0.05;

/// Knows whether an answer may still come.
class Client : public XmlRpc::XmlRpcClient {
 public:
  using XmlRpcClient::XmlRpcClient;
  bool isConnected() const { return _connectionState != NO_CONNECTION; }
  void waitForEvents() { _disp.work(kLook); }
};

int count(const XmlRpcValue& list) { return list.getType() == XmlRpcValue::TypeArray ? list.size() : 0; }

}  // namespace

// The addresses are read here, not when they are needed: roscpp cannot give them during shutdown.
RegistrationWatchdog::RegistrationWatchdog(std::vector<std::string> services)
    : services_(std::move(services)),
      uri_(ros::XMLRPCManager::instance()->getServerURI()),
      service_uri_("rosrpc://" + ros::network::getHost() + ":" +
                   std::to_string(ros::ConnectionManager::instance()->getTCPPort())),
      thread_([this] { run(); }) {}

RegistrationWatchdog::~RegistrationWatchdog() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ended_ = true;
  }
  ended_.notify_all();
  thread_.join();
}

bool RegistrationWatchdog::waitOrEnd(std::chrono::milliseconds time) {
  std::unique_lock<std::mutex> lock(mutex_);
  return ended_.wait_for(lock, time, [this] { return is_ended_; }) || !ros::ok() || ros::isShuttingDown();
}

// Not by roscpp's own calls: they wait without limit, and their clients are deleted under them when roscpp shuts down.
template <class... Values>
std::optional<XmlRpcValue> RegistrationWatchdog::ask(const std::string& uri, const char* method, const Values&... values) {
  XmlRpcValue arguments, answer;
  int i = 0;
  arguments[i++] = ros::this_node::getName();
  ((arguments[i++] = values), ...);

  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(uri, host, port)) return std::nullopt;
  Client client(host.c_str(), static_cast<int>(port), "/");
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  if (!client.executeNonBlock(method, arguments)) return std::nullopt;
  while (!client.executeCheckDone(answer)) {
    if (!client.isConnected() || waitOrEnd(std::chrono::milliseconds(0)) || std::chrono::steady_clock::now() > give_up)
      return std::nullopt;
    client.waitForEvents();
  }
  if (client.isFault() || count(answer) < 3) return std::nullopt;
  return answer;
}

bool RegistrationWatchdog::isMissing() {
  const auto isUnknown = [&](const char* question, const std::string& name) {
    std::optional<XmlRpcValue> answer = ask(ros::master::getURI(), question, name);
    return answer && static_cast<int>((*answer)[0]) != kSuccess;
  };
  if (isUnknown("lookupNode", ros::this_node::getName())) return true;
  // roscpp repeats a call that a dying master left unanswered: the new master then knows the node, but not the rest of it.
  return !services_.empty() && isUnknown("lookupService", services_.back());
}

void RegistrationWatchdog::registerAll() {
  const std::string master = ros::master::getURI();

  if (std::optional<XmlRpcValue> topics = ask(uri_, "getPublications")) {
    for (int i = 0; i < count((*topics)[2]); ++i)
      ask(master, "registerPublisher", std::string((*topics)[2][i][0]), std::string((*topics)[2][i][1]), uri_);
  }

  if (std::optional<XmlRpcValue> topics = ask(uri_, "getSubscriptions")) {
    for (int i = 0; i < count((*topics)[2]); ++i) {
      const std::string topic = (*topics)[2][i][0];
      std::optional<XmlRpcValue> publishers = ask(master, "registerSubscriber", topic, std::string((*topics)[2][i][1]), uri_);
      // Publishers that registered before this node are reported by nobody else.
      if (publishers && static_cast<int>((*publishers)[0]) == kSuccess) ask(uri_, "publisherUpdate", topic, (*publishers)[2]);
    }
  }

  for (const std::string& service : services_) ask(master, "registerService", service, service_uri_, uri_);
  for (const char* service : {"/get_loggers", "/set_logger_level"})
    ask(master, "registerService", ros::this_node::getName() + service, service_uri_, uri_);
}

void RegistrationWatchdog::keepParameters(const std::string& name, const XmlRpcValue& tree) {
  const std::lock_guard<std::mutex> lock(mutex_);
  parameters_name_ = name;
  parameters_ = tree;
}

// Parameters of a launch file that restarted the roscore are newer.
void RegistrationWatchdog::restoreParameters() {
  std::string name;
  XmlRpcValue tree;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    name = parameters_name_;
    tree = parameters_;
  }
  if (!tree.valid()) return;
  std::optional<XmlRpcValue> known = ask(ros::master::getURI(), "hasParam", name);
  if (!known || static_cast<int>((*known)[0]) != kSuccess || static_cast<bool>((*known)[2])) return;
  ask(ros::master::getURI(), "setParam", name, tree);
}

void RegistrationWatchdog::run() {
  while (!waitOrEnd(kPeriod)) {
    try {
      if (!isMissing()) continue;
      if (waitOrEnd(kGrace)) return;
      if (!isMissing()) continue;
      restoreParameters();
      registerAll();
      if (waitOrEnd(std::chrono::milliseconds(0))) return;
      ROS_WARN(
          "the roscore was restarted; %s has registered again and set its parameters; parameters of other nodes, and messages "
          "sent before connections were restored, are lost",
          ros::this_node::getName().c_str());
    } catch (const XmlRpc::XmlRpcException& error) {
      ROS_ERROR("registering again after a restart of the roscore failed: %s", error.getMessage().c_str());
    } catch (const std::exception& error) {
      ROS_ERROR("registering again after a restart of the roscore failed: %s", error.what());
    }
  }
}

}  // namespace deformable_surface::node
