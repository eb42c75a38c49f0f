// musher wait STATE [ACTUATOR]: waits until the machine, or one actuator, is in a state. For
// scripts, and for other services that start with the robot.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/render/json.hpp"

namespace musher::cli {
namespace {

struct WaitOptions {
  std::string state;
  std::string actuator;  // empty: the machine
};

constexpr Duration kWait = std::chrono::seconds(60);
constexpr Duration kAttempt = std::chrono::seconds(2);  // then the machine is searched again
constexpr Duration kPause = Milliseconds(200);          // after a search that ended at once

const msg::ActuatorInfo* Find(const msg::MachineStatus& status, const std::string& name) {
  const auto found =
      std::find_if(status.actuators.begin(), status.actuators.end(),
                   [&](const msg::ActuatorInfo& actuator) { return actuator.name == name; });
  return found == status.actuators.end() ? nullptr : &*found;
}

bool IsThere(const msg::MachineStatus& status, const WaitOptions& options) {
  if (options.actuator.empty()) return status.state == options.state && status.target.empty();
  const msg::ActuatorInfo* actuator = Find(status, options.actuator);
  return actuator != nullptr && actuator->state == options.state && actuator->target.empty();
}

// "the machine is in LowPower", "audio is in SetUp".
std::string Where(const msg::MachineStatus& status, const WaitOptions& options) {
  if (options.actuator.empty()) {
    return "the machine is in " + status.state +
           (status.target.empty() ? "" : ", on its way to " + status.target);
  }
  const msg::ActuatorInfo* actuator = Find(status, options.actuator);
  return options.actuator + " is in " + (actuator == nullptr ? "no state" : actuator->state);
}

// One controller's part of the waiting: until the state is reached, the time is over, or the
// controller has ended. nullopt: another controller may follow.
std::optional<ExitCode> WaitFor(Link& link, const WaitOptions& options, Time deadline,
                                Console& console) {
  const auto plan =
      link.Call<msg::GetPlan>("get_plan", {options.state, options.actuator}, kAttempt);
  const auto* answer = std::get_if<msg::GetPlan::Response>(&plan);
  if (answer != nullptr && answer->code == kCodeParametersInvalid) {
    return console.Fail(Failure{ExitCode::kUsage, {kCodeParametersInvalid, answer->reason}});
  }
  const auto& status = link.status();
  link.RunUntil([&] { return !status || IsThere(*status, options); }, deadline - link.loop().Now());
  if (link.interrupted()) return ExitCode::kInterrupted;
  if (!status) return std::nullopt;
  if (!IsThere(*status, options)) {
    return console.Fail(Failure{
        ExitCode::kNotDone,
        {kCodeTimeout, Where(*status, options) + ", and not in " + options.state + " in time"}});
  }
  if (console.mode().json) console.Print(StatusJson(*status));
  return ExitCode::kDone;
}

ExitCode Wait(const WaitOptions& options, const GlobalOptions& global, Console& console) {
  const Time deadline = std::chrono::steady_clock::now() + global.timeout.value_or(kWait);
  std::optional<Failure> none;  // of the last search that had its whole time
  for (;;) {
    GlobalOptions attempt = global;  // the link has a reference to it
    const auto left = [deadline] {
      return std::max<Duration>(deadline - std::chrono::steady_clock::now(), Milliseconds(1));
    };
    attempt.timeout = left();  // with several networks each of them takes its time
    const auto opened = Link::Open(attempt);
    if (!opened) return console.Fail(opened.error());
    attempt.timeout = std::min(left(), kAttempt);
    Link& link = *opened.value();
    // A script acts by the result: another machine than that of this host does not count.
    if (const auto failure = link.ChooseMachine(Link::Purpose::kAct)) {
      const bool may_come = failure->exit == ExitCode::kNoController;
      if (!may_come || !none || *attempt.timeout >= link.discovery()) none = failure;
      if (may_come) {
        link.RunUntil([] { return false; }, std::min(kPause, deadline - link.loop().Now()));
      }
      if (link.interrupted()) return ExitCode::kInterrupted;
      if (may_come && link.loop().Now() < deadline) continue;
      return console.Fail(*none);
    }
    const auto followed = link.FollowStatus([](const auto&) {});
    if (!followed) return console.Fail(followed.error());
    const auto failure = link.AwaitStatus();
    if (link.interrupted()) return ExitCode::kInterrupted;
    if (!failure) {
      if (const auto end = WaitFor(link, options, deadline, console)) return *end;
    } else if (link.loop().Now() >= deadline) {
      return console.Fail(*failure);
    }
  }
}

}  // namespace

void AddWait(Grammar& grammar) {
  auto [app, options] = grammar.Add(
      "wait", "Wait until the machine, or one actuator, is in a state; --timeout limits it", Wait,
      "musher wait Active --timeout 30");
  grammar.Offer(app.add_option("STATE", options.state, "For example Active"), Names::kStates)
      ->required()
      ->type_name("");
  grammar
      .Offer(app.add_option("ACTUATOR", options.actuator, "Default: the machine"),
             Names::kActuators)
      ->type_name("");
}

}  // namespace musher::cli
