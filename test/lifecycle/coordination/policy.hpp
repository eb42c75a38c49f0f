#pragma once
// The fixture of the policy tests: a robot with all rules.

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "musher/lifecycle/policy/policy.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing {

inline MachineConfig WithPolicy(int actuators = 2) {
  MachineConfig config = MachineOf(actuators);
  PolicyConfig& policy = config.policy.emplace();
  BatteryPolicy& battery = policy.battery.emplace();
  battery.tear_down_after = battery.raise_after = std::chrono::seconds(1);
  policy.low_power.emplace().motion_ids = {0, 101};
  return config;
}

class Rules : public Switching {
 protected:
  // A robot in `state` whose states are noted from now on.
  Harness& Robot(const State& state = "Active", MachineConfig config = WithPolicy()) {
    harness_ = &In(state, std::move(config));
    harness_->after_step = [this] {
      const State& now = harness_->machine().state;
      if (states_.empty() || states_.back() != now) states_.push_back(now);
    };
    return *harness_;
  }
  Harness& robot() { return *harness_; }
  const State& state() { return robot().machine().state; }
  const PolicyState& policy() { return robot().machine().policy; }
  // The states that the machine has been in since Robot().
  std::vector<State>& states() { return states_; }

  // For two seconds, long enough to confirm it.
  void Battery(int percent, bool charging = false, std::uint32_t source = 0) {
    for (int i = 0; i < 4; ++i) {
      robot().Feed(event::BatterySeen{percent, charging, source});
      robot().RunFor(Milliseconds(500));
    }
  }
  void Motion(std::int32_t id) { robot().Feed(event::MotionSeen{id}); }

  RequestId RequestPolicy(PolicyRequest what, bool enable = false) {
    return robot().SendPolicyRequest({0, what, "", 0, enable});
  }
  RequestId Keep(const State& wanted, std::int64_t seconds) {
    return robot().SendPolicyRequest({0, PolicyRequest::kKeep, wanted, seconds, false});
  }
  // Sends a request, and returns the answer after two seconds.
  std::string RequestAndWait(PolicyRequest what, bool enable = false) {
    return AnswerTo(RequestPolicy(what, enable));
  }
  std::string KeepAndWait(const State& wanted, std::int64_t seconds) {
    return AnswerTo(Keep(wanted, seconds));
  }
  std::string AnswerTo(RequestId request) {
    robot().RunFor(std::chrono::seconds(2));
    const auto answer = robot().calls.find(request);
    return answer == robot().calls.end() ? "no answer" : Text(answer->second);
  }
  // "113: the battery is at …", or "ok".
  static std::string Text(const Result<>& answer) {
    if (answer.ok()) return "ok";
    return std::to_string(answer.error().code) + ": " + answer.error().message;
  }
  // `what`: an EventName or a RecordText.
  template <class What>
  action::Record RecordWith(const What& what) {
    return testing::RecordWith(robot().whole_records, what);
  }
  template <class What>
  bool IsRecorded(const What& what) {
    return testing::IsRecorded(robot().records, what);
  }
  template <class What>
  Records Why(const What& what) {
    return testing::Why(robot().whole_records, what);
  }

 private:
  Harness* harness_ = nullptr;
  std::vector<State> states_;
};

}  // namespace musher::testing
