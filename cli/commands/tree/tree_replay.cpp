// musher tree replay FILE: shows the recording of a behaviour tree. Uses no network.

#include <fmt/format.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>

#include "musher/base/files.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/words.hpp"
#include "musher/behavior/tree/recording.hpp"
#include "musher/cli/commands/tree/tree_commands.hpp"
#include "musher/cli/console/console.hpp"
#include "musher/cli/console/signals.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/tree.hpp"

namespace musher::cli {
namespace {

constexpr std::size_t kMostRecordingBytes = std::size_t{256} << 20;
constexpr std::string_view kScreenHome = "\x1b[H\x1b[J";  // the empty screen of a terminal
constexpr double kPictureEveryS = 0.1;

struct TreeReplayOptions {
  std::string file;
  std::optional<double> at_s;
  std::optional<double> speed;
  std::size_t number = 0;  // of a tree in the recording, from 1; 0: all, or the last
  std::size_t history = 10;
  bool entries = false;
  std::string btlog;
};

std::uint8_t CodeOf(tree::Status status) {
  return static_cast<std::uint8_t>(status);
}

msg::TreeChange ChangeOf(const tree::RecordedEvent& event) {
  return {ToSeconds(event.at), event.change.node, CodeOf(event.change.from),
          CodeOf(event.change.to)};
}

// A running tree does not report the reset of a node that has ended, either.
bool IsReported(const tree::RecordedEvent& event) {
  return event.kind == tree::RecordedEvent::Kind::kChange &&
         !(tree::IsCompleted(event.change.from) && event.change.to == tree::Status::kIdle);
}

class TreeReplay {
 public:
  TreeReplay(const tree::Recording& recording, const TreeReplayOptions& options, Console& console)
      : recording_(recording), options_(options), console_(console) {}

  ExitCode Run() {
    const std::size_t count = recording_.trees.size();
    if (options_.number > count) {
      return console_.Fail(Error{kCodeParametersInvalid, recording_.file + " has " +
                                                             Counted(count, "tree") + ", no tree " +
                                                             std::to_string(options_.number)});
    }
    if (count == 0) {
      return console_.Fail(
          Error{kCodeParametersInvalid, recording_.file + ": no tree was loaded so far"});
    }
    const std::size_t one = options_.number > 0 ? options_.number : count;
    if (!options_.btlog.empty()) {
      const ExitCode exported = Export(recording_.trees[one - 1]);
      if (exported != ExitCode::kDone) return exported;
    } else if (options_.at_s) {
      ShowAt(one);
    } else if (options_.speed) {
      Play(one);
    } else {
      const std::size_t first = options_.number > 0 ? one : 1;
      for (std::size_t number = first; number <= one; ++number) List(number);
    }
    if (recording_.cut_at) {
      console_.PrintError(recording_.file + ":" + std::to_string(*recording_.cut_at) +
                          ": the recording ends within this line (a loss of power, or a crash); "
                          "everything before it is " +
                          (options_.btlog.empty() ? "shown" : "written"));
    }
    return ExitCode::kDone;
  }

 private:
  ExitCode Export(const tree::RecordedTree& tree) {
    std::error_code none;  // there is no such file
    if (std::filesystem::equivalent(options_.btlog, recording_.file, none)) {
      return console_.Fail(
          Error{kCodeParametersInvalid, "--btlog: " + options_.btlog + " is the recording itself"});
    }
    const Result<std::string> log = tree::WriteBtlog(tree);
    if (!log) return console_.Fail(log.error());
    const Result<> saved = ReplaceFile(options_.btlog, log.value(), {.synced = false});
    return saved ? ExitCode::kDone : console_.Fail(saved.error());
  }

  void ShowAt(std::size_t number) {
    tree::Playback playback(recording_.trees[number - 1]);
    playback.To(std::chrono::duration_cast<Duration>(
        std::chrono::duration<double>(std::min(*options_.at_s, ToSeconds(playback.tree().End())))));
    Print(number, playback, options_.history);
  }

