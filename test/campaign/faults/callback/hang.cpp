// A callback that does not come back, and a cycle that does not get on.

#include <signal.h>

#include "musher/test/campaign/faults/callback.hpp"
#include "musher/test/campaign/faults/promise.hpp"

namespace musher::campaign::callback {
namespace {

// In SetUp only one that is started again can hang.
void HangInSetUp(Trial& trial) {
  const std::string victim = trial.Victim({"legs", "arm", "eyes"});
  Board& board = trial.robot.board(victim);
  board.hang_in = IndexOfState("SetUp");
  const pid_t pid = trial.robot.PidOf(victim);
  trial.Struck();
  kill(pid, SIGKILL);
  trial.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  Relieve(board);
  trial.RecoveredIn(trial.state());
}

void HangInTearDown(Trial& trial) {
  const std::string victim = trial.Victim(Modules());
  trial.robot.board(victim).hang_in = IndexOfState("TearDown");
  trial.RobotIsTornDown();
  trial.Struck();
  const auto answer = trial.observer().SetState("TearDown");
  trial.Require(trial.robot.AwaitControllerEnd(kPatience), "the machine does not end");
  trial.RecoveredNow();
  trial.Expect(Answer(answer).ok(), "nobody has answered the call for TearDown");
  Relieve(trial.robot.board(victim));
}

}  // namespace

void Hangs(Trial& trial, const std::string& state) {
  if (state == "SetUp") return HangInSetUp(trial);
  if (state == "TearDown") return HangInTearDown(trial);
  LeaveStateOf(trial, state);
  const std::string victim = trial.Victim(Modules());
  const Member& member = MemberOf(victim);
  Board& board = trial.robot.board(victim);
  const SwitchPromise promise = PromiseForSwitch(trial.state(), state);
  trial.MayBecome(state);
  board.hang_in = IndexOfState(state);
  trial.Struck();
  const auto answer = trial.observer().SetState(state);
  if (member.checkpoint_ms > 0) {
    trial.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  } else {
    trial.Detected(victim + " is overdue",
                   [&](const auto& status) { return Find(status, victim).degraded; });
  }
  const auto result = Answer(answer);
  Relieve(board);
  trial.ExpectOutcome(result, promise.outcome);
  // One that may not be started again comes to itself; the machine has gone where it goes without.
  const std::string end = member.checkpoint_ms > 0
                              ? PromiseFor(victim, Loss::kFailure, promise.state).state
                              : promise.state;
  const bool stays_up = victim == "planner" || victim == "hands";  // nobody kills it
  if (state == "SelfCheck" && stays_up) return trial.PassesSelfCheckLater(victim, end);
  trial.RecoveredIn(end);
}

void ThreadIsSilent(Trial& trial) {
  const std::string victim = trial.Victim({"legs", "arm", "eyes", "planner"});
  Board& board = trial.robot.board(victim);
  const bool comes_to_itself = trial.random.Chance(50);
  trial.Drawn("comes to itself", comes_to_itself ? "at once" : "never");
  // It is watched from the first one after a state callback.
  const int before = board.checkpoints;
  AwaitThat([&] { return board.checkpoints > before + 1; }, kPatience);
  trial.Struck();
  board.silent = true;
  trial.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  const std::string state = PromiseFor(victim, Loss::kFailure, trial.state()).state;
  if (comes_to_itself || victim == "planner") {
    Relieve(board);
  } else {
    const auto killed = [&](const auto& s) { return Find(s, victim).restarts > 0; };
    trial.Require(trial.observer().Await(killed, kPatience).has_value(),
                  victim + " is not started again");
    Relieve(board);
  }
  trial.RecoveredIn(state);
}

}  // namespace musher::campaign::callback
