#include "deformable_surface/ros/node/surface_node.h"

#include "cloud_worker.h"
#include "frame_thread.h"
#include "grow_service.h"
#include "inbox.h"
#include "node_diagnostics.h"
#include "publishers.h"
#include "queue_thread.h"
#include "reconfigure.h"
#include "registration_watchdog.h"
#include "rollouts.h"
#include "services.h"
#include "stepper.h"
#include "warning_log.h"
#include "wrench_publishers.h"

#include "deformable_surface/ToolArray.h"
#include "deformable_surface/base/error.h"
#include "deformable_surface/base/parallel.h"
#include "deformable_surface/base/value.h"
#include "deformable_surface/io/mesh_files.h"
#include "deformable_surface/io/scene.h"
#include "deformable_surface/io/volume_files.h"
#include "deformable_surface/ros/convert/find_package.h"
#include "deformable_surface/ros/convert/robot_tools.h"
#include "deformable_surface/ros/convert/tool_decoder.h"
#include "deformable_surface/ros/convert/xmlrpc_value.h"

#include <ros/callback_queue.h>
#include <ros/console.h>
#include <rosgraph_msgs/Clock.h>
#include <tf2_ros/transform_listener.h>
#include <boost/make_shared.hpp>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <optional>
#include <thread>
#include <utility>

namespace deformable_surface::node {
namespace {

// A second cloud may wait while one is decoded; more would be out of date.
constexpr std::uint32_t kCloudQueue = 2;
// As many commands as come while a large cloud is decoded.
constexpr std::uint32_t kCommandQueue = 1000;
// Every message of the clock counts, since the steps between two jumps depend on it.
constexpr std::uint32_t kClockQueue = 10000;
// Drivers and players of bags have started by then. A wrong remapping would otherwise show no sign.
constexpr std::chrono::seconds kCloudPatience(10);

// The robot's links as tools; none if the parameters name none. Throws InputError.
std::vector<Tool> readRobotTools(const ros::NodeHandle& private_node, const tool::RobotParams& robot) {
  if (robot.links.empty()) return {};
  if (!robot.file.empty()) return makeRobotTools(readDescription(robot.file), robot.links);
  std::string name, urdf;
  if (!private_node.searchParam(robot.description, name) || !private_node.getParam(name, urdf))
    throw InputError("robot.description: found no parameter " + quote(robot.description) +
                     "; accepted: one that holds a URDF, or robot.file");
  return makeRobotTools(urdf, robot.links);
}

}  // namespace

simulation::SceneParams readNodeParameters(const ros::NodeHandle& private_node) {
  XmlRpc::XmlRpcValue tree;
  private_node.getParam(private_node.getNamespace(), tree);
  Value::Map scene;
  if (tree.valid() && tree.getType() == XmlRpc::XmlRpcValue::TypeStruct) {
    const Value all = toValue(tree);
    for (const auto& [key, value] : *all.asMap())
      if (key != kRolloutName) scene.emplace_back(key, value);
  }
  simulation::SceneParams params = io::readScene(Value(std::move(scene)));
  io::readMeshFiles(params.tools, findPackage);
  io::readGuide(params.oriented_particles.guide, findPackage);
  const std::filesystem::path directory = params.save_directory;
  std::error_code error;
  if (!directory.empty() && !(directory.is_absolute() && std::filesystem::is_directory(directory, error)))
    throw InputError("save_directory: found " + quote(params.save_directory) +
                     "; accepted: the absolute path of a directory that is there");
  return params;
}

struct SurfaceNode::Impl {
  ros::CallbackQueue input_queue, service_queue, reset_queue;
  ros::NodeHandle node, private_node, service_node, reset_node;
  WarningLog warnings;
  tf2::BufferCore transforms;
  Inbox inbox;
  CloudWorker worker;
  tf2_ros::TransformListener transform_listener;
  Publishers publishers;
  FrameThread frames;
  WrenchPublishers wrenches;
  Stepper stepper;
  std::optional<NodeDiagnostics> diagnostics;
  Services services;
  GrowService grow;
  Rollouts rollouts;
  Reconfigure reconfigure;
  ros::Subscriber cloud_subscriber;
  std::vector<ros::Subscriber> subscribers;
  std::atomic<bool> has_cloud_come{false};
  RegistrationWatchdog watchdog;
  QueueThread input_thread, service_thread, reset_thread;
  std::thread simulation_thread;

  static int countCores(Index threads) {
    return std::max(1, threads > 0 ? static_cast<int>(threads) : static_cast<int>(std::thread::hardware_concurrency()));
  }

  static ros::NodeHandle onQueue(ros::NodeHandle node, ros::CallbackQueue& queue) {
    node.setCallbackQueue(&queue);
    return node;
  }

