// Commands that work on files only.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void Grammar::AddConfigCommands() {
  group_ = "Prepare a config";
  auto check = std::make_shared<CheckOptions>();
  auto* command = AddCommand("check", "Report every error in a state config", check);
  Offer(command->add_option("FILE", check->files, "State configs (TOML)"), Names::kConfigs)
      ->required()
      ->type_name("");

  AddGraph();
  AddSimulate();
}

void Grammar::AddGraph() {
  auto graph = std::make_shared<GraphOptions>();
  auto* command =
      AddCommand("graph", "Draw a config, or the state machine of an application", graph);
  auto* file =
      Offer(command->add_option("FILE", graph->file, "State config (TOML)"), Names::kConfigs)
          ->type_name("");
  auto* what = OneOf(command->add_option("--what", graph->what,
                                         "flow: the transitions between states (default);\n"
                                         "actuators: their stages and start order"),
                     {"flow", "actuators"});
  Offer(command->add_option("--behavior", graph->behavior,
                            "Instead of a config: the state machine of this\n"
                            "running application, with its current state marked"),
        Names::kApplications)
      ->excludes(file)
      ->excludes(what)
      ->type_name("NAME");
  OneOf(command->add_option("--format", graph->format,
                            "svg needs Graphviz; default: from the output file's name, else dot"),
        {"dot", "mermaid", "svg"});
  Offer(command->add_option("-o,--output", graph->output, "Default standard output"), Names::kFiles)
      ->type_name("FILE");
}

void Grammar::AddSimulate() {
  auto simulate = std::make_shared<SimulateOptions>();
  auto* command = AddCommand(
      "simulate", "Simulate a state config under thousands of injected faults", simulate);
  Offer(command->add_option("FILE", simulate->file, "The state config"), Names::kConfigs)
      ->required()
      ->type_name("");
  auto* seeds =
      command->add_option("--seeds", simulate->seeds, "Number of runs; default 1000")
          ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100'000'000}).description(""))
          ->type_name("N");
  auto* seed = command->add_option("--seed", simulate->seed, "Repeat and show the run of this seed")
                   ->excludes(seeds)
                   ->type_name("N");
  command->add_option("--only", simulate->only, "Inject only these of its faults, as in 3,7")
      ->needs(seed)
      ->type_name("LIST");
  command
      ->add_option("--bound", simulate->bound_s,
                   "Seconds within which the machine must reach\n"
                   "a stable state after the last fault; default:\n"
                   "from the config's times and restarts")
      ->check(CLI::Range(0.001, 1e9).description(""))
      ->type_name("SECONDS");
  Offer(command->add_option("--home", simulate->home,
                            "State that the operator recovers it to; default Active"),
        Names::kStates)
      ->type_name("STATE");
  Offer(command->add_option("--svg", simulate->svg,
                            "Draw the shortest failing run, or the run of --seed"),
        Names::kFiles)
      ->type_name("FILE");
  command->add_option("-j,--jobs", simulate->jobs, "Threads; default all cores")
      ->check(CLI::Range(1U, 256U).description(""))
      ->type_name("N");
}

}  // namespace musher::cli
