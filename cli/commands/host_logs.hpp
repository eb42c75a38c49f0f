#pragma once
// What the processes of other hosts have printed, from the journals of their systemd.
//
// Threads: any; blocks.

#include <string>
#include <vector>

#include "musher/cli/machine/host_query.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/render/log_lines.hpp"

namespace musher::cli {

// The log of an actuator that another host runs.
struct HostLog {
  std::string actuator;
  const HostConfig* host = nullptr;
  std::string unit;
};

// nullopt: this host runs it, or the controller starts none.
std::optional<HostLog> HostLogOf(const MachineFiles& files, const std::string& actuator);

struct ReadHostLogs {
  std::vector<std::vector<LogEntry>> entries;  // of each log
  std::vector<std::string> troubles;           // of hosts that have not answered
};
// The newest `lines` of each, 0: all, by our clock. `since_ns`: 0, or since 1970.
ReadHostLogs ReadLogsOf(const std::vector<HostLog>& logs, std::int64_t since_ns, std::size_t lines);

// The script that prints new lines of these logs of one host.
std::string FollowScript(const std::vector<HostLog>& logs);
// A line of that script; nullopt: it is of none of them.
struct JournalLine {
  std::string unit;
  WrittenLine line;  // by the clock of that host
};
std::optional<JournalLine> ParseJournalLine(const std::string& json);

}  // namespace musher::cli
