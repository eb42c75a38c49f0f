// musher history: past events and their causes, from the controller, or from the journal of one
// that has exited.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/suggest.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/machine/why.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/controller/journal/journal_gap.hpp"
#include "musher/controller/journal/journal_reader.hpp"
#include "musher/controller/shell/wire.hpp"
#include "musher/lifecycle/event_name.hpp"
#include "musher/wire/journal_cursor.hpp"

namespace musher::cli {
namespace {

struct HistoryOptions {
  std::string since;     // empty: all
  std::string until;     // empty: all
  std::string actuator;  // empty: of all, and of the machine
  std::string event;     // empty: all
  std::string journal;   // empty: query the controller; without one, that of its machine
  std::string level = "info";
  bool boot = false;              // only since the host has booted
  std::optional<unsigned> lines;  // 0: no limit
  bool csv = false;
  bool follow = false;             // then print new entries
  std::optional<std::string> why;  // explain this state instead; empty: the current one
};

using Entries = msg::GetHistory::Response;

constexpr unsigned kAll = UINT32_MAX;
constexpr unsigned kLines = 1000;
constexpr std::uint32_t kMostFollowed = 5000;  // new entries at once
constexpr const char* kErrorLevel = "error";
constexpr Duration kFollowPeriod = Milliseconds(300);

std::variant<Entries, Failure> FromFile(const std::string& path, std::int64_t since,
                                        unsigned limit) {
  const auto read = ReadJournal(path, since, limit);
  const auto gap = ReadGap(path);
  const std::string missing =
      gap ? "the journal lacks the newest entries: it is not on disk since " + gap->Text() : "";
  const auto with_gap = [&missing](const std::string& trouble) {
    return trouble + (trouble.empty() || missing.empty() ? "" : "; ") + missing;
  };
  if (!read) {
    return Failure{ExitCode::kUsage, {read.error().code, with_gap(read.error().message)}};
  }
  msg::GetHistory::Response history = ToMessage(read.value().entries);
  history.error = with_gap(read.value().damage);
  return history;
}

// A controller of an older version sends no events.
Entries WithEvents(Entries history) {
  history.events.resize(history.entries.size());
  return history;
}

// Keeps the entries, and their events, for which `keep` is true.
template <class Keep>
void KeepOnly(Entries& history, const Keep& keep) {
  Entries kept;
  kept.error = std::move(history.error);
  for (std::size_t i = 0; i < history.entries.size(); ++i) {
    if (!keep(history.entries[i], history.events[i])) continue;
    kept.entries.push_back(std::move(history.entries[i]));
    kept.events.push_back(std::move(history.events[i]));
  }
  history = std::move(kept);
}

std::variant<Entries, Failure> FromController(Link& link, std::int64_t since, unsigned limit) {
  const auto answer =
      link.Call<msg::GetHistory>("get_history", {since, limit}, std::chrono::seconds(5));
  if (const auto* failure = std::get_if<Failure>(&answer)) return *failure;
  const auto& response = std::get<msg::GetHistory::Response>(answer);
  if (!response.error.empty() && response.entries.empty()) {
    return Failure{ExitCode::kNotDone, {kCodeFailed, response.error}};
  }
  return WithEvents(response);
}

// Which entries are requested.
struct Selection {
  std::int64_t since = 0;
  std::int64_t until = INT64_MAX;
  std::string actuator;
  std::string event;
  bool failures_only = false;
  unsigned limit = 0;  // 0: all

  // The limit counts matching entries only.
  unsigned ReadLimit() const {
    const bool filters = until != INT64_MAX || !actuator.empty() || !event.empty() || failures_only;
    return limit == 0 || filters ? kAll : limit;
  }
  void Apply(Entries& history) const {
    KeepOnly(history, [this](const msg::HistoryEntry& entry, const std::string& of_entry) {
      return entry.wall_ns >= since && entry.wall_ns <= until &&
             (actuator.empty() || entry.actuator == actuator) &&
             (event.empty() || of_entry == event) && (!failures_only || entry.code != kCodeOk);
    });
    KeepNewest(history);
  }
  // A chain of causes passes through entries of all actuators and levels.
  void ApplyTimeAndLimit(Entries& history) const {
    KeepOnly(history, [this](const auto& entry, const auto&) { return entry.wall_ns <= until; });
    KeepNewest(history);
  }

