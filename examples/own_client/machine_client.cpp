// machine_client: prints the state of the machine and each change.
// machine_client STATE: sets the state, and prints the outcome.

#include <iostream>
#include <optional>
#include <string>

#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

using musher::msg::MachineStatus;
using musher::msg::SetState;
namespace transport = musher::transport;

// Prints each change, the present state first; the controller latches it.
int Follow(transport::LinuxEventLoop& loop, transport::Node& node) {
  std::string last;
  const auto status = transport::MakeSubscription<MachineStatus>(
      node, transport::MachineStatusTopic(""),
      [&](const MachineStatus& machine, const transport::SampleInfo&) {
        if (machine.state != last) std::cout << machine.state << std::endl;
        last = machine.state;
      },
      transport::kLatchedQos);
  if (!status) {
    std::cerr << "machine_client: " << status.error().message << "\n";
    return 1;
  }
  loop.Run();
  return 0;
}

int Set(transport::LinuxEventLoop& loop, transport::Node& node, const std::string& state) {
  auto client = transport::MakeClient<SetState>(node, transport::MachineService("", "set_state"));
  if (!client) {
    std::cerr << "machine_client: " << client.error().message << "\n";
    return 1;
  }
  std::optional<musher::Result<SetState::Response>> answer;
  SetState::Request request;
  request.target = state;
  client.value()->Call(request, std::chrono::seconds(60), [&](auto response) {
    answer = std::move(response);
    loop.Stop();
  });
  loop.Run();
  if (!*answer) {
    std::cerr << "machine_client: " << answer->error().message << "\n";
    return 1;
  }
  const SetState::Response& result = answer->value();
  std::cout << result.outcome << ", the machine is in " << result.state << std::endl;
  return result.outcome == "done" ? 0 : 1;
}

int main(int argc, char** argv) {
  transport::LinuxEventLoop loop;
  const auto node = transport::MakeDdsNode(loop, {});  // of the domain in ROS_DOMAIN_ID
  if (!node) {
    std::cerr << "machine_client: " << node.error().message << "\n";
    return 1;
  }
  return argc == 2 ? Set(loop, *node.value(), argv[1]) : Follow(loop, *node.value());
}
