// A process of another kind than ours, for tests on real DDS: runs until it is killed.
//
//   protocol_peer ros2 <namespace> <name> <lease_ms> [faulty]   a ROS 2 managed node
//   protocol_peer cyberdog <namespace> <name> <lease_ms>        a CyberDog module that beats
//
// `faulty`: its first replies are lost, as to a client that has not been matched.

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "musher/test/protocols/cyberdog_module.hpp"
#include "musher/test/protocols/ros_managed_node.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

using namespace musher;  // NOLINT(google-build-using-namespace): a main program

int main(int argc, char** argv) {
  if (argc < 5) return EXIT_FAILURE;
  const std::string kind = argv[1], name_space = argv[2], name = argv[3];
  const bool faulty = argc > 5;
  transport::LinuxEventLoop loop;
  transport::DdsOptions options;
  options.lease = Milliseconds(std::atoi(argv[4]));
  const auto node = transport::MakeDdsNode(loop, options);
  if (!node) {
    std::fprintf(stderr, "%s\n", node.error().message.c_str());
    return EXIT_FAILURE;
  }
  std::optional<testing::RosManagedNode> ros;
  std::optional<testing::CyberdogModule> module;
  if (kind == "ros2") {
    ros.emplace(*node.value(), transport::ResolveName(name_space, name));
    if (faulty) ros->lost_change_replies = ros->lost_get_replies = 1;
  } else {
    module.emplace(*node.value(), name_space, name, name);
  }
  loop.Run();
  return EXIT_SUCCESS;
}
