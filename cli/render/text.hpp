#pragma once
// Text output: the messages of json.hpp as lines and tables for people.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "musher/cli/console/console.hpp"
#include "musher/cli/machine/direct_tear_down.hpp"
#include "musher/cli/machine/host_clocks.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/cli/machine/why.hpp"
#include "musher/cli/start/progress.hpp"
#include "musher/controller/client/stop_latch.hpp"
#include "musher/controller/journal/replay.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher::cli {

// The colour of a state, from good to bad.
Style StyleOfState(std::string_view state);

// Since when, in seconds; nullopt: not known.
struct StatusTimes {
  std::optional<double> in_state_s;  // the machine in its state
  std::optional<double> up_s;        // its controller
};
std::string StatusText(const msg::MachineStatus& status, bool colour,
                       const StatusTimes& times = {});
// What its marks mean; empty: there are none.
std::string StatusLegend(const msg::MachineStatus& status, bool colour);
// The other hosts of a machine, with how far their clocks are from this computer's.
std::string HostsText(const std::vector<HostClock>& hosts, bool colour);
// The units of this host's systemd that run processes of the machine; empty: there are none.
std::string UnitsText(const std::map<std::string, std::string>& units, bool colour);
// The status on one line, for output that is not a terminal.
std::string StatusLine(const msg::MachineStatus& status, std::int64_t wall_ns);

// Behind a name: " (pid 7)"; nothing of a process that is not known.
std::string PidText(std::int64_t pid);

// Actuators that run without a controller; RunningNames(): "legs (pid 7), …".
std::string RunningText(const std::map<std::string, RunningActuators::Actuator>& running,
                        bool colour);
std::string RunningNames(const std::map<std::string, RunningActuators::Actuator>& running);
std::string EndingText(const std::vector<DirectTearDown::Outcome>& outcomes, bool colour);
std::string OthersText(const std::vector<DirectTearDown::Other>& others);

std::string SwitchText(const msg::SetState::Response& result, bool colour);
// Why a switch is not done, as one sentence.
std::string SwitchError(const msg::SetState::Response& result);

std::string EstopText(const EstopReport& report, bool colour);
// The actuators that have not stopped, as one sentence.
std::string EstopError(const EstopReport& report);
// The stops that a release is about to cover.
std::string StopsToRelease(const msg::MachineStatus& machine);
// The machine's state after the release of an emergency stop.
std::string ReleaseText(const msg::MachineStatus& machine, bool colour);
std::string RestartText(const msg::ActuatorInfo& actuator, bool colour);

std::string CapabilitiesText(const msg::Capabilities& all, bool colour);
std::string CapabilityText(const msg::Capability& one, bool colour);

std::string BehaviorText(const std::string& name, const msg::GetBehavior::Response& report,
                         bool colour);
// The state changes, one line each.
std::string BehaviorLines(const msg::GetBehavior::Response& report, std::int64_t wall_ns,
                          bool colour);

// Of a plan that would be refused.
std::string PlanError(const msg::GetPlan::Response& plan);
std::string PlanText(const msg::GetPlan::Response& plan, bool colour);
// "the machine went to ...", then a line "because ..." for each cause.
std::string WhyText(const Why& why, bool colour);
std::string HistoryText(const std::vector<msg::HistoryEntry>& entries, bool colour);
// The entries as CSV (RFC 4180); `head`: with a header line.
std::string HistoryCsv(const std::vector<msg::HistoryEntry>& entries, bool head);
// A timeline; "-" marks decisions that are only recorded, "+" new ones.
std::string ReplayText(const recording::ReplayReport& report, bool colour);
std::string ProgressText(const Progress& progress, bool colour);

// "7 actuators, 9 states, 2 stages"
std::string ConfigSummary(const MachineConfig& config);

}  // namespace musher::cli
