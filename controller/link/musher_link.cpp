#include "musher/controller/link/musher_link.hpp"

#include <algorithm>
#include <utility>

#include "musher/wire/lifecycle_wire.hpp"

namespace musher {

Result<std::unique_ptr<ActuatorLink>> MusherLink::Make(transport::Node& node,
                                                       const MachineConfig& config,
                                                       ActuatorIndex actuator, Emit emit) {
  const std::string& name = config.actuators[actuator].name;
  std::unique_ptr<MusherLink> link(new MusherLink(name, actuator, std::move(emit)));
  auto client = transport::MakeClient<msg::ActuatorCommand>(
      node, transport::CommandService(config.name_space, name),
      [self = link.get()] { self->SendHeld(); });
  if (!client) return client.error();
  link->client_ = std::move(client).value();
  return std::unique_ptr<ActuatorLink>(std::move(link));
}

void MusherLink::Switch(const SwitchCommand& command) {
  msg::ActuatorCommand::Request request;
  request.kind = msg::ActuatorCommand::kKindSwitch;
  request.epoch = command.epoch.value();
  request.number = command.number.value();
  request.target = command.target;
  request.budget_ns = command.budget.count();
  request.status_stamp_ns = transport::ToNanoseconds(command.status_stamp);
  request.since_status_ns = command.since_status.count();
  request.incarnation = command.incarnation.value();
  request.detached = command.detached;
  SendOrHold(request);
}

void MusherLink::Query(const QueryCommand& command) {
  msg::ActuatorCommand::Request request;
  request.kind = msg::ActuatorCommand::kKindQuery;
  request.epoch = command.epoch.value();
  request.number = command.number.value();
  request.stop = command.stop;
  SendOrHold(request);
}

void MusherLink::OnPeer(transport::ParticipantId participant) {
  if (participant == peer_) return;
  peer_ = participant;
  held_.clear();  // they were for the previous process
}

void MusherLink::SendOrHold(const msg::ActuatorCommand::Request& request) {
  if (PeerIsMatched()) return Call(request);
  // The newest request of a kind supersedes the older ones.
  std::erase_if(held_, [&](const auto& held) { return held.kind == request.kind; });
  held_.push_back(request);
}

bool MusherLink::PeerIsMatched() const {
  if (peer_ == 0) return true;
  const std::vector<transport::ParticipantId> servers = client_->Servers();
  return std::find(servers.begin(), servers.end(), peer_) != servers.end();
}

void MusherLink::SendHeld() {
  if (!client_ || held_.empty() || !PeerIsMatched()) return;
  for (const auto& request : std::exchange(held_, {})) Call(request);
}

void MusherLink::Call(msg::ActuatorCommand::Request request) {
  request.machine = machine_.name;
  request.machine_id = machine_.id;
  const CommandNumber number(request.number);
  const bool query = request.kind == msg::ActuatorCommand::kKindQuery;
  client_->Call(
      request, kCallTimeout,
      [this, number, query](const Result<msg::ActuatorCommand::Response>& reply) {
        // Without a reply the decision code applies its own deadline.
        if (!reply || reply.value().status.name != name_) return;
        const msg::ActuatorCommand::Response& response = reply.value();
        if (IsOfOtherMachine(response.status)) return;
        emit_(event::Replied{actuator_, number, query, transport::VerdictFrom(response.verdict),
                             response.code, response.message,
                             transport::FromMessage(response.status)});
      },
      peer_);
}

// A process on another host that follows the controller of another machine there: the epoch that it
// reports is not of a successor of this controller. One on this host follows this controller as
// soon as it has received its heartbeat.
bool MusherLink::IsOfOtherMachine(const msg::ActuatorStatus& status) const {
  const bool here = !host_.empty() && status.host == host_;
  return !here && !SameMachine(machine_, {status.machine, status.machine_id});
}

}  // namespace musher
