#include "musher/cli/commands/switch_request.hpp"

#include <fmt/format.h>

#include <map>

#include "musher/base/host.hpp"
#include "musher/cli/commands/switch_progress.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/controller/client/switch_client.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

constexpr Duration kSwitchTimeout = std::chrono::seconds(60);
// For the controller's last writes to a slow disk and for leaving the network.
constexpr Duration kControllerEnd = std::chrono::seconds(7);
// Longer than a service manager takes to start another controller, including its listening time.
constexpr Duration kSuccessor = std::chrono::seconds(6);
constexpr Duration kSecuredSuccessor = std::chrono::seconds(12);

// A switch continues when the client stops waiting: adds to the message which switch that is.
Failure WithSwitch(Failure failure, Link& link, const std::string& target) {
  if (failure.exit != ExitCode::kNoAnswer && failure.exit != ExitCode::kInterrupted) return failure;
  const auto& status = link.StatusTowards(target);
  if (status && status->target == target) {
    failure.switch_number = CommandNumber(status->switch_number);
    failure.error.message +=
        fmt::format("; switch {} to {} continues, `musher status` shows its outcome",
                    status->switch_number, target);
  } else if (status) {
    failure.error.message +=
        fmt::format("; a requested switch continues, its number is above {}: see `musher history`",
                    status->switch_number);
  }
  return failure;
}

// Reports running actuators of an earlier config, or ones that the TearDown did not reach. Returns
// whether there are any.
bool ReportLeftBehind(std::map<std::string, RunningActuators::Actuator> running, Console& console) {
  std::erase_if(running, [](const auto& one) { return !one.second.has_status; });
  if (running.empty()) return false;
  console.PrintError(RunningNames(running) + (running.size() == 1 ? " still runs" : " still run") +
                     " in this namespace; `musher down --without-controller` stops what is left");
  return true;
}

// The time limits of a switch, by its plan. They are shown only, so nothing waits for the plan.
class SwitchLimits {
 public:
  SwitchLimits(Link& link, const GlobalOptions& global) : link_(link), global_(global) {}

  void Request(const std::string& target, const std::string& actuator) {
    auto client = transport::MakeClient<msg::GetPlan>(
        link_.node(), transport::MachineService(global_.name_space, "get_plan"));
    if (!client) return;
    plans_ = std::move(client).value();
    const MachineIdentity& machine = link_.machine();
    plans_->Call({target, actuator, machine.name, machine.id}, kSwitchTimeout, [this](auto reply) {
      if (!reply) return;
      for (const msg::PlanStep& step : reply.value().steps) steps_[step.name] = step;
    });
  }
  std::optional<Duration> Of(const std::string& actuator, const std::string& state) const {
    const auto step = steps_.find(actuator);
    if (step == steps_.end() || step->second.to != state || step->second.deadline_ms <= 0) {
      return std::nullopt;
    }
    return Milliseconds(step->second.deadline_ms);
  }

 private:
  Link& link_;
  const GlobalOptions& global_;
  std::map<std::string, msg::PlanStep> steps_;              // by actuator
  std::unique_ptr<transport::Client<msg::GetPlan>> plans_;  // last: its callback uses steps_
};

}  // namespace

ExitCode RequestSwitch(const std::string& target, const std::string& actuator,
                       const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global, &console);
  if (!link) return console.Fail(link.error());
  if (const auto open = link.value()->ChooseMachine(Link::Purpose::kAct)) {
    return console.Fail(*open);
  }
  SwitchLimits limits(*link.value(), global);
  SwitchProgress progress(link.value()->loop(), console,
                          [&limits](const std::string& name, const std::string& state) {
                            return limits.Of(name, state);
                          });
  const auto follow = [&progress](const auto& status) { progress.Show(status); };
  if (const auto r = link.value()->FollowStatus(follow); !r) return console.Fail(r.error());
  if (progress.on()) limits.Request(target, actuator);
  const auto running =
      RunningActuators::Begin(link.value()->node(), global.name_space, !global.keys.empty());
  if (!running) return console.Fail(running.error());
  running.value()->OnlyOf(link.value()->machine());
  const Duration timeout = global.timeout.value_or(kSwitchTimeout);
  SwitchClient::Options options;
  options.leader = {global.name_space, HostId(), WatchByPidfd(link.value()->loop())};
  options.leader.machine = link.value()->machine();
  options.by = UserAtHost();
  options.timeout = timeout + Link::kAfterAwait;  // Await() has the better error message
  options.successor = global.keys.empty() ? kSuccessor : kSecuredSuccessor;
  std::optional<SwitchEnd> end;
  const auto client = SwitchClient::Make(
      link.value()->node(), options, target, actuator,
      [&](const std::string& news) { console.PrintError(news); },
      [&end](const SwitchEnd& known) { end = known; });
  if (!client) return console.Fail(client.error());
  const auto failure = link.value()->Await([&] { return end.has_value(); },
                                           [&] { return client.value()->found(); }, timeout);
  progress.Hide();
  if (failure) return console.Fail(WithSwitch(*failure, *link.value(), target));
  const msg::SetState::Response& result = end->result;
  if (end->kind == SwitchEnd::Kind::kUnknown) {
    return console.Fail(
        {ExitCode::kUnknownEnd, {result.code, result.reason}, CommandNumber(result.switch_number)});
  }
  // The controller exits with its machine. Once this command returns, the next one may start.
  // Its status may be lost before the process exits, so the last known one identifies it.
  const auto leader = link.value()->last_leader();
  const bool down = target == kTearDown && actuator.empty() && result.state == kTearDown;
  if (down && leader && !link.value()->AwaitEndOf(*leader, kControllerEnd)) {
    console.PrintError(
        fmt::format("the controller (pid {}) has not exited yet; the machine cannot be "
                    "started again until then",
                    leader->pid));
  }
  console.Print(console.mode().json ? SwitchJson(result)
                                    : SwitchText(result, console.mode().colour));
  const bool left = down && ReportLeftBehind(running.value()->Now(), console);
  if (result.outcome == "done") return left ? ExitCode::kNotDone : ExitCode::kDone;
  console.PrintError(SwitchError(result));
  return ExitCodeOfRefusal(result.outcome == "refused" ? result.code : kCodeFailed);
}

}  // namespace musher::cli