 private:
  void KeepNewest(Entries& history) const {
    const std::size_t count = history.entries.size();
    std::size_t left_out = limit == 0 || count <= limit ? 0 : count - limit;
    KeepOnly(history, [&](const auto&, const auto&) { return left_out == 0 || left_out-- == 0; });
  }
};

Result<Selection> Select(const HistoryOptions& options) {
  Selection selection;
  selection.actuator = options.actuator;
  selection.event = options.event;
  selection.failures_only = options.level == kErrorLevel;
  selection.limit = options.lines.value_or(options.why ? 0 : kLines);
  if (!options.since.empty()) {
    const auto since = ParseSince(options.since, WallNow());
    if (!since) return since.error();
    selection.since = since.value();
  }
  if (!options.until.empty()) {
    const auto until = ParseSince(options.until, WallNow());
    if (!until) return until.error();
    selection.until = until.value();
  }
  if (options.boot) selection.since = std::max(selection.since, BootWallNs());
  return selection;
}

void Show(const Entries& history, bool csv, bool first, Console& console) {
  if (csv) {
    console.Print(HistoryCsv(history.entries, first));
  } else if (console.mode().json) {
    console.Print(HistoryJson(history));
  } else if (first || !history.entries.empty()) {
    console.Print(HistoryText(history.entries, console.mode().colour));
  }
}

// Prints the entries that `cursor` has not taken, until Ctrl-C or until the controller exits.
ExitCode Follow(Link& link, Selection selection, JournalCursor& cursor, bool csv,
                Console& console) {
  // The wall clock may be set back: what is new is not before a time.
  selection.since = 0;
  selection.limit = 0;
  link.EndWithReader();
  if (const auto followed = link.FollowStatus({}); !followed) return console.Fail(followed.error());
  while (!link.interrupted() && console.HasReader()) {
    link.RunUntil([&link] { return link.LeaderIsLost(); }, kFollowPeriod);
    if (link.interrupted()) break;
    const auto read = FromController(link, 0, cursor.limit());
    if (const auto* failure = std::get_if<Failure>(&read)) {
      return link.interrupted() ? ExitCode::kDone : console.Fail(*failure);
    }
    auto fresh = cursor.Take(std::get<Entries>(read));
    if (!fresh) continue;
    selection.Apply(*fresh);
    if (!fresh->entries.empty()) Show(*fresh, csv, false, console);
  }
  return ExitCode::kDone;
}

WhyWanted WantedWhy(const HistoryOptions& options) {
  return {State(*options.why), options.actuator, options.level == kErrorLevel};
}

ExitCode Explain(const Entries& history, const WhyWanted& wanted, Console& console) {
  const auto found = FindWhy(history, wanted);
  if (!found) return console.Fail({ExitCode::kNotDone, found.error()});
  const Why& why = found.value();
  if (why.change.entries.empty() && !wanted.failure_only) {
    console.Note("the machine's last change of state is before these entries");
  }
  const bool shows_failure =
      !why.failure.entries.empty() ||
      std::ranges::any_of(why.change.entries, [&wanted](const msg::HistoryEntry& entry) {
        return entry.code != kCodeOk && entry.actuator == wanted.actuator;
      });
  if (!shows_failure && (wanted.failure_only || !wanted.actuator.empty())) {
    console.Note("these entries contain no failure" +
                 (wanted.actuator.empty() ? "" : " of " + wanted.actuator));
  }
  console.Print(console.mode().json ? WhyJson(why) : WhyText(why, console.mode().colour));
  return ExitCode::kDone;
}

// Where entries are read: from a controller, or from a file without one.
struct Source {
  std::unique_ptr<Link> link;
  std::string journal;

