#pragma once
// The machine that the tests draw and show.

#include <gtest/gtest.h>

#include <string>

#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher::cli {

inline constexpr const char* kRobotToml = R"(
[controller]
name = "dog"
actuators = ["legs", "eyes"]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "LowPower", "Error"]
default_time = 1000
default_state = "Uninitialized"

[actuator.legs]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "LowPower", "Error"]
times = [1, 2, 3, 4, 5, 6]
critical = true

[actuator.eyes]
states = ["SetUp", "TearDown", "SelfCheck", "Active"]
times = [1, 2, 3, 4]
stage = 2
after = ["legs"]
)";

inline MachineConfig RobotConfig() {
  const ConfigReading reading = ReadConfigText(kRobotToml, "dog.toml");
  if (!reading.config) {
    for (const Diagnostic& d : reading.diagnostics) ADD_FAILURE() << FormatDiagnostic(d);
  }
  return reading.config.value_or(MachineConfig{});
}

// Active and on its way to LowPower, the eyes degraded.
inline msg::MachineStatus RobotStatus() {
  msg::MachineStatus status;
  status.machine = "dog";
  status.name_space = "pack";
  status.phase = "running";
  status.state = "Active";
  status.target = "LowPower";
  status.epoch = 3;
  status.switch_number = 12;
  status.pid = 100;
  status.host = "here";
  status.config_file = "dog.toml";
  status.config_hash = "cafe";
  status.degraded = {"eyes"};
  msg::ActuatorInfo legs{"legs", "Active", "LowPower", "present", 101,    "here", 1,     true,
                         false,  false,    0,          "",        "well", 0,      false, "musher"};
  msg::ActuatorInfo eyes{"eyes", "SetUp", "",  "lost",   0,         "here", 2,    false,
                         true,   true,    107, "gone\n", "crashed", 2,      true, "musher"};
  status.actuators = {legs, eyes};
  return status;
}

}  // namespace musher::cli
