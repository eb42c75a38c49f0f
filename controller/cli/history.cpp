// musher history: what happened and why, told by the controller, or read from the journal of one
// that has gone.

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/link.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/wall_time.hpp"
#include "musher/controller/cli/why.hpp"
#include "musher/controller/journal_reader.hpp"
#include "musher/controller/wire.hpp"

namespace musher::cli {
namespace {

using Told = msg::GetHistory::Response;

std::variant<Told, Failure> FromFile(const std::string& path, std::int64_t since, unsigned limit) {
  const auto read = ReadJournal(path, since, limit);
  if (!read) return Failure{ExitCode::kUsage, read.error()};
  msg::GetHistory::Response history;
  history.error = read.value().damage;
  for (const JournalEntry& entry : read.value().entries) {
    history.entries.push_back(ToMessage(entry));
  }
  return history;
}

std::variant<Told, Failure> FromController(const GlobalOptions& global, std::int64_t since,
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
  if (!response.error.empty() && response.entries.empty()) {
    return Failure{ExitCode::kNotDone, {kCodeFailed, response.error}};
  }
  return response;
}

ExitCode Explain(const std::vector<msg::HistoryEntry>& entries, const State& state,
                 Console& console) {
  const auto why = FindWhy(entries, state);
  if (!why) return console.Fail({ExitCode::kNotDone, why.error()});
  console.Print(console.mode().json ? WhyJson(why.value())
                                    : WhyText(why.value(), console.mode().colour));
  return ExitCode::kDone;
}

}  // namespace

ExitCode History(const HistoryOptions& options, const GlobalOptions& global, Console& console) {
  std::int64_t since = 0;
  if (!options.since.empty()) {
    const auto parsed = ParseSince(options.since, WallNow());
    if (!parsed) return console.Fail({ExitCode::kUsage, parsed.error()});
    since = parsed.value();
  }
  const auto told = options.journal.empty() ? FromController(global, since, options.limit)
                                            : FromFile(options.journal, since, options.limit);
  if (const auto* failure = std::get_if<Failure>(&told)) return console.Fail(*failure);
  const auto& history = std::get<Told>(told);
  if (!history.error.empty()) console.Complain(history.error);
  if (options.why) return Explain(history.entries, *options.why, console);
  console.Print(console.mode().json ? HistoryJson(history)
                                    : HistoryText(history.entries, console.mode().colour));
  return ExitCode::kDone;
}

}  // namespace musher::cli
