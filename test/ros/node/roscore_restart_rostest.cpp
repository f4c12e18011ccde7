// The node survives its roscore: it registers everything again with a new one. The master that ends belongs to this test.
#include "../node_client.h"

#include <xmlrpcpp/XmlRpcClient.h>

#include <set>

#include <netinet/in.h>
#include <sys/socket.h>

namespace deformable_surface::node::test {
namespace {

using XmlRpc::XmlRpcValue;

int findFreePort() {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  const int handle = socket(AF_INET, SOCK_STREAM, 0);
  EXPECT_EQ(bind(handle, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(getsockname(handle, reinterpret_cast<sockaddr*>(&address), &size), 0);
  close(handle);
  return ntohs(address.sin_port);
}

class Master {
 public:
  explicit Master(int port) : client_("127.0.0.1", port, "/") {
    const std::string text = std::to_string(port);
    char* arguments[] = {const_cast<char*>("rosmaster"), const_cast<char*>("--core"), const_cast<char*>("-p"),
                         const_cast<char*>(text.c_str()), nullptr};
    EXPECT_EQ(posix_spawnp(&process_, "rosmaster", nullptr, nullptr, arguments, environ), 0);
    EXPECT_TRUE(waitUntil([this] { return ask("getPid", {}).valid(); }));
  }
  ~Master() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }

  XmlRpcValue ask(const char* method, const std::vector<XmlRpcValue>& values) {
    XmlRpcValue arguments, answer;
    arguments[0] = std::string("/test");
    for (std::size_t i = 0; i < values.size(); ++i) arguments[static_cast<int>(i) + 1] = values[i];
    if (!client_.execute(method, arguments, answer) || answer.getType() != XmlRpcValue::TypeArray) return XmlRpcValue();
    return answer[2];
  }

  /// "publish /topic", "subscribe /topic", "serve /name" of the node.
  std::set<std::string> listRegistrations(const std::string& node) {
    std::set<std::string> list;
    XmlRpcValue state = ask("getSystemState", {});
    const char* kinds[] = {"publish ", "subscribe ", "serve "};
    for (int kind = 0; state.valid() && kind < 3; ++kind)
      for (int i = 0; i < state[kind].size(); ++i)
        for (int n = 0; n < state[kind][i][1].size(); ++n)
          if (static_cast<std::string&>(state[kind][i][1][n]) == node)
            list.insert(kinds[kind] + static_cast<std::string&>(state[kind][i][0]));
    return list;
  }

 private:
  XmlRpc::XmlRpcClient client_;
  pid_t process_ = 0;
};

TEST(RoscoreRestart, IsFollowedByTheRegistrationOfAllThereWas) {
  const int port = findFreePort();
  auto master = std::make_unique<Master>(port);
  master->ask("setParam", {std::string("/surface"), toXmlRpc(io::parseYaml("{model: mass_spring}", "scene"))});
  const std::string uri = "http://127.0.0.1:" + std::to_string(port);
  setenv("ROS_MASTER_URI", uri.c_str(), 1);
  NodeProcess process("/surface");

  std::set<std::string> before;
  ASSERT_TRUE(waitUntil([&] {
    before = master->listRegistrations("/surface");
    return before.count("serve /surface/save") && before.count("subscribe /surface/tools") &&
           before.count("publish /diagnostics");
  })) << process.output();
  master.reset();
  master = std::make_unique<Master>(port);
  EXPECT_TRUE(waitUntil([&] { return master->listRegistrations("/surface") == before; })) << process.output();
  XmlRpcValue model = master->ask("getParam", {std::string("/surface/model")});
  EXPECT_EQ(model.getType() == XmlRpcValue::TypeString ? static_cast<std::string&>(model) : "", "mass_spring");
  process.send(SIGTERM);
  EXPECT_EQ(process.waitForExit(), std::optional<int>(0));
  EXPECT_TRUE(master->listRegistrations("/surface").empty());
}

}  // namespace
}  // namespace deformable_surface::node::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "roscore_restart_rostest");
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
