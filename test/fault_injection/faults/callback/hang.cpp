// A callback that does not come back, and a cycle that does not get on.

#include <signal.h>

#include "musher/test/fault_injection/faults/callback.hpp"
#include "musher/test/fault_injection/faults/expectation.hpp"

namespace musher::fault_injection::callback {
namespace {

// In SetUp only one that is started again can hang.
void HangInSetUp(FaultRun& run) {
  const std::string victim = run.Victim({"legs", "arm", "eyes"});
  Board& board = run.robot.board(victim);
  board.hang_in = IndexOfState("SetUp");
  const pid_t pid = run.robot.PidOf(victim);
  run.Struck();
  kill(pid, SIGKILL);
  run.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  Relieve(board);
  run.RecoveredIn(run.state());
}

void HangInTearDown(FaultRun& run) {
  const std::string victim = run.Victim(Modules());
  run.robot.board(victim).hang_in = IndexOfState("TearDown");
  run.RobotIsTornDown();
  run.Struck();
  const auto answer = run.observer().SetState("TearDown");
  run.Require(run.robot.AwaitControllerEnd(kPatience), "the machine does not end");
  run.RecoveredNow();
  run.Expect(Answer(answer).ok(), "nobody has answered the call for TearDown");
  Relieve(run.robot.board(victim));
}

}  // namespace

void Hangs(FaultRun& run, const std::string& state) {
  if (state == "SetUp") return HangInSetUp(run);
  if (state == "TearDown") return HangInTearDown(run);
  LeaveStateOf(run, state);
  const std::string victim = run.Victim(Modules());
  const Member& member = MemberOf(victim);
  Board& board = run.robot.board(victim);
  const SwitchExpectation expectation = ExpectationForSwitch(run.state(), state);
  run.MayBecome(state);
  board.hang_in = IndexOfState(state);
  run.Struck();
  const auto answer = run.observer().SetState(state);
  if (member.checkpoint_ms > 0) {
    run.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  } else {
    run.Detected(victim + " is overdue",
                 [&](const auto& status) { return Find(status, victim).degraded; });
  }
  const auto result = Answer(answer);
  Relieve(board);
  run.ExpectOutcome(result, expectation.outcome);
  // One that may not be started again comes to itself; the machine has gone where it goes without.
  const std::string end = member.checkpoint_ms > 0
                              ? ExpectationFor(victim, Loss::kFailure, expectation.state).state
                              : expectation.state;
  const bool stays_up = victim == "planner" || victim == "hands";  // nobody kills it
  if (state == "SelfCheck" && stays_up) return run.PassesSelfCheckLater(victim, end);
  run.RecoveredIn(end);
}

void ThreadIsSilent(FaultRun& run) {
  const std::string victim = run.Victim({"legs", "arm", "eyes", "planner"});
  Board& board = run.robot.board(victim);
  const bool comes_to_itself = run.random.Chance(50);
  run.Drawn("comes to itself", comes_to_itself ? "at once" : "never");
  // It is watched from the first one after a state callback.
  const int before = board.checkpoints;
  AwaitThat([&] { return board.checkpoints > before + 1; }, kPatience);
  run.Struck();
  board.silent = true;
  run.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  const std::string state = ExpectationFor(victim, Loss::kFailure, run.state()).state;
  if (comes_to_itself || victim == "planner") {
    Relieve(board);
  } else {
    const auto killed = [&](const auto& s) { return Find(s, victim).restarts > 0; };
    run.Require(run.observer().Await(killed, kPatience).has_value(),
                victim + " is not started again");
    Relieve(board);
  }
  run.RecoveredIn(state);
}

}  // namespace musher::fault_injection::callback
