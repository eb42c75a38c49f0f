#pragma once
// Converts values of the decision code to messages and back, and names a machine's topics and
// services.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "musher/lifecycle/actuator/actuator_core.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/machine/report.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

// The id of an emergency stop as 16 hexadecimal digits: JavaScript's numbers have 53 bits only.
std::string StopIdText(StopId id);
// 0: the text is no id.
StopId ReadStopId(std::string_view text);

// Names of topics and services, resolved in the machine's namespace.
std::string CommandService(std::string_view name_space, std::string_view actuator);
std::string ActuatorStatusTopic(std::string_view name_space);
std::string MachineStatusTopic(std::string_view name_space);
std::string CapabilitiesTopic(std::string_view name_space);
std::string ActuatorHeartbeatTopic(std::string_view name_space);
std::string ControllerHeartbeatTopic(std::string_view name_space);
std::string EmergencyStopTopic(std::string_view name_space);
std::string PermitTopic(std::string_view name_space);
// `name` is "set_state", "restart_actuator", "release_emergency_stop", "get_status", "get_plan",
// "get_capabilities" or "get_history".
std::string MachineService(std::string_view name_space, std::string_view name);
inline constexpr std::string_view kMachinesTopic = "musher/machines";

// The partition in which an actuator publishes its status and heartbeats, and the one for their
// readers. With keys an actuator writes in the partition of its name, where no other participant
// may write; without keys in the default one.
std::string_view WriterPartition(const MachineConfig& config, ActuatorIndex actuator);
std::string_view ReaderPartition(bool with_keys);
// Whether a sample that names an actuator comes from that actuator, as far as known.
bool IsFrom(std::string_view actuator, const SampleInfo& info);
// Whether a sample comes from the participant whose number it has. A bridge between domains, a
// router or a replayed recording repeats samples of others. True where it has no number, as from an
// older version.
bool IsOwn(std::uint64_t participant, const SampleInfo& info);
bool IsFrom(const msg::ActuatorStatus& status, const SampleInfo& info);

// The id of a stop whose sender gave none: the time at which the sample was written, else the
// participant.
std::uint64_t StopIdOf(const SampleInfo& info);

// Subscribes to the emergency stops. The callback gets each stop with an id other than 0: where the
// sender gave none, as `ros2 topic pub` does by default, it is made of the sample, and it is the
// same for every subscriber. A sample that cannot be decoded is a stop that is engaged.
using OnStop = std::function<void(const msg::EmergencyStop&, const SampleInfo&)>;
Result<std::unique_ptr<Subscription>> SubscribeToStops(Node& node, std::string_view name_space,
                                                       OnStop on_stop);
// The stop in a message that did not come by the transport, in the same way. `received_ns`: by the
// wall clock.
msg::EmergencyStop DecodeStop(std::span<const std::byte> bytes, std::int64_t received_ns);

// A steady clock's time on the wire. Only the process that it came from can interpret it.
std::int64_t ToNanoseconds(Time time);
Time FromNanoseconds(std::int64_t ns);

msg::ActuatorStatus ToMessage(const std::string& name, const ActuatorReport& report);
// A stamp out of range becomes the nearest valid one.
ActuatorReport FromMessage(const msg::ActuatorStatus& status);

std::uint8_t ToMessage(Verdict verdict);
// Health of a work thread: well, starved or hung.
std::uint8_t ToMessage(Health work);
Health WorkFrom(std::uint8_t work);  // an unknown value counts as kWell

Verdict VerdictFrom(std::uint8_t verdict);  // an unknown value counts as refused

}  // namespace musher::transport
