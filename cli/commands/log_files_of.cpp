#include "musher/cli/commands/log_files_of.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "musher/base/files.hpp"
#include "musher/controller/storage/log_reader.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLogEnd = ".log";
constexpr std::size_t kMostBytes = 256 << 20;  // of a log in memory

// The names of the live files in the folder.
std::vector<std::string> NamesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const fs::path& file : EntriesOf(fs::path(folder))) {
    if (file.extension() == kLogEnd) names.push_back(file.stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::vector<std::string> LogNamesOf(const MachineFiles& files) {
  std::vector<std::string> names;
  if (files.config) {
    for (const ActuatorConfig& actuator : files.config->actuators) names.push_back(actuator.name);
  }
  for (const std::string& name : NamesIn(files.state_dir + "/logs")) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  if (std::find(names.begin(), names.end(), kControllerWord) == names.end()) {
    names.emplace_back(kControllerWord);
  }
  return names;
}

std::string WhyNoLog(const MachineFiles& files, const std::string& name, const std::string& path) {
  const auto index = files.config ? files.config->IndexOf(name) : std::nullopt;
  if (index && files.config->actuators[*index].command.empty()) {
    return name + " has no log here: " + files.config_file +
           " gives it no `command`, so it prints where it was started, by hand or on another host";
  }
  return name + " has no log here: " + path + " does not exist; the controller creates it when " +
         files.name + " is started on this host" + HiddenFilesNote();
}

Result<ReadLogs> ReadLog(const std::string& source, const std::string& path,
                         const LogFilter& filter, std::size_t lines) {
  auto reader = LogReader::Open(path);
  if (!reader) return reader.error();
  ReadLogs read;
  read.end = reader.value().end();
  std::vector<std::vector<WrittenLine>> pieces;  // newest first
  std::size_t matching = 0;
  std::size_t bytes = 0;
  for (auto piece = reader.value().Before(); !piece.empty(); piece = reader.value().Before()) {
    const auto entries = LogEntriesOf(source, piece);
    matching += std::count_if(entries.begin(), entries.end(),
                              [&](const LogEntry& entry) { return filter.Shows(entry); });
    for (const WrittenLine& line : piece) bytes += line.text.size() + 1;
    pieces.push_back(std::move(piece));
    const auto timed = std::find_if(entries.begin(), entries.end(),
                                    [](const LogEntry& entry) { return entry.wall_ns != 0; });
    const bool reached =
        filter.since_ns != 0 && timed != entries.end() && timed->wall_ns < filter.since_ns;
    if (reached || (lines != 0 && matching >= lines)) break;
    if (bytes > kMostBytes) {
      read.note = path + " is longer: only its last 256 MiB are shown";
      break;
    }
  }
  std::reverse(pieces.begin(), pieces.end());
  std::vector<WrittenLine> all;
  for (auto& piece : pieces) {
    all.insert(all.end(), std::make_move_iterator(piece.begin()),
               std::make_move_iterator(piece.end()));
  }
  read.entries = LogEntriesOf(source, all);
  if (!reader.value().damage().empty()) read.note = reader.value().damage();
  return read;
}

}  // namespace musher::cli
