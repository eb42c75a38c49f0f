// Commands that work on files alone.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void Grammar::AddConfigCommands() {
  auto check = std::make_shared<CheckOptions>();
  auto* command = AddCommand("check", "Report every fault of a state config", check);
  command->add_option("FILE", check->files, "State configs (TOML)")->required()->type_name("");

  auto up = std::make_shared<UpOptions>();
  command = AddCommand("up", "Start a machine and stay with it; Ctrl-C takes it down", up);
  command
      ->add_option("FILE", up->file,
                   "State config (TOML), or a folder with upgrades as\n"
                   "`musher ota init` makes it")
      ->required()
      ->type_name("");
  command->add_flag("-d,--detach", up->detach,
                    "Return when the start has ended; the machine stays up");
  command->add_flag("--takeover", up->takeover,
                    "End a controller that leads this machine; its actuators\n"
                    "go on and are taken over");
  command->add_flag("--adopt", up->adopt,
                    "Take over actuators that run already with another config;\n"
                    "without it they are a reason not to start");
  command->add_flag("--restarted", up->restarted,
                    "For supervisors such as systemd: if the controller ended\n"
                    "while it took the machine down, finish that and stay down");
  // How a controller executes this program when it starts again; for nobody else.
  command
      ->add_option_function<std::vector<int>>(
          "--resume",
          [up](const std::vector<int>& values) {
            up->resume = UpOptions::Resume{values.at(0), values.at(1)};
          })
      ->expected(2)
      ->delimiter(',')
      ->group("");

  AddGraph();
  AddSimulate();

  auto completion = std::make_shared<CompletionOptions>();
  command = AddCommand("completion", "Print the completion script of a shell", completion);
  command->add_option("SHELL", completion->shell, "bash or zsh")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh"}).description(""))
      ->type_name("");
}

void Grammar::AddGraph() {
  auto graph = std::make_shared<GraphOptions>();
  auto* command =
      AddCommand("graph", "Draw a config, or the state machine of an application", graph);
  auto* file = command->add_option("FILE", graph->file, "State config (TOML)")->type_name("");
  auto* what = command
                   ->add_option("--what", graph->what,
                                "flow: which state follows which (default);\n"
                                "actuators: their stages and what comes after what")
                   ->check(CLI::IsMember({"flow", "actuators"}).description(""))
                   ->type_name("flow|actuators");
  command
      ->add_option("--behavior", graph->behavior,
                   "Instead of a config: the state machine of this\n"
                   "application that runs, its present state marked")
      ->excludes(file)
      ->excludes(what)
      ->type_name("NAME");
  command
      ->add_option("--format", graph->format,
                   "svg needs Graphviz; default: by the output file's name, else dot")
      ->check(CLI::IsMember({"dot", "mermaid", "svg"}).description(""))
      ->type_name("dot|mermaid|svg");
  command->add_option("-o,--output", graph->output, "Default standard output")->type_name("FILE");
}

void Grammar::AddSimulate() {
  auto simulate = std::make_shared<SimulateOptions>();
  auto* command =
      AddCommand("simulate", "Live through thousands of faults with a state config", simulate);
  command->add_option("FILE", simulate->file, "The state config")->required()->type_name("");
  auto* seeds =
      command->add_option("--seeds", simulate->seeds, "How many stories; default 1000")
          ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100'000'000}).description(""))
          ->type_name("N");
  command->add_option("--seed", simulate->seed, "Tell the story of this seed")
      ->excludes(seeds)
      ->type_name("N");
  command->add_option("--only", simulate->only, "Only these of its incidents, as in 3,7")
      ->type_name("LIST");
  command
      ->add_option("--bound", simulate->bound_s,
                   "Seconds in which the machine has to be at\n"
                   "rest once faults have ceased; default: by\n"
                   "the config's times and restarts")
      ->check(CLI::Range(0.001, 1e9).description(""))
      ->type_name("SECONDS");
  command->add_option("--home", simulate->home, "Where people bring it back to; default Active")
      ->type_name("STATE");
  command->add_option("--svg", simulate->svg, "Draw the shortest bad story, or the one told")
      ->type_name("FILE");
  command->add_option("-j,--jobs", simulate->jobs, "Threads; default all cores")
      ->check(CLI::Range(1U, 256U).description(""))
      ->type_name("N");
}

}  // namespace musher::cli
