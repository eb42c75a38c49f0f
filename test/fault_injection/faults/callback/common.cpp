#include <signal.h>

#include "musher/test/fault_injection/faults/callback.hpp"

namespace musher::fault_injection::callback {

SwitchExpectation ExpectationForSwitch(const std::string& before, const std::string& target) {
  if (target == "SelfCheck") return {"done-degraded", before};
  if (RankOf(target) > RankOf(before)) return {"undone", before};
  return {"done-degraded", target};
}

void LeaveStateOf(FaultRun& run, const std::string& target) {
  if (run.state() != target) return;
  run.MoveTo(target == "Active" ? "DeActive" : "Active");
}

void InjectInSetUp(FaultRun& run, const std::string& victim, CallbackFault fault,
                   const std::string& what, const Observer::Is& is) {
  Board& board = run.robot.board(victim);
  board.*fault = IndexOfState("SetUp");
  const pid_t pid = run.robot.PidOf(victim);
  run.FaultInjected();
  kill(pid, SIGKILL);
  run.Detected(what, is);
  ClearFaults(board);
  run.RecoveredIn(run.state());
}

void InjectInTearDown(FaultRun& run, CallbackFault fault) {
  Board& board = run.robot.board(run.Victim(Modules()));
  board.*fault = IndexOfState("TearDown");
  run.RobotIsTornDown();
  run.FaultInjected();
  const auto reply = run.observer().SetState("TearDown");
  run.Require(run.robot.AwaitControllerEnd(kTimeout), "the machine does not end");
  run.RecoveredNow();
  run.Expect(AwaitFuture(reply).ok(), "the request for TearDown has no reply");
  ClearFaults(board);
}

}  // namespace musher::fault_injection::callback
