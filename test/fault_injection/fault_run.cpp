#include "musher/test/fault_injection/fault_run.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>

namespace musher::fault_injection {
namespace {

double MillisecondsOf(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

Time TimeNow() {
  return std::chrono::steady_clock::now();
}

bool IsLost(const msg::ActuatorInfo& info) {
  return info.presence == "lost" || info.health == "hung" || info.health == "crashed" ||
         info.health == "partitioned";
}

}  // namespace

void FaultRun::Begin() {
  const std::vector<std::string> states = {"Active",    "Active",   "Active",
                                           "Protected", "DeActive", "LowPower"};
  state_ = random.Pick(states);
  Sampled("in", state_);
  robot.GoTo(state_);
  const auto rested = [](const msg::MachineStatus& status) {
    return std::all_of(status.actuators.begin(), status.actuators.end(),
                       [](const auto& info) { return info.restarts == 0; });
  };
  // Else the faults of earlier runs would count as restarts in a row.
  Require(observer().Await(rested, kTimeout).has_value(), "the restart counters are not reset");
  robot.ForgetLines();
  ForgetReports();
  const auto status = observer().Latest();
  for (const msg::ActuatorInfo& info : status->actuators) pids_[info.name] = info.pid;
  ceiling_ = RankOf(state_);
  begun_ = TimeNow();
  injected_at_ = begun_;
  recovers_from_ = begun_;
}

void FaultRun::MoveTo(const std::string& state) {
  Sampled("then in", state);
  robot.GoTo(state);
  state_ = state;
  ceiling_ = RankOf(state);
  ForgetReports();
}

// On a busy machine the reports of earlier states arrive late; they must not count as more active.
void FaultRun::ForgetReports() {
  Require(observer().AwaitAllIn(state_, kTimeout), "not all actuators report " + state_);
  observer().Forget();
}

std::string FaultRun::Victim(const std::vector<std::string>& among) {
  const std::string& name = random.Pick(among);
  Sampled("victim", name);
  MayBeAffected(name);
  return name;
}

void FaultRun::MayAllBeAffected() {
  for (const Member& member : Members()) MayBeAffected(member.name);
}

void FaultRun::Sampled(const std::string& what, const std::string& value) {
  outcome.sampled += (outcome.sampled.empty() ? "" : ", ") + what + " " + value;
}

void FaultRun::MayBecome(const std::string& state) {
  ceiling_ = std::max(ceiling_, RankOf(state));
}

void FaultRun::FaultInjected(Clock clock) {
  recovers_from_ = TimeNow();
  if (clock == Clock::kBoth) injected_at_ = recovers_from_;
}

void FaultRun::Expect(bool holds, const std::string& what) {
  if (!holds) outcome.failures.push_back(what);
}

void FaultRun::Require(bool holds, const std::string& what) {
  Expect(holds, what);
  if (!holds) throw Over{};
}

void FaultRun::ExpectOutcome(const Result<msg::SetState::Response>& reply,
                             const std::string& expected) {
  if (!reply) {
    Expect(false, "the switch has no outcome: " + reply.error().message);
  } else {
    const msg::SetState::Response& result = reply.value();
    Expect(result.outcome == expected, "the switch to " + result.target + " is " + result.outcome +
                                           ", not " + expected + ": " + result.reason);
  }
}

void FaultRun::Detected(const std::string& what, const Is& is, Duration timeout) {
  const auto at = observer().AwaitSince(injected_at_, is, timeout);
  Require(at.has_value(), "the status never reports: " + what);
  outcome.detection_ms = MillisecondsOf(*at - injected_at_);
}

void FaultRun::DetectedNow() {
  outcome.detection_ms = MillisecondsOf(TimeNow() - injected_at_);
}

void FaultRun::RecoveredNow() {
  outcome.recovery_ms = MillisecondsOf(TimeNow() - recovers_from_);
}

void FaultRun::Recovered(const std::string& what, const Is& is, Duration timeout) {
  const auto at = observer().Await(is, timeout);
  Require(at.has_value(), "it does not happen: " + what);
  outcome.recovery_ms = std::max(0.0, MillisecondsOf(*at - recovers_from_));
}

void FaultRun::RecoveredIn(const std::string& state, const std::set<std::string>& without) {
  std::string except;
  for (const std::string& name : without) except += " without " + name;
  Recovered("settled in " + state + except,
            [&](const msg::MachineStatus& status) { return IsSettled(status, state, without); });
}

void FaultRun::PassesSelfCheckLater(const std::string& victim, const std::string& state) {
  RecoveredIn(state, {victim});
  ExpectOutcome(AwaitFuture(observer().SetState("SelfCheck")), "done");
  const auto settled = [&](const msg::MachineStatus& s) { return IsSettled(s, state); };
  Require(observer().Await(settled, kTimeout).has_value(),
          victim + " is not available after its self-check");
}

void FaultRun::LetPass(Duration time) {
  const Time end = TimeNow() + time;
  AwaitThat([&] { return TimeNow() >= end; }, time + kTimeout);
}

void FaultRun::CheckAlways() {
  outcome.whole_ms = MillisecondsOf(TimeNow() - begun_);
  if (!torn_down_) {
    const auto status = observer().GetStatus();
    Expect(status.ok(), "the controller does not reply any more");
    CheckOthers();
  }
  CheckActivity();
  CheckSwitches();
  CheckProcesses();
}

// No actuator runs twice, whatever happens to the controllers, and none outlives its machine.
void FaultRun::CheckProcesses() {
  for (const auto& [name, count] : robot.StartedProcesses()) {
    const int most = torn_down_ && robot.ControllerHasEnded() ? 0 : 1;
    Expect(count <= most, name + " has " + std::to_string(count) + " processes, expected at most " +
                              std::to_string(most));
  }
}

// No actuator but the victims was reported as lost, or has another process.
void FaultRun::CheckOthers() {
  std::set<std::string> reported;
  for (const msg::MachineStatus& status : observer().Since(injected_at_)) {
    for (const msg::ActuatorInfo& info : status.actuators) {
      if (affected_.count(info.name) > 0 || reported.count(info.name) > 0) continue;
      const bool other_process = info.pid != 0 && info.pid != pids_[info.name];
      // A controller that has just begun has no reports yet.
      const bool unknown = status.phase != "running" && controller_may_die_;
      if (unknown || (!IsLost(info) && !other_process)) continue;
      reported.insert(info.name);
      outcome.failures.push_back("false loss: " + info.name + " is " + info.presence + ", " +
                                 info.health + ", process " + std::to_string(info.pid) + " after " +
                                 std::to_string(pids_[info.name]) + ": " + info.message);
    }
  }
}

// No actuator became more active than the machine was, or was commanded to become.
void FaultRun::CheckActivity() {
  std::set<std::string> reported;
  for (const msg::ActuatorStatus& status : observer().Reports()) {
    const std::string what = status.name + " in " + status.state;
    if (RankOf(status.state) <= ceiling_ || !reported.insert(what).second) continue;
    outcome.failures.push_back("more active than it was: " + what);
  }
}

// Each switch has at most one outcome; exactly one when its controller kept running.
void FaultRun::CheckSwitches() {
  static const std::regex end(R"(^switch (\d+) is (done|done-degraded|undone|refused|superseded))");
  std::map<std::pair<int, std::string>, int> ends;  // by controller and switch
  int controller = 0;
  for (const nlohmann::json& line : robot.Lines()) {
    const std::string message = line.value("message", "");
    if (message.find("releases control") != std::string::npos) ++controller;
    if (message.ends_with(" set up")) ++controller;
    std::smatch match;
    if (std::regex_search(message, match, end)) ++ends[{controller, match[1]}];
  }
  for (const auto& [which, count] : ends) {
    Expect(count == 1, "switch " + which.second + " has " + std::to_string(count) + " outcomes");
  }
}

}  // namespace musher::fault_injection
