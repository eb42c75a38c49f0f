// Commands that work on files alone.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void Grammar::AddConfigCommands() {
  group_ = "Prepare a config";
  auto check = std::make_shared<CheckOptions>();
  auto* command = AddCommand("check", "Report every fault of a state config", check);
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
                                         "flow: which state follows which (default);\n"
                                         "actuators: their stages and what comes after what"),
                     {"flow", "actuators"});
  Offer(command->add_option("--behavior", graph->behavior,
                            "Instead of a config: the state machine of this\n"
                            "application that runs, its present state marked"),
        Names::kApplications)
      ->excludes(file)
      ->excludes(what)
      ->type_name("NAME");
  OneOf(command->add_option("--format", graph->format,
                            "svg needs Graphviz; default: by the output file's name, else dot"),
        {"dot", "mermaid", "svg"});
  Offer(command->add_option("-o,--output", graph->output, "Default standard output"), Names::kFiles)
      ->type_name("FILE");
}

void Grammar::AddSimulate() {
  auto simulate = std::make_shared<SimulateOptions>();
  auto* command =
      AddCommand("simulate", "Simulate a state config under thousands of faults", simulate);
  Offer(command->add_option("FILE", simulate->file, "The state config"), Names::kConfigs)
      ->required()
      ->type_name("");
  auto* seeds =
      command->add_option("--seeds", simulate->seeds, "How many runs; default 1000")
          ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100'000'000}).description(""))
          ->type_name("N");
  auto* seed = command->add_option("--seed", simulate->seed, "Repeat and show the run of this seed")
                   ->excludes(seeds)
                   ->type_name("N");
  command->add_option("--only", simulate->only, "Only these of its faults, as in 3,7")
      ->needs(seed)
      ->type_name("LIST");
  command
      ->add_option("--bound", simulate->bound_s,
                   "Seconds in which the machine has to be at\n"
                   "rest once faults have ceased; default: by\n"
                   "the config's times and restarts")
      ->check(CLI::Range(0.001, 1e9).description(""))
      ->type_name("SECONDS");
  Offer(command->add_option("--home", simulate->home,
                            "Where an operator brings it back to; default Active"),
        Names::kStates)
      ->type_name("STATE");
  Offer(command->add_option("--svg", simulate->svg, "Draw the shortest bad run, or the one shown"),
        Names::kFiles)
      ->type_name("FILE");
  command->add_option("-j,--jobs", simulate->jobs, "Threads; default all cores")
      ->check(CLI::Range(1U, 256U).description(""))
      ->type_name("N");
}

}  // namespace musher::cli
