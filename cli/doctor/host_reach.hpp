#pragma once
// What `musher doctor` and `musher check --hosts` read from the other hosts of a machine. They
// change nothing there.

#include <string>
#include <vector>

#include "musher/cli/doctor/facts.hpp"

namespace musher::cli {

// All hosts that run an actuator, at the same time; blocks for 8 s at most.
std::vector<OtherHostFacts> ReadOtherHosts(const MachineConfig& config);

// What the script has printed. `machine_id`: empty: not known.
void TakeHostLines(const std::vector<std::string>& lines, const std::string& machine_id,
                   OtherHostFacts& facts);

// The script, of sh.
std::string HostFactsScript(const MachineConfig& config, const std::string& host);

// An error, or a warning, of each host that has one, at its place in the config.
std::vector<Diagnostic> CheckOtherHosts(const MachineConfig& config,
                                        const std::vector<OtherHostFacts>& hosts);

}  // namespace musher::cli
