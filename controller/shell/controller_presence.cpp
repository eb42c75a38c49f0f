#include "musher/controller/shell/controller_presence.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "musher/lifecycle/actuator/actuator_core.hpp"
#include "musher/lifecycle/health/health_monitor.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

// A release is published once for each stop that it ends. The depth has room for all stops that a
// machine keeps, and for more that are published meanwhile.
constexpr transport::Qos kStopsQos{transport::Qos::Reliability::kReliable,
                                   transport::Qos::Durability::kTransientLocal, 512};

// Another host discovers a controller within 500 ms, with credentials within some seconds.
constexpr Duration kListenTime = Milliseconds(1000);
constexpr Duration kSecuredListenTime = Milliseconds(4000);
// A controller that starts on another host takes over from a controller that is silent meanwhile.
constexpr Duration kLongestSilence = kListenTime / 2;
// Another machine is reported again after this time, and is gone after a silence of some
// heartbeats.
constexpr Duration kReportAgain = std::chrono::minutes(10);
constexpr Duration kOtherSilence = std::chrono::seconds(5);
constexpr std::size_t kMostOthers = 64;
constexpr std::size_t kMostUnproven = 512;       // releases, as many as a controller latches
constexpr std::size_t kLongestMachineText = 64;  // bytes, of a name from the network

}  // namespace

Duration ListenTime(const MachineConfig& config) {
  return config.keys.empty() ? kListenTime : kSecuredListenTime;
}

ControllerPresence::ControllerPresence(transport::Node& node, const MachineConfig& config,
                                       Identity identity, Emit emit, OnOtherMachine on_other)
    : node_(node),
      config_(config),
      identity_(std::move(identity)),
      emit_(std::move(emit)),
      on_other_(std::move(on_other)) {}

Result<std::unique_ptr<ControllerPresence>> ControllerPresence::Make(transport::Node& node,
                                                                     const MachineConfig& config,
                                                                     Identity identity, Emit emit,
                                                                     OnOtherMachine on_other) {
  std::unique_ptr<ControllerPresence> presence(new ControllerPresence(
      node, config, std::move(identity), std::move(emit), std::move(on_other)));
  if (auto opened = presence->Open(); !opened) return opened.error();
  return presence;
}

Result<> ControllerPresence::Open() {
  const std::string& name_space = config_.name_space;
  auto heartbeats = transport::MakePublisher<msg::ControllerHeartbeat>(
      node_, transport::ControllerHeartbeatTopic(name_space), transport::kLatchedQos);
  if (!heartbeats) return heartbeats.error();
  heartbeats_ = std::move(heartbeats).value();
  auto stops = transport::MakePublisher<msg::EmergencyStop>(
      node_, transport::EmergencyStopTopic(name_space), kStopsQos);
  if (!stops) return stops.error();
  released_stops_ = std::move(stops).value();
  auto rivals = transport::MakeSubscription<msg::ControllerHeartbeat>(
      node_, transport::ControllerHeartbeatTopic(name_space),
      [this](const msg::ControllerHeartbeat& heartbeat, const transport::SampleInfo& info) {
        if (transport::IsOwn(heartbeat.participant, info)) OnHeartbeat(heartbeat);
      },
      transport::kLatchedFromManyQos);
  if (!rivals) return rivals.error();
  rivals_ = std::move(rivals).value();
  auto received = transport::SubscribeToStops(
      node_, name_space, [this](const msg::EmergencyStop& stop, const transport::SampleInfo& info) {
        OnStop(stop, info.participant);
      });
  if (!received) return received.error();
  received_stops_ = std::move(received).value();
  return Ok();
}

void ControllerPresence::OnStop(const msg::EmergencyStop& stop, transport::ParticipantId from) {
  if (!SameMachine(machine(), {stop.machine, stop.machine_id})) return;
  if (stop.engaged || std::ranges::count(controllers_, from) != 0) {
    return emit_(event::EmergencyStopSeen{{StopId(stop.id), stop.by, stop.reason}, stop.engaged});
  }
  if (unproven_.size() >= kMostUnproven) unproven_.erase(unproven_.begin());
  unproven_.push_back({from, stop});
}

void ControllerPresence::NoteController(transport::ParticipantId participant) {
  if (participant == 0 || std::ranges::count(controllers_, participant) != 0) return;
  if (controllers_.size() >= kMostOthers) controllers_.erase(controllers_.begin());
  controllers_.push_back(participant);
  const std::vector<Release> releases = std::exchange(unproven_, {});
  for (const Release& release : releases) OnStop(release.stop, release.from);
}

void ControllerPresence::SetAwaitsRequest(bool awaits) {
  if (std::exchange(awaits_request_, awaits) != awaits && timer_) Repeat();
}

void ControllerPresence::Announce(Epoch epoch) {
  epoch_ = epoch;
  Repeat();
  timer_ = node_.loop().Every(ControllerHeartbeatPeriod(config_), [this] { Repeat(); });
}

