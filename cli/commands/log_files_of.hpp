#pragma once
// The logs of a machine on this host, and their last lines.
//
// Waits for the disk.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/render/log_lines.hpp"

namespace musher::cli {

// The actuators in the order of the config, the programs beside them, then the controller.
std::vector<std::string> LogNamesOf(const MachineFiles& files);
// Why the file at `path` of this actuator does not exist.
std::string WhyNoLog(const MachineFiles& files, const std::string& name, const std::string& path);

struct ReadLogs {
  std::vector<LogEntry> entries;  // at least those that are requested, if there are so many
  std::int64_t end = 0;           // of the live file
  std::string note;               // what could not be read
};
// The newest lines, with the older parts of the log as far as the filter needs them. `lines`: that
// many matching ones; 0: all.
Result<ReadLogs> ReadLog(const std::string& source, const std::string& path,
                         const LogFilter& filter, std::size_t lines);

}  // namespace musher::cli
