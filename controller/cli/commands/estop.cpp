// musher estop [REASON...]: engages an emergency stop, with or without a controller, and prints
// which actuators have stopped. musher estop --release: releases it; that alone moves nothing.

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>

#include "musher/base/host.hpp"
#include "musher/controller/cli/commands/commands.hpp"
#include "musher/controller/cli/grammar/grammar.hpp"
#include "musher/controller/cli/machine/link.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/client/latching.hpp"
#include "musher/controller/storage/machine_origin.hpp"

namespace musher::cli {
namespace {

struct EstopOptions {
  std::vector<std::string> reason;  // words
  bool release = false;
};

constexpr Duration kStopTimeout = std::chrono::seconds(5);

// "alice@dog1"
std::string Me() {
  const passwd* user = getpwuid(getuid());  // NOLINT(concurrency-mt-unsafe)
  return (user != nullptr ? std::string(user->pw_name) : std::to_string(getuid())) + "@" +
         HostName();
}

// Stops the machine of --machine, else the one whose controller runs here; what is not known stops
// every machine that receives it. It waits for no discovery.
MachineIdentity MachineToStop(const Link& link, const GlobalOptions& global) {
  if (!global.machine.empty()) return {global.machine, ""};
  const auto origin = OriginOfProcess(link.LeaderHere());
  return origin ? MachineIdentity{origin->name, origin->id} : MachineIdentity{};
}

msg::EmergencyStop NewStop(const std::vector<std::string>& reason, const MachineIdentity& machine) {
  msg::EmergencyStop stop = NewEmergencyStop(Me(), fmt::format("{}", fmt::join(reason, " ")));
  stop.machine = machine.name;
  stop.machine_id = machine.id;
  return stop;
}

// Waits until all actuators have latched the stop. A controller reports which are present; without
// one the actuators have the time of discovery to appear.
EstopReport AwaitAll(Link& link, const Latching& latching, Duration timeout) {
  const Time begin = link.loop().Now();
  const auto report = [&] { return latching.Report(link.status()); };
  const auto led = [&] { return report().controller && report().settled(); };
  if (!link.RunUntil(led, std::min(link.discovery(), timeout))) {
    const bool none = report().actuators.empty() && !report().controller;
    const auto settled = [&] { return report().settled(); };
    if (!none || link.HasMachine()) {
      link.RunUntil(settled, begin + timeout - link.loop().Now());
    }
  }
  return report();
}

ExitCode Engage(const EstopOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const MachineIdentity machine = MachineToStop(*link.value(), global);
  const auto latching = Latching::Begin(link.value()->node(), global.name_space,
                                        NewStop(options.reason, machine), !global.keys.empty());
  if (!latching) return console.Fail(latching.error());
  link.value()->Choose(machine);
  if (const auto followed = link.value()->FollowStatus({}); !followed) {
    return console.Fail(followed.error());
  }
  const EstopReport report =
      AwaitAll(*link.value(), *latching.value(), global.timeout.value_or(kStopTimeout));
  if (!report.controller && report.actuators.empty()) {
    return console.Fail(link.value()->NotFound("controller or actuator"));
  }
  console.Print(console.mode().json ? EstopJson(report) : EstopText(report, console.mode().colour));
  if (report.complete()) return ExitCode::kDone;
  console.PrintError(EstopError(report));
  return link.value()->interrupted() ? ExitCode::kInterrupted : ExitCode::kNotDone;
}

ExitCode Release(const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto answer =
      link.value()->Call<msg::ReleaseEmergencyStop>("release_emergency_stop", {Me()}, kStopTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) {
    Failure with_hint = *failure;
    if (failure->exit == ExitCode::kNoController) {
      with_hint.error.message += "; only a controller can release an emergency stop";
    }
    return console.Fail(with_hint);
  }
  const auto& released = std::get<msg::ReleaseEmergencyStop::Response>(answer);
  if (released.code != kCodeOk) {
    return console.Fail({ExitCode::kNotDone, {released.code, released.reason}});
  }
  const auto status = link.value()->Call<msg::GetStatus>("get_status", {}, kStopTimeout);
  if (const auto* failure = std::get_if<Failure>(&status)) return console.Fail(*failure);
  const msg::MachineStatus& machine = std::get<msg::GetStatus::Response>(status).status;
  console.Print(console.mode().json ? ReleaseJson(machine)
                                    : ReleaseText(machine, console.mode().colour));
  return ExitCode::kDone;
}

ExitCode Estop(const EstopOptions& options, const GlobalOptions& global, Console& console) {
  return options.release ? Release(global, console) : Engage(options, global, console);
}

}  // namespace

void AddEstop(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("estop", "Emergency stop; works without a controller, too", Estop);
  auto* reason =
      app.add_option("REASON", options.reason, "Why; `musher status` shows it")->type_name("");
  app.add_flag("--release", options.release, "Release it; needs the controller, changes no state")
      ->excludes(reason);
}

}  // namespace musher::cli
