// kill -9 of the controller at every moment of a switch, then another one.

#include <signal.h>

#include "musher/test/campaign/faults/controller.hpp"

namespace musher::campaign::controller {
namespace {

constexpr int kSlowCallbackMs = 120;  // a status that is told once a while is told meanwhile

struct Case {
  std::string target;     // of the switch it dies in; "": none
  Observer::When moment;  // none: at once
};

bool IsUp(const Trial& trial, const std::string& target) {
  return RankOf(target) > RankOf(trial.state());
}

Case CaseFor(Trial& trial, Moment moment) {
  if (moment == Moment::kAtRest) return {"", {}};
  if (moment == Moment::kSelfCheck) {
    return {"SelfCheck", [](const auto& status) { return status.target == "SelfCheck"; }};
  }
  if (moment == Moment::kRollback) {
    if (trial.state() == "Active") trial.MoveTo("DeActive");
    const std::string before = trial.state();
    // hands come last on the way up: legs and arm are there by then.
    trial.robot.board("hands").fail_in = IndexOfState("Active");
    trial.MayBecome("Active");
    return {"Active", [before](const auto& s) { return s.target == before; }};
  }
  std::vector<std::string> others;
  for (const char* state : {"Active", "Protected", "DeActive", "LowPower"}) {
    if (state != trial.state()) others.emplace_back(state);
  }
  const std::string target = trial.random.Pick(others);
  trial.MayBecome(target);
  if (moment == Moment::kRequested) return {target, {}};
  if (moment == Moment::kCommandsOut) {
    return {target, [target](const auto& status) { return status.target == target; }};
  }
  return {target, [target](const auto& s) { return s.state == target && s.target.empty(); }};
}

// A switch that died on the way down is finished; one on the way up is undone, unless all had
// arrived.
void JudgeWhereItEnded(Trial& trial, const Case& fault, bool begun) {
  const std::string state = trial.observer().Latest()->state;
  const std::string what = "the machine is " + state + " after it was killed on the way from " +
                           trial.state() + " to " + fault.target;
  const bool stays = fault.target.empty() || fault.target == "SelfCheck";
  if (stays) return trial.Expect(state == trial.state(), what);
  trial.Expect(state == trial.state() || state == fault.target, what);
  if (begun && !IsUp(trial, fault.target)) trial.Expect(state == fault.target, what);
}

std::set<std::string> Missing(const msg::MachineStatus& status) {
  std::set<std::string> missing;
  for (const msg::ActuatorInfo& info : status.actuators) {
    const bool gone = info.presence != "present" && info.degraded && !info.restarting;
    if (gone) missing.insert(info.name);
  }
  return missing;
}

}  // namespace

void KilledAt(Trial& trial, Moment moment) {
  trial.ControllerMayDie();
  const Case fault = CaseFor(trial, moment);
  if (!fault.target.empty()) trial.Drawn("to", fault.target);
  for (const std::string& name : Modules()) trial.robot.board(name).callback_ms = kSlowCallbackMs;
  const pid_t pid = trial.robot.ControllerPid();
  trial.Require(pid != 0, "there is no controller to kill");
  std::shared_future<void> killed;
  if (fault.moment) {
    killed = trial.observer().Once(fault.moment, [pid] { kill(pid, SIGKILL); });
  }
  std::shared_future<Result<msg::SetState::Response>> answer;
  if (!fault.target.empty()) answer = trial.observer().SetState(fault.target);
  if (fault.moment) {
    Answer(killed);
  } else {
    const auto wait = moment == Moment::kRequested ? trial.random.Between(0, 3) : 0;
    trial.Drawn("after", std::to_string(wait) + " ms");
    trial.LetPass(Milliseconds(wait));
    kill(pid, SIGKILL);
  }
  trial.Struck();
  trial.Require(trial.robot.AwaitControllerEnd(kPatience), "the controller is not dead");
  trial.DetectedNow();  // its front has told the person
  for (const std::string& name : Modules()) Relieve(trial.robot.board(name));
  trial.robot.StartController();
  trial.Require(trial.robot.AwaitSettled(), "the next controller does not adopt the robot");
  trial.RecoveredNow();
  JudgeWhereItEnded(trial, fault, static_cast<bool>(fault.moment));
}

void KilledInStartUp(Trial& trial) {
  trial.ControllerMayDie();
  trial.MayAllBeHurt();
  trial.MayBecome("Active");
  trial.robot.Down();
  const std::string at =
      trial.random.Pick(std::vector<std::string>{"SetUp", "SelfCheck", "Active"});
  trial.Drawn("at", at);
  for (const std::string& name : Modules()) trial.robot.board(name).callback_ms = kSlowCallbackMs;
  // By then its children are there, and their parent is the front's child.
  Robot& robot = trial.robot;
  const auto killed =
      trial.observer().Once([at](const auto& status) { return status.target == at; },
                            [&robot] { kill(robot.ControllerPid(), SIGKILL); });
  robot.StartController();
  Answer(killed);
  trial.Struck();
  trial.Require(robot.AwaitControllerEnd(kPatience), "the controller is not dead");
  trial.DetectedNow();
  for (const std::string& name : Modules()) Relieve(robot.board(name));
  robot.StartController();
  trial.RecoveredIn("Active");
}

// The next one ends what was begun, if it finds anybody in the middle of it; else it goes on from
// whom it finds, or starts the robot.
void KilledInStop(Trial& trial) {
  trial.ControllerMayDie();
  trial.MayBecome("Active");
  trial.RobotIsTornDown();
  for (const std::string& name : Modules()) trial.robot.board(name).callback_ms = kSlowCallbackMs;
  const pid_t pid = trial.robot.ControllerPid();
  const auto killed =
      trial.observer().Once([](const auto& status) { return status.target == "TearDown"; },
                            [pid] { kill(pid, SIGKILL); });
  const auto answer = trial.observer().SetState("TearDown");
  Answer(killed);
  trial.Struck();
  trial.Require(trial.robot.AwaitControllerEnd(kPatience), "the controller is not dead");
  trial.DetectedNow();
  for (const std::string& name : Modules()) Relieve(trial.robot.board(name));
  trial.robot.StartController();
  const auto over = [&] {
    if (trial.robot.ControllerHasEnded()) return true;
    const auto status = trial.observer().Latest();
    const bool leads = status && status->pid == trial.robot.ControllerPid();
    // Who was torn down already and may not be restarted is missing: for a person to decide.
    return leads && RankOf(status->state) > 0 &&
           IsSettled(*status, status->state, Missing(*status));
  };
  trial.Require(AwaitThat(over, kPatience), "the machine neither ends nor starts");
  trial.RecoveredNow();
}

}  // namespace musher::campaign::controller
