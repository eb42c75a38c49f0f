// musher logs [ACTUATOR...]: what the processes of a machine have printed, from their log files.

#include <sys/inotify.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/base/joined.hpp"
#include "musher/base/suggest.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/host_logs.hpp"
#include "musher/cli/commands/log_files_of.hpp"
#include "musher/cli/console/output_reader.hpp"
#include "musher/cli/console/signals.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/render/log_lines.hpp"
#include "musher/controller/storage/log_parts.hpp"
#include "musher/controller/storage/log_reader.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli {
namespace {

struct LogsOptions {
  std::vector<std::string> actuators;  // empty: all, and the controller
  bool follow = false;
  std::string since;  // empty: no limit
  std::optional<unsigned> lines;
  std::string level = "debug";
  std::string config;
};

constexpr unsigned kDefaultLines = 50;
constexpr Duration kFollowAgain = Milliseconds(2'000);

// A log that is shown.
struct ShownLog {
  std::string source;
  std::string path;
  std::int64_t end = 0;
};

class LogPrinter {
 public:
  LogPrinter(Console& console, LogFilter filter, const std::vector<ShownLog>& logs,
             const std::vector<HostLog>& host_logs)
      : console_(console), filter_(filter) {
    if (logs.size() + host_logs.size() < 2) return;
    for (const ShownLog& log : logs) width_ = std::max(width_, Width(log.source));
    for (const HostLog& log : host_logs) width_ = std::max(width_, Width(log.actuator));
  }

  void Print(const std::vector<LogEntry>& entries) { Print(entries, filter_); }
  // Lines that were just written: of any time, as the wall clock may be set back.
  void PrintAppended(const std::vector<LogEntry>& entries) { Print(entries, {0, filter_.level}); }

 private:
  void Print(const std::vector<LogEntry>& entries, const LogFilter& filter) {
    std::string text;
    for (const LogEntry& entry : entries) {
      if (!filter.Shows(entry)) continue;
      text += console_.mode().json ? LogJson(entry) + '\n'
                                   : LogText(entry, width_, console_.mode().colour);
    }
    if (!text.empty()) console_.Print(text);
  }

  Console& console_;
  LogFilter filter_;
  std::size_t width_ = 0;
};

// Prints what is appended to the logs until Ctrl-C.
class LogFollower {
 public:
  // `positions`: of the other hosts, from where their lines follow; since `begun_ns` where that is
  // not known.
  LogFollower(const std::vector<ShownLog>& logs, const std::vector<HostLog>& host_logs,
              std::map<const HostConfig*, JournalPosition> positions, std::int64_t begun_ns,
              LogPrinter& printer, Console& console)
      : printer_(printer),
        console_(console),
        begun_ns_(begun_ns),
        signals_(TakeEndSignals()),
        changes_(inotify_init1(IN_CLOEXEC | IN_NONBLOCK)) {
    for (const ShownLog& log : logs) {
      tails_.push_back({log.path, LogTail(log.path, log.end), LogLines(log.source)});
      const std::string folder = std::filesystem::path(log.path).parent_path();
      inotify_add_watch(changes_.get(), folder.c_str(), IN_CREATE | IN_MOVED_TO);
    }
    WatchFiles();
    for (const HostLog& log : host_logs) {
      HostTail& tail = TailOf(log.host);
      tail.logs.push_back(log);
      tail.lines.emplace(log.unit, log.actuator);
    }
    for (const auto& tail : host_tails_) {
      tail->position = std::move(positions[tail->host]);
      Follow(*tail);
    }
  }

  ExitCode Run() {
    const auto end = loop_.WhenReadable(signals_.get(), [this] {
      if (NextSignal(signals_) != 0) loop_.Stop();
    });
    const UniqueFd reader = TakeReaderOf(STDOUT_FILENO);
    transport::LoopHandlePtr no_reader;
    if (reader.valid()) no_reader = loop_.WhenReadable(reader.get(), [this] { loop_.Stop(); });
    const auto change = loop_.WhenReadable(changes_.get(), [this] { OnChange(); });
    OnChange();  // appended before the files were watched
    loop_.Run();
    return ExitCode::kDone;
  }

 private:
  struct Tail {
    std::string path;
    LogTail file;
    LogLines lines;
  };

  // The logs of one host. A connection that ends is made again, and goes on where it was.
  struct HostTail {
    const HostConfig* host;
    std::vector<HostLog> logs = {};
    JournalPosition position = {};
    std::optional<HostScript> script = {};
    std::map<std::string, LogLines> lines = {};  // by unit
    std::string reported = {};                   // the trouble
    transport::LoopHandlePtr watch = nullptr;
    transport::LoopHandlePtr again = nullptr;
  };

  HostTail& TailOf(const HostConfig* host) {
    const auto found = std::find_if(host_tails_.begin(), host_tails_.end(),
                                    [&](const auto& tail) { return tail->host == host; });
    if (found != host_tails_.end()) return **found;
    return *host_tails_.emplace_back(std::make_unique<HostTail>(HostTail{host}));
  }

  void Follow(HostTail& tail) {
    auto script =
        HostScript::Start(*tail.host, FollowScript(tail.logs, tail.position.cursor, begun_ns_));
    if (!script) return FollowAgain(tail, script.error().message);
    tail.script.emplace(std::move(script).value());
    tail.watch = loop_.WhenReadable(tail.script->output(), [this, &tail] { OnLines(tail); });
  }

  void FollowAgain(HostTail& tail, const std::string& why) {
    if (std::exchange(tail.reported, why) != why) {
      console_.PrintError(why + "; its lines follow once it is reached again");
    }
    tail.again = loop_.At(loop_.Now() + kFollowAgain, [this, &tail] { Follow(tail); });
  }

  void OnLines(HostTail& tail) {
    const bool more = tail.script->Read();
    std::vector<LogEntry> entries;
    for (const std::string& text : tail.script->TakeLines()) {
      auto line = ParseJournalLine(text);
      const auto reader = line ? tail.lines.find(line->unit) : tail.lines.end();
      if (reader == tail.lines.end()) continue;
      tail.reported.clear();
      const bool again = !line->cursor.empty() && (line->cursor == tail.position.cursor ||
                                                   tail.position.shown.contains(line->cursor));
      if (again) continue;
      tail.position.cursor = line->cursor;
      line->line.written_ns -= tail.script->clock_offset_ns().value_or(0);
      entries.push_back(reader->second.Take(line->line));
    }
    printer_.Print(entries);
    if (more) return;
    tail.watch = nullptr;
    const std::string trouble = tail.script->Trouble();
    tail.script.reset();
    FollowAgain(tail,
                trouble.empty() ? "host " + tail.host->name + ": its journal has ended" : trouble);
  }

  // Adds nothing where a file is watched already.
  void WatchFiles() {
    for (const Tail& tail : tails_) {
      inotify_add_watch(changes_.get(), tail.path.c_str(), IN_MODIFY);
    }
  }

  void OnChange() {
    bool made = false;
    alignas(inotify_event) std::array<char, 16 << 10> buffer{};
    for (ssize_t got = 0; (got = read(changes_.get(), buffer.data(), buffer.size())) > 0;) {
      for (ssize_t at = 0; at < got;) {
        const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
        made |= (event->mask & IN_MODIFY) == 0;
        at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
      }
    }
    if (made) WatchFiles();
    const std::int64_t now = WallNow();
    std::vector<std::vector<LogEntry>> logs;
    for (Tail& tail : tails_) {
      logs.emplace_back();
      for (std::string& line : tail.file.Read()) {
        logs.back().push_back(tail.lines.Take({std::move(line), now}));
      }
    }
    printer_.PrintAppended(Merge(std::move(logs)));
    if (!console_.HasReader()) loop_.Stop();
  }

  LogPrinter& printer_;
  Console& console_;
  std::int64_t begun_ns_;
  UniqueFd signals_;
  UniqueFd changes_;
  std::vector<Tail> tails_;
  transport::LinuxEventLoop loop_;
  std::vector<std::unique_ptr<HostTail>> host_tails_;
};

// "; …" if no controller leads the machine that this command reaches.
std::string WhoLeads(const MachineFiles& files) {
  if (files.led) return "";
  if (const auto beyond = InOtherNetwork(files)) {
    return "; " + beyond->Text();
  }
  return "; no controller of this host leads it now";
}

void ReportFiles(const MachineFiles& files, const std::vector<ShownLog>& logs,
                 const std::vector<std::string>& missing, bool requested, Console& console) {
  if (console.mode().json) return;
  if (logs.size() == 1) {
    const std::size_t parts = LogPartsOf(logs.front().path).size();
    console.Note("reading " + logs.front().path +
                 (parts == 0 ? "" : " and " + Counted(parts, "older part")));
  } else if (!logs.empty()) {
    console.Note("reading " + Counted(logs.size(), "log") + " of " + files.name + " in " +
                 files.state_dir + WhoLeads(files));
  }
  if (requested || missing.empty()) return;
  console.Note("no log here of " + Joined(missing) + ": `musher logs " + missing.front() +
               "` gives the reason");
}

ExitCode Logs(const LogsOptions& options, const GlobalOptions& global, Console& console) {
  auto found = FindMachineFiles(options.config, global);
  if (const auto* failure = std::get_if<Failure>(&found)) return console.Fail(*failure);
  const MachineFiles& files = std::get<MachineFiles>(found);
  if (const std::string why = WhyUnreadable(files); !why.empty()) {
    return console.Fail({ExitCode::kNotDone, {kCodePermissionDenied, why}});
  }
  const std::vector<std::string> known = LogNamesOf(files);
  const bool requested = !options.actuators.empty();
  std::vector<ShownLog> logs;
  std::vector<HostLog> host_logs;
  std::vector<std::string> missing;
  for (const std::string& name : requested ? options.actuators : known) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      return console.Fail(
          {ExitCode::kUsage, {kCodeParametersInvalid, NoSuch("actuator", name, known)}});
    }
    const bool twice = std::any_of(logs.begin(), logs.end(),
                                   [&](const ShownLog& log) { return log.source == name; }) ||
                       std::any_of(host_logs.begin(), host_logs.end(),
                                   [&](const HostLog& log) { return log.actuator == name; });
    if (twice) continue;
    const auto host_log = HostLogOf(files, name);
    if (host_log) host_logs.push_back(*host_log);
    const std::string path = LogPathOf(files, name);
    if (std::filesystem::exists(path)) {
      logs.push_back({name, path});
      continue;
    }
    if (host_log) continue;
    missing.push_back(name);
    if (requested) console.PrintError(WhyNoLog(files, name, path));
  }
  if (logs.empty() && host_logs.empty()) {
    if (requested) return ExitCode::kNotDone;
    return console.Fail({ExitCode::kNotDone,
                         {kCodeFailed, "no logs in " + files.state_dir + ": " + files.name +
                                           " was never started on this host" + HiddenFilesNote()}});
  }
  ReportFiles(files, logs, missing, requested, console);

