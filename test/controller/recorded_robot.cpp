#include "musher/test/controller/recorded_robot.hpp"

#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/simulation/robot.hpp"

namespace musher {

std::string RobotToml(const std::string& on_lost) {
  return R"([controller]
actuators = ["legs", "eyes", "voice"]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "LowPower", "Error"]
default_time = 1000
default_state = "Uninitialized"

[actuator.legs]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "LowPower", "Error"]
times = [1000, 1000, 1000, 1000, 1000, 1000, 1000]
command = ["legs"]
restart = "no"
critical = true
on_lost = ")" +
         on_lost + R"("

[actuator.eyes]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "LowPower", "Error"]
times = [1000, 1000, 1000, 1000, 1000, 1000, 1000]
command = ["eyes"]
after = ["legs"]

[actuator.voice]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "LowPower", "Error"]
times = [1000, 1000, 1000, 1000, 1000, 1000, 1000]
command = ["voice"]
)";
}

std::vector<JournalItem> RecordedLife() {
  const std::string text = RobotToml();
  const MachineConfig config = ReadConfigText(text, "dog.toml").config.value();
  simulation::SimRobot robot(1, config);
  const auto start = [&robot] {
    robot.StartController();
    robot.RunUntil([&] { return robot.machine().phase == Phase::kRunning; });
    robot.RunFor(std::chrono::seconds(1));
  };
  start();
  for (int i = 0; i < 5; ++i) {
    robot.Set("LowPower");
    robot.Set("Active");
  }
  robot.CrashController();
  start();
  robot.Set("LowPower");
  robot.Set("Active");
  robot.CrashActuator("legs");
  robot.RunFor(std::chrono::seconds(10));
  std::vector<JournalItem> items;
  for (const JournalRow& row : robot.recording()) {
    JournalItem item = row.item;
    if (auto* input = std::get_if<JournalInput>(&item)) {
      auto* config_text = std::get_if<recording::ConfigText>(&input->what);
      if (config_text != nullptr) config_text->text = text;
    }
    items.push_back(std::move(item));
  }
  return items;
}

}  // namespace musher
