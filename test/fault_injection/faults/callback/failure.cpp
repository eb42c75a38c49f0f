// A callback fails with a code.

#include <signal.h>

#include "musher/test/fault_injection/faults/callback.hpp"
#include "musher/test/fault_injection/faults/expectation.hpp"

namespace musher::fault_injection::callback {
namespace {

void FailInSetUp(FaultRun& run) {
  const std::string victim = run.Victim({"legs", "arm", "eyes", "hands"});
  Board& board = run.robot.board(victim);
  board.fail_in = IndexOfState("SetUp");
  const pid_t pid = run.robot.PidOf(victim);
  run.FaultInjected();
  kill(pid, SIGKILL);
  run.Detected(victim + " has failed its SetUp",
               [&](const auto& status) { return Find(status, victim).restarts > 1; });
  ClearFaults(board);
  run.RecoveredIn(run.state());
}

void FailInTearDown(FaultRun& run) {
  const std::string victim = run.Victim(Modules());
  run.robot.board(victim).fail_in = IndexOfState("TearDown");
  run.RobotIsTornDown();
  run.FaultInjected();
  const auto reply = run.observer().SetState("TearDown");
  run.Require(run.robot.AwaitControllerEnd(kTimeout), "the machine does not end");
  run.RecoveredNow();
  run.Expect(AwaitFuture(reply).ok(), "the request for TearDown has no reply");
}

}  // namespace

void Fails(FaultRun& run, const std::string& state) {
  if (state == "SetUp") return FailInSetUp(run);
  if (state == "TearDown") return FailInTearDown(run);
  LeaveStateOf(run, state);
  const std::string victim = run.Victim(Modules());
  Board& board = run.robot.board(victim);
  const SwitchExpectation expectation = ExpectationForSwitch(run.state(), state);
  run.MayBecome(state);
  board.fail_in = IndexOfState(state);
  run.FaultInjected();
  const auto reply = run.observer().SetState(state);
  const auto result = AwaitFuture(reply);
  run.DetectedNow();
  ClearFaults(board);
  run.ExpectOutcome(result, expectation.outcome);
  if (expectation.outcome == "undone") return run.RecoveredIn(expectation.state);
  run.Recovered(victim + " is listed as degraded, the others are in the state",
                [&](const msg::MachineStatus& status) {
                  const msg::ActuatorInfo& info = Find(status, victim);
                  return IsSettled(status, expectation.state, {victim}) && info.degraded &&
                         info.health == "well";
                });
  // An operator requests it once more.
  const auto again = AwaitFuture(run.observer().SetState(state));
  run.ExpectOutcome(again, "done");
}

}  // namespace musher::fault_injection::callback