  LogFilter filter;
  if (!options.since.empty()) filter.since_ns = ParseSince(options.since, WallNow()).value();
  filter.level = LogLevelNamed(options.level).value();
  const unsigned lines = options.lines.value_or(options.since.empty() ? kDefaultLines : 0);
  std::vector<std::vector<LogEntry>> all;
  for (ShownLog& log : logs) {
    auto read = ReadLog(log.source, log.path, filter, lines);
    if (!read) return console.Fail(Failure{ExitCode::kNotDone, read.error()});
    if (!read.value().note.empty()) console.PrintError(read.value().note);
    log.end = read.value().end;
    all.push_back(std::move(read.value().entries));
  }
  // A level may leave out most of the lines.
  const bool filtered = filter.level > LogLevel::kDebug;
  const std::int64_t begun_ns = WallNow();
  ReadHostLogs there = ReadLogsOf(host_logs, filter.since_ns, filtered ? 0 : lines);
  for (const std::string& trouble : there.troubles) console.PrintError(trouble);
  for (auto& of_one : there.entries) all.push_back(std::move(of_one));
  std::vector<LogEntry> entries = Merge(std::move(all));
  std::erase_if(entries, [&](const LogEntry& entry) { return !filter.Shows(entry); });
  if (lines != 0 && entries.size() > lines) entries.erase(entries.begin(), entries.end() - lines);
  LogPrinter printer(console, filter, logs, host_logs);
  printer.Print(entries);
  const bool nothing = logs.empty() && !there.troubles.empty() && entries.empty();
  if (!options.follow) return nothing ? ExitCode::kNotDone : ExitCode::kDone;
  return LogFollower(logs, host_logs, std::move(there.positions), begun_ns, printer, console).Run();
}

}  // namespace

void AddLogs(Grammar& grammar) {
  auto [app, options] = grammar.Add("logs", "Show what the actuators' processes print", Logs,
                                    "musher logs -f audio motion_manager --level warning");
  grammar
      .Offer(app.add_option("ACTUATOR", options.actuators,
                            "Only of these; `controller`: its own log.\nDefault: all, by time"),
             Names::kActuators)
      ->type_name("");
  app.add_flag("-f,--follow", options.follow, "Then print new lines, until Ctrl-C");
  app.add_option("--since", options.since, "How long ago (90s, 10m, 2h, 1d), or a date and time")
      ->check(TimeError)
      ->type_name("TIME");
  app.add_option("-n,--lines", options.lines,
                 "Number of newest lines; default 50, with --since all;\n0: all")
      ->check(CLI::Range(0U, 10'000'000U).description(""))
      ->type_name("N");
  grammar.OneOf(app.add_option("--level", options.level,
                               "Only lines of this level and above; lines without\na level count "
                               "as info"),
                {"debug", "info", "warning", "error"});
  grammar
      .Offer(app.add_option("--config", options.config,
                            "Of the machine of this config, also if it is down"),
             Names::kConfigs)
      ->type_name("FILE");
}

}  // namespace musher::cli
