// Registers the process again after the roscore was restarted, and gives the new one the parameters that the old one had of it.
// roscpp does not: the node would vanish from the graph, and nobody new could find it, while old connections live on.
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
  /// services: resolved names; topics are found by themselves. Runs in a thread of its own, since a master that hangs blocks
  /// whoever asks it.
  explicit RegistrationWatchdog(std::vector<std::string> services);
  ~RegistrationWatchdog();

  /// Sets parameters (a tree) below a name in the new roscore, unless it has some there already.
  void keepParameters(const std::string& name, const XmlRpc::XmlRpcValue& tree);

  RegistrationWatchdog(const RegistrationWatchdog&) = delete;
  RegistrationWatchdog& operator=(const RegistrationWatchdog&) = delete;

 private:
  void run();
  /// True if a master that can be reached does not know this process, or not all of it.
  bool isMissing();
  /// Connections that live are left alone; only the master's books are written again.
  void registerAll();
  void restoreParameters();
  /// Asks a master or a slave API, of which this process has one that knows its topics with their types: the name of the node and
  /// the values in, code, text and value out. Nothing if no answer comes, or the process ends meanwhile.
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
