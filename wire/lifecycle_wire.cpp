#include "musher/wire/lifecycle_wire.hpp"

#include <algorithm>
#include <charconv>
#include <span>
#include <utility>

namespace musher::transport {
namespace {

constexpr std::size_t kMostStopsReported = 64;  // beside the oldest; an actuator keeps 63

msg::EmergencyStop MalformedStop() {
  msg::EmergencyStop stop;
  stop.engaged = true;
  stop.reason = "a malformed message on the topic of emergency stops";
  return stop;
}

}  // namespace

std::string StopIdText(StopId id) {
  std::string text(16, '0');
  std::uint64_t rest = id.value();
  for (std::size_t i = text.size(); i-- > 0; rest /= 16) text[i] = "0123456789abcdef"[rest % 16];
  return text;
}

StopId ReadStopId(std::string_view text) {
  std::uint64_t id = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, id, 16);
  return StopId(error == std::errc() && at == end ? id : 0);
}

// The highest bit keeps it apart from small ids that people choose.
std::uint64_t StopIdOf(const SampleInfo& info) {
  const auto written = static_cast<std::uint64_t>(info.written_ns);
  return (written != 0 ? written : info.participant.value()) | (std::uint64_t{1} << 63U);
}

std::string CommandService(std::string_view name_space, std::string_view actuator) {
  return ResolveName(name_space, std::string(actuator) + "/musher_command");
}
std::string ActuatorStatusTopic(std::string_view name_space) {
  return ResolveName(name_space, "musher/actuator_status");
}
std::string MachineStatusTopic(std::string_view name_space) {
  return ResolveName(name_space, "musher/machine_status");
}
std::string CapabilitiesTopic(std::string_view name_space) {
  return ResolveName(name_space, "musher/capabilities");
}
std::string ActuatorHeartbeatTopic(std::string_view name_space) {
  return ResolveName(name_space, "musher/actuator_heartbeat");
}
std::string ControllerHeartbeatTopic(std::string_view name_space) {
  return ResolveName(name_space, "musher/controller_heartbeat");
}
std::string EmergencyStopTopic(std::string_view name_space) {
  return ResolveName(name_space, "musher/emergency_stop");
}
std::string PermitTopic(std::string_view name_space) {
  return ResolveName(name_space, "musher/permit");
}
std::string MachineService(std::string_view name_space, std::string_view name) {
  return ResolveName(name_space, "musher/" + std::string(name));
}

msg::EmergencyStop DecodeStop(std::span<const std::byte> bytes, std::int64_t received_ns) {
  msg::EmergencyStop stop = msg::Decode<msg::EmergencyStop>(bytes).value_or(MalformedStop());
  SampleInfo received;
  received.written_ns = received_ns;
  if (stop.id == 0) stop.id = StopIdOf(received);
  return stop;
}

Result<std::unique_ptr<Subscription>> SubscribeToStops(Node& node, std::string_view name_space,
                                                       OnStop on_stop) {
  auto malformed = std::make_shared<std::uint64_t>(0);
  ReaderCallbacks callbacks;
  callbacks.on_sample = [malformed, on_stop = std::move(on_stop)](std::span<const std::byte> bytes,
                                                                  const SampleInfo& info) {
    auto stop = msg::Decode<msg::EmergencyStop>(bytes);
    if (!stop) ++*malformed;
    if (!stop) stop = MalformedStop();
    if (stop->id == 0) stop->id = StopIdOf(info);
    on_stop(*stop, info);
  };
  auto reader = node.MakeRawReader("rt/" + EmergencyStopTopic(name_space),
                                   std::string(msg::EmergencyStop::kTypeName), kLatchedFromManyQos,
                                   std::move(callbacks));
  if (!reader) return reader.error();
  return std::make_unique<Subscription>(std::move(reader).value(), std::move(malformed));
}

std::string_view WriterPartition(const MachineConfig& config, ActuatorIndex actuator) {
  return config.keys.empty() ? std::string_view() : config.actuators[actuator].name;
}
std::string_view ReaderPartition(bool with_keys) {
  return with_keys ? kEveryPartition : std::string_view();
}
bool IsFrom(std::string_view actuator, const SampleInfo& info) {
  return info.partition.value_or(actuator) == actuator;
}
bool IsOwn(std::uint64_t participant, const SampleInfo& info) {
  return participant == 0 || ParticipantId(participant) == info.participant;
}
bool IsFrom(const msg::ActuatorStatus& status, const SampleInfo& info) {
  return IsFrom(status.name, info) && IsOwn(status.participant, info);
}

