// musher restart ACTUATOR: restarts its process and switches it back to the machine's state.

#include <CLI/CLI.hpp>
#include <algorithm>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/restart_call.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

struct RestartOptions {
  std::string actuator;
};

ExitCode Restart(const RestartOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::OpenForCalls(global, &console);
  if (const auto failure = RestartActuator(*link, options.actuator)) return console.Fail(*failure);
  const auto status = link->Call<msg::GetStatus>("get_status", {}, std::chrono::seconds(5));
  if (const auto* failure = std::get_if<Failure>(&status)) {
    Failure unknown = *failure;
    unknown.error.message.insert(0,
                                 options.actuator + " is restarted, but its status is not known: ");
    return console.Fail(unknown);
  }
  const auto& actuators = std::get<msg::GetStatus::Response>(status).status.actuators;
  const auto back = std::find_if(actuators.begin(), actuators.end(), [&](const auto& actuator) {
    return actuator.name == options.actuator;
  });
  if (back == actuators.end()) return ExitCode::kDone;  // another machine runs by now
  console.Print(console.mode().json ? RestartJson(*back)
                                    : RestartText(*back, console.mode().colour));
  return ExitCode::kDone;
}

}  // namespace

void AddRestart(Grammar& grammar) {
  auto [app, options] = grammar.Add("restart", "End an actuator's process and start it again",
                                    Restart, "musher restart audio");
  grammar
      .Offer(app.add_option("ACTUATOR", options.actuator, "The one to restart"), Names::kActuators)
      ->required()
      ->type_name("");
}

}  // namespace musher::cli
