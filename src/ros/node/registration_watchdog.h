// Registers the process again after a restart of the roscore, and sets the parameters that the old one had of it.
// roscpp does not: the node would vanish from the graph. New nodes could not find it, while old connections continue.
#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace deformable_surface::node {

class RegistrationWatchdog {
 public:
  /// services: resolved names; topics are found automatically. Runs in a thread of its own, since a master that hangs blocks
  /// its callers.
  explicit RegistrationWatchdog(std::vector<std::string> services);
  ~RegistrationWatchdog();

  /// Sets parameters (a tree) below a name in the new roscore, unless they are set there already.
  void keepParameters(const std::string& name, const XmlRpc::XmlRpcValue& tree);

  RegistrationWatchdog(const RegistrationWatchdog&) = delete;
  RegistrationWatchdog& operator=(const RegistrationWatchdog&) = delete;

 private:
  void run();
  /// True if a reachable master does not know this process, or not all of it.
  bool isMissing();
  /// Leaves existing connections alone; only the registration is renewed.
  void registerAll();
  void restoreParameters();
  /// Calls a master or a slave API, of which this process has one that knows its topics with their types: name of the node and
  /// the values in, code, text and value out. None if there is no answer, or the process ends meanwhile.
  template <class... Values>
  std::optional<XmlRpc::XmlRpcValue> ask(const std::string& uri, const char* method, const Values&... values);
  /// True if the process ends meanwhile.
  bool waitOrEnd(std::chrono::milliseconds time);

  const std::vector<std::string> services_;
  const std::string uri_, service_uri_;
  std::mutex mutex_;
  std::string parameters_name_;
  XmlRpc::XmlRpcValue parameters_;
  std::condition_variable ended_;
  bool is_ended_ = false;
  std::thread thread_;
};

}  // namespace deformable_surface::node
