// A callback that does not return, and a work thread that makes no progress.

#include "musher/test/fault_injection/faults/callback.hpp"
#include "musher/test/fault_injection/faults/expectation.hpp"

namespace musher::fault_injection::callback {
namespace {

// Only an actuator that is restarted can hang in SetUp here.
void HangInSetUp(FaultRun& run) {
  const std::string victim = run.Victim({"legs", "arm", "eyes"});
  InjectInSetUp(run, victim, &Board::hang_in, victim + " hangs", IsKnownAs(victim, "hung"));
}

}  // namespace

void Hangs(FaultRun& run, const std::string& state) {
  if (state == "SetUp") return HangInSetUp(run);
  if (state == "TearDown") return InjectInTearDown(run, &Board::hang_in);
  LeaveStateOf(run, state);
  const std::string victim = run.Victim(Modules());
  const Member& member = MemberOf(victim);
  Board& board = run.robot.board(victim);
  const SwitchExpectation expectation = ExpectationForSwitch(run.state(), state);
  run.MayBecome(state);
  board.hang_in = IndexOfState(state);
  run.FaultInjected();
  const auto reply = run.observer().SetState(state);
  if (member.checkpoint_ms > 0) {
    run.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  } else {
    run.Detected(victim + " is overdue",
                 [&](const auto& status) { return Find(status, victim).degraded; });
  }
  const auto result = AwaitFuture(reply);
  ClearFaults(board);
  run.ExpectOutcome(result, expectation.outcome);
  // An actuator that is not restarted recovers; the machine stays in the state for its loss.
  const std::string end = member.checkpoint_ms > 0
                              ? ExpectationFor(victim, Loss::kFailure, expectation.state).state
                              : expectation.state;
  const bool stays_up =
      victim == "planner" || victim == "hands";  // the controller does not kill it
  if (state == "SelfCheck" && stays_up) return run.PassesSelfCheckLater(victim, end);
  run.RecoveredIn(end);
}

void ThreadStopsCheckpoints(FaultRun& run) {
  const std::string victim = run.Victim({"legs", "arm", "eyes", "planner"});
  Board& board = run.robot.board(victim);
  const bool recovers = run.random.Bernoulli(50);
  run.Sampled("recovers", recovers ? "at once" : "never");
  // Checkpoints are monitored from the first one after a state callback.
  const int before = board.checkpoints;
  AwaitThat([&] { return board.checkpoints > before + 1; }, kTimeout);
  run.FaultInjected();
  board.silent = true;
  run.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  const std::string state = ExpectationFor(victim, Loss::kFailure, run.state()).state;
  if (recovers || victim == "planner") {
    ClearFaults(board);
  } else {
    const auto killed = [&](const auto& s) { return Find(s, victim).restarts > 0; };
    run.Require(run.observer().Await(killed, kTimeout).has_value(), victim + " is not restarted");
    ClearFaults(board);
  }
  run.RecoveredIn(state);
}

}  // namespace musher::fault_injection::callback
