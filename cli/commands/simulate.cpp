// musher simulate FILE: many scenarios of a robot with this config, on the real decision code, in
// virtual time, with faults sampled from seeds. Touches no network and no process.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <thread>

#include "musher/base/files.hpp"
#include "musher/base/suggest.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/simulation.hpp"
#include "musher/simulation/timeline.hpp"

namespace musher::cli {
namespace {

struct SimulateOptions {
  std::string file;
  std::uint64_t seeds = 1000;
  std::optional<std::uint64_t> seed;  // show only the run of this seed
  std::string only;                   // inject only these of its events: "3,7"; empty: all
  std::optional<double> bound_s;      // within which the machine must reach a stable state
  std::string home;                   // the state that operators recover it to; empty: Active
  std::string rules;                  // file with rules of the user; empty: those of the config
  std::string svg;                    // file for the drawing of the failing or shown run
  unsigned jobs = 0;                  // threads; 0: one per core
};

using simulation::Scenario;
using simulation::ScenarioId;
using simulation::ScenarioOptions;
using simulation::Timeline;

// "3,7,12"
Result<std::vector<std::size_t>> ParseNumbers(const std::string& text) {
  std::vector<std::size_t> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at < end) {
    std::size_t number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    const bool continues = next == end || (*next == ',' && next + 1 != end);
    if (error != std::errc() || !continues) {
      return Error{kCodeParametersInvalid,
                   "--only: '" + text + "' is not a list of numbers; use commas, as in 3,7,12"};
    }
    numbers.push_back(number);
    at = next == end ? end : next + 1;
  }
  return numbers;
}

Result<ScenarioOptions> OptionsFor(const SimulateOptions& options, const MachineConfig& config) {
  ScenarioOptions scenario = simulation::UsualOptions(config);
  if (options.bound_s) {
    scenario.bound = FromSeconds(*options.bound_s);
  }
  if (options.home.empty()) return scenario;
  if (!config.RankOf(options.home) || !config.HasState(options.home)) {
    return Error{kCodeParametersInvalid, "--home: " + config.name + " has no stable state '" +
                                             options.home + "'" +
                                             DidYouMean(options.home, config.states)};
  }
  scenario.home = State(options.home);
  return scenario;
}

// Simulated actuators use Musher's protocol, and the controller starts them by itself. Returns the
// names of those that really use another.
std::vector<std::string> MakeAllUseMusher(MachineConfig& config) {
  std::vector<std::string> others;
  for (ActuatorConfig& actuator : config.actuators) {
    if (actuator.protocol == Protocol::kMusher) continue;
    others.push_back(actuator.name);
    actuator.protocol = Protocol::kMusher;
  }
  config.ros2.started_by_manager = false;  // no manager is simulated
  return others;
}

struct SimulatedRun {
  std::string text;
  std::string svg;
  simulation::ScenarioEnd ending;
};

Result<SimulatedRun> RunWithTimeline(const MachineConfig& config, const ScenarioOptions& options,
                                     const ScenarioId& id) {
  auto injections = InjectionsOf(config, id);
  if (!injections) return injections.error();
  Scenario scenario(config, id.seed, std::move(injections).value(), options);
  Timeline timeline(scenario, config);
  SimulatedRun run;
  run.ending = scenario.Run();
  timeline.End(run.ending);
  run.text = timeline.Text();
  run.svg = timeline.Svg(config.name + ", seed " + std::to_string(id.seed));
  return run;
}

// Runs the scenario of --seed, and prints its timeline.
ExitCode RunOne(const SimulateOptions& options, const MachineConfig& config,
                const ScenarioOptions& scenario, Console& console) {
  ScenarioId id{*options.seed, std::nullopt};
  if (!options.only.empty()) {
    auto numbers = ParseNumbers(options.only);
    if (!numbers) return console.Fail(numbers.error());
    id.only = std::move(numbers).value();
  }
  const auto run = RunWithTimeline(config, scenario, id);
  if (!run) return console.Fail(run.error());
  if (!options.svg.empty()) {
    const auto written = WriteFile(options.svg, run.value().svg);
    if (!written) return console.Fail(written.error());
  }
  const auto& ending = run.value().ending;
  console.Print(console.mode().json ? ScenarioJson(id, ending, run.value().text)
                                    : run.value().text + ScenarioVerdict(ending));
  return ending.violation ? ExitCode::kNotDone : ExitCode::kDone;
}

ExitCode Simulate(const SimulateOptions& options, const GlobalOptions& /*global*/,
                  Console& console) {
  auto config = LoadConfig(options.file, console);
  if (!config) return ExitCode::kUsage;
  const std::vector<std::string> others = MakeAllUseMusher(*config);
  auto scenario = OptionsFor(options, *config);
  if (!scenario) return console.Fail(scenario.error());
  if (!LoadUserRules(options.rules, *config, console, scenario.value().rules)) {
    return ExitCode::kUsage;
  }
  if (options.seed) return RunOne(options, *config, scenario.value(), console);

  SimulationReport report{*config, options.file, scenario.value(), {},           {},
                          {},      {},           others,           options.rules};
  const auto begin = std::chrono::steady_clock::now();
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  report.threads = options.jobs == 0 ? cores : options.jobs;
  report.summary = RunMany(*config, scenario.value(), 1, options.seeds, report.threads, {});
  report.took = std::chrono::steady_clock::now() - begin;
  report.worst = ShortestFailingScenario(*config, scenario.value(), report.summary);
  std::string failing_scenario;
  if (report.worst) {
    const auto run = RunWithTimeline(*config, scenario.value(), *report.worst);
    failing_scenario = run.value().text;
    if (!options.svg.empty()) {
      const auto written = WriteFile(options.svg, run.value().svg);
      if (!written) return console.Fail(written.error());
    }
  }
  console.Print(console.mode().json
                    ? SimulationJson(report, failing_scenario)
                    : SimulationText(report, failing_scenario, console.mode().colour));
  return report.summary.good() ? ExitCode::kDone : ExitCode::kNotDone;
}

}  // namespace

