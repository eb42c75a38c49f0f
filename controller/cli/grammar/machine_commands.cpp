// Commands that call a controller.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/grammar/grammar.hpp"
#include "musher/controller/cli/wall_time.hpp"

namespace musher::cli {
namespace {

CLI::Validator IsTime() {
  return {[](const std::string& text) {
            const auto time = ParseSince(text, 0);
            return time ? "" : time.error().message;
          },
          ""};
}

}  // namespace

void Grammar::AddSwitchingCommands() {
  auto set = std::make_shared<SetOptions>();
  auto* command = AddCommand("set", "Switch the machine, or one actuator, to a state", set);
  Offer(command->add_option("STATE", set->state, "Active, LowPower, SelfCheck, ..."),
        Names::kStates)
      ->required()
      ->type_name("");
  Offer(command->add_option("ACTUATOR", set->actuator, "Only this one; default the whole machine"),
        Names::kActuators)
      ->type_name("");

  auto restart = std::make_shared<RestartOptions>();
  command = AddCommand("restart", "End an actuator's process and start it again", restart);
  Offer(command->add_option("ACTUATOR", restart->actuator, "The one to restart"), Names::kActuators)
      ->required()
      ->type_name("");

  auto estop = std::make_shared<EstopOptions>();
  command = AddCommand("estop", "Emergency stop; works without a controller, too", estop);
  auto* reason =
      command->add_option("REASON", estop->reason, "Why; `musher status` shows it")->type_name("");
  command
      ->add_flag("--release", estop->release, "Release it; needs the controller, changes no state")
      ->excludes(reason);
}

void Grammar::AddMachineCommands() {
  group_ = "Operate the machine";
  auto status = std::make_shared<StatusOptions>();
  auto* command = AddCommand("status", "Show the machine and its actuators", status);
  command->add_flag("-w,--watch", status->watch, "Show every change as it happens");

  auto capabilities = std::make_shared<CapabilitiesOptions>();
  command = AddCommand("capabilities", "Show what the robot can do now, and why not", capabilities);
  Offer(command->add_option("NAME", capabilities->name,
                            "Only this one; exit code 1 if it is refused"),
        Names::kCapabilities)
      ->type_name("");

  AddSwitchingCommands();
  auto plan = std::make_shared<PlanOptions>();
  command = AddCommand("plan", "Show what a switch would do; changes nothing", plan);
  Offer(command->add_option("STATE", plan->state, "The state to switch to"), Names::kStates)
      ->required()
      ->type_name("");
  Offer(command->add_option("ACTUATOR", plan->actuator, "Only this one; default the whole machine"),
        Names::kActuators)
      ->type_name("");

  AddPolicyCommands();

  auto behavior = std::make_shared<BehaviorOptions>();
  command = AddCommand("behavior", "Show the state machine of an application", behavior);
  Offer(command->add_option("NAME", behavior->name, "The application's actuator"),
        Names::kApplications)
      ->required()
      ->type_name("");
  command
      ->add_option("--history", behavior->history, "Number of latest changes to show; default 10")
      ->check(CLI::Range(0U, 1000U).description(""))
      ->type_name("N");
  command->add_flag("-w,--watch", behavior->watch, "Show every change as it happens");
  Offer(command->add_option("--send", behavior->send,
                            "Send it this command, which it must have registered"),
        Names::kCommands)
      ->check([](const std::string& word) { return word.empty() ? "needs a command" : ""; })
      ->type_name("COMMAND");
}

void Grammar::AddRecordCommands() {
  group_ = "Inspect the past";
  auto history = std::make_shared<HistoryOptions>();
  auto* command = AddCommand("history", "Show past events, oldest first", history);
  command->add_option("--since", history->since, "90s, 10m, 2h, 1d ago, or a date and time")
      ->check(IsTime())
      ->type_name("TIME");
  command->add_option("--until", history->until, "Same format; later events are left out")
      ->check(IsTime())
      ->type_name("TIME");
  Offer(command->add_option("--actuator", history->actuator, "Only events of this one"),
        Names::kActuators)
      ->type_name("NAME");
  command
      ->add_option("--limit", history->limit,
                   "Number of newest matching entries; default 1000, 0: all")
      ->check(CLI::Range(0U, 1'000'000U).description(""))
      ->type_name("N");
  command->add_flag("--csv", history->csv, "Print CSV (RFC 4180)");
  auto* journal = Offer(command->add_option("--journal", history->journal,
                                            "Read this file instead of calling a controller"),
                        Names::kFiles)
                      ->type_name("FILE");
  auto* follow =
      command->add_flag("-f,--follow", history->follow, "Then print new events, until Ctrl-C");
  follow->excludes(journal);
  Offer(command->add_option("--why", history->why,
                            "Why the machine is in its current state, or\n"
                            "last went to STATE: the chain of causes"),
        Names::kStates)
      ->expected(0, 1)
      ->excludes(follow)
      ->type_name("[STATE]");

  auto replay = std::make_shared<ReplayOptions>();
  command = AddCommand("replay", "Re-run the recorded decisions of a journal and compare", replay);
  Offer(command->add_option("JOURNAL", replay->journal, "A controller's journal.sqlite"),
        Names::kFiles)
      ->required()
      ->type_name("");
  Offer(command->add_option("--config", replay->config, "Show what this state config would change"),
        Names::kConfigs)
      ->type_name("FILE");
  command->add_option("--since", replay->since, "90s, 10m, 2h, 1d ago, or a date and time")
      ->check(IsTime())
      ->type_name("TIME");
  command->add_option("--epoch", replay->epoch, "Only decisions of the controller with this epoch")
      ->type_name("N");
}

}  // namespace musher::cli
