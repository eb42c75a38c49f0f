#pragma once
// What `musher doctor` and `musher check` read from the hosts of a machine whose systemd runs
// actuators. They change nothing there.

#include <string>
#include <vector>

#include "musher/cli/doctor/facts.hpp"

namespace musher::cli {

// All hosts that run an actuator, at the same time; blocks for 8 s at most.
std::vector<OtherHostFacts> ReadOtherHosts(const MachineConfig& config);

// This host, if its systemd runs actuators (`units = "always"`): one without a name, or none.
// Blocks for some tenths of a second.
std::vector<OtherHostFacts> ReadOwnHost(const MachineConfig& config);

// What the script has printed. `machine_id`: empty: not known.
void TakeHostLines(const std::vector<std::string>& lines, const std::string& machine_id,
                   OtherHostFacts& facts);

// The script, of sh.
std::string HostFactsScript(const MachineConfig& config, const std::string& host);

// An error, or a warning, of each host that has one, at its place in the config.
std::vector<Diagnostic> CheckOtherHosts(const MachineConfig& config,
                                        const std::vector<OtherHostFacts>& hosts);

}  // namespace musher::cli
