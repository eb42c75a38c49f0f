#pragma once
// A simulated robot whose controller answers as CyberDog's manager, and an app that speaks with it.

#include <gmock/gmock.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/cyberdog/voice_policy.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/manager.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/service.hpp"

namespace musher::testing {

inline MachineConfig ManagedMachine(int actuators = 2) {
  MachineConfig config = MachineOf(actuators);
  config.name_space = "dog";
  for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
  config.policy.emplace();
  config.policy->manager = true;
  config.policy->battery.emplace();
  config.policy->low_power.emplace();
  cyberdog::CompletePolicy({}, *config.policy);
  return config;
}

class ManagedRobot : public ::testing::Test {
 protected:
  explicit ManagedRobot(MachineConfig config = ManagedMachine(), simulation::Script script = {})
      : robot_(1, std::move(config), std::move(script)), app_(robot_.network().MakeNode("app")) {
    Subscribe<msg::StateSwitchStatus>("state_switch_status",
                                      [this](const auto& status) { states_.push_back(status); });
    Subscribe<msg::SelfCheckStatus>("self_check_status",
                                    [this](const auto& status) { self_checks_.push_back(status); });
    battery_ = PublishFunction<msg::BmsStatus>("bms_status");
    robot_.on_record = [this](const action::Record& record) { records_.push_back(record); };
  }

  void BringUp() {
    robot_.StartController();
    ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
    Settle();
    states_.clear();
  }
  void Settle() { robot_.RunFor(Milliseconds(500)); }
  // Takes it there, however the manager's own rules stand to that.
  void Take(const State& state) {
    if (robot_.machine().state != state) {
      ASSERT_TRUE(robot_.Set(state)->done());
    }
    Settle();
    states_.clear();
  }
  const State& state() const { return robot_.machine().state; }

  // The answer to a request; a failure when there is none within a minute.
  template <msg::Service S>
  typename S::Response Call(const std::string& name, const typename S::Request& request = {}) {
    auto client = transport::MakeClient<S>(*app_, "dog/" + name).value();
    std::optional<Result<typename S::Response>> answer;
    client->Call(request, std::chrono::minutes(1), [&](auto reply) { answer = std::move(reply); });
    EXPECT_TRUE(robot_.RunUntil([&] { return answer.has_value(); })) << name;
    EXPECT_TRUE(answer && answer->ok()) << name;
    return answer && answer->ok() ? answer->value() : typename S::Response{};
  }
  msg::Trigger::Response Trigger(const std::string& name) { return Call<msg::Trigger>(name); }
  msg::SetBool::Response SetBool(const std::string& name, bool data) {
    return Call<msg::SetBool>(name, {data});
  }
  // Requests a state by its number, to be kept for so many seconds.
  msg::MachineState::Response Keep(std::uint8_t number, std::uint16_t ticks = 0) {
    return Call<msg::MachineState>("machine_state_switch_keep", {number, ticks});
  }
  void SetBattery(std::uint8_t percent, bool charging = false) {
    msg::BmsStatus status;
    status.batt_soc = percent;
    status.power_wired_charging = charging;
    status.batt_volt = 29'000;
    battery_(status);
    Settle();
  }

  template <msg::Message M>
  std::function<void(const M&)> PublishFunction(const std::string& name) {
    return [publisher = std::shared_ptr(transport::MakePublisher<M>(*app_, "dog/" + name).value())](
               const M& sample) { ASSERT_TRUE(publisher->Publish(sample).ok()); };
  }
  template <msg::Message M>
  void Subscribe(const std::string& name, std::function<void(const M&)> handler) {
    subscriptions_.push_back(
        transport::MakeSubscription<M>(
            *app_, "dog/" + name,
            [handler](const M& sample, const transport::SampleInfo&) { handler(sample); })
            .value());
  }
  // The messages of what went into the journal since the last call.
  std::string Records() {
    std::string text;
    for (const action::Record& record : std::exchange(records_, {})) {
      text += std::to_string(record.code) + " " + record.message + "\n";
    }
    return text;
  }
  // The states published since the last call: "2 0" or "3 -2(107)".
  std::string States() {
    Settle();
    std::string text;
    for (const msg::StateSwitchStatus& status : std::exchange(states_, {})) {
      text += (text.empty() ? "" : " ") + std::to_string(status.state);
      if (status.code != 0) text += "(" + std::to_string(status.code) + ")";
    }
    return text;
  }

  simulation::SimRobot robot_;
  std::unique_ptr<transport::Node> app_;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
  std::function<void(const msg::BmsStatus&)> battery_;
  std::vector<msg::StateSwitchStatus> states_;
  std::vector<msg::SelfCheckStatus> self_checks_;
  std::vector<action::Record> records_;
};

}  // namespace musher::testing
