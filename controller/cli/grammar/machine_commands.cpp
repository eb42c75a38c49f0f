// Commands that speak to a controller.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void Grammar::AddSwitchingCommands() {
  auto set = std::make_shared<SetOptions>();
  auto* command = AddCommand("set", "Switch the machine, or one actuator, to a state", set);
  command->add_option("STATE", set->state, "Active, LowPower, SelfCheck, ...")
      ->required()
      ->type_name("");
  command->add_option("ACTUATOR", set->actuator, "Only this one; default the whole machine")
      ->type_name("");

  auto restart = std::make_shared<RestartOptions>();
  command = AddCommand("restart", "End an actuator's process and start it again", restart);
  command->add_option("ACTUATOR", restart->actuator, "The one to restart")
      ->required()
      ->type_name("");

  auto estop = std::make_shared<EstopOptions>();
  command = AddCommand("estop", "Emergency stop: also without a controller", estop);
  auto* reason = command->add_option("REASON", estop->reason, "Why; told to everybody who asks")
                     ->type_name("");
  command
      ->add_flag("--release", estop->release,
                 "Release it; needs the controller, and changes no state")
      ->excludes(reason);
}

void Grammar::AddMachineCommands() {
  auto down = std::make_shared<DownOptions>();
  auto* command =
      AddCommand("down", "Take the machine down: TearDown, then end its processes", down);
  command->add_flag("--without-controller", down->without_controller,
                    "End the actuators of the namespace that run though no\n"
                    "controller leads them, all at the same time");

  auto status = std::make_shared<StatusOptions>();
  command = AddCommand("status", "Show the machine and its actuators", status);
  command->add_flag("-w,--watch", status->watch, "Show every change as it happens");

  auto capabilities = std::make_shared<CapabilitiesOptions>();
  command = AddCommand("capabilities", "Show what the robot can do now, and why not", capabilities);
  command->add_option("NAME", capabilities->name, "Only this one; exit code 1 when it is refused")
      ->type_name("");

  AddSwitchingCommands();
  AddPolicyCommands();

  auto plan = std::make_shared<PlanOptions>();
  command = AddCommand("plan", "Show what a switch would do; changes nothing", plan);
  command->add_option("STATE", plan->state, "The state to switch to")->required()->type_name("");
  command->add_option("ACTUATOR", plan->actuator, "Only this one; default the whole machine")
      ->type_name("");

  auto behavior = std::make_shared<BehaviorOptions>();
  command = AddCommand("behavior", "Show the state machine of an application", behavior);
  command->add_option("NAME", behavior->name, "The application's actuator")
      ->required()
      ->type_name("");
  command->add_option("--history", behavior->history, "The last so many changes; default 10")
      ->check(CLI::Range(0U, 1000U).description(""))
      ->type_name("N");
  command->add_flag("-w,--watch", behavior->watch, "Show every change as it happens");
  command->add_option("--send", behavior->send, "Send it this command; one that it registered")
      ->check([](const std::string& word) { return word.empty() ? "needs a command" : ""; })
      ->type_name("COMMAND");

  auto history = std::make_shared<HistoryOptions>();
  command = AddCommand("history", "Show what happened, oldest first", history);
  command->add_option("--since", history->since, "90s, 10m, 2h, 1d ago, or a date and time")
      ->type_name("TIME");
  command->add_option("--until", history->until, "The same; what came later is left out")
      ->type_name("TIME");
  command->add_option("--actuator", history->actuator, "Only what concerns this one")
      ->type_name("NAME");
  command
      ->add_option("--limit", history->limit,
                   "The newest so many entries that match; default 1000, 0: all")
      ->check(CLI::Range(0U, 1'000'000U).description(""))
      ->type_name("N");
  command->add_flag("--csv", history->csv, "Print a table for spreadsheets, RFC 4180");
  auto* journal = command
                      ->add_option("--journal", history->journal,
                                   "Read this file instead of asking a controller")
                      ->type_name("FILE");
  auto* follow =
      command->add_flag("-f,--follow", history->follow, "Then print what happens, until Ctrl-C");
  follow->excludes(journal);
  command
      ->add_option("--why", history->why,
                   "Why the machine is in its state, or went\n"
                   "to STATE last: the chain of causes")
      ->expected(0, 1)
      ->excludes(follow)
      ->type_name("[STATE]");

  auto replay = std::make_shared<ReplayOptions>();
  command = AddCommand("replay", "Decide once more what a journal recorded; compare", replay);
  command->add_option("JOURNAL", replay->journal, "A controller's journal.sqlite")
      ->required()
      ->type_name("");
  command->add_option("--config", replay->config, "Show what this state config would change")
      ->type_name("FILE");
  command->add_option("--since", replay->since, "90s, 10m, 2h, 1d ago, or a date and time")
      ->type_name("TIME");
  command->add_option("--epoch", replay->epoch, "Only what the controller of this epoch decided")
      ->type_name("N");
}

}  // namespace musher::cli
