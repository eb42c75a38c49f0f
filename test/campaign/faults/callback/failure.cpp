// A callback that fails with a code.

#include <signal.h>

#include "musher/test/campaign/faults/callback.hpp"
#include "musher/test/campaign/faults/promise.hpp"

namespace musher::campaign::callback {
namespace {

void FailInSetUp(Trial& trial) {
  const std::string victim = trial.Victim({"legs", "arm", "eyes", "hands"});
  Board& board = trial.robot.board(victim);
  board.fail_in = IndexOfState("SetUp");
  const pid_t pid = trial.robot.PidOf(victim);
  trial.Struck();
  kill(pid, SIGKILL);
  trial.Detected(victim + " has failed its SetUp",
                 [&](const auto& status) { return Find(status, victim).restarts > 1; });
  Relieve(board);
  trial.RecoveredIn(trial.state());
}

void FailInTearDown(Trial& trial) {
  const std::string victim = trial.Victim(Modules());
  trial.robot.board(victim).fail_in = IndexOfState("TearDown");
  trial.RobotIsTornDown();
  trial.Struck();
  const auto answer = trial.observer().SetState("TearDown");
  trial.Require(trial.robot.AwaitControllerEnd(kPatience), "the machine does not end");
  trial.RecoveredNow();
  trial.Expect(Answer(answer).ok(), "nobody has answered the call for TearDown");
}

}  // namespace

void Fails(Trial& trial, const std::string& state) {
  if (state == "SetUp") return FailInSetUp(trial);
  if (state == "TearDown") return FailInTearDown(trial);
  LeaveStateOf(trial, state);
  const std::string victim = trial.Victim(Modules());
  Board& board = trial.robot.board(victim);
  const SwitchPromise promise = PromiseForSwitch(trial.state(), state);
  trial.MayBecome(state);
  board.fail_in = IndexOfState(state);
  trial.Struck();
  const auto answer = trial.observer().SetState(state);
  const auto result = Answer(answer);
  trial.DetectedNow();
  Relieve(board);
  trial.ExpectOutcome(result, promise.outcome);
  if (promise.outcome == "undone") return trial.RecoveredIn(promise.state);
  trial.Recovered(victim + " is listed as degraded, the others are there",
                  [&](const msg::MachineStatus& status) {
                    const msg::ActuatorInfo& info = Find(status, victim);
                    return IsSettled(status, promise.state, {victim}) && info.degraded &&
                           info.health == "well";
                  });
  // A person says it once more.
  const auto again = Answer(trial.observer().SetState(state));
  trial.ExpectOutcome(again, "done");
}

}  // namespace musher::campaign::callback