void AddSimulate(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("simulate", "Simulate a state config under thousands of injected faults",
                  Simulate, "musher simulate robot.toml --seeds 10000");
  grammar.Offer(app.add_option("FILE", options.file, "The state config"), Names::kConfigs)
      ->required()
      ->type_name("");
  auto* seeds =
      app.add_option("--seeds", options.seeds, "Number of runs; default 1000")
          ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100'000'000}).description(""))
          ->type_name("N");
  auto* seed = app.add_option("--seed", options.seed, "Repeat and show the run of this seed")
                   ->excludes(seeds)
                   ->type_name("N");
  app.add_option("--only", options.only, "Inject only these of its faults, as in 3,7")
      ->needs(seed)
      ->type_name("LIST");
  app.add_option("--bound", options.bound_s,
                 "Seconds within which the machine must reach\n"
                 "a stable state after the last fault; default:\n"
                 "from the config's times and restarts")
      ->check(CLI::Range(0.001, 1e9).description(""))
      ->type_name("SECONDS");
  grammar
      .Offer(app.add_option("--home", options.home,
                            "State that the operator recovers it to; default Active"),
             Names::kStates)
      ->type_name("STATE");
  grammar
      .Offer(app.add_option("--rules", options.rules,
                            "Rules of your own, as in\n"
                            "never lamp Active while base is not Active, and\n"
                            "within 5 s of Error arm in DeActive;\n"
                            "default: those that the config names"),
             Names::kFiles)
      ->type_name("FILE");
  grammar
      .Offer(app.add_option("--svg", options.svg,
                            "Draw the shortest failing run, or the run of --seed"),
             Names::kFiles)
      ->type_name("FILE");
  app.add_option("-j,--jobs", options.jobs, "Threads; default all cores")
      ->check(CLI::Range(1U, 256U).description(""))
      ->type_name("N");
}

}  // namespace musher::cli
