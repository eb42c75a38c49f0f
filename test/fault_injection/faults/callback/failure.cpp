// A callback fails with a code.

#include "musher/test/fault_injection/faults/callback.hpp"
#include "musher/test/fault_injection/faults/expectation.hpp"

namespace musher::fault_injection::callback {
namespace {

void FailInSetUp(FaultRun& run) {
  const std::string victim = run.Victim({"legs", "arm", "eyes", "hands"});
  InjectInSetUp(run, victim, &Board::fail_in, victim + " has failed its SetUp",
                [&](const auto& status) { return Find(status, victim).restarts > 1; });
}

}  // namespace

void Fails(FaultRun& run, const std::string& state) {
  if (state == "SetUp") return FailInSetUp(run);
  if (state == "TearDown") return InjectInTearDown(run, &Board::fail_in);
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
