// The controller of another machine has begun on the host of an actuator, and has taken it.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::taken_actuator_test {

class TakenActuator : public OneController {
 protected:
  TakenActuator() {
    config_.actuators[0].command = {"run", "a"};
    config_.actuators[0].restart.policy = RestartPolicy::kAlways;
    config_.actuators[0].on_lost = kDeActive;
    StartUp();
    Of(0).process.pid = 700;  // which this controller has started there
    Of(0).process.host = Of(0).report.host = "board";
    Do(event::Vanished{0, kFirst, false, "it follows another machine now, cart", true});
  }
};

// A controller that could restart it waited for an exit that never came, in Active.
TEST_F(TakenActuator, TakesTheMachineToItsOnLost) {
  ObeyAll();
  EXPECT_EQ(machine_.state, kDeActive);
  EXPECT_EQ(Of(0).presence, Presence::kLost);
}

}  // namespace musher::testing::taken_actuator_test
