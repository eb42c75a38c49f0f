#pragma once
// The run of one fault: its robot, its measured times and its checks.
//
//   a settled robot in a sampled state ──▶ fault injected ──▶ detected ──▶ recovered ──▶ checked
//
// A kind checks with Expect(), which continues after a failure, or with Require(), which ends the
// run. CheckAlways() checks afterwards what holds for every fault.

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
  std::string sampled;  // what the random generator has chosen
  std::optional<double> detection_ms;
  std::optional<double> recovery_ms;
  double whole_ms = 0;
  std::vector<std::string> failures;
};

class FaultRun {
 public:
  using Is = Observer::Is;
  // Thrown to end a run that cannot continue; the reason is among the failures.
  struct Over {};

  FaultRun(Robot& on_robot, std::uint64_t seed) : robot(on_robot), random(seed) {}

  Observer& observer() { return robot.observer(); }
  // Brings the machine to a sampled state.
  void Begin();
  const std::string& state() const { return state_; }

  // Samples the actuator for the fault; its loss is then no failure.
  std::string Victim(const std::vector<std::string>& among);
  void MayBeAffected(const std::string& actuator) { affected_.insert(actuator); }
  void MayAllBeAffected();
  // Records a sampled parameter for the report of a failure.
  void Sampled(const std::string& what, const std::string& value);
  // A switch to this state is part of the run: the robot may become that active.
  void MayBecome(const std::string& state);
  // Before the fault: brings the machine to another state than the sampled one.
  void MoveTo(const std::string& state);
  // The controller is killed or replaced in this run: calls may remain without a reply.
  void ControllerMayDie() { controller_may_die_ = true; }
  // The run ends without a controller.
  void RobotIsTornDown() { torn_down_ = true; }
  bool controller_may_die() const { return controller_may_die_; }

  // The fault was injected now: times count from here. kRecovery: a fault that lasts has ended,
  // only the recovery time counts from here.
  enum class Clock { kBoth, kRecovery };
  void FaultInjected(Clock clock = Clock::kBoth);
  Time injected_at() const { return injected_at_; }

  void Expect(bool holds, const std::string& what);
  void Require(bool holds, const std::string& what);
  void ExpectOutcome(const Result<msg::SetState::Response>& reply, const std::string& outcome);
  // Waits for a status since the fault that reports it.
  void Detected(const std::string& what, const Is& is, Duration timeout = kTimeout);
  // For what is detected by other means than a status.
  void DetectedNow();
  void RecoveredNow();
  // Waits until the machine is in the state that is expected after the fault.
  void Recovered(const std::string& what, const Is& is, Duration timeout = kTimeout);
  void RecoveredIn(const std::string& state, const std::set<std::string>& without = {});
  // The same for an actuator that has not passed its self-check: it is listed as degraded until an
  // operator requests another self-check.
  void PassesSelfCheckLater(const std::string& victim, const std::string& state);
  // Waits for `time` while the fault lasts.
  void LetPass(Duration time);

  // Checks what holds for every fault.
  void CheckAlways();

  Robot& robot;
  Random random;
  Outcome outcome;

 private:
  void ForgetReports();
  void CheckOthers();
  void CheckActivity();
  void CheckSwitches();
  void CheckProcesses();

  std::string state_ = "Active";
  std::map<std::string, int> pids_;  // before the fault
  std::set<std::string> affected_;
  int ceiling_ = 0;
  bool controller_may_die_ = false;
  bool torn_down_ = false;
  Time begun_{};
  Time injected_at_{};
  Time recovers_from_{};
};

}  // namespace musher::fault_injection
