#include "musher/controller/cli/switch_request.hpp"

#include <fmt/format.h>

#include <map>

#include "musher/controller/cli/link.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/running.hpp"
#include "musher/controller/cli/switch_progress.hpp"
#include "musher/controller/switch_client.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/transport/host.hpp"

namespace musher::cli {
namespace {

constexpr Duration kSwitchTimeout = std::chrono::seconds(60);
// For its last writes to a slow disk, and to leave the network.
constexpr Duration kControllerEnd = std::chrono::seconds(7);
// Longer than a service manager takes to start another controller, and that to look around.
constexpr Duration kSuccessor = std::chrono::seconds(6);
constexpr Duration kSecuredSuccessor = std::chrono::seconds(12);

// A switch does not end because nobody waits for it any more: says which one goes on.
Failure WithSwitch(Failure failure, Link& link, const std::string& target) {
  if (failure.exit != ExitCode::kNoAnswer && failure.exit != ExitCode::kInterrupted) return failure;
  const auto& status = link.StatusTowards(target);
  if (status && status->target == target) {
    failure.switch_number = status->switch_number;
    failure.error.message +=
        fmt::format("; switch {} to {} goes on, `musher status` shows how it ends",
                    status->switch_number, target);
  } else if (status) {
    failure.error.message += fmt::format(
        "; a switch that was begun goes on, its number is above {} (`musher history` tells)",
        status->switch_number);
  }
  return failure;
}

// An actuator of an earlier config, or one that the TearDown did not reach.
void NameLeftBehind(std::map<std::string, Running::Actuator> running, Console& console) {
  std::erase_if(running, [](const auto& one) { return !one.second.heard; });
  if (running.empty()) return;
  console.Complain(RunningNames(running) + (running.size() == 1 ? " still runs" : " still run") +
                   " in this namespace; `musher down --without-controller` ends what is left");
}

}  // namespace

ExitCode RequestSwitch(const std::string& target, const std::string& actuator,
                       const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  if (const auto r = link.value()->FollowStatus({}); !r) {
    return console.Fail(r.error());
  }
  const auto running =
      Running::Begin(link.value()->node(), global.name_space, !global.keys.empty());
  if (!running) return console.Fail(running.error());
  const Duration timeout = global.timeout.value_or(kSwitchTimeout);
  SwitchClient::Options options;
  options.leader = {global.name_space, transport::HostId(), WatchByPidfd(link.value()->loop())};
  options.timeout = timeout + std::chrono::minutes(1);  // Await() says more about who is silent
  options.successor = global.keys.empty() ? kSuccessor : kSecuredSuccessor;
  std::optional<SwitchEnd> end;
  SwitchProgress progress(*link.value(), target, console);
  const auto client = SwitchClient::Make(
      link.value()->node(), options, target, actuator,
      [&](const std::string& news) {
        progress.Clear();
        console.Complain(news);
      },
      [&end](const SwitchEnd& known) { end = known; });
  if (!client) return console.Fail(client.error());
  const auto failure = link.value()->Await([&] { return end.has_value(); },
                                           [&] { return client.value()->found(); }, timeout);
  progress.Clear();
  if (failure) return console.Fail(WithSwitch(*failure, *link.value(), target));
  const msg::SetState::Response& result = end->result;
  if (end->kind == SwitchEnd::Kind::kUnknown) {
    return console.Fail(
        {ExitCode::kUnknownEnd, {result.code, result.reason}, result.switch_number});
  }
  // A controller ends with its machine. Once we return, the next one may start.
  // Its status may be gone before it is, and it is known whose that was.
  const auto leader = link.value()->last_leader();
  const bool down = target == kTearDown && actuator.empty() && result.state == kTearDown;
  if (down && leader && !link.value()->AwaitEndOf(*leader, kControllerEnd)) {
    console.Complain(
        fmt::format("the controller, process {}, has not ended yet; until then the "
                    "machine is not started again",
                    leader->pid));
  }
  console.Print(console.mode().json ? SwitchJson(result)
                                    : SwitchText(result, console.mode().colour));
  if (down) NameLeftBehind(running.value()->Now(), console);
  if (result.outcome == "done") return ExitCode::kDone;
  console.Complain(SwitchComplaint(result));
  return ExitCode::kNotDone;
}

}  // namespace musher::cli
