// SIGKILL of the controller in every phase of a switch, then the next controller.

#include <signal.h>

#include "musher/test/fault_injection/faults/controller.hpp"

namespace musher::fault_injection::controller {
namespace {

constexpr int kSlowCallbackMs = 120;  // long enough for a periodic status meanwhile

struct Case {
  std::string target;    // of the switch in which it is killed; "": none
  Observer::When phase;  // none: at once
};

bool IsUp(const FaultRun& run, const std::string& target) {
  return RankOf(target) > RankOf(run.state());
}

Case CaseFor(FaultRun& run, SwitchPhase phase) {
  if (phase == SwitchPhase::kAtRest) return {"", {}};
  if (phase == SwitchPhase::kSelfCheck) {
    return {"SelfCheck", [](const auto& status) { return status.target == "SelfCheck"; }};
  }
  if (phase == SwitchPhase::kRollback) {
    if (run.state() == "Active") run.MoveTo("DeActive");
    const std::string before = run.state();
    // hands are the last to switch up: legs and arm are in Active by then.
    run.robot.board("hands").fail_in = IndexOfState("Active");
    run.MayBecome("Active");
    return {"Active", [before](const auto& s) { return s.target == before; }};
  }
  std::vector<std::string> others;
  for (const char* state : {"Active", "Protected", "DeActive", "LowPower"}) {
    if (state != run.state()) others.emplace_back(state);
  }
  const std::string target = run.random.Pick(others);
  run.MayBecome(target);
  if (phase == SwitchPhase::kRequested) return {target, {}};
  if (phase == SwitchPhase::kCommandsOut) {
    return {target, [target](const auto& status) { return status.target == target; }};
  }
  return {target, [target](const auto& s) { return s.state == target && s.target.empty(); }};
}

// An interrupted switch down is finished; one up is undone, unless all actuators had reached the
// target.
void CheckFinalState(FaultRun& run, const Case& fault, bool began) {
  const std::string state = run.observer().Latest()->state;
  const std::string what = "the machine is " + state +
                           " after the controller was killed in a switch from " + run.state() +
                           " to " + fault.target;
  const bool stays = fault.target.empty() || fault.target == "SelfCheck";
  if (stays) return run.Expect(state == run.state(), what);
  run.Expect(state == run.state() || state == fault.target, what);
  if (began && !IsUp(run, fault.target)) run.Expect(state == fault.target, what);
}

std::set<std::string> Missing(const msg::MachineStatus& status) {
  std::set<std::string> missing;
  for (const msg::ActuatorInfo& info : status.actuators) {
    const bool gone = info.presence != "present" && info.degraded && !info.restarting;
    if (gone) missing.insert(info.name);
  }
  return missing;
}

// A robot that is found in SelfCheck stays there until a person leads it on.
void LeadOnFromSelfCheck(FaultRun& run, std::uint64_t killed_epoch) {
  const auto is_over = [killed_epoch](const msg::MachineStatus& status) {
    return status.epoch > killed_epoch && (status.phase == "failed" || IsSettled(status, "Active"));
  };
  run.Require(run.observer().Await(is_over, kTimeout).has_value(),
              "the start of the next controller does not end");
  if (run.observer().Latest()->phase != "failed") return;
  run.ExpectOutcome(AwaitFuture(run.observer().SetState("SelfCheck")), "done");
  run.ExpectOutcome(AwaitFuture(run.observer().SetState("Active")), "done");
  // A start that has failed leaves its controller without a launcher.
  run.Require(run.robot.AwaitControllerEnd(kTimeout), "the launcher of the failed start stays");
  run.robot.StartController({"--takeover"});
  run.Require(run.robot.AwaitSettled("Active"), "the controller after it does not lead");
}

}  // namespace

void KilledAt(FaultRun& run, SwitchPhase phase) {
  run.ControllerMayDie();
  const Case fault = CaseFor(run, phase);
  if (!fault.target.empty()) run.Sampled("to", fault.target);
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = kSlowCallbackMs;
  const pid_t pid = run.robot.RunningController();
  std::shared_future<void> killed;
  if (fault.phase) {
    killed = run.observer().Once(fault.phase, [pid] { kill(pid, SIGKILL); });
  }
  std::shared_future<Result<msg::SetState::Response>> reply;
  if (!fault.target.empty()) reply = run.observer().SetState(fault.target);
  if (fault.phase) {
    AwaitFuture(killed);
  } else {
    const auto wait = phase == SwitchPhase::kRequested ? run.random.Between(0, 3) : 0;
    run.Sampled("after", std::to_string(wait) + " ms");
    run.LetPass(Milliseconds(wait));
    kill(pid, SIGKILL);
  }
  run.FaultInjected();
  run.Require(run.robot.AwaitControllerEnd(kTimeout), "the controller has not ended");
  run.DetectedNow();  // its launcher has reported it
  for (const std::string& name : Modules()) ClearFaults(run.robot.board(name));
  run.robot.StartController();
  run.Require(run.robot.AwaitSettled(), "the next controller does not adopt the robot");
  run.RecoveredNow();
  CheckFinalState(run, fault, static_cast<bool>(fault.phase));
}

void KilledInStartUp(FaultRun& run) {
  run.ControllerMayDie();
  run.MayAllBeAffected();
  run.MayBecome("Active");
  run.robot.Down();
  const std::string at = run.random.Pick(std::vector<std::string>{"SetUp", "SelfCheck", "Active"});
  run.Sampled("at", at);
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = kSlowCallbackMs;
  // By then its children run, and their parent is the launcher's child.
  Robot& robot = run.robot;
  const auto killed = run.observer().Once([at](const auto& status) { return status.target == at; },
                                          [&robot] {
                                            if (const pid_t pid = robot.ControllerPid(); pid > 0)
                                              kill(pid, SIGKILL);
                                          });
  robot.StartController();
  AwaitFuture(killed);
  run.FaultInjected();
  run.Require(robot.AwaitControllerEnd(kTimeout), "the controller has not ended");
  run.DetectedNow();
  for (const std::string& name : Modules()) ClearFaults(robot.board(name));
  const std::uint64_t killed_epoch = run.observer().Latest()->epoch;
  robot.StartController();
  LeadOnFromSelfCheck(run, killed_epoch);
  run.RecoveredIn("Active");
}

// The next controller finishes the TearDown if it finds an actuator in the middle of it; else it
// adopts the running actuators, or starts the robot.
void KilledInStop(FaultRun& run) {
  run.ControllerMayDie();
  run.MayBecome("Active");
  run.RobotIsTornDown();
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = kSlowCallbackMs;
  const pid_t pid = run.robot.RunningController();
  const auto killed =
      run.observer().Once([](const auto& status) { return status.target == "TearDown"; },
                          [pid] { kill(pid, SIGKILL); });
  const auto reply = run.observer().SetState("TearDown");
  AwaitFuture(killed);
  run.FaultInjected();
  run.Require(run.robot.AwaitControllerEnd(kTimeout), "the controller has not ended");
  run.DetectedNow();
  for (const std::string& name : Modules()) ClearFaults(run.robot.board(name));
  run.robot.StartController();
  const auto over = [&] {
    if (run.robot.ControllerHasEnded()) return true;
    const auto status = run.observer().Latest();
    const bool leads = status && status->pid == run.robot.ControllerPid();
    // An actuator that was torn down already and is not restarted is missing, until an operator
    // acts.
    return leads && RankOf(status->state) > 0 &&
           IsSettled(*status, status->state, Missing(*status));
  };
  run.Require(AwaitThat(over, kTimeout), "the machine neither ends nor starts");
  run.RecoveredNow();
}

}  // namespace musher::fault_injection::controller
