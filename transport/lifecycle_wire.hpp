#pragma once
// The rules' values as messages and back, and the names under which a machine speaks.

#include <string>
#include <string_view>

#include "musher/lifecycle/actuator_core.hpp"
#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/health.hpp"
#include "musher/lifecycle/report.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/transport/endpoint.hpp"

namespace musher::transport {

// Names of topics and services, resolved in the machine's namespace.
std::string CommandService(std::string_view name_space, std::string_view actuator);
std::string ActuatorStatusTopic(std::string_view name_space);
std::string MachineStatusTopic(std::string_view name_space);
std::string CapabilitiesTopic(std::string_view name_space);
std::string ActuatorBeatTopic(std::string_view name_space);
std::string ControllerBeatTopic(std::string_view name_space);
std::string EmergencyStopTopic(std::string_view name_space);
// `name` is "set_state", "restart_actuator", "release_emergency_stop", "get_status", "get_plan",
// "get_capabilities" or "get_history".
std::string MachineService(std::string_view name_space, std::string_view name);
inline constexpr std::string_view kMachinesTopic = "musher/machines";

// In what partition an actuator tells its status and its signs of life, and in which of them they
// are heard: with keys, that of its name, where nobody else may write; without, the usual one.
std::string_view SpeakingPartition(const MachineConfig& config, std::size_t actuator);
std::string_view HearingPartition(bool with_keys);
// Whether what names an actuator comes from it, as far as that can be known.
bool IsFrom(std::string_view actuator, const SampleInfo& info);

// A steady clock's time as it crosses the wire. Means something only to the process it came from.
std::int64_t ToNanoseconds(Time time);
Time FromNanoseconds(std::int64_t ns);

msg::ActuatorStatus ToMessage(const std::string& name, const ActuatorReport& report);
// A stamp that no clock gives becomes the nearest that can be computed with.
ActuatorReport FromMessage(const msg::ActuatorStatus& status);

std::uint8_t ToMessage(Verdict verdict);
// Of a work thread: well, starved or hung.
std::uint8_t ToMessage(Health work);
Health WorkFrom(std::uint8_t work);  // an unknown one counts as well

Verdict VerdictFrom(std::uint8_t verdict);  // an unknown one counts as refused

}  // namespace musher::transport
