// musher status [--follow]: the machine's status now, or every change of it.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/console/error_json.hpp"
#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/host_clocks.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/process_facts.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/controller/client/standby_call.hpp"
#include "musher/controller/process/host_processes.hpp"
#include "musher/controller/process/own_systemd.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

struct StatusOptions {
  bool follow = false;
  bool failed = false;
  bool hosts = false;
};

constexpr Duration kStatusTime = Milliseconds(300);
constexpr Duration kStandbyTime = Milliseconds(500);
constexpr Duration kHistoryTime = std::chrono::seconds(1);
constexpr Duration kClocksWithin = std::chrono::seconds(8);  // ssh gives up after 5 s
constexpr std::uint32_t kRecent = 200;  // entries in which the last change of the state is searched
constexpr const char* kRedraw = "\x1b[H\x1b[2J";  // from the top of an empty screen

void Show(const std::optional<msg::MachineStatus>& status, Console& console) {
  const Failure gone{ExitCode::kNoController, {kCodeNetError, "controller lost"}};
  if (console.mode().json) {
    console.Print(status ? StatusJson(*status) : FailureJson(gone));
  } else if (console.mode().terminal) {
    console.Print(kRedraw + (status ? StatusText(*status, console.mode().colour)
                                    : gone.error.message + "; waiting for another one\n"));
  } else {
    console.Print(status ? StatusLine(*status, WallNow())
                         : LocalTime(WallNow()) + "  " + gone.error.message);
  }
}

// With [security] an actuator that the controller did not start may run here but be unreachable: it
// then has no credentials, or other ones.
void AddCredentialHints(msg::MachineStatus& status, const GlobalOptions& global) {
  if (global.keys.empty() || status.host != HostId()) return;
  const int domain = transport::DomainId({}).value();
  for (msg::ActuatorInfo& actuator : status.actuators) {
    if (actuator.presence != PresenceName(Presence::kAbsent)) continue;
    const std::string name = NameLock::NameOf(domain, status.name_space, actuator.name);
    const pid_t holder = NameLock::HolderOf(name).pid;
    if (holder == 0) continue;
    actuator.message = "process " + std::to_string(holder) +
                       " runs but publishes no status: check that it has the keys of this machine" +
                       (actuator.message.empty() ? "" : " " + actuator.message);
  }
}

using Uncontrolled = std::map<std::string, RunningActuators::Actuator>;

// The actuators with a status that the machine does not list. A process that only holds a name on
// this host may be an actuator that is still starting.
Uncontrolled NotIn(const msg::MachineStatus& status, Uncontrolled running) {
  std::erase_if(running, [&](const auto& one) {
    return !one.second.has_status ||
           std::any_of(status.actuators.begin(), status.actuators.end(),
                       [&](const auto& actuator) { return actuator.name == one.first; });
  });
  return running;
}

// Actuators latch their status as the controller does, so all statuses arrive at about the same
// time.
Uncontrolled AwaitUnlisted(Link& link, const RunningActuators& running,
                           const msg::MachineStatus& status) {
  const auto all_received = [&] {
    const Uncontrolled here = running.Now();  // a name held here is found before its status arrives
    const auto received = [](const auto& one) { return one.second.has_status; };
    if (!std::all_of(here.begin(), here.end(), received)) return false;
    return std::all_of(status.actuators.begin(), status.actuators.end(), [&](const auto& actuator) {
      return actuator.protocol != ProtocolName(Protocol::kMusher) ||
             actuator.presence != PresenceName(Presence::kPresent) ||
             running.HasStatusOf(actuator.name);
    });
  };
  link.RunUntil(all_received, kStatusTime);
  return NotIn(status, running.Now());
}

// Of the machine that --machine means, as far as a status says so. `led`: a controller leads here.
// Then what has sent no status is its own, and that one is not meant.
Uncontrolled OnlyMeant(Uncontrolled running, const std::string& word, bool led) {
  if (word.empty()) return running;
  std::erase_if(running, [&](const auto& one) {
    const msg::ActuatorStatus& status = one.second.status;
    const MachineIdentity machine{status.machine, status.machine_id};
    if (!one.second.has_status) return led;
    return machine.name != word && !BeginsIdOf(machine, word);
  });
  return running;
}

// "this host stands by for dog (pid 7): …".
std::string StandbyText(const StandbyReport& standby) {
  const std::string& name = standby.machine.name;
  return fmt::format("this host stands by{} (pid {}): {}",
                     name.empty() ? "" : " for " + Printable(name), standby.pid,
                     standby.why_not.empty() ? "it leads in a moment" : Printable(standby.why_not));
}

// The standby of this host, if the command means its machine.
std::optional<StandbyReport> StandbyHere(Link& link, const GlobalOptions& global) {
  const auto domain = transport::DomainId({});
  if (!domain) return std::nullopt;
  const auto call = StandbyCall::Make(link.loop(), StandbyName(domain.value(), global.name_space));
  if (!call) return std::nullopt;
  link.RunUntil([&] { return call->ended(); }, kStandbyTime);
  const auto report = call->Report();
  const std::string& meant = global.machine;
  if (!report || meant.empty() || report->machine.name == meant) return report;
  return BeginsIdOf(report->machine, meant) ? report : std::nullopt;
}

