// musher down: TearDown in reverse order, then the processes end, then the controller does.
// musher down --without-controller: ends what runs though no controller leads it.

#include <fmt/format.h>

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/ending.hpp"
#include "musher/controller/cli/link.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/running.hpp"
#include "musher/controller/cli/switch_request.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

constexpr Duration kPatience = std::chrono::seconds(10);

ExitCode EndWhatRuns(const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto running =
      Running::Begin(link.value()->node(), global.name_space, !global.keys.empty());
  if (!running) return console.Fail(running.error());
  link.value()->RunUntil([&] { return link.value()->HasMachine(); }, link.value()->discovery());
  if (link.value()->HasMachine() || link.value()->LeaderHere() != 0) {
    return console.Fail(
        {ExitCode::kNotDone,
         {kCodeTargetBusy, "a controller leads the actuators of namespace '" + global.name_space +
                               "': `musher down` ends them in their order, and it"}});
  }
  if (running.value()->Now().empty()) {
    return console.Fail(link.value()->NotFound("controller and no actuator"));
  }
  const auto ending = Ending::Begin(link.value()->node(), global.name_space, *running.value(),
                                    global.timeout.value_or(kPatience));
  if (!ending) return console.Fail(ending.error());
  link.value()->RunUntil([&] { return ending.value()->Ended() || ending.value()->OutOfTime(); },
                         std::chrono::hours(1));
  const auto outcomes = ending.value()->Outcomes();
  console.Print(console.mode().json ? EndingJson(outcomes)
                                    : EndingText(outcomes, console.mode().colour));
  if (link.value()->interrupted()) return ExitCode::kInterrupted;
  if (ending.value()->Ended()) return ExitCode::kDone;
  console.Complain("not all actuators have ended");
  return ExitCode::kNotDone;
}

}  // namespace

ExitCode Down(const DownOptions& options, const GlobalOptions& global, Console& console) {
  if (options.without_controller) return EndWhatRuns(global, console);
  return RequestSwitch(State(kTearDown), "", global, console);
}

}  // namespace musher::cli
