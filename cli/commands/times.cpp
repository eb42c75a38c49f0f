// musher times [CONFIG]: what the states of actuators have taken, from journals, and limits for
// `times` of the config. Needs no robot.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/config/times_diff.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/command_times.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/render/times.hpp"
#include "musher/lifecycle/config/config_toml.hpp"

namespace musher::cli {
namespace {

struct TimesOptions {
  std::string config;                 // empty: that of the machine of this host
  std::vector<std::string> journals;  // empty: that of the machine
  std::string since;                  // empty: all
  bool diff = false;
  LearningOptions learning;
};

// The change of the config, with a name of the file that `patch -p0` accepts in the working
// directory.
Result<std::string> DiffOf(const MachineConfig& config, const std::vector<LearnedTime>& rows) {
  const std::string text = ReadFile(config.file);
  if (ConfigHash(text) != config.hash) {
    return Error{kCodeParametersInvalid, config.file + " has changed meanwhile; try again"};
  }
  std::error_code ignored;
  const auto below = std::filesystem::path(config.file)
                         .lexically_proximate(std::filesystem::current_path(ignored));
  const bool is_below = !below.empty() && *below.begin() != "..";
  return TimesDiff(text, config, rows, is_below ? below.string() : config.file);
}

ExitCode PrintDiff(const std::string& diff, Console& console) {
  if (!diff.empty()) {
    console.Print(diff);
  } else {
    console.Note("no limit changes");
  }
  return ExitCode::kDone;
}

ExitCode Times(const TimesOptions& options, const GlobalOptions& global, Console& console) {
  std::int64_t since_ns = 0;
  if (!options.since.empty()) since_ns = ParseSince(options.since, WallNow()).value();
  std::string config_file = options.config;
  std::vector<std::string> journals = options.journals;
  if (config_file.empty() || journals.empty()) {
    const auto found = FindMachineFiles(config_file, global);
    if (const auto* failure = std::get_if<Failure>(&found)) return console.Fail(*failure);
    const MachineFiles& files = std::get<MachineFiles>(found);
    if (config_file.empty()) config_file = files.config_file;
    if (journals.empty()) journals.push_back(files.state_dir + "/journal.sqlite");
  }
  const auto config = LoadConfig(config_file, console);
  if (!config) return ExitCode::kUsage;
  std::vector<CommandTime> commands;
  for (const std::string& file : journals) {
    auto read = ReadCommandTimes(file, since_ns);
    if (!read) return console.Fail(read.error());
    CommandTimes times = std::move(read).value();
    if (!times.damage.empty()) console.PrintError(file + ": " + times.damage);
    std::ranges::move(times.commands, std::back_inserter(commands));
  }
  const auto rows = LearnTimes(commands, *config, options.learning);
  std::string diff;
  if (options.diff) {
    auto made = DiffOf(*config, rows);
    if (!made) return console.Fail(made.error());
    diff = std::move(made).value();
  }
  if (options.diff && !console.mode().json) return PrintDiff(diff, console);
  console.Print(console.mode().json ? TimesJson(rows, diff)
                                    : TimesText(rows, *config, console.mode().colour));
  return ExitCode::kDone;
}

}  // namespace

void AddTimes(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("times", "Show what states have taken, and propose limits for `times`", Times,
                  "musher times robot.toml --since 7d");
  grammar
      .Offer(app.add_option("CONFIG", options.config,
                            "State config; default: of the machine of this host"),
             Names::kConfigs)
      ->type_name("");
  grammar
      .Offer(app.add_option("--journal", options.journals,
                            "Journals to read, also of other robots of this config;\n"
                            "default: of the machine of this host"),
             Names::kFiles)
      ->type_name("FILE");
  app.add_option("--since", options.since, "How long ago (90s, 10m, 2h, 1d), or a date and time")
      ->check(TimeError)
      ->type_name("TIME");
  app.add_flag("--diff", options.diff, "Print only what changes in the config, for `patch -p0`");
  app.add_option("--least", options.learning.least_commands,
                 "Commands that a proposal needs; default 100")
      ->check(CLI::Range(1U, 1'000'000U).description(""))
      ->type_name("N");
  app.add_option("--margin", options.learning.margin,
                 "Proposed limit, as a multiple of the 99.9th percentile;\ndefault 1.5")
      ->check(Between(1, 100, "times"))
      ->type_name("FACTOR");
}

}  // namespace musher::cli