  std::variant<Entries, Failure> Read(std::int64_t since, unsigned limit) const {
    return link ? FromController(*link, since, limit) : FromFile(journal, since, limit);
  }
};

// Reads the journal on disk of a machine of this host that no controller leads, which is `source`
// then; else `failure`.
std::variant<Entries, Failure> FromDisk(const Failure& failure, std::int64_t since, unsigned limit,
                                        const GlobalOptions& global, Console& console,
                                        Source& source) {
  const auto found = FindMachineFiles("", global);
  const auto* files = std::get_if<MachineFiles>(&found);
  if (files == nullptr || files->led) return failure;
  if (const std::string why = WhyUnreadable(*files); !why.empty()) {
    return Failure{failure.exit, {kCodePermissionDenied, failure.error.message + "; " + why}};
  }
  const std::string journal = files->state_dir + "/journal.sqlite";
  if (!std::filesystem::exists(journal)) return failure;
  const auto beyond = InOtherNetwork(*files);
  console.Note((beyond ? beyond->Text() : "no controller leads " + files->name + " now") +
               "; reading " + journal);
  source = {nullptr, journal};
  auto read = source.Read(since, limit);
  const auto* entries = std::get_if<Entries>(&read);
  const bool led = beyond && beyond->actuators.empty();
  if (!led && entries != nullptr && EndsWithoutRecord(*entries)) {
    console.Note("the last controller ended without a record: it was killed, or the power failed");
  }
  return read;
}

// Why there is no actuator of that name: neither an entry nor the config knows it; empty: there is.
std::string UnknownActuator(const std::string& name, const Entries& history,
                            const GlobalOptions& global) {
  std::set<std::string> known;
  for (const msg::HistoryEntry& entry : history.entries) known.insert(entry.actuator);
  const auto found = FindMachineFiles("", global);
  const auto* files = std::get_if<MachineFiles>(&found);
  if (files != nullptr && files->config) {
    for (const ActuatorConfig& actuator : files->config->actuators) known.insert(actuator.name);
  }
  known.erase("");
  return known.contains(name) ? "" : NoSuch("actuator", name, {known.begin(), known.end()});
}

// What explains a state is mostly among the newest entries; all are read only where it is not. A
// damaged journal has fewer of them than it was asked for.
std::variant<Entries, Failure> ReadWanted(const HistoryOptions& options, const Selection& wanted,
                                          const GlobalOptions& global, Console& console,
                                          Source& source) {
  const bool newest_first = options.why && !options.lines && options.until.empty();
  unsigned limit = newest_first ? kLines : wanted.ReadLimit();
  if (options.follow) limit = JournalCursor::FirstLimit(limit);
  // One that follows needs the newest entry, of any time.
  auto read = source.Read(options.follow ? 0 : wanted.since, limit);
  const auto* missing = std::get_if<Failure>(&read);
  if (missing != nullptr && missing->exit == ExitCode::kNoController && !options.follow) {
    read = FromDisk(*missing, wanted.since, limit, global, console, source);
  }
  const auto* newest = std::get_if<Entries>(&read);
  const bool is_cut = newest_first && newest != nullptr &&
                      (newest->entries.size() >= limit || !newest->error.empty());
  if (!is_cut || !NeedsOlderEntries(*newest, WantedWhy(options))) return read;
  auto all = source.Read(wanted.since, kAll);
  const auto* failure = std::get_if<Failure>(&all);
  if (failure == nullptr || (source.link && source.link->interrupted())) return all;
  console.Note("older entries could not be read: " + failure->error.message);
  return read;
}

ExitCode History(const HistoryOptions& options, const GlobalOptions& global, Console& console) {
  const auto selection = Select(options);
  if (!selection) return console.Fail(selection.error());
  const Selection& wanted = selection.value();
  if (options.why && !options.why->empty() && (!options.actuator.empty() || wanted.failures_only)) {
    return console.Fail({kCodeParametersInvalid, "--why " + *options.why +
                                                     " shows no failure, which --actuator and "
                                                     "--level choose: leave STATE or them out"});
  }
  Source source{nullptr, options.journal};
  if (options.journal.empty()) source.link = Link::OpenForCalls(global, &console);
  auto read = ReadWanted(options, wanted, global, console, source);
  if (const auto* failure = std::get_if<Failure>(&read)) return console.Fail(*failure);
  auto& history = std::get<Entries>(read);
  if (!history.error.empty()) console.PrintError(history.error);
  if (!options.actuator.empty()) {
    const std::string unknown = UnknownActuator(options.actuator, history, global);
    if (!unknown.empty()) {
      return console.Fail({ExitCode::kUsage, {kCodeParametersInvalid, unknown}});
    }
  }
  if (options.why) {
    wanted.ApplyTimeAndLimit(history);
    return Explain(history, WantedWhy(options), console);
  }
  JournalCursor cursor(INT64_MAX, kMostFollowed);
  if (options.follow) cursor.Take(history);
  wanted.Apply(history);
  Show(history, options.csv, true, console);
  if (!options.follow) return ExitCode::kDone;
  return Follow(*source.link, wanted, cursor, options.csv, console);
}

std::vector<std::string> Events() {
  return {kEventNames.begin() + 1, kEventNames.end()};
}

// Why a name is not that of an event; empty: it is.
std::string EventError(const std::string& name) {
  const auto events = Events();
  if (std::find(events.begin(), events.end(), name) != events.end()) return "";
  const std::string hint = DidYouMean(name, events);
  return "unknown event '" + name.substr(0, 64) + "'" +
         (hint.empty() ? "; docs/reference.md lists them" : hint);
}

}  // namespace

void AddHistory(Grammar& grammar) {
  auto [app, options] = grammar.Add("history", "Show past events, oldest first", History,
                                    "musher history --since 10m --actuator audio");
  app.add_option("--since", options.since, "How long ago (90s, 10m, 2h, 1d), or a date and time")
      ->check(TimeError)
      ->type_name("TIME");
  app.add_option("--until", options.until, "Same format; later events are left out")
      ->check(TimeError)
      ->type_name("TIME");
  grammar
      .Offer(app.add_option("--actuator", options.actuator, "Only events of this one"),
             Names::kActuators)
      ->type_name("NAME");
  auto* event = app.add_option("--event", options.event, "Only events of this name");
  grammar.Suggest(event, Events())->check(EventError)->type_name("EVENT");
  grammar.OneOf(app.add_option("--level", options.level, "`error`: only failures"),
                {"info", kErrorLevel});
  app.add_flag("--boot", options.boot, "Only since this host has booted");
  app.add_option("-n,--lines", options.lines,
                 "Number of newest matching entries; default 1000, 0: all")
      ->check(CLI::Range(0U, 1'000'000U).description(""))
      ->type_name("N");
  auto* csv = app.add_flag("--csv", options.csv, "Print CSV (RFC 4180)");
  auto* journal = grammar
                      .Offer(app.add_option("--journal", options.journal,
                                            "Read this file instead of calling a controller"),
                             Names::kFiles)
                      ->type_name("FILE");
  auto* follow = app.add_flag("-f,--follow", options.follow, "Then print new events, until Ctrl-C");
  follow->excludes(journal);
  grammar
      .Offer(app.add_option("--why", options.why,
                            "Why the machine is in its current state, and what\n"
                            "failed last, with --actuator of it, with --level\n"
                            "error that alone; or why it last went to STATE"),
             Names::kStates)
      ->expected(0, 1)
      ->excludes(follow)
      ->excludes(event)
      ->excludes(csv)
      ->type_name("[STATE]");
}

}  // namespace musher::cli