// A failed publish needs no retry: the next heartbeat follows.
void ControllerPresence::Repeat() {
  if (!heartbeats_) return;
  NoteSilence();
  NoteOtherSilence();
  last_heartbeat_ = node_.loop().Now();
  suspended_then_ = node_.loop().TimeSuspended();
  breaks_.Note(last_heartbeat_, suspended_then_);
  static_cast<void>(heartbeats_->Publish(
      {config_.name, epoch_.value(), identity_.incarnation.value(), identity_.host, identity_.pid,
       ControllerHeartbeatPeriod(config_).count(), identity_.host_name, identity_.machine_id,
       node_.participant().value(), awaits_request_}));
}

void ControllerPresence::NoteSilence() {
  const Time now = node_.loop().Now();
  const Duration silence = now - last_heartbeat_ + (node_.loop().TimeSuspended() - suspended_then_);
  const bool was_silent = last_heartbeat_ != Time{} && silence > kLongestSilence;
  if (was_silent && config_.transport == TransportProfile::kLan) {
    listens_until_ = now + ListenTime(config_);
  }
}

std::optional<Duration> ControllerPresence::RecentBreak() {
  if (!timer_) return std::nullopt;  // it does not lead, and is silent on purpose
  return breaks_.Recent(node_.loop().Now(), node_.loop().TimeSuspended());
}

Time ControllerPresence::MayStartProcessesAt() {
  NoteSilence();  // perhaps the timer of the heartbeat comes after the caller's event
  return listens_until_;
}

void ControllerPresence::SetMachineId(std::string id) {
  identity_.machine_id = std::move(id);
  if (rival_ && !SameMachine(machine(), rival_->machine)) rival_.reset();
}

void ControllerPresence::FallSilent() {
  timer_ = nullptr;
  heartbeats_ = nullptr;  // removes the latched one, which late joiners would receive
  engaged_stops_ = nullptr;
  released_stops_ = nullptr;
}

// A controller of an older version sends no name; the beginning of the boot id distinguishes hosts.
std::string ControllerPresence::HostOf(const msg::ControllerHeartbeat& heartbeat) const {
  if (heartbeat.host == identity_.host) return "this host";
  if (!heartbeat.host_name.empty()) return "host " + heartbeat.host_name.substr(0, 64);
  return "another host (boot id " + heartbeat.host.substr(0, 8) + "…)";
}

void ControllerPresence::OnHeartbeat(const msg::ControllerHeartbeat& heartbeat) {
  // If two controllers have the same epoch, both give precedence to the lower identity.
  // Incarnations of different hosts, and of different boots of one host, cannot be compared: so the
  // host is compared first.
  const Incarnation incarnation(heartbeat.incarnation);
  const auto theirs = std::tie(heartbeat.host, incarnation, heartbeat.pid);
  const auto ours = std::tie(identity_.host, identity_.incarnation, identity_.pid);
  if (theirs == ours) return;
  const Epoch epoch(heartbeat.epoch);
  if (epoch > kLastEpoch) return;  // out of range
  Rival other{"process " + std::to_string(heartbeat.pid) + " of " + HostOf(heartbeat),
              epoch,
              {heartbeat.machine, heartbeat.machine_id},
              heartbeat.awaits_request,
              heartbeat.host == identity_.host};
  if (!SameMachine(machine(), other.machine)) return NoteOtherMachine(std::move(other));
  rival_ = std::move(other);
  NoteController(transport::ParticipantId(heartbeat.participant));
  // Only a heartbeat that may change something is an event: others would fill the journal.
  if (epoch < epoch_) return;
  emit_(event::RivalSeen{epoch, rival_->process, theirs < ours, !rival_->here});
}

void ControllerPresence::NoteOtherMachine(Rival other) {
  other.machine.name = other.machine.name.substr(0, kLongestMachineText);
  other.machine.id = other.machine.id.substr(0, kLongestMachineText);
  const std::pair key(other.machine.name, other.machine.id);
  if (!others_.contains(key) && others_.size() >= kMostOthers) return;
  const Time now = node_.loop().Now();
  OtherMachine& known = others_[key];
  known.controller = std::move(other);
  known.received = now;
  const bool came = !std::exchange(known.present, true);
  const bool recorded = known.reported && now - *known.reported < kReportAgain;
  if (recorded && !came) return;
  if (!recorded) known.reported = now;
  if (on_other_) on_other_(recorded ? nullptr : &known.controller);
}

void ControllerPresence::NoteOtherSilence() {
  for (auto& [key, other] : others_) {
    if (!other.present || node_.loop().Now() - other.received <= kOtherSilence) continue;
    other.present = false;
    if (on_other_) on_other_(nullptr);
  }
}

std::vector<ControllerPresence::Rival> ControllerPresence::OtherMachines() const {
  std::vector<Rival> others;
  for (const auto& [key, other] : others_) {
    if (other.present) others.push_back(other.controller);
  }
  return others;
}

void ControllerPresence::Publish(const action::PublishEmergencyStop& published) {
  const auto& [stop, engaged, last_command] = published;
  auto& stops = engaged ? engaged_stops_ : released_stops_;
  if (engaged && !stops) {
    auto made = transport::MakePublisher<msg::EmergencyStop>(
        node_, transport::EmergencyStopTopic(config_.name_space), kStopsQos);
    if (made) stops = std::move(made).value();
  }
  if (!stops) return;
  static_cast<void>(stops->Publish({stop.id.value(), engaged, stop.by, stop.reason, config_.name,
                                    identity_.machine_id, last_command.value()}));
}

}  // namespace musher
