#pragma once
// A machine of logging states that is ticked every 20 ms.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/behavior/fsm/machine.hpp"
#include "musher/test/behavior/fsm/logging_state.hpp"

namespace musher::fsm {

inline constexpr Duration kStep = Milliseconds(20);

class MachineFixture : public ::testing::Test {
 protected:
  LoggingState& Add(const std::string& name, std::vector<std::string> transitions = {},
                    Role role = Role::kNormal) {
    return Add(machine_, name, std::move(transitions), role);
  }
  LoggingState& Add(Machine& machine, const std::string& name,
                    std::vector<std::string> transitions = {}, Role role = Role::kNormal) {
    auto state = std::make_unique<LoggingState>(name, log_, std::move(transitions));
    LoggingState& added = *state;
    machine.Add(name, std::move(state), role);
    return added;
  }
  void Start(std::string_view at) {
    const Result<> built = machine_.Build(at);
    ASSERT_TRUE(built) << built.error().message;
    ASSERT_TRUE(machine_.Start(now_));
  }
  void Run(int ticks = 1) {
    for (int i = 0; i < ticks; ++i) machine_.RunOnce(now_ += kStep);
  }
  std::string_view Current() const { return machine_.Name(machine_.current()); }

  Log log_;
  Machine machine_{{.name = "show"}};
  Time now_ = Time(std::chrono::hours(1));
};

}  // namespace musher::fsm
