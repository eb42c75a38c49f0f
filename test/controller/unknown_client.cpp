// A process that commands an actuator it does not lead: queries it, then sends a command as its
// controller would, with an epoch that is so much ahead, and prints "<verdict> <code> <epoch
// after>".
//
//   controller_unknown_client <command service> <ahead>

#include <cstdint>
#include <cstdlib>
#include <future>
#include <iostream>
#include <memory>
#include <string>

#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/service.hpp"

namespace musher {
namespace {

using msg::ActuatorCommand;

ActuatorCommand::Response Call(transport::NodeThread& node, const std::string& service,
                               const ActuatorCommand::Request& request) {
  std::unique_ptr<transport::Client<ActuatorCommand>> client;
  std::promise<Result<ActuatorCommand::Response>> promise;
  node.RunOnLoop([&] {
    client = transport::MakeClient<ActuatorCommand>(node.node(), service).value();
    client->Call(request, std::chrono::seconds(20), [&](Result<ActuatorCommand::Response> reply) {
      promise.set_value(std::move(reply));
    });
  });
  const auto reply = promise.get_future().get();
  node.RunOnLoop([&] { client.reset(); });
  if (!reply) std::cerr << reply.error().message << std::endl;
  return reply ? reply.value() : ActuatorCommand::Response{};
}

}  // namespace
}  // namespace musher

int main(int argc, char** argv) {
  using musher::msg::ActuatorCommand;
  if (argc != 3) return EXIT_FAILURE;
  const auto node = musher::transport::NodeThread::Start().value();
  ActuatorCommand::Request request;
  request.kind = ActuatorCommand::kKindQuery;
  const auto status = musher::Call(*node, argv[1], request).status;
  request.kind = ActuatorCommand::kKindSwitch;
  const std::uint64_t ahead = std::stoull(argv[2]);
  const bool overflows = ahead > UINT64_MAX - status.epoch;
  request.epoch = overflows ? UINT64_MAX : status.epoch + ahead;
  request.number = status.number + 1;
  request.target = "LowPower";
  request.budget_ns = musher::Duration(std::chrono::seconds(10)).count();
  request.status_stamp_ns = status.stamp_ns;
  request.incarnation = status.incarnation;
  const auto response = musher::Call(*node, argv[1], request);
  std::cout << int{response.verdict} << ' ' << response.code << ' ' << response.status.epoch
            << '\n';
  return EXIT_SUCCESS;
}