  // Every change, then the tree at its end.
  void List(std::size_t number) {
    tree::Playback playback(recording_.trees[number - 1]);
    const auto names = MomentOf(number, playback, 0).report;
    ticking_ = false;
    while (playback.Step()) PrintEvent(playback, names);
    Print(number, playback, console_.mode().json ? SIZE_MAX : 0, "\n");
  }

  void Play(std::size_t number) {
    using Clock = std::chrono::steady_clock;
    const UniqueFd signals = TakeEndSignals();
    const tree::RecordedTree& tree = recording_.trees[number - 1];
    tree::Playback playback(tree);
    const auto names = MomentOf(number, playback, 0).report;
    const bool redrawn = console_.mode().terminal && !console_.mode().json;
    const Clock::time_point start = Clock::now();
    while (console_.HasReader()) {
      const double played_s = std::chrono::duration<double>(Clock::now() - start).count();
      const double tree_s = std::min(played_s * *options_.speed, ToSeconds(tree.End()));
      const auto until =
          std::chrono::duration_cast<Duration>(std::chrono::duration<double>(tree_s));
      const bool at_end = tree_s >= ToSeconds(tree.End());
      while (playback.position() < tree.events.size() &&
             (at_end || tree.events[playback.position()].at <= until)) {
        playback.Step();
        if (!redrawn) PrintEvent(playback, names);
      }
      playback.To(until);
      if (redrawn) {
        console_.Redraw(std::string(kScreenHome) +
                        RecordedTreeText(recording_.actuator,
                                         MomentOf(number, playback, options_.history),
                                         console_.mode().colour));
      }
      if (at_end) break;
      const double next_s = ToSeconds(tree.events[playback.position()].at) - tree_s;
      const double wait_s = std::min(kPictureEveryS, next_s / *options_.speed);
      pollfd ended{signals.get(), POLLIN, 0};
      if (poll(&ended, 1, 1 + static_cast<int>(1e3 * wait_s)) > 0) return;
    }
    if (console_.mode().json) Print(number, playback, SIZE_MAX);
  }

  // The event that was stepped over last.
  void PrintEvent(const tree::Playback& playback, const msg::GetTree::Response& names) {
    using Kind = tree::RecordedEvent::Kind;
    if (console_.mode().json) return;
    const tree::RecordedEvent& event = playback.tree().events[playback.position() - 1];
    const std::string time = fmt::format("{:>10.3f} s", ToSeconds(event.at));
    if (IsReported(event)) {
      console_.Print(RecordedChangeLine(names, ChangeOf(event), console_.mode().colour));
    } else if (event.kind == Kind::kFault && !event.text.empty()) {
      console_.Print(time + "  fault: " + Printable(event.text));
    } else if (event.kind == Kind::kState && event.ticking != ticking_) {
      ticking_ = event.ticking;
      console_.Print(time + (ticking_ ? "  ticking" : "  paused"));
    } else if (event.kind == Kind::kLost) {
      console_.Print(time + "  " + Counted(event.lines, "line") + " lost: the disk was too slow");
    }
  }

  void Print(std::size_t number, const tree::Playback& playback, std::size_t history,
             const std::string& before = "") {
    const RecordedMoment moment = MomentOf(number, playback, history);
    console_.Print(console_.mode().json ? RecordedTreeJson(recording_.actuator, moment)
                                        : before + RecordedTreeText(recording_.actuator, moment,
                                                                    console_.mode().colour));
  }