  Impl(const ros::NodeHandle& given, const ros::NodeHandle& given_private, const simulation::SceneParams& params)
      : node(onQueue(given, input_queue)),
        private_node(onQueue(given_private, input_queue)),
        service_node(onQueue(given_private, service_queue)),
        reset_node(onQueue(given_private, reset_queue)),
        warnings(private_node.getNamespace()),
        // Steps behind the clock need transforms that are that much older.
        transforms(ros::Duration(tf2::BufferCore::DEFAULT_CACHE_TIME + params.input.delay)),
        inbox(ros::Time::isSimTime(), transforms),
        worker(inbox, warnings, DecodeLimits{params.input.max_points}),
        // Not in a thread of its own, which would wake up a hundred times a second.
        transform_listener(transforms, node, false),
        publishers(private_node, [this] { inbox.wantFrame(); }),
        // Half of the cores are left to the steps.
        frames([this](Moment& moment) { show(moment); }, std::max(1, countCores(params.threads) / 2)),
        wrenches(private_node, [this] { inbox.wantFrame(); }),
        stepper(params, inbox, worker, publishers, frames, wrenches, transforms, warnings),
        services(service_node, reset_node, inbox, stepper, transforms, warnings, params.save_directory),
        grow(given_private, inbox, stepper, warnings),
        rollouts(given_private, inbox, stepper, transforms, warnings,
                 // One is left to the surface, where there are several.
                 std::max(1, countCores(params.threads) - 1)),
        reconfigure(service_node, inbox, stepper, warnings),
        watchdog(listServices()),
        // One thread each: input keeps its order, and is not delayed by services that wait, nor by the call that ends the wait.
        input_thread(input_queue),
        service_thread(service_queue),
        reset_thread(reset_queue) {
    stepper.setStanding(readRobotTools(private_node, params.robot));
    stepper.onParams([this] { reconfigure.publish(); });
    services.onRestore([this] { reconfigure.store(); });
    reconfigure.onStore([this] { keepParameters(); });
    keepParameters();
    if (params.diagnostics) diagnostics.emplace(given, given_private, private_node, stepper, inbox, warnings);
    subscribe();
    service_thread.start();
    reset_thread.start();
    input_thread.start();
    // The last one: if a thread cannot be started, only the others end by themselves.
    simulation_thread = std::thread([this, num_threads = params.threads] {
      setNumThreads(num_threads);
      run();
    });
  }

  ~Impl() {
    inbox.close();
    simulation_thread.join();
    input_thread.stop();
    service_thread.stop();
    reset_thread.stop();
  }

  void show(Moment& moment) {
    try {
      publishers.publish(moment);
    } catch (const std::exception& error) {
      warnings.report(Warning::kInternal, std::string("the surface cannot be shown: ") + error.what());
    }
  }

  std::vector<std::string> listServices() const {
    std::vector<std::string> names = services.names();
    for (std::string& name : grow.names()) names.push_back(std::move(name));
    names.push_back(reconfigure.serviceName());
    return names;
  }

  // As they are on the parameter server now.
  void keepParameters() {
    XmlRpc::XmlRpcValue tree;
    if (private_node.getParam(private_node.getNamespace(), tree)) watchdog.keepParameters(private_node.getNamespace(), tree);
  }

  void subscribe() {
    if (ros::Time::isSimTime()) {
      subscribers.push_back(
          node.subscribe<rosgraph_msgs::Clock>("/clock", kClockQueue, [this](const rosgraph_msgs::ClockConstPtr& clock) {
            inbox.observeClock(static_cast<std::int64_t>(clock->clock.toNSec()));
          }));
    }
    cloud_subscriber = private_node.subscribe<BoundedCloud>("cloud_in", kCloudQueue,
                                                            [this](const boost::shared_ptr<const BoundedCloud>& message) {
                                                              has_cloud_come = true;
                                                              worker.put(message);
                                                            });
    ROS_INFO_STREAM(warnings.name() << ": waiting for a cloud on " << cloud_subscriber.getTopic());
    subscribers.push_back(
        private_node.subscribe<PointForce>("force", kCommandQueue, [this](const PointForceConstPtr& m) { inbox.put(m); }));
    subscribers.push_back(private_node.subscribe<geometry_msgs::WrenchStamped>(
        "wrench", kCommandQueue, [this](const geometry_msgs::WrenchStampedConstPtr& m) { inbox.put(m); }));
    using RawTools = RawMessage<ToolArray>;
    subscribers.push_back(
        private_node.subscribe<RawTools>("tools", kCommandQueue, [this](const boost::shared_ptr<const RawTools>& message) {
          DecodedTools decoded = decodeTools(message->bytes.data(), message->bytes.size());
          for (Tool& tool : decoded.tools) inbox.put(boost::make_shared<const Tool>(std::move(tool)));
          if (decoded.ok()) return;
          warnings.report(Warning::kToolsRefused, "~tools: " + decoded.problem);
          inbox.putRefusedTools(decoded.problem);
        }));
  }

  // No message may end the thread.
  void run() {
    const auto start = std::chrono::steady_clock::now();
    bool was_reminded = false, is_clock_missed = false;
    for (bool goes_on = true; goes_on;) {
      if (!was_reminded && !has_cloud_come && std::chrono::steady_clock::now() - start > kCloudPatience) {
        was_reminded = true;
        ROS_WARN_STREAM(warnings.name() << ": no cloud came on " << cloud_subscriber.getTopic() << " in "
                                        << kCloudPatience.count()
                                        << " s (publishers there: " << cloud_subscriber.getNumPublishers()
                                        << "); remap ~cloud_in to the topic of the clouds");
      }
      if (!is_clock_missed && std::chrono::steady_clock::now() - start > kCloudPatience && ros::Time::now().isZero()) {
        is_clock_missed = true;
        warnings.report(Warning::kClock,
                        "nothing came on /clock in " + std::to_string(kCloudPatience.count()) +
                            " s, while use_sim_time is true: clouds and commands wait for it (rosbag play --clock, "
                            "or a simulator, publishes it)");
      }
      try {
        goes_on =
            stepper.turn(diagnostics ? diagnostics->nextTime() : std::chrono::steady_clock::now() + std::chrono::seconds(1));
        if (diagnostics) diagnostics->update();
      } catch (const std::exception& error) {
        warnings.report(Warning::kInternal,
                        std::string("the simulation is paused after an error of this program: ") + error.what());
        stepper.setPaused(true);
      }
    }
  }
};

SurfaceNode::SurfaceNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const simulation::SceneParams& params)
    : impl_(std::make_unique<Impl>(node, private_node, params)) {}

SurfaceNode::~SurfaceNode() = default;

}  // namespace deformable_surface::node
