// Two controllers of one machine.

#include <signal.h>

#include "musher/test/campaign/faults/controller.hpp"

namespace musher::campaign::controller {
namespace {

void TakeOver(Trial& trial) {
  const auto before = trial.observer().Latest();
  trial.ControllerMayDie();
  trial.Struck();
  trial.robot.StartController({"--takeover"});
  const int first = trial.robot.AwaitEndOfFirst();
  trial.Expect(first == 1, "the first controller ends with " + std::to_string(first) + ", not 1");
  trial.DetectedNow();
  trial.Require(trial.robot.AwaitSettled(), "the second controller does not adopt the robot");
  trial.RecoveredNow();
  const auto after = trial.observer().Latest();
  trial.Expect(after->epoch > before->epoch, "the epoch has not grown");
}

}  // namespace

void SecondIsRefused(Trial& trial) {
  const auto before = trial.observer().GetStatus();
  trial.Struck();
  const int exit_code = trial.robot.Musher({"up", trial.robot.folder() / "robot.toml"});
  trial.DetectedNow();
  trial.Expect(exit_code == 2, "a second controller ends with " + std::to_string(exit_code));
  trial.RecoveredIn(trial.state());
  const auto after = trial.observer().GetStatus();
  trial.Require(before.ok() && after.ok(), "the first controller does not answer");
  trial.Expect(before.value() == after.value(), "the first controller was disturbed");
}

void TakenOver(Trial& trial) {
  TakeOver(trial);
  const std::string state = trial.observer().Latest()->state;
  trial.Expect(state == trial.state(), "the machine is " + state + " after the take-over");
}

void TakenOverFrozen(Trial& trial) {
  kill(trial.robot.ControllerPid(), SIGSTOP);
  const auto before = trial.observer().Latest();
  trial.ControllerMayDie();
  trial.Struck();
  trial.robot.StartController({"--takeover"});
  const int first = trial.robot.AwaitEndOfFirst();
  trial.Expect(first == 1, "the first front ends with " + std::to_string(first) + ", not 1");
  trial.DetectedNow();
  trial.Require(trial.robot.AwaitSettled(), "the second controller does not adopt the robot");
  trial.RecoveredNow();
  trial.Expect(trial.observer().Latest()->epoch > before->epoch, "the epoch has not grown");
}

void TakenOverInSwitch(Trial& trial) {
  const std::string target = trial.state() == "Active" ? "LowPower" : "Active";
  trial.MayBecome(target);
  for (const std::string& name : Modules()) trial.robot.board(name).callback_ms = 150;
  const auto begun = trial.observer().Once(
      [target](const auto& status) { return status.target == target; }, [] {});
  const auto answer = trial.observer().SetState(target);
  Answer(begun);
  TakeOver(trial);
  for (const std::string& name : Modules()) Relieve(trial.robot.board(name));
  const std::string state = trial.observer().Latest()->state;
  trial.Expect(state == trial.state() || state == target, "the machine is " + state);
  if (target == "LowPower") trial.Expect(state == target, "a switch down was not finished");
}

void StoppedInSwitch(Trial& trial) {
  const std::string target = trial.state() == "Active" ? "LowPower" : "Active";
  trial.MayBecome(target);
  trial.RobotIsTornDown();
  for (const std::string& name : Modules()) trial.robot.board(name).callback_ms = 100;
  const pid_t pid = trial.robot.ControllerPid();
  const auto struck =
      trial.observer().Once([target](const auto& status) { return status.target == target; },
                            [pid] { kill(pid, SIGTERM); });
  const auto answer = trial.observer().SetState(target);
  Answer(struck);
  trial.Struck();
  trial.ExpectOutcome(Answer(answer), "superseded");
  trial.DetectedNow();
  trial.Require(trial.robot.AwaitControllerEnd(kPatience), "the machine does not end");
  trial.RecoveredNow();
}

}  // namespace musher::campaign::controller
