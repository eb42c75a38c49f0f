// musher plan STATE [ACTUATOR]: what a switch would do. Changes nothing.

#include <CLI/CLI.hpp>
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

struct PlanOptions {
  std::string state;
  std::string actuator;
};

ExitCode Plan(const PlanOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::OpenForCalls(global, &console);
  const auto answer = link->Call<msg::GetPlan>("get_plan", {options.state, options.actuator},
                                               std::chrono::seconds(5));
  if (const auto* failure = std::get_if<Failure>(&answer)) return console.Fail(*failure);
  const auto& plan = std::get<msg::GetPlan::Response>(answer);
  console.Print(console.mode().json ? PlanJson(plan) : PlanText(plan, console.mode().colour));
  if (plan.allowed) return ExitCode::kDone;
  console.PrintError(PlanError(plan));
  return ExitCodeOfRefusal(plan.code);
}

}  // namespace

void AddPlan(Grammar& grammar) {
  auto [app, options] = grammar.Add("plan", "Show what a switch would do; changes nothing", Plan,
                                    "musher plan LowPower");
  grammar.Offer(app.add_option("STATE", options.state, "The state to switch to"), Names::kStates)
      ->required()
      ->type_name("");
  grammar
      .Offer(
          app.add_option("ACTUATOR", options.actuator, "Only this one; default the whole machine"),
          Names::kActuators)
      ->type_name("");
}

}  // namespace musher::cli
