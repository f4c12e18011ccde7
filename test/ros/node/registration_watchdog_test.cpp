// The watchdog ends with its process, whatever the master does. The test has its own master. It holds back an answer, so that a
// question is always in flight at shutdown.
#include "../../../src/ros/node/registration_watchdog.h"

#include <gtest/gtest.h>
#include <ros/init.h>

#include <condition_variable>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace deformable_surface::node {
namespace {

/// A master without nodes and parameters, as after a restart. It accepts every registration. Never destroyed: its threads wait in
/// calls.
class KeptMaster {
 public:
  /// kept: the number of the "lookupNode" question whose answer is held back, from 1. knows_node: the master has the node
  /// registered.
  explicit KeptMaster(int kept, bool knows_node = false)
      : kept_(kept), knows_node_(knows_node), listener_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(listener_, 100) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
      std::abort();
    uri_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    std::thread([this] {
      for (int handle; (handle = accept(listener_, nullptr, nullptr)) >= 0;)
        std::thread([this, handle] { serve(handle); }).detach();
    }).detach();
  }

  const std::string& uri() const { return uri_; }
  void waitForTheQuestion() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return lookups_ >= kept_; });
  }
  void waitForTheService() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return has_service_; });
  }
  void answerIt() {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_released_ = true;
    changed_.notify_all();
  }

 private:
  void serve(int handle) {
    std::string bytes;
    char block[4096];
    for (ssize_t size; (size = read(handle, block, sizeof block)) > 0;) {
      bytes.append(block, static_cast<std::size_t>(size));
      if (bytes.find("</methodCall>") == std::string::npos) continue;
      if (bytes.find("lookupNode") != std::string::npos) keepBack();
      const auto contains = [&](const char* text) { return bytes.find(text) != std::string::npos; };
      const bool is_accepted = contains("egister") || contains("getPid") || (knows_node_ && contains("lookupNode"));
      if (contains("registerService") && contains("/watched/service")) {
        const std::lock_guard<std::mutex> lock(mutex_);
        has_service_ = true;
        changed_.notify_all();
      }
      bytes.clear();
      const std::string code = is_accepted ? "1" : "-1";
      const std::string body =
          "<?xml version=\"1.0\"?><methodResponse><params><param><value><array><data><value><int>" + code +
          "</int></value><value></value><value><array><data></data></array></value></data></array></value></param></params>"
          "</methodResponse>";
      const std::string answer =
          "HTTP/1.1 200 OK\r\nContent-type: text/xml\r\nContent-length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
      if (write(handle, answer.data(), answer.size()) < 0) break;
    }
    close(handle);
  }
  void keepBack() {
    std::unique_lock<std::mutex> lock(mutex_);
    const int number = ++lookups_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return number < kept_ || is_released_; });
  }

  const int kept_;
  const bool knows_node_;
  const int listener_;
  std::string uri_;
  std::mutex mutex_;
  std::condition_variable changed_;
  int lookups_ = 0;
  bool is_released_ = false, has_service_ = false;
};

enum class Answer { kBeforeTheWatchdogEnds, kNever };

/// In a process of its own, because roscpp shuts down only once. Ends it with status 0.
[[noreturn]] void shutDownInAQuestion(int kept, Answer when) {
  // A watchdog that waits for ever is a failure, too.
  alarm(20);
  auto* master = new KeptMaster(kept);
  setenv("ROS_MASTER_URI", master->uri().c_str(), 1);
  setenv("ROS_IP", "127.0.0.1", 1);
  ros::init(ros::M_string(), "watched", ros::init_options::NoSigintHandler);
  ros::start();
  auto watchdog = std::make_unique<RegistrationWatchdog>(std::vector<std::string>{"/watched/service"});
  master->waitForTheQuestion();
  ros::shutdown();
  if (when == Answer::kBeforeTheWatchdogEnds) master->answerIt();
  watchdog.reset();
  std::_Exit(0);
}

[[noreturn]] void waitUntilTheServiceIsRegistered() {
  alarm(20);
  constexpr int kNever = 1000000;
  auto* master = new KeptMaster(kNever, true);
  setenv("ROS_MASTER_URI", master->uri().c_str(), 1);
  setenv("ROS_IP", "127.0.0.1", 1);
  ros::init(ros::M_string(), "watched", ros::init_options::NoSigintHandler);
  ros::start();
  auto watchdog = std::make_unique<RegistrationWatchdog>(std::vector<std::string>{"/watched/service"});
  master->waitForTheService();
  std::_Exit(0);
}

class RegistrationWatchdogDeathTest : public testing::Test {
 protected:
  void SetUp() override { testing::GTEST_FLAG(death_test_style) = "threadsafe"; }
};

TEST_F(RegistrationWatchdogDeathTest, LivesThroughAShutdownBetweenQuestionAndAnswer) {
  EXPECT_EXIT(shutDownInAQuestion(1, Answer::kBeforeTheWatchdogEnds), testing::ExitedWithCode(0), "");
}

TEST_F(RegistrationWatchdogDeathTest, LivesThroughAShutdownJustBeforeItRegistersAgain) {
  EXPECT_EXIT(shutDownInAQuestion(2, Answer::kBeforeTheWatchdogEnds), testing::ExitedWithCode(0), "");
}

TEST_F(RegistrationWatchdogDeathTest, RegistersAgainWithAMasterThatKnowsTheNodeButNotItsServices) {
  EXPECT_EXIT(waitUntilTheServiceIsRegistered(), testing::ExitedWithCode(0), "");
}

TEST_F(RegistrationWatchdogDeathTest, DoesNotWaitForAMasterThatHangs) {
  EXPECT_EXIT(shutDownInAQuestion(1, Answer::kNever), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace deformable_surface::node
