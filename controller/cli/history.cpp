// musher history: what happened, told by the controller, or read from the journal of one that has
// gone.

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/link.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/wall_time.hpp"
#include "musher/controller/journal.hpp"

namespace musher::cli {
namespace {

using Entries = std::vector<msg::HistoryEntry>;

std::variant<Entries, Failure> FromFile(const std::string& path, std::int64_t since,
                                        unsigned limit) {
  const auto read = ReadJournal(path, since, limit);
  if (!read) return Failure{ExitCode::kUsage, read.error()};
  Entries entries;
  for (const JournalEntry& e : read.value()) {
    entries.push_back({static_cast<std::int64_t>(entries.size()) + 1, e.wall_ns, e.epoch,
                       e.switch_number, e.kind, e.actuator, e.code, e.message});
  }
  return entries;
}

std::variant<Entries, Failure> FromController(const GlobalOptions& global, std::int64_t since,
                                              unsigned limit) {
  const auto link = Link::Open(global);
  if (!link) return Failure{ExitCode::kUsage, link.error()};
  const auto answer =
      link.value()->Ask<msg::GetHistory>("get_history", {since, limit}, std::chrono::seconds(5));
  if (const auto* failure = std::get_if<Failure>(&answer)) {
    Failure with_hint = *failure;
    if (failure->exit == ExitCode::kNoController) {
      with_hint.error.message +=
          "; the journal of one that has gone: --journal <its state_dir>/journal.sqlite";
    }
    return with_hint;
  }
  const auto& response = std::get<msg::GetHistory::Response>(answer);
  if (!response.error.empty()) {
    return Failure{ExitCode::kNotDone, {kCodeFailed, response.error}};
  }
  return response.entries;
}

}  // namespace

ExitCode History(const HistoryOptions& options, const GlobalOptions& global, Console& console) {
  std::int64_t since = 0;
  if (!options.since.empty()) {
    const auto parsed = ParseSince(options.since, WallNow());
    if (!parsed) return console.Fail({ExitCode::kUsage, parsed.error()});
    since = parsed.value();
  }
  const auto entries = options.journal.empty() ? FromController(global, since, options.limit)
                                               : FromFile(options.journal, since, options.limit);
  if (const auto* failure = std::get_if<Failure>(&entries)) return console.Fail(*failure);
  const auto& list = std::get<Entries>(entries);
  console.Print(console.mode().json ? HistoryJson(list) : HistoryText(list, console.mode().colour));
  return ExitCode::kDone;
}

}  // namespace musher::cli
