// musher replay JOURNAL: re-runs the recorded decisions of a journal. Needs no robot.

#include "musher/controller/journal/replay.hpp"
#include <CLI/CLI.hpp>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

struct ReplayOptions {
  std::string journal;
  std::string config;  // empty: the recorded one
  std::string since;   // empty: all
  std::optional<std::uint64_t> epoch;
};

ExitCode Replay(const ReplayOptions& options, const GlobalOptions& /*global*/, Console& console) {
  recording::ReplayOptions what;
  if (options.epoch) what.epoch = Epoch(*options.epoch);
  if (!options.since.empty()) {
    const auto since = ParseSince(options.since, WallNow());
    if (!since) return console.Fail(since.error());
    what.since_wall_ns = since.value();
  }
  if (!options.config.empty()) {
    what.config = LoadConfig(options.config, console);
    if (!what.config) return ExitCode::kUsage;
  }
  const auto journal = ReadRecording(options.journal);
  if (!journal) return console.Fail(journal.error());
  const std::string& damage = journal.value().damage;
  if (!damage.empty()) console.PrintError(damage);
  const auto replayed = recording::Replay(journal.value().rows, what);
  if (!replayed) return console.Fail(replayed.error());
  const recording::ReplayReport& report = replayed.value();
  for (const std::string& note : report.notes) console.PrintError(note);
  console.Print(console.mode().json ? ReplayJson(report, damage)
                                    : ReplayText(report, console.mode().colour));
  return report.equal() ? ExitCode::kDone : ExitCode::kNotDone;
}

}  // namespace

void AddReplay(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("replay", "Re-run the recorded decisions of a journal and compare", Replay,
                  "musher replay journal.sqlite --config robot.toml");
  grammar
      .Offer(app.add_option("JOURNAL", options.journal, "A controller's journal.sqlite"),
             Names::kFiles)
      ->required()
      ->type_name("");
  grammar
      .Offer(app.add_option("--config", options.config, "Show what this state config would change"),
             Names::kConfigs)
      ->type_name("FILE");
  app.add_option("--since", options.since, "How long ago (90s, 10m, 2h, 1d), or a date and time")
      ->check(TimeError)
      ->type_name("TIME");
  app.add_option("--epoch", options.epoch, "Only decisions of the controller with this epoch")
      ->type_name("N");
}

}  // namespace musher::cli
