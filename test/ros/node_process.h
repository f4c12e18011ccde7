// A program of the package in a process of its own, with the parameters of a scene. Separate from the client of the tests,
// because the benchmark over ROS starts its nodes in the same way.
#pragma once

#include "deformable_surface/io/scene.h"

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace deformable_surface::node::test {

// Long enough for a busy machine. Only a test that fails takes that long.
constexpr double kPatience = 30.0;

/// Processes messages until the condition holds; false if it does not in time.
inline bool waitUntil(const std::function<bool()>& condition, double seconds = kPatience) {
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(seconds);
  while (!condition()) {
    if (ros::WallTime::now() > end || !ros::ok()) return false;
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.005));
  }
  return true;
}

inline XmlRpc::XmlRpcValue toXmlRpc(const Value& value) {
  XmlRpc::XmlRpcValue result;
  if (const bool* flag = value.asBool()) return XmlRpc::XmlRpcValue(*flag);
  if (const std::int64_t* integer = value.asInteger()) return XmlRpc::XmlRpcValue(static_cast<int>(*integer));
  if (const double* real = value.asReal()) return XmlRpc::XmlRpcValue(*real);
  if (const std::string* text = value.asText()) return XmlRpc::XmlRpcValue(*text);
  if (const Value::List* list = value.asList()) {
    result.setSize(static_cast<int>(list->size()));
    for (std::size_t i = 0; i < list->size(); ++i) result[static_cast<int>(i)] = toXmlRpc((*list)[i]);
  }
  if (const Value::Map* map = value.asMap())
    for (const auto& [key, member] : *map) result[key] = toXmlRpc(member);
  return result;
}

/// The node, or another program of the package, in a process of its own. It starts with the parameters of a scene in YAML, or
/// with those that are set already. It ends with this object.
class NodeProcess {
 public:
  explicit NodeProcess(const std::string& name, const std::string& scene = "",
                       const std::string& executable = "deformable_surface_node", std::vector<std::string> options = {}) {
    if (!scene.empty()) ros::param::set(name, toXmlRpc(io::parseYaml(scene, name)));
    output_ = std::filesystem::temp_directory_path() / ("deformable_surface" + std::to_string(getpid()) + "_" + name.substr(1));
    // The executables of a package are in one folder.
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / executable;
    options.insert(options.begin(), program);
    options.push_back("__name:=" + name.substr(1));
    std::vector<char*> arguments;
    for (std::string& option : options) arguments.push_back(option.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    is_running_ = posix_spawn(&process_, program.c_str(), &actions, nullptr, arguments.data(), environ) == 0;
    posix_spawn_file_actions_destroy(&actions);
    if (!is_running_) throw std::runtime_error(program + " cannot be started");
  }
  ~NodeProcess() {
    if (isRunning()) {
      kill(process_, SIGTERM);
      if (!waitForExit()) {
        kill(process_, SIGKILL);
        waitpid(process_, nullptr, 0);
      }
    }
    std::filesystem::remove(output_);
  }
  NodeProcess(const NodeProcess&) = delete;
  NodeProcess& operator=(const NodeProcess&) = delete;

  pid_t id() const { return process_; }
  void send(int signal) { kill(process_, signal); }
  bool isRunning() {
    int status = 0;
    if (is_running_ && waitpid(process_, &status, WNOHANG) == process_) {
      is_running_ = false;
      exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }
    return is_running_;
  }
  /// The exit code, negative for a signal; nothing if it did not end.
  std::optional<int> waitForExit() {
    if (!waitUntil([this] { return !isRunning(); })) return std::nullopt;
    return exit_code_;
  }
  std::string output() const {
    std::stringstream text;
    text << std::ifstream(output_).rdbuf();
    return text.str();
  }

 private:
  std::filesystem::path output_;
  pid_t process_ = 0;
  bool is_running_ = false;
  int exit_code_ = 0;
};

}  // namespace deformable_surface::node::test
