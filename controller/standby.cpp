#include "musher/controller/standby.hpp"

#include <algorithm>
#include <utility>

#include "musher/wire/lifecycle_wire.hpp"

namespace musher {

std::vector<StoredActuator> StoredActuatorsOf(const MachineConfig& config,
                                              const msg::MachineStatus& status) {
  std::vector<StoredActuator> stored;
  for (const msg::ActuatorInfo& info : status.actuators) {
    const auto index = config.IndexOf(info.name);
    if (!index) continue;
    const bool by_hand = config.actuators[*index].command.empty();
    const bool away = info.presence == PresenceName(Presence::kLost) ||
                      info.presence == PresenceName(Presence::kAbsent);
    const bool out_of_reach = info.health == HealthName(Health::kPartitioned);
    StoredActuator one{info.name, StaysDown::kNo, {}, {}};
    if (info.state == kTearDown) {
      one.stays_down = StaysDown::kTornDown;
    } else if (away && !info.restarting && !out_of_reach) {
      if (!by_hand) one.stays_down = StaysDown::kGivenUp;
      if (info.presence == PresenceName(Presence::kLost)) one.lost_in = State(info.state);
    } else if (info.held) {
      one.kept_in = State(info.state);
    } else {
      continue;
    }
    stored.push_back(std::move(one));
  }
  return stored;
}

Standby::Standby(transport::Node& node, const MachineConfig& config, IdentityOf identity)
    : node_(node),
      config_(config),
      identity_(std::move(identity)),
      decision_(config, node.loop().Now()) {}

Result<std::unique_ptr<Standby>> Standby::Make(transport::Node& node, const MachineConfig& config,
                                               IdentityOf identity) {
  std::unique_ptr<Standby> standby(new Standby(node, config, std::move(identity)));
  if (auto opened = standby->Open(); !opened) return opened.error();
  return standby;
}

bool Standby::IsOurs(const std::string& name, const std::string& id) const {
  return SameMachine(identity_(), {name, id});
}

Result<> Standby::Open() {
  const std::string& name_space = config_.name_space;
  auto controllers = transport::MakeSubscription<msg::ControllerHeartbeat>(
      node_, transport::ControllerHeartbeatTopic(name_space),
      [this](const msg::ControllerHeartbeat& heartbeat, const transport::SampleInfo& info) {
        if (!transport::IsOwn(heartbeat.participant, info)) return;
        if (!IsOurs(heartbeat.machine, heartbeat.machine_id)) return;
        received_ = true;
        decision_.OnController(node_.loop().Now());
      },
      transport::kLatchedFromManyQos);
  if (!controllers) return controllers.error();
  subscriptions_.push_back(std::move(controllers).value());
  transport::Qos statuses_qos = transport::kLatchedFromManyQos;
  statuses_qos.partition = transport::ReaderPartition(!config_.keys.empty());
  auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      node_, transport::ActuatorStatusTopic(name_space),
      [this](const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
        if (!transport::IsFrom(status, info)) return;
        if (IsOurs(status.machine, status.machine_id)) {
          participants_[status.name] = info.participant;
        }
      },
      statuses_qos);
  if (!statuses) return statuses.error();
  subscriptions_.push_back(std::move(statuses).value());
  transport::Qos qos = transport::kHeartbeatQos;
  qos.partition = transport::ReaderPartition(!config_.keys.empty());
  auto heartbeats = transport::MakeSubscription<msg::ActuatorHeartbeat>(
      node_, transport::ActuatorHeartbeatTopic(name_space),
      [this](const msg::ActuatorHeartbeat& heartbeat, const transport::SampleInfo& info) {
        const auto process = participants_.find(heartbeat.name);
        const auto index = config_.IndexOf(heartbeat.name);
        if (!index || process == participants_.end() || process->second != info.participant) return;
        decision_.OnActuator(*index, heartbeat.controller_lost, node_.loop().Now());
      },
      qos);
  if (!heartbeats) return heartbeats.error();
  subscriptions_.push_back(std::move(heartbeats).value());
  auto machine = transport::MakeSubscription<msg::MachineStatus>(
      node_, transport::MachineStatusTopic(name_space),
      [this](const msg::MachineStatus& status, const transport::SampleInfo& info) {
        if (!transport::IsOwn(status.participant, info)) return;
        if (IsOurs(status.machine, status.machine_id)) status_ = status;
      },
      transport::kLatchedFromManyQos);
  if (!machine) return machine.error();
  subscriptions_.push_back(std::move(machine).value());
  return Ok();
}

std::string Standby::WhyNot() {
  const std::string why = decision_.WhyNot(node_.loop().Now());
  if (!received_ || !status_) return "no controller of this machine was received yet";
  if (!why.empty()) return why;
  return identity_().id.empty() ? "no actuator of this host has shown the id of this machine" : "";
}

}  // namespace musher