// `led`: a controller leads them here, but cannot be reached.
ExitCode WithoutController(Failure failure, const Uncontrolled& running, bool led,
                           const std::optional<StandbyReport>& standby, Console& console) {
  const bool shows = !running.empty() || standby;
  if (failure.exit != ExitCode::kNoController || !shows) return console.Fail(failure);
  if (standby) {
    failure.error.message += "; " + StandbyText(*standby);
  } else if (!led) {
    failure.error.message += "; " + RunningNames(running) +
                             (running.size() == 1 ? " runs" : " run") +
                             " without one: `musher up` with their config takes control of them, "
                             "`musher down --without-controller` stops them";
  }
  if (console.mode().json) {
    console.Print(RunningJson(failure, running, standby));
  } else if (!running.empty()) {
    console.Print(RunningText(running, console.mode().colour));
  }
  console.PrintError(failure.error.message);
  return failure.exit;
}

ExitCode Watch(Link& link, Console& console) {
  link.EndWithReader();
  const auto followed =
      link.FollowStatus([&console](const auto& status) { Show(status, console); });
  if (!followed) return console.Fail(followed.error());
  if (const auto failure = link.AwaitStatus()) return console.Fail(*failure);
  link.RunUntilInterrupted(console);
  return ExitCode::kDone;
}

// Of the processes of this host.
void AddUnits(const msg::MachineStatus& status, StatusSince& since) {
  for (const msg::ActuatorInfo& actuator : status.actuators) {
    if (actuator.pid == 0 || (!actuator.host.empty() && actuator.host != HostId())) continue;
    const std::string unit = UnitOf(actuator.pid);
    if (unit == UnitNameOf(status.machine, actuator.name)) since.units[actuator.name] = unit;
  }
}

// When that entry was recorded, by the present wall clock: it may have been set since then, as on a
// robot that gets its time from the network after its boot. Of an earlier controller only the wall
// clock's time is known.
std::int64_t WallTimeOf(const msg::GetHistory::Response& history, std::size_t entry,
                        const msg::MachineStatus& status) {
  const bool same_clock = history.entries[entry].epoch == status.epoch &&
                          IsOfThisBoot(status.host) && entry < history.steady_ns.size();
  if (!same_clock) return history.entries[entry].wall_ns;
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return WallNow() - (std::chrono::nanoseconds(now).count() - history.steady_ns[entry]);
}

// Of a machine that works: what is not known is left out.
StatusSince SinceWhen(Link& link, const msg::MachineStatus& status) {
  StatusSince since;
  if (status.host == HostId()) {
    if (const auto facts = FactsOf(status.pid)) since.up_s = facts->age_s;
    AddUnits(status, since);
  }
  const auto answer = link.Call<msg::GetHistory>("get_history", {0, kRecent}, kHistoryTime);
  const auto* history = std::get_if<msg::GetHistory::Response>(&answer);
  if (history == nullptr) return since;
  const auto change = std::find_if(history->entries.rbegin(), history->entries.rend(),
                                   [](const auto& entry) { return !entry.state.empty(); });
  if (change != history->entries.rend() && change->state == status.state) {
    const auto entry = static_cast<std::size_t>(history->entries.rend() - change) - 1;
    since.state_since_ns = WallTimeOf(*history, entry, status);
  }
  return since;
}

// The time of the change is by the clock of the controller, which may be hours from this
// computer's.
StatusTimes TimesOf(const StatusSince& since, const std::string& host) {
  StatusTimes times{std::nullopt, since.up_s};
  if (since.state_since_ns && IsOfThisBoot(host)) {
    times.in_state_s = static_cast<double>(WallNow() - *since.state_since_ns) / 1e9;
  }
  return times;
}

void PrintStatus(const msg::MachineStatus& status, const Uncontrolled& unlisted,
                 const StatusSince& since, const std::optional<std::vector<HostClock>>& hosts,
                 Console& console) {
  const bool colour = console.mode().colour;
  if (console.mode().json) {
    console.Print(StatusJson(status, unlisted, since, hosts));
  } else {
    console.Print(StatusText(status, colour, TimesOf(since, status.host)) +
                  (console.mode().terminal ? StatusLegend(status, colour) : "") +
                  UnitsText(since.units, colour) +
                  (since.standby ? StandbyText(*since.standby) + "\n" : "") +
                  (hosts ? HostsText(*hosts, colour) : ""));
  }
  if (!hosts) return;
  for (const HostClock& host : *hosts) {
    if (!host.trouble.empty()) console.PrintError(host.trouble);
  }
}

