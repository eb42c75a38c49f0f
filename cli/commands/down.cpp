// musher down: TearDown in reverse order, then the processes exit, then the controller.
// musher down --without-controller: stops the actuators that run without a controller.

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <set>
#include <variant>

#include "musher/base/host.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/switch_request.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/direct_tear_down.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/machine/machines_beside.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/cli/machine/silent_controller.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/controller/storage/machines_here.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

struct DownOptions {
  bool without_controller = false;  // stop the actuators that run without a controller
};

constexpr Duration kTearDownTime = std::chrono::seconds(10);

// The machine whose actuators are stopped: that of this host, by its actuators or its files.
// Without either, the only one.
std::variant<MachineIdentity, Failure> MachineToEnd(const Link& link,
                                                    const RunningActuators& running,
                                                    const GlobalOptions& global) {
  if (!global.machine.empty()) return MachineIdentity{global.machine, ""};
  const std::vector<MachineIdentity> here = running.Machines(true);
  if (!here.empty()) return here.front();
  const std::vector<MachineIdentity> elsewhere = running.Machines(false);
  const auto of_files = MachineOfFilesHere(global);
  const auto beside = [&]() -> std::optional<Failure> {
    const auto machines = MachinesBeside(global, of_files);
    if (machines.empty()) return std::nullopt;
    const std::string others = "actuators of " + MachineText(elsewhere.front());
    return Failure{ExitCode::kNoController,
                   {kCodeNetError, machines.front().InsteadOf(others, global)}};
  };
  if (of_files) {
    const bool its_own = std::any_of(elsewhere.begin(), elsewhere.end(), [&](const auto& machine) {
      return SameMachine(machine, *of_files);
    });
    const auto actuators = running.Now();
    const bool any_here = std::any_of(actuators.begin(), actuators.end(), [](const auto& one) {
      return one.second.status.host == HostId();
    });
    if (its_own || elsewhere.empty() || any_here) return *of_files;
    if (auto failure = beside()) return *std::move(failure);
    return link.NotHere(*of_files, "actuators of " + MachineText(elsewhere.front()));
  }
  if (elsewhere.empty()) return MachineIdentity{};
  if (auto failure = beside()) return *std::move(failure);
  if (elsewhere.size() == 1) return elsewhere.front();
  return Failure{
      ExitCode::kUsage,
      {kCodeTargetBusy, "actuators of several machines run in " + NamespaceText(global.name_space) +
                            ": " + MachineText(elsewhere[0]) + ", " + MachineText(elsewhere[1]) +
                            ". Nothing was done; --machine NAME chooses one"}};
}

// The actuators of the machine whose processes have ended without a TearDown, before or after its
// controller.
std::set<std::string> LostActuators(const MachineIdentity& machine, const GlobalOptions& global) {
  std::set<std::string> lost;
  const int domain = transport::DomainId({}).value();
  for (const MachineHere& here : MachinesHere(domain, global.name_space)) {
    if (!SameMachine(here.identity, machine)) continue;
    for (const StoredActuator& one : here.lost) lost.insert(one.name);
  }
  return lost;
}

ExitCode DownWithoutController(const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global, &console);
  if (!link) return console.Fail(link.error());
  const auto running =
      RunningActuators::Begin(link.value()->node(), global.name_space, !global.keys.empty());
  if (!running) return console.Fail(running.error());
  // The controller of another machine says nothing about the actuators of this one.
  const bool led_here = link.value()->LeaderHere() != 0;
  link.value()->RunUntil([&] { return led_here && link.value()->HasMachine(); },
                         link.value()->discovery());
  const auto machine = MachineToEnd(*link.value(), *running.value(), global);
  if (const auto* open = std::get_if<Failure>(&machine)) return console.Fail(*open);
  running.value()->OnlyOf(std::get<MachineIdentity>(machine));
  link.value()->Choose(std::get<MachineIdentity>(machine));
  const pid_t leader = link.value()->LeaderHere();
  if (link.value()->HasMachine() || leader != 0) {
    std::string message = "a controller leads the actuators of " + NamespaceText(global.name_space);
    message += link.value()->HasMachine()
                   ? ": `musher down` stops them in their order, and it"
                   : ": " + WhySilent(ExamineSilent(leader, global), global) +
                         "; then `musher down` stops them in their order, and it";
    return console.Fail({ExitCode::kNotDone, {kCodeTargetBusy, message}});
  }
  if (running.value()->Now().empty()) {
    return console.Fail(link.value()->NotFound("controller or actuator"));
  }
  const auto ending =
      DirectTearDown::Begin(link.value()->node(), global.name_space, *running.value(),
                            global.timeout.value_or(kTearDownTime));
  if (!ending) return console.Fail(ending.error());
  link.value()->RunUntil([&] { return ending.value()->Ended() || ending.value()->OutOfTime(); },
                         std::chrono::hours(1));
  const auto outcomes = ending.value()->Outcomes();
  console.Print(console.mode().json ? EndingJson(outcomes)
                                    : EndingText(outcomes, console.mode().colour));
  if (link.value()->interrupted()) return ExitCode::kInterrupted;
  const auto others = ending.value()->Others();
  if (!others.empty()) console.PrintError(OthersText(others));
  if (!ending.value()->Ended()) {
    console.PrintError("not all actuators have exited");
    return ExitCode::kNotDone;
  }
  std::vector<std::string> not_torn_down;
  for (const auto& one : outcomes) {
    if (one.has_tear_down && !one.torn_down) not_torn_down.push_back(one.name);
  }
  for (const std::string& name : LostActuators(std::get<MachineIdentity>(machine), global)) {
    const bool listed = std::ranges::count(outcomes, name, &DirectTearDown::Outcome::name) != 0;
    if (!listed) not_torn_down.push_back(name);
  }
  if (not_torn_down.empty()) return others.empty() ? ExitCode::kDone : ExitCode::kNotDone;
  console.PrintError(fmt::format("without TearDown what {} {} switched on may still be on",
                                 fmt::join(not_torn_down, ", "),
                                 not_torn_down.size() == 1 ? "has" : "have"));
  return ExitCode::kNotDone;
}

ExitCode Down(const DownOptions& options, const GlobalOptions& global, Console& console) {
  if (options.without_controller) return DownWithoutController(global, console);
  return RequestSwitch(State(kTearDown), "", global, console);
}

}  // namespace

void AddDown(Grammar& grammar) {
  auto [app, options] = grammar.Add(
      "down", "Take the machine down: TearDown, then stop its processes", Down, "musher down");
  app.add_flag("--without-controller", options.without_controller,
               "Stop the actuators of the namespace that run without a\n"
               "controller, all at the same time");
}

}  // namespace musher::cli