std::int64_t ToNanoseconds(Time time) {
  return Duration(time.time_since_epoch()).count();
}
Time FromNanoseconds(std::int64_t ns) {
  return Time(Duration(ns));
}

msg::ActuatorStatus ToMessage(const std::string& name, const ActuatorReport& report) {
  msg::ActuatorStatus status;
  status.name = name;
  status.state = report.state;
  status.target = report.target;
  status.busy_number = report.busy_number.value();
  status.epoch = report.epoch.value();
  status.number = report.number.value();
  status.outcome_number = report.outcome_number.value();
  status.outcome_code = report.outcome_code;
  status.outcome_message = report.outcome_message;
  status.incarnation = report.incarnation.value();
  status.pid = report.pid;
  status.host = report.host;
  status.config_hash = report.config_hash;
  status.detached = report.detached;
  status.emergency_stop = report.emergency_stop.value();
  status.held_by_stop = report.held_by_stop;
  status.degraded_code = report.degraded_code;
  status.degraded_reason = report.degraded_reason;
  status.emergency_stop_by = report.emergency_stop_by;
  status.emergency_stop_reason = report.emergency_stop_reason;
  status.released_stop = report.released_stop.value();
  for (const StopId stop : report.other_stops) status.other_stops.push_back(stop.value());
  status.stamp_ns = ToNanoseconds(report.stamp);
  return status;
}

ActuatorReport FromMessage(const msg::ActuatorStatus& status) {
  ActuatorReport report;
  report.state = State(status.state);
  report.target = State(status.target);
  report.busy_number = CommandNumber(status.busy_number);
  report.epoch = Epoch(status.epoch);
  report.number = CommandNumber(status.number);
  report.outcome_number = CommandNumber(status.outcome_number);
  report.outcome_code = status.outcome_code;
  report.outcome_message = status.outcome_message;
  report.incarnation = Incarnation(status.incarnation);
  report.pid = status.pid;
  report.host = status.host;
  report.config_hash = status.config_hash;
  report.detached = status.detached;
  report.emergency_stop = StopId(status.emergency_stop);
  report.held_by_stop = status.held_by_stop;
  report.degraded_code = status.degraded_code;
  report.degraded_reason = status.degraded_reason;
  report.emergency_stop_by = status.emergency_stop_by;
  report.emergency_stop_reason = status.emergency_stop_reason;
  report.released_stop = StopId(status.released_stop);
  for (const std::uint64_t stop : status.other_stops) {
    if (report.other_stops.size() == kMostStopsReported) break;
    report.other_stops.emplace_back(stop);
  }
  report.stamp = FromNanoseconds(std::clamp(status.stamp_ns, -kFarthestNs, kFarthestNs));
  return report;
}

std::uint8_t ToMessage(Verdict verdict) {
  switch (verdict) {
    case Verdict::kDone:
      return msg::ActuatorCommand::kVerdictDone;
    case Verdict::kRefused:
      return msg::ActuatorCommand::kVerdictRefused;
    case Verdict::kFailed:
      break;
  }
  return msg::ActuatorCommand::kVerdictFailed;
}

Verdict VerdictFrom(std::uint8_t verdict) {
  if (verdict == msg::ActuatorCommand::kVerdictDone) return Verdict::kDone;
  return verdict == msg::ActuatorCommand::kVerdictFailed ? Verdict::kFailed : Verdict::kRefused;
}

std::uint8_t ToMessage(Health work) {
  if (work == Health::kHung) return msg::ActuatorHeartbeat::kWorkHung;
  return work == Health::kStarved ? msg::ActuatorHeartbeat::kWorkStarved
                                  : msg::ActuatorHeartbeat::kWorkWell;
}

Health WorkFrom(std::uint8_t work) {
  if (work == msg::ActuatorHeartbeat::kWorkHung) return Health::kHung;
  return work == msg::ActuatorHeartbeat::kWorkStarved ? Health::kStarved : Health::kWell;
}

}  // namespace musher::transport
