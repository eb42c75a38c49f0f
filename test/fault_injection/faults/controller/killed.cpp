// kill -9 of the controller at every moment of a switch, then another one.

#include <signal.h>

#include "musher/test/fault_injection/faults/controller.hpp"

namespace musher::fault_injection::controller {
namespace {

constexpr int kSlowCallbackMs = 120;  // a status that is told once a while is told meanwhile

struct Case {
  std::string target;     // of the switch it dies in; "": none
  Observer::When moment;  // none: at once
};

bool IsUp(const FaultRun& run, const std::string& target) {
  return RankOf(target) > RankOf(run.state());
}

Case CaseFor(FaultRun& run, Moment moment) {
  if (moment == Moment::kAtRest) return {"", {}};
  if (moment == Moment::kSelfCheck) {
    return {"SelfCheck", [](const auto& status) { return status.target == "SelfCheck"; }};
  }
  if (moment == Moment::kRollback) {
    if (run.state() == "Active") run.MoveTo("DeActive");
    const std::string before = run.state();
    // hands come last on the way up: legs and arm are there by then.
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
  if (moment == Moment::kRequested) return {target, {}};
  if (moment == Moment::kCommandsOut) {
    return {target, [target](const auto& status) { return status.target == target; }};
  }
  return {target, [target](const auto& s) { return s.state == target && s.target.empty(); }};
}

// A switch that died on the way down is finished; one on the way up is undone, unless all had
// arrived.
void CheckWhereItEnded(FaultRun& run, const Case& fault, bool begun) {
  const std::string state = run.observer().Latest()->state;
  const std::string what = "the machine is " + state + " after it was killed on the way from " +
                           run.state() + " to " + fault.target;
  const bool stays = fault.target.empty() || fault.target == "SelfCheck";
  if (stays) return run.Expect(state == run.state(), what);
  run.Expect(state == run.state() || state == fault.target, what);
  if (begun && !IsUp(run, fault.target)) run.Expect(state == fault.target, what);
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

void KilledAt(FaultRun& run, Moment moment) {
  run.ControllerMayDie();
  const Case fault = CaseFor(run, moment);
  if (!fault.target.empty()) run.Drawn("to", fault.target);
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = kSlowCallbackMs;
  const pid_t pid = run.robot.LivingController();
  std::shared_future<void> killed;
  if (fault.moment) {
    killed = run.observer().Once(fault.moment, [pid] { kill(pid, SIGKILL); });
  }
  std::shared_future<Result<msg::SetState::Response>> answer;
  if (!fault.target.empty()) answer = run.observer().SetState(fault.target);
  if (fault.moment) {
    Answer(killed);
  } else {
    const auto wait = moment == Moment::kRequested ? run.random.Between(0, 3) : 0;
    run.Drawn("after", std::to_string(wait) + " ms");
    run.LetPass(Milliseconds(wait));
    kill(pid, SIGKILL);
  }
  run.Struck();
  run.Require(run.robot.AwaitControllerEnd(kPatience), "the controller is not dead");
  run.DetectedNow();  // its front has told the person
  for (const std::string& name : Modules()) Relieve(run.robot.board(name));
  run.robot.StartController();
  run.Require(run.robot.AwaitSettled(), "the next controller does not adopt the robot");
  run.RecoveredNow();
  CheckWhereItEnded(run, fault, static_cast<bool>(fault.moment));
}

void KilledInStartUp(FaultRun& run) {
  run.ControllerMayDie();
  run.MayAllBeHurt();
  run.MayBecome("Active");
  run.robot.Down();
  const std::string at = run.random.Pick(std::vector<std::string>{"SetUp", "SelfCheck", "Active"});
  run.Drawn("at", at);
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = kSlowCallbackMs;
  // By then its children are there, and their parent is the front's child.
  Robot& robot = run.robot;
  const auto killed = run.observer().Once([at](const auto& status) { return status.target == at; },
                                          [&robot] {
                                            if (const pid_t pid = robot.ControllerPid(); pid > 0)
                                              kill(pid, SIGKILL);
                                          });
  robot.StartController();
  Answer(killed);
  run.Struck();
  run.Require(robot.AwaitControllerEnd(kPatience), "the controller is not dead");
  run.DetectedNow();
  for (const std::string& name : Modules()) Relieve(robot.board(name));
  robot.StartController();
  run.RecoveredIn("Active");
}

// The next one ends what was begun, if it finds anybody in the middle of it; else it goes on from
// whom it finds, or starts the robot.
void KilledInStop(FaultRun& run) {
  run.ControllerMayDie();
  run.MayBecome("Active");
  run.RobotIsTornDown();
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = kSlowCallbackMs;
  const pid_t pid = run.robot.LivingController();
  const auto killed =
      run.observer().Once([](const auto& status) { return status.target == "TearDown"; },
                          [pid] { kill(pid, SIGKILL); });
  const auto answer = run.observer().SetState("TearDown");
  Answer(killed);
  run.Struck();
  run.Require(run.robot.AwaitControllerEnd(kPatience), "the controller is not dead");
  run.DetectedNow();
  for (const std::string& name : Modules()) Relieve(run.robot.board(name));
  run.robot.StartController();
  const auto over = [&] {
    if (run.robot.ControllerHasEnded()) return true;
    const auto status = run.observer().Latest();
    const bool leads = status && status->pid == run.robot.ControllerPid();
    // Who was torn down already and may not be restarted is missing: for a person to decide.
    return leads && RankOf(status->state) > 0 &&
           IsSettled(*status, status->state, Missing(*status));
  };
  run.Require(AwaitThat(over, kPatience), "the machine neither ends nor starts");
  run.RecoveredNow();
}

}  // namespace musher::fault_injection::controller
