#pragma once
// What the processes of other hosts have printed, from the journals of their systemd.
//
// Threads: any; blocks.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
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

// Up to where the journal of a host was read.
struct JournalPosition {
  std::string cursor;           // of its last entry before that; empty: not known
  std::set<std::string> shown;  // cursors of the lines that were read, also after it
};

struct ReadHostLogs {
  std::vector<std::vector<LogEntry>> entries;  // of each log
  std::vector<std::string> troubles;           // why lines of a host are missing
  std::map<const HostConfig*, JournalPosition> positions;
};
// The newest `lines` of each, 0: all, by our clock. `since_ns`: 0, or since 1970. Of a host that
// is slower than `within`, the newest that have arrived.
ReadHostLogs ReadLogsOf(const std::vector<HostLog>& logs, std::int64_t since_ns, std::size_t lines,
                        Duration within = Milliseconds(10'000));

// The script that prints the lines of these logs of one host from this cursor on, with the entry
// that it names; empty: those since a time by our clock, and some seconds before it.
std::string FollowScript(const std::vector<HostLog>& logs, const std::string& cursor,
                         std::int64_t since_ns);
// A line of that script; nullopt: it is of none of them.
struct JournalLine {
  std::string unit;
  WrittenLine line;  // by the clock of that host
  std::string cursor = {};
};
std::optional<JournalLine> ParseJournalLine(const std::string& json);

}  // namespace musher::cli
