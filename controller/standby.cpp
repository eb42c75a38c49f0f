#include "musher/controller/standby.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/policy/policy.hpp"
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

StoredPolicy StoredPolicyOf(const MachineConfig& config, const msg::MachineStatus& status,
                            StoredPolicy own) {
  own.power = PowerAhead::kNone;
  const msg::PolicyInfo& policy = status.policy;
  BatteryLevel level = BatteryLevel::kFree;
  if (!policy.ceiling_reason.empty()) {
    const State most = CeilingState(config, BatteryLevel::kProtected);
    const bool is_higher = most != CeilingState(config, BatteryLevel::kLowPower);
    const bool is_protected = is_higher && policy.ceiling == std::string_view(most);
    level = is_protected ? BatteryLevel::kProtected : BatteryLevel::kLowPower;
  }
  const bool is_known = policy.active && policy.battery >= 0;
  own.level = is_known ? level : std::max(own.level, level);
  return own;
}

void GoOnFrom(const MachineConfig& config, const msg::MachineStatus& status, event::Begin& begin) {
  begin.actuators = StoredActuatorsOf(config, status);
  begin.epoch = std::max(begin.epoch, Epoch(status.epoch));
  begin.stop_intent = status.phase == PhaseName(Phase::kStopping);
  begin.policy = StoredPolicyOf(config, status, begin.policy);
}

Standby::Standby(transport::Node& node, const MachineConfig& config, IdentityOf identity)
    : node_(node),
      config_(config),
      identity_(std::move(identity)),
      decision_(config, node.loop().Now()),
      why_not_("it has just been started") {}

Result<std::unique_ptr<Standby>> Standby::Make(transport::Node& node, const MachineConfig& config,
                                               IdentityOf identity) {
  std::unique_ptr<Standby> standby(new Standby(node, config, std::move(identity)));
  if (auto opened = standby->Open(); !opened) return opened.error();
  return standby;
}

bool Standby::IsOurs(const std::string& name, const std::string& id) const {
  return SameMachine(identity_(), {name, id});
}

template <class Message, class OnMessage>
Result<> Standby::Receive(const std::string& topic, const transport::Qos& qos,
                          OnMessage on_message) {
  auto subscription =
      transport::MakeSubscription<Message>(node_, topic, std::move(on_message), qos);
  if (!subscription) return subscription.error();
  subscriptions_.push_back(std::move(subscription).value());
  return Ok();
}

Result<> Standby::Open() {
  using transport::SampleInfo;
  const std::string& name_space = config_.name_space;
  const bool with_keys = !config_.keys.empty();
  auto controllers = Receive<msg::ControllerHeartbeat>(
      transport::ControllerHeartbeatTopic(name_space), transport::kLatchedFromManyQos,
      [this](const msg::ControllerHeartbeat& heartbeat, const SampleInfo& info) {
        if (!transport::IsOwn(heartbeat.participant, info)) return;
        if (!IsOurs(heartbeat.machine, heartbeat.machine_id)) return;
        received_ = true;
        decision_.OnController(node_.loop().Now());
      });
  if (!controllers) return controllers;
  auto machine = Receive<msg::MachineStatus>(
      transport::MachineStatusTopic(name_space), transport::kLatchedFromManyQos,
      [this](const msg::MachineStatus& status, const SampleInfo& info) {
        if (transport::IsOwn(status.participant, info)) OnStatus(status);
      });
  if (!machine) return machine;
  transport::Qos statuses_qos = transport::kLatchedFromManyQos;
  statuses_qos.partition = transport::ReaderPartition(with_keys);
  auto statuses = Receive<msg::ActuatorStatus>(
      transport::ActuatorStatusTopic(name_space), statuses_qos,
      [this](const msg::ActuatorStatus& status, const SampleInfo& info) {
        if (!transport::IsFrom(status, info)) return;
        if (!IsOurs(status.machine, status.machine_id)) return;
        participants_[status.name] = info.participant;
      });
  if (!statuses) return statuses;
  transport::Qos heartbeats_qos = transport::kHeartbeatQos;
  heartbeats_qos.partition = transport::ReaderPartition(with_keys);
  return Receive<msg::ActuatorHeartbeat>(
      transport::ActuatorHeartbeatTopic(name_space), heartbeats_qos,
      [this](const msg::ActuatorHeartbeat& heartbeat, const SampleInfo& info) {
        const auto process = participants_.find(heartbeat.name);
        const auto index = config_.IndexOf(heartbeat.name);
        if (!index || process == participants_.end() || process->second != info.participant) return;
        decision_.OnActuator(*index, heartbeat.controller_lost, node_.loop().Now());
      });
}

void Standby::OnStatus(const msg::MachineStatus& status) {
  if (!IsOurs(status.machine, status.machine_id)) return;
  if (status.phase != PhaseName(Phase::kStopped)) {
    status_ = status;
    return;
  }
  status_.reset();
  received_ = false;
}

Result<> Standby::ReportHere(const std::string& name) {
  auto server = StandbyServer::Make(node_.loop(), name, [this] {
    return StandbyReport{{config_.name, identity_().id}, why_not_, 0};
  });
  if (!server) return server.error();
  server_ = std::move(server).value();
  return Ok();
}

std::string Standby::WhyNot() {
  why_not_ = Reason();
  return why_not_;
}

std::string Standby::Reason() {
  std::string why = decision_.WhyNot(node_.loop().Now());
  // The id may have been learned since: then the status may be of another robot of the name.
  const bool is_ours = status_ && IsOurs(status_->machine, status_->machine_id);
  if (!received_ || !is_ours) return "no controller of this machine was received yet";
  if (!why.empty()) return why;
  return identity_().id.empty() ? "no actuator of this host has shown the id of this machine" : "";
}

}  // namespace musher
