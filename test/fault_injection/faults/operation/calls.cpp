// Requests during a switch.

#include "musher/test/fault_injection/faults/operation.hpp"

namespace musher::fault_injection::operation {

void Superseded(FaultRun& run) {
  const std::string target = run.state() == "Active" ? "LowPower" : "Active";
  run.MayBecome(target);
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = 100;
  const auto began =
      run.observer().Once([target](const auto& status) { return status.target == target; }, [] {});
  const auto older = run.observer().SetState(target);
  AwaitFuture(began);
  run.FaultInjected();
  const auto newer = run.observer().SetState("Error");
  run.ExpectOutcome(AwaitFuture(older), "superseded");
  run.DetectedNow();
  run.ExpectOutcome(AwaitFuture(newer), "done");
  run.RecoveredIn("Error");
}

void ManyCalls(FaultRun& run) {
  std::vector<std::string> targets = {"Protected", "DeActive", "LowPower", "Active"};
  run.random.Shuffle(targets);
  run.MayBecome("Active");
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = 50;
  run.FaultInjected();
  std::vector<std::shared_future<Result<msg::SetState::Response>>> replies;
  for (const std::string& target : targets) replies.push_back(run.observer().SetState(target));
  int done = 0;
  std::string state = run.state();
  for (const auto& future : replies) {
    const auto reply = AwaitFuture(future);
    run.Require(reply.ok(), "a request has no reply");
    const msg::SetState::Response& result = reply.value();
    const bool is_done = result.outcome == "done";
    run.Expect(is_done || (result.outcome == "refused" && result.code == 111),
               "the switch to " + result.target + " is " + result.outcome + ": " + result.reason);
    if (is_done) state = result.target;
    if (is_done) ++done;
  }
  run.Expect(done >= 1, "no request was executed");
  for (const std::string& name : Modules()) ClearFaults(run.robot.board(name));
  run.RecoveredIn(state);
}

}  // namespace musher::fault_injection::operation
