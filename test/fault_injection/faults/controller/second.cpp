// Two controllers of one machine.

#include <signal.h>

#include "musher/test/fault_injection/faults/controller.hpp"

namespace musher::fault_injection::controller {
namespace {

void TakeOver(FaultRun& run) {
  const auto before = run.observer().Latest();
  run.ControllerMayDie();
  run.FaultInjected();
  run.robot.StartController({"--takeover"});
  const int first = run.robot.AwaitEndOfFirst();
  run.Expect(first == 1, "the first controller exits with " + std::to_string(first) + ", not 1");
  run.DetectedNow();
  run.Require(run.robot.AwaitSettled(), "the second controller does not adopt the robot");
  run.RecoveredNow();
  const auto after = run.observer().Latest();
  run.Expect(after->epoch > before->epoch, "the epoch has not grown");
}

}  // namespace

void SecondIsRefused(FaultRun& run) {
  const auto before = run.observer().GetStatus();
  run.FaultInjected();
  const int exit_code = run.robot.Musher({"up", run.robot.folder() / "robot.toml"});
  run.DetectedNow();
  run.Expect(exit_code == 2, "a second controller exits with " + std::to_string(exit_code));
  run.RecoveredIn(run.state());
  const auto after = run.observer().GetStatus();
  run.Require(before.ok() && after.ok(), "the first controller does not reply");
  run.Expect(before.value() == after.value(), "the status of the first controller has changed");
}

void TakenOver(FaultRun& run) {
  TakeOver(run);
  const std::string state = run.observer().Latest()->state;
  run.Expect(state == run.state(), "the machine is " + state + " after the takeover");
}

void TakenOverFrozen(FaultRun& run) {
  kill(run.robot.RunningController(), SIGSTOP);
  const auto before = run.observer().Latest();
  run.ControllerMayDie();
  run.FaultInjected();
  run.robot.StartController({"--takeover"});
  const int first = run.robot.AwaitEndOfFirst();
  run.Expect(first == 1, "the first launcher exits with " + std::to_string(first) + ", not 1");
  run.DetectedNow();
  run.Require(run.robot.AwaitSettled(), "the second controller does not adopt the robot");
  run.RecoveredNow();
  run.Expect(run.observer().Latest()->epoch > before->epoch, "the epoch has not grown");
}

void TakenOverInSwitch(FaultRun& run) {
  const std::string target = run.state() == "Active" ? "LowPower" : "Active";
  run.MayBecome(target);
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = 150;
  const auto began =
      run.observer().Once([target](const auto& status) { return status.target == target; }, [] {});
  const auto reply = run.observer().SetState(target);
  AwaitFuture(began);
  TakeOver(run);
  for (const std::string& name : Modules()) ClearFaults(run.robot.board(name));
  const std::string state = run.observer().Latest()->state;
  run.Expect(state == run.state() || state == target, "the machine is " + state);
  if (target == "LowPower") run.Expect(state == target, "a switch down was not finished");
}

void StoppedInSwitch(FaultRun& run) {
  const std::string target = run.state() == "Active" ? "LowPower" : "Active";
  run.MayBecome(target);
  run.RobotIsTornDown();
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = 100;
  const pid_t pid = run.robot.RunningController();
  const auto terminated =
      run.observer().Once([target](const auto& status) { return status.target == target; },
                          [pid] { kill(pid, SIGTERM); });
  const auto reply = run.observer().SetState(target);
  AwaitFuture(terminated);
  run.FaultInjected();
  run.ExpectOutcome(AwaitFuture(reply), "superseded");
  run.DetectedNow();
  run.Require(run.robot.AwaitControllerEnd(kTimeout), "the machine does not end");
  run.RecoveredNow();
}

}  // namespace musher::fault_injection::controller
