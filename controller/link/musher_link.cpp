#include "musher/controller/link/musher_link.hpp"

#include <utility>

#include "musher/transport/lifecycle_wire.hpp"

namespace musher {
namespace {

// Long past every deadline of the decision code, which does its own waiting: ends a forgotten call.
constexpr Duration kCallTimeout = std::chrono::hours(2);

}  // namespace

Result<std::unique_ptr<ActuatorLink>> MusherLink::Make(transport::Node& node,
                                                       const MachineConfig& config,
                                                       std::size_t actuator, Emit emit) {
  const std::string& name = config.actuators[actuator].name;
  auto client = transport::MakeClient<msg::ActuatorCommand>(
      node, transport::CommandService(config.name_space, name));
  if (!client) return client.error();
  std::unique_ptr<MusherLink> link(new MusherLink(name, actuator, std::move(emit)));
  link->client_ = std::move(client).value();
  return std::unique_ptr<ActuatorLink>(std::move(link));
}

void MusherLink::Switch(const SwitchCommand& command) {
  msg::ActuatorCommand::Request request;
  request.kind = msg::ActuatorCommand::kKindSwitch;
  request.epoch = command.epoch;
  request.number = command.number;
  request.target = command.target;
  request.budget_ns = command.budget.count();
  request.status_stamp_ns = transport::ToNanoseconds(command.status_stamp);
  request.since_status_ns = command.since_status.count();
  request.incarnation = command.incarnation;
  request.apart = command.apart;
  Call(request);
}

void MusherLink::Ask(const AskCommand& command) {
  msg::ActuatorCommand::Request request;
  request.kind = msg::ActuatorCommand::kKindAsk;
  request.epoch = command.epoch;
  request.number = command.number;
  request.stop = command.stop;
  Call(request);
}

void MusherLink::Call(const msg::ActuatorCommand::Request& request) {
  const bool ask = request.kind == msg::ActuatorCommand::kKindAsk;
  client_->Call(
      request, kCallTimeout,
      [this, number = request.number, ask](const Result<msg::ActuatorCommand::Response>& reply) {
        // Without a reply the decision code goes by its own deadline.
        if (!reply || reply.value().status.name != name_) return;
        const msg::ActuatorCommand::Response& response = reply.value();
        emit_(event::Replied{actuator_, number, ask, transport::VerdictFrom(response.verdict),
                             response.code, response.message,
                             transport::FromMessage(response.status)});
      });
}

}  // namespace musher
