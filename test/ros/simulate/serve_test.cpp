// `simulate --serve` from a program's view: answers in order, files in the folder of the run, and no process that outlives the
// program.
#include "../../../src/ros/simulate/serve.h"

#include "simulate_fixture.h"

#include <poll.h>
#include <sys/wait.h>

#include <chrono>
#include <thread>

namespace deformable_surface::node::test {
namespace {

constexpr int kPatience = 60000;  // ms: the run that this waits for to end would take hours

// A server in a process of its own, and the ends of its pipes.
class Serve : public Simulate {
 protected:
  void SetUp() override {
    Simulate::SetUp();
    int requests[2], answers[2];
    ASSERT_EQ(pipe(requests), 0);
    ASSERT_EQ(pipe(answers), 0);
    server_ = fork();
    if (server_ == 0) {
      close(requests[1]);
      close(answers[0]);
      _exit(serve(requests[0], answers[1]));
    }
    close(requests[0]);
    close(answers[1]);
    requests_ = requests[1];
    answers_ = answers[0];
  }
  void TearDown() override {
    hangUp();
    close(answers_);
    Simulate::TearDown();
  }

  void ask(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {folder_.string(), path("scene.yaml")});
    std::string request;
    for (const std::string& argument : arguments) request += argument + '\0';
    request += '\0';
    ASSERT_EQ(write(requests_, request.data(), request.size()), static_cast<ssize_t>(request.size()));
  }
  std::string answer() {
    std::string line;
    char c;
    while (read(answers_, &c, 1) == 1 && c != '\n') line += c;
    return line;
  }
  // Returns the exit status of the server.
  int hangUp() {
    if (requests_ < 0) return -1;
    close(requests_);
    requests_ = -1;
    int status = 0;
    EXPECT_EQ(waitpid(server_, &status, 0), server_);
    return status;
  }

  pid_t server_ = 0;
  int requests_ = -1, answers_ = -1;
};

TEST_F(Serve, RunsSceneAfterSceneWithTheResultsOfSimulate) {
  ask({"--statistics", "a.csv"});
  ask({"--duration", "0.105"});
  ask({"--final", "b.ply"});
  EXPECT_EQ(answer(), "0");
  EXPECT_NE(readFile(path("a.csv")), "");
  EXPECT_EQ(answer(), "2");
  EXPECT_EQ(answer(), "0");
  EXPECT_EQ(readFile(path("err")), "");
  const std::string out = readFile(path("out")), said = out.substr(out.find("state hash"));
  EXPECT_EQ(run({"--final", path("c.ply"), "--threads", "1"}), 0);  // more would be lost to the servers of later tests
  EXPECT_EQ(said, out_.substr(out_.find("state hash")));
  EXPECT_EQ(readFile(path("b.ply")), readFile(path("c.ply")));
  EXPECT_EQ(hangUp(), 0);
}

TEST_F(Serve, TellsTheSentencesOfARefusedRunInItsFolder) {
  ask({"--set", "material.thickness=-1"});
  EXPECT_EQ(answer(), "2");
  EXPECT_NE(readFile(path("err")).find("material.thickness: found -1; accepted"), std::string::npos);
}

TEST_F(Serve, GivesRunsOfOneCloudTheResultsOfSimulateAlsoAfterTheCloudWasWrittenAnew) {
  const auto writeCloud = [&](double height) {
    std::ofstream cloud(path("cloud.xyz"));
    for (int i = 0; i < 100; ++i) cloud << 0.1 * (i % 10) << ' ' << 0.1 * (i / 10) << ' ' << height * (i % 10) * (i % 10) << '\n';
  };
  const std::vector<std::vector<std::string>> others{
      {},
      {"--set", "material.thickness=0.01"},
      {"--set", "simplification.target_points=30"},
      {"--set", "accuracy.position_error=0.1", "--set", "simplification={}"},
      {"--set", "input.filter.crop=[{box: {min: [-1, -1, -1], max: [0.75, 2, 2]}}]"}};
  for (const double height : {0.0, 0.001})
    for (std::vector<std::string> arguments : others) {
      writeCloud(height);
      arguments.insert(arguments.end(),
                       {"--set", "cloud={file: " + path("cloud.xyz") + "}", "--set", "gravity=[0, 0, -9.81]", "--threads", "1"});
      for (int again = 0; again < 2; ++again) {
        ask(arguments);
        EXPECT_EQ(answer(), "0");
        EXPECT_EQ(run(arguments), 0) << err_;
        const std::string out = readFile(path("out"));
        EXPECT_EQ(out.substr(0, out.find("wall time")), out_.substr(0, out_.find("wall time")));
        EXPECT_EQ(out.substr(out.find("state hash")), out_.substr(out_.find("state hash")));
      }
    }
}

TEST_F(Serve, EndsItsRunWithWhoeverAsked) {
  ask({"--duration", "1000000", "--frames", "frames"});
  while (!fs::exists(path("frames/frame_000001.ply"))) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_NE(hangUp(), 0);
  // The pipe of answers ends with the last process that has it, and the run was one.
  pollfd end{answers_, POLLIN, 0};
  ASSERT_EQ(poll(&end, 1, kPatience), 1) << "the run goes on";
  EXPECT_EQ(answer(), "");
}

}  // namespace
}  // namespace deformable_surface::node::test
