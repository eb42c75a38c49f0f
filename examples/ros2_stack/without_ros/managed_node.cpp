// A ROS 2 managed node without ROS 2, in the place of nav2's nodes: it answers like a node of
// rclcpp_lifecycle and prints its callbacks, all of which succeed.
//
//   managed_node map_server

#include <unistd.h>

#include <iostream>
#include <string>
#include <utility>

#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/wire/managed_node_endpoints.hpp"

namespace transport = musher::transport;
using Endpoints = transport::ManagedNodeEndpoints;

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: managed_node NAME\n";
    return 2;
  }
  const std::string name = argv[1];
  transport::LinuxEventLoop loop;
  const auto node = transport::MakeDdsNode(loop, {.node_name = name});
  if (!node) {
    std::cerr << name << ": " << node.error().message << "\n";
    return 1;
  }
  Endpoints::Hooks hooks;
  hooks.change = [&](const musher::Ros2Transition& transition, musher::transport::ParticipantId,
                     const Endpoints::Done& done) {
    std::cout << name << ": on_" << transition.name << std::endl;
    done(musher::Ok());
  };
  const std::string instance = name + "-" + std::to_string(getpid());
  const auto endpoints = Endpoints::Make(*node.value(), "", name, instance, std::move(hooks));
  if (!endpoints) {
    std::cerr << name << ": " << endpoints.error().message << "\n";
    return 1;
  }
  loop.Run();
  return 0;
}
