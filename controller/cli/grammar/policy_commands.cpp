// Requests to the policy.

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void Grammar::AddPolicyCommands() {
  AddCommand("wake", "Wake the robot up from LowPower", std::make_shared<WakeOptions>());

  auto keep = std::make_shared<KeepOptions>();
  auto* command =
      AddCommand("keep", "Switch to a state and hold it, whatever the battery level", keep);
  constexpr std::int64_t kLongestKeep = 65'535;  // limit of CyberDog's service
  auto* state =
      Offer(command->add_option("STATE", keep->state, "Active, Protected, ..."), Names::kStates)
          ->type_name("");
  auto* seconds = command->add_option("--for", keep->seconds, "How long")
                      ->check(CLI::Range(std::int64_t{1}, kLongestKeep).description(""))
                      ->type_name("SECONDS");
  auto* end = command->add_flag("--end", keep->end, "End it early");
  state->needs(seconds);
  seconds->needs(state);
  end->excludes(state);
  command->preparse_callback([](std::size_t words) {
    if (words == 0) throw CLI::ValidationError("expected STATE --for SECONDS, or --end");
  });

  auto low_power = std::make_shared<LowPowerOptions>();
  command =
      AddCommand("low-power", "Turn automatic LowPower when lying still on or off", low_power);
  OneOf(command->add_option_function<std::string>(
            "on|off", [low_power](const std::string& word) { low_power->on = word == "on"; },
            "Saved, unless --this-run"),
        {"on", "off"})
      ->required();
  command->add_flag("--this-run", low_power->this_run, "Only until the controller ends");
}

}  // namespace musher::cli
