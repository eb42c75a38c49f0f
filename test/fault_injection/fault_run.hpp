#pragma once
// One fault: what it is given, what it measures, and what is judged of it.
//
//   a settled robot in a drawn state ──▶ the kind strikes ──▶ detected ──▶ recovered ──▶ judged
//
// A kind says what it expects with Expect() and goes on, or with Require() and is over when that
// does not hold. What holds for every fault is judged after it, by CheckAlways().

#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "musher/test/fault_injection/random.hpp"
#include "musher/test/fault_injection/robot/robot.hpp"

namespace musher::fault_injection {

struct Outcome {
  std::string kind;
  std::uint64_t seed = 0;
  std::string drawn;  // what the seed has chosen
  std::optional<double> detection_ms;
  std::optional<double> recovery_ms;
  double whole_ms = 0;
  std::vector<std::string> failures;
};

class FaultRun {
 public:
  using Is = Observer::Is;
  // Ends a run that cannot go on; the reason is among the failures.
  struct Over {};

  FaultRun(Robot& on_robot, std::uint64_t seed) : robot(on_robot), random(seed) {}

  Observer& observer() { return robot.observer(); }
  // The state that the machine was brought to.
  void Begin();
  const std::string& state() const { return state_; }

  // Draws an actuator to be hurt; it may end, and does not count among the others any more.
  std::string Victim(const std::vector<std::string>& among);
  void MayBeHurt(const std::string& actuator) { hurt_.insert(actuator); }
  void MayAllBeHurt();
  // For what the seed has chosen: appears in the report of a failure.
  void Drawn(const std::string& what, const std::string& value);
  // A switch to this state is part of the run: so active the robot may become.
  void MayBecome(const std::string& state);
  // Before the fault: another state of the machine than the one drawn.
  void MoveTo(const std::string& state);
  // The controller is killed or replaced in this run: calls may remain without an answer.
  void ControllerMayDie() { controller_may_die_ = true; }
  // There is no controller at its end.
  void RobotIsTornDown() { torn_down_ = true; }
  bool controller_may_die() const { return controller_may_die_; }

  // The fault is done now; times count from here. kRecovery: only that of the recovery, which a
  // fault that lasts has to end for.
  enum class Clock { kBoth, kRecovery };
  void Struck(Clock clock = Clock::kBoth);
  Time struck() const { return struck_; }

  void Expect(bool holds, const std::string& what);
  void Require(bool holds, const std::string& what);
  void ExpectOutcome(const Result<msg::SetState::Response>& answer, const std::string& outcome);
  // Waits for a status since the fault that tells of it.
  void Detected(const std::string& what, const Is& is, Duration patience = kPatience);
  // For what is known by other means than a status: by now.
  void DetectedNow();
  void RecoveredNow();
  // Waits until the machine is so: what is promised after the fault.
  void Recovered(const std::string& what, const Is& is, Duration patience = kPatience);
  void RecoveredIn(const std::string& state, const std::set<std::string>& without = {});
  // The same for one that has not passed its self-check: it is listed as degraded until a person
  // has it checked once more.
  void PassesSelfCheckLater(const std::string& victim, const std::string& state);
  // Lets a drawn time go by; the fault does its work meanwhile.
  void LetPass(Duration time);

  // What is promised of every fault.
  void CheckAlways();

  Robot& robot;
  Random random;
  Outcome outcome;

 private:
  void ForgetWhatWasSaid();
  void CheckOthers();
  void CheckActivity();
  void CheckSwitches();
  void CheckProcesses();

  std::string state_ = "Active";
  std::map<std::string, int> pids_;  // before the fault
  std::set<std::string> hurt_;
  int ceiling_ = 0;
  bool controller_may_die_ = false;
  bool torn_down_ = false;
  Time begun_{};
  Time struck_{};
  Time recovers_from_{};
};

}  // namespace musher::fault_injection
