// musher set STATE [ACTUATOR]: switches the machine or one actuator and prints the outcome.

#include <CLI/CLI.hpp>
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/switch_request.hpp"
#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {
namespace {

struct SetOptions {
  std::string state;
  std::string actuator;  // empty: the whole machine
};

ExitCode Set(const SetOptions& options, const GlobalOptions& global, Console& console) {
  return RequestSwitch(options.state, options.actuator, global, console);
}

}  // namespace

void AddSet(Grammar& grammar) {
  auto [app, options] = grammar.Add("set", "Switch the machine, or one actuator, to a state", Set,
                                    "musher set LowPower audio");
  grammar
      .Offer(app.add_option("STATE", options.state, "Active, LowPower, SelfCheck, ..."),
             Names::kStates)
      ->required()
      ->type_name("");
  grammar
      .Offer(
          app.add_option("ACTUATOR", options.actuator, "Only this one; default the whole machine"),
          Names::kActuators)
      ->type_name("");
}

}  // namespace musher::cli
