#pragma once
// The fixture of the actuator tests: one actuator and its one controller.

#include <gtest/gtest.h>

#include <vector>

#include "musher/base/code.hpp"
#include "musher/lifecycle/actuator/actuator_core.hpp"

namespace musher::testing {

using Actions = std::vector<ActuatorAction>;

class OneActuator : public ::testing::Test {
 protected:
  OneActuator() {
    ActuatorConfig audio;
    audio.name = "audio";
    for (const BuiltInState state :
         {kSetUp, kSelfCheck, kActive, kDeActive, kLowPower, kTearDown}) {
      audio.states.emplace_back(state);
      audio.times.push_back(Milliseconds(100));
      if (const auto rank = BuiltInRank(state)) config_.ranks[state] = *rank;
    }
    config_.actuators.push_back(audio);
    core_.report.incarnation = 77;
    Announce(1);
  }

  Actions Do(const ActuatorEvent& event) { return Step(config_, 0, core_, event, now_); }

  // The controller of an epoch.
  static Sender SenderOf(Epoch epoch) { return Sender(epoch.value()); }

  // A heartbeat of the controller of an epoch, the sender of Command().
  void Announce(Epoch epoch) {
    Do(actuator_event::ControllerHeartbeatReceived{SenderOf(epoch), epoch});
  }

  void SetUpIt() {
    Do(actuator_event::Started{});
    Do(actuator_event::CallbackEnded{});
  }

  // An up-to-date command, number n.
  actuator_event::SwitchArrived Command(CommandNumber n, const State& target, Epoch epoch = 1) {
    return {++token_, {epoch, n, target, Milliseconds(100), now_, {}, 77}, SenderOf(epoch)};
  }

  // Takes it to `state` by command n.
  void Switch(CommandNumber n, const State& target) {
    Do(Command(n, target));
    Do(actuator_event::CallbackEnded{});
    EXPECT_EQ(core_.report.state, target);
  }

  static std::vector<actuator_action::Answer> AnswersIn(const Actions& actions) {
    std::vector<actuator_action::Answer> answers;
    for (const ActuatorAction& action : actions) {
      if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) {
        answers.push_back(*answer);
      }
    }
    return answers;
  }
  static const actuator_action::Answer& AnswerIn(const Actions& actions) {
    for (const ActuatorAction& action : actions) {
      if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) return *answer;
    }
    static const actuator_action::Answer none{0, Verdict::kFailed, -1, "no answer"};
    ADD_FAILURE() << "no answer among the actions";
    return none;
  }

  MachineConfig config_;
  ActuatorCore core_;
  Time now_ = Time(std::chrono::hours(1));
  RequestToken token_ = 0;
};

}  // namespace musher::testing
