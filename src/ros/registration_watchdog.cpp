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
#include <memory>
#include <utility>

namespace deformable_surface::node {
namespace {

using XmlRpc::XmlRpcValue;

// Restarts are rare and asking costs less than a millisecond.
constexpr std::chrono::milliseconds kPeriod(1000);
// A node that is shutting down takes itself out of the master's books before it says so: being missing counts when it lasts.
constexpr std::chrono::milliseconds kGrace(200);

template <class... Values>
XmlRpcValue makeArguments(const Values&... values) {
  XmlRpcValue arguments;
  int i = 0;
  arguments[i++] = ros::this_node::getName();
  ((arguments[i++] = values), ...);
  return arguments;
}

/// Asks the master; false if it cannot be reached or refuses.
template <class... Values>
bool askMaster(const std::string& method, XmlRpcValue& answer, const Values&... values) {
  XmlRpcValue response;
  return ros::master::execute(method, makeArguments(values...), response, answer, false);
}

/// The slave API of this very process, which knows its topics with their types.
class Self {
 public:
  explicit Self(const std::string& uri) {
    std::string host;
    std::uint32_t port = 0;
    ros::network::splitURI(uri, host, port);
    client_ = std::make_unique<XmlRpc::XmlRpcClient>(host.c_str(), static_cast<int>(port), "/");
  }
  template <class... Values>
  XmlRpcValue ask(const char* method, const Values&... values) {
    XmlRpcValue answer;
    if (!client_->execute(method, makeArguments(values...), answer) || answer.getType() != XmlRpcValue::TypeArray ||
        answer.size() < 3)
      return XmlRpcValue();
    return answer[2];
  }

 private:
  std::unique_ptr<XmlRpc::XmlRpcClient> client_;
};

int count(const XmlRpcValue& list) { return list.getType() == XmlRpcValue::TypeArray ? list.size() : 0; }

/// Connections that live are left alone; only the master's books are written again.
void registerAll(const std::vector<std::string>& services, const std::string& uri, const std::string& service_uri) {
  Self self(uri);
  XmlRpcValue answer;

  XmlRpcValue topics = self.ask("getPublications");
  for (int i = 0; i < count(topics); ++i)
    askMaster("registerPublisher", answer, std::string(topics[i][0]), std::string(topics[i][1]), uri);

  topics = self.ask("getSubscriptions");
  for (int i = 0; i < count(topics); ++i) {
    const std::string topic = topics[i][0];
    // Publishers that were faster than this node are told to nobody else.
    if (askMaster("registerSubscriber", answer, topic, std::string(topics[i][1]), uri))
      self.ask("publisherUpdate", topic, answer);
  }

  for (const std::string& service : services) askMaster("registerService", answer, service, service_uri, uri);
  for (const char* service : {"/get_loggers", "/set_logger_level"})
    askMaster("registerService", answer, ros::this_node::getName() + service, service_uri, uri);
}

}  // namespace

// The addresses are read here and not when they are needed: while roscpp shuts down it can no longer tell them.
RegistrationWatchdog::RegistrationWatchdog(std::vector<std::string> services)
    : services_(std::move(services)),
      uri_(ros::XMLRPCManager::instance()->getServerURI()),
      service_uri_("rosrpc://" + ros::network::getHost() + ":" + std::to_string(ros::ConnectionManager::instance()->getTCPPort())),
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

void RegistrationWatchdog::run() {
  const auto isMissing = [] {
    XmlRpcValue answer;
    return !askMaster("lookupNode", answer, ros::this_node::getName()) && ros::master::check();
  };
  while (!waitOrEnd(kPeriod)) {
    try {
      if (!isMissing()) continue;
      if (waitOrEnd(kGrace)) return;
      if (!isMissing()) continue;
      registerAll(services_, uri_, service_uri_);
      ROS_WARN("the roscore was restarted; %s registered itself again", ros::this_node::getName().c_str());
    } catch (const XmlRpc::XmlRpcException& error) {
      ROS_ERROR("registering again after a restart of the roscore failed: %s", error.getMessage().c_str());
    } catch (const std::exception& error) {
      ROS_ERROR("registering again after a restart of the roscore failed: %s", error.what());
    }
  }
}

}  // namespace deformable_surface::node
