// musher status [--watch]: the machine now, or every change of it.

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/link.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/wall_time.hpp"
#include "musher/lifecycle/machine.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/host.hpp"

namespace musher::cli {
namespace {

constexpr const char* kRedraw = "\x1b[H\x1b[2J";  // from the top of an empty screen

void Show(const std::optional<msg::MachineStatus>& status, Console& console) {
  const Failure gone{ExitCode::kNoController, {kCodeNetError, "the controller has gone"}};
  if (console.mode().json) {
    console.Print(status ? StatusJson(*status) : FailureJson(gone));
  } else if (console.mode().terminal) {
    console.Print(kRedraw + (status ? StatusText(*status, console.mode().colour)
                                    : gone.error.message + "; waiting for another\n"));
  } else {
    console.Print(status ? StatusLine(*status, WallNow())
                         : LocalTime(WallNow()) + "  " + gone.error.message);
  }
}

// With keys an actuator that we did not start may run here and not be heard: then it has none, or
// others.
void HintAtKeys(msg::MachineStatus& status, const GlobalOptions& global) {
  if (global.keys.empty() || status.host != transport::HostId()) return;
  const int domain = transport::DomainId({}).value();
  for (msg::ActuatorInfo& actuator : status.actuators) {
    if (actuator.presence != PresenceName(Presence::kAbsent)) continue;
    const std::string name = transport::NameLock::NameOf(domain, status.name_space, actuator.name);
    const pid_t holder = transport::NameLock::HolderOf(name).pid;
    if (holder == 0) continue;
    actuator.message = "process " + std::to_string(holder) +
                       " is not heard: has it the keys of this machine?" +
                       (actuator.message.empty() ? "" : " " + actuator.message);
  }
}

ExitCode Watch(Link& link, Console& console) {
  const auto followed =
      link.FollowStatus([&console](const auto& status) { Show(status, console); });
  if (!followed) return console.Fail({ExitCode::kUsage, followed.error()});
  if (const auto failure = link.AwaitStatus()) return console.Fail(*failure);
  link.RunUntilInterrupted();
  return ExitCode::kDone;
}

}  // namespace

ExitCode Status(const StatusOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail({ExitCode::kUsage, link.error()});
  if (options.watch) return Watch(*link.value(), console);
  const auto answer = link.value()->Ask<msg::GetStatus>("get_status", {}, std::chrono::seconds(5));
  if (const auto* failure = std::get_if<Failure>(&answer)) return console.Fail(*failure);
  msg::MachineStatus status = std::get<msg::GetStatus::Response>(answer).status;
  HintAtKeys(status, global);
  console.Print(console.mode().json ? StatusJson(status)
                                    : StatusText(status, console.mode().colour));
  return ExitCode::kDone;
}

}  // namespace musher::cli
