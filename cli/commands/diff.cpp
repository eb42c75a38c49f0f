// musher diff FILE [FILE]: what changes between two state configs, or from the config of the
// running machine to a file. Uses the network only for the running machine.

#include <CLI/CLI.hpp>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_diff.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/render/diff.hpp"
#include "musher/controller/journal/journal_reader.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/lifecycle/config/config_toml.hpp"

namespace musher::cli {
namespace {

struct DiffOptions {
  std::vector<std::string> files;  // one or two
};

// The config in the place of another file: its default name and its relative paths are those it
// would have there.
MachineConfig InPlaceOf(const std::string& place, const std::string& text, MachineConfig as_read) {
  ConfigReading moved = ReadConfigText(text, place);
  if (!moved.config) return as_read;
  moved.config->file = as_read.file;
  return *std::move(moved.config);
}

ExitCode ShowDiff(const ConfigDiff& diff, Console& console) {
  console.Print(console.mode().json ? DiffJson(diff) : DiffText(diff, console.mode().colour));
  return diff.changes.empty() ? ExitCode::kDone : ExitCode::kNotDone;
}

// The text of a config with this hash that a journal has recorded; empty: none.
std::string RecordedText(const std::string& journal, const std::string& hash) {
  const auto recording = ReadRecording(journal);
  if (!recording) return "";
  for (const JournalRow& row : recording.value().rows) {
    const auto* input = std::get_if<JournalInput>(&row.item);
    if (input == nullptr) continue;
    const auto* config = std::get_if<recording::ConfigText>(&input->what);
    if (config != nullptr && config->hash == hash && !config->text.empty()) return config->text;
  }
  return "";
}

// The text that the controller has read when it started: its file, or if that has changed since,
// the journal.
Result<std::string> TextOf(const msg::MachineStatus& running) {
  if (running.host.empty() || running.host != HostId()) {
    return Error{kCodeParametersInvalid,
                 "the controller runs on another host, where its config is " + running.config_file +
                     "; run this command there, or compare two files"};
  }
  std::string text = ReadFile(running.config_file);
  if (ConfigHash(text) == running.config_hash) return text;
  const std::string folder = StateDirOfProcess(running.pid);
  if (!folder.empty()) text = RecordedText(folder + "/journal.sqlite", running.config_hash);
  if (ConfigHash(text) == running.config_hash) return text;
  return Error{kCodeParametersInvalid,
               running.config_file + " has changed since the machine was started with it, and " +
                   (folder.empty() ? "the folder of its controller is not readable"
                                   : "the journal in " + folder + " does not have its text") +
                   "; compare two files"};
}

ExitCode CompareWithRunning(const MachineConfig& after, const GlobalOptions& global,
                            Console& console) {
  const auto link = Link::Open(global, &console);
  if (!link) return console.Fail(link.error());
  if (auto followed = link.value()->FollowStatus({}); !followed) {
    return console.Fail(followed.error());
  }
  if (const auto failure = link.value()->AwaitStatus()) return console.Fail(*failure);
  const msg::MachineStatus running = *link.value()->status();
  const auto text = TextOf(running);
  if (!text) return console.Fail(text.error());
  ConfigReading reading = ReadConfigText(text.value(), running.config_file);
  if (!reading.config) {
    return console.Fail(
        Error{kCodeParametersInvalid, "the config of the running machine, " + running.config_file +
                                          ", is not valid for this version of musher"});
  }
  ConfigDiff diff =
      Compare(*reading.config, InPlaceOf(running.config_file, ReadFile(after.file), after));
  diff.before = "the running machine " + running.machine;
  return ShowDiff(diff, console);
}

ExitCode Diff(const DiffOptions& options, const GlobalOptions& global, Console& console) {
  const auto first = LoadConfig(options.files.front(), console);
  if (!first) return ExitCode::kUsage;
  if (options.files.size() == 1) return CompareWithRunning(*first, global, console);
  const std::string& other = options.files.back();
  auto second = LoadConfig(other, console);
  if (!second) return ExitCode::kUsage;
  return ShowDiff(Compare(*first, InPlaceOf(first->file, ReadFile(other), *std::move(second))),
                  console);
}

}  // namespace

void AddDiff(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("diff", "Show what changes between two state configs, and what it takes", Diff,
                  "musher diff old.toml robot.toml");
  grammar
      .Offer(app.add_option("FILE", options.files,
                            "Two state configs, the earlier first; or one, which is\n"
                            "compared with that of the running machine"),
             Names::kConfigs)
      ->required()
      ->expected(1, 2)
      ->type_name("");
}

}  // namespace musher::cli