  RecordedMoment MomentOf(std::size_t number, const tree::Playback& playback,
                          std::size_t history) const {
    const tree::RecordedTree& tree = playback.tree();
    RecordedMoment moment;
    moment.number = number;
    moment.trees = recording_.trees.size();
    moment.end_s = ToSeconds(tree.End());
    moment.wall_us = playback.WallAt(playback.now());
    moment.cut_at_line = recording_.cut_at.value_or(0);
    msg::TreeState& state = moment.report.state;
    state.tree = tree.name;
    state.revision = tree.revision;
    state.ticking = playback.ticking();
    state.time_s = ToSeconds(playback.now());
    state.last_fault = playback.fault();
    for (tree::NodeId id = 0; id < tree.nodes.size(); ++id) {
      const tree::RecordedNode& recorded = tree.nodes[id];
      msg::TreeNode node;
      node.name = recorded.name;
      node.type = recorded.type;
      node.kind = recorded.kind;
      node.parent = recorded.parent ? static_cast<std::int32_t>(*recorded.parent) : -1;
      node.spent_s = ToSeconds(playback.Spent(id));
      node.runs = playback.runs(id).starts;
      moment.report.nodes.push_back(std::move(node));
      state.status.push_back(CodeOf(playback.status(id)));
    }
    if (!state.status.empty()) state.status[0] = CodeOf(playback.result());
    AddHistory(playback, history, moment);
    if (!options_.entries) return moment;
    for (const auto& entry : playback.entries()) {
      moment.report.entries.push_back({entry.board, entry.key, entry.type, entry.value});
    }
    return moment;
  }

  // The last so many changes, and the lines that were lost so far.
  static void AddHistory(const tree::Playback& playback, std::size_t most, RecordedMoment& moment) {
    const auto& events = playback.tree().events;
    auto& changes = moment.report.history;
    for (std::size_t i = playback.position(); i-- > 0;) {
      if (events[i].kind == tree::RecordedEvent::Kind::kLost) moment.lost_lines += events[i].lines;
      if (IsReported(events[i]) && changes.size() < most) changes.push_back(ChangeOf(events[i]));
    }
    std::ranges::reverse(changes);
  }

  const tree::Recording& recording_;
  const TreeReplayOptions& options_;
  Console& console_;
  bool ticking_ = false;  // as it was printed last
};

ExitCode ReplayTree(const TreeReplayOptions& options, const GlobalOptions& /*global*/,
                    Console& console) {
  if (!std::isfinite(options.at_s.value_or(0)) || !std::isfinite(options.speed.value_or(1))) {
    return console.Fail(Error{kCodeParametersInvalid, "--at and --speed are finite numbers"});
  }
  const Result<std::string> text = config_toml::ReadTextFile(options.file, kMostRecordingBytes);
  if (!text) {
    return console.Fail(Error{kCodeParametersInvalid, options.file + ": " + text.error().message});
  }
  if (text.value().size() > kMostRecordingBytes) {
    return console.Fail(Error{kCodeParametersInvalid,
                              options.file + ": larger than 256 MiB, which is no recording"});
  }
  const Result<tree::Recording> recording = tree::ReadRecording(text.value(), options.file);
  if (!recording) return console.Fail(recording.error());
  return TreeReplay(recording.value(), options, console).Run();
}

}  // namespace

void AddTreeReplay(Grammar& grammar, CLI::App& family) {
  auto [app, options] = grammar.Add("replay", "Show the recording of a tree: what each node did",
                                    ReplayTree, &family);
  grammar
      .Offer(app.add_option("FILE", options.file, "A recording, by the key `record` of a program"),
             Names::kFiles)
      ->required()
      ->type_name("");
  auto* const at =
      app.add_option("--at", options.at_s, "The tree as it was at this time of it, in s")
          ->check(Between(0, 1e9, "seconds"))
          ->type_name("S");
  auto* const speed =
      app.add_option("--speed", options.speed, "Play it at so many times its speed; 1: as it was")
          ->check(Between(0.001, 1e6, "times its speed"))
          ->excludes(at)
          ->type_name("N");
  app.add_option("--tree", options.number,
                 "The number of a tree in the recording, from 1; default: all trees, but only the "
                 "last one with --at, --speed or --btlog")
      ->check(CLI::Range(1U, 1'000'000U).description(""))
      ->type_name("N");
  app.add_option("--history", options.history,
                 "With --at and --speed: the last N changes (default 10)")
      ->check(CLI::Range(0U, 1'000'000U).description(""))
      ->type_name("N");
  app.add_flag("--entries", options.entries, "With the blackboards");
  grammar
      .Offer(app.add_option("--btlog", options.btlog,
                            "Write the tree as a log of BehaviorTree.CPP 4, for Groot2"),
             Names::kFiles)
      ->excludes(at)
      ->excludes(speed)
      ->type_name("OUT");
}

}  // namespace musher::cli