// Those that a person has to look at.
void KeepFailed(msg::MachineStatus& status) {
  std::erase_if(status.actuators, [](const msg::ActuatorInfo& actuator) {
    return !actuator.degraded && actuator.health == HealthName(Health::kWell) &&
           !actuator.restarting && actuator.presence != PresenceName(Presence::kLost);
  });
}

// By ssh, in the environment of this user, which has the keys. Only the config knows the hosts.
std::variant<std::vector<HostClock>, Failure> ReadClocks(Link& link,
                                                         const msg::MachineStatus& status) {
  if (status.host != HostId()) {
    return Failure{ExitCode::kUsage,
                   {kCodeParametersInvalid,
                    "--hosts needs the config, which is on the computer of the controller: run it "
                    "there"}};
  }
  const ConfigReading reading = ReadConfigFile(status.config_file);
  if (!reading.config) {
    return Failure{ExitCode::kUsage,
                   {kCodeParametersInvalid, "--hosts needs the config; see `musher check " +
                                                ShellWord(status.config_file) + "`"}};
  }
  const HostClocks clocks(link.loop(), *reading.config);
  link.RunUntil([&] { return clocks.Complete(); }, kClocksWithin);
  if (link.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  return clocks.Now(kClocksWithin);
}

// Where the controller of this host answers by itself, nothing unlisted can be known without a
// network, but on this host.
bool HasUnlistedHere(const msg::MachineStatus& status) {
  const std::string prefix =
      NameLock::NameOf(transport::DomainId({}).value(), status.name_space, "");
  const std::vector<std::string> held = NameLock::HeldBelow(prefix);
  return std::any_of(held.begin(), held.end(), [&](const std::string& name) {
    return std::none_of(status.actuators.begin(), status.actuators.end(),
                        [&](const auto& actuator) { return actuator.name == name; });
  });
}

ExitCode Status(const StatusOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::OpenForCalls(global, &console);
  if (options.follow) return Watch(*link, console);
  std::unique_ptr<RunningActuators> running;
  const auto look_at_all = [&]() -> Result<> {
    if (auto joined = link->Join(); !joined) return joined.error();
    auto begun = RunningActuators::Begin(link->node(), global.name_space, !global.keys.empty());
    if (!begun) return begun.error();
    running = std::move(begun).value();
    return Ok();
  };
  if (!link->CallsHere()) {
    if (auto looks = look_at_all(); !looks) return console.Fail(looks.error());
  }
  auto answer = link->Call<msg::GetStatus>("get_status", {}, std::chrono::seconds(5));
  std::optional<std::vector<HostClock>> hosts;
  if (const auto* first = std::get_if<msg::GetStatus::Response>(&answer); first && options.hosts) {
    auto clocks = ReadClocks(*link, first->status);
    if (const auto* failure = std::get_if<Failure>(&clocks)) return console.Fail(*failure);
    hosts = std::get<std::vector<HostClock>>(std::move(clocks));
    // The other hosts have taken up to 8 s.
    answer = link->Call<msg::GetStatus>("get_status", {}, std::chrono::seconds(5));
  }
  if (const auto* failure = std::get_if<Failure>(&answer)) {
    const bool led = link->LeaderHere() != 0;
    const Uncontrolled others =
        OnlyMeant(running ? running->Now() : Uncontrolled{}, global.machine, led);
    return WithoutController(*failure, others, led, StandbyHere(*link, global), console);
  }
  msg::MachineStatus status = std::get<msg::GetStatus::Response>(answer).status;
  if (!running && (transport::ReachesOtherHosts() || HasUnlistedHere(status))) {
    if (auto looks = look_at_all(); !looks) return console.Fail(looks.error());
  }
  if (running) running->OnlyOf({status.machine, status.machine_id});
  AddCredentialHints(status, global);
  const Uncontrolled unlisted = running ? AwaitUnlisted(*link, *running, status) : Uncontrolled{};
  StatusSince since = SinceWhen(*link, status);
  since.standby = StandbyHere(*link, global);
  if (options.failed) KeepFailed(status);
  PrintStatus(status, unlisted, since, hosts, console);
  if (!unlisted.empty()) {
    console.PrintError(RunningNames(unlisted) + (unlisted.size() == 1 ? " runs" : " run") +
                       " in this namespace and " + (unlisted.size() == 1 ? "is" : "are") +
                       " not in " + status.config_file +
                       ": they run without a controller. `musher down` and "
                       "then `musher down --without-controller` stop them");
  }
  return ExitCode::kDone;
}

}  // namespace

void AddStatus(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("status", "Show the machine and its actuators", Status, "musher status --follow");
  auto* follow = app.add_flag("-f,--follow", options.follow, "Show every change as it happens");
  app.add_flag("--failed", options.failed,
               "Only the actuators that are degraded, not well, lost or being restarted")
      ->excludes(follow);
  app.add_flag(
         "--hosts", options.hosts,
         "Also how far the clocks of the other hosts are from this computer's,\nby ssh; 8 s at "
         "most")
      ->excludes(follow);
}

}  // namespace musher::cli
