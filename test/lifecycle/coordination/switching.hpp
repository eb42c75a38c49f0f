#pragma once
// The fixture of the switch tests: a machine in some state, its log empty.

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/lifecycle/coordination/records.hpp"

namespace musher::testing {

class Switching : public ::testing::Test {
 protected:
  // A machine in `state`, its log empty.
  Harness& In(const State& state, MachineConfig config = MachineOf(3)) {
    harness_.emplace(std::move(config));
    harness_->Begin();
    harness_->Rest();
    EXPECT_EQ(harness_->machine().state, "Active");
    if (state != "Active") {
      EXPECT_TRUE(harness_->Set(state).done());
    }
    harness_->ClearLog();
    return *harness_;
  }

  static const ActuatorResult& Of(const SwitchResult& result, const std::string& name) {
    for (const ActuatorResult& actuator : result.actuators) {
      if (actuator.name == name) return actuator;
    }
    static const ActuatorResult none{"none of that name", ActuatorOutcome::kLost, -1, "", {}, ""};
    ADD_FAILURE() << "no result for " << name;
    return none;
  }

 private:
  std::optional<Harness> harness_;
};

// Processes that the controller starts, and restarts after 100, 200, 400 ms.
inline MachineConfig Ours(int actuators) {
  MachineConfig config = MachineOf(actuators);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.command = {"run", actuator.name};
    actuator.restart.policy = RestartPolicy::kOnFailure;
    actuator.restart.limit = 3;
    actuator.restart.reset_after = std::chrono::seconds(5);
  }
  return config;
}

// The same, b critical.
inline MachineConfig OursWithCriticalB(int actuators = 3) {
  MachineConfig config = Ours(actuators);
  ActuatorNamed(config, "b").critical = true;
  ActuatorNamed(config, "b").on_lost = "Protected";
  return config;
}

inline MachineConfig Chain() {  // a comes after b comes after c
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "a").after = {"b"};
  ActuatorNamed(config, "b").after = {"c"};
  return config;
}

}  // namespace musher::testing
