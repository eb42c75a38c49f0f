// The actuator of a robot's skills under thousands of injected faults: skills run in Active only,
// and never during an emergency stop. The test has no clock and no transport: it checks whether
// skills are to be stepped.

#include "musher/modules/skills/load_skills.hpp"
#include "musher/modules/skills/skills/body_skills.hpp"
#include "musher/modules/skills/skills/navigation_skills.hpp"
#include "musher/modules/skills/skills_actuator.hpp"
#include "musher/simulation/actuator_fault_test.hpp"

namespace musher::skills::skills_actuator_fault_test {

constexpr const char* kRobot = R"(
[controller]
actuators = ["planner_server", "jetbot_0"]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "DeActive", "Protected", "LowPower", "OTA",
          "Error"]
default_time = 2000
default_state = "Uninitialized"

[actuator.planner_server]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"]
times = [2000, 1000, 2000, 1000, 1000]
critical = true
command = ["planner"]

[actuator.jetbot_0]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "DeActive", "Protected", "LowPower", "OTA",
          "Error"]
times = [2000, 1000, 2000, 1000, 1000, 1000, 1000, 1000, 1000]
after = ["planner_server"]
command = ["skills"]
)";

Result<> RegisterAll(skill::Registry& registry, Robot& robot) {
  if (Result<> added = RegisterNavigationSkills(registry, robot); !added) return added;
  return RegisterBodySkills(registry, robot);
}

// All skills of the program, on a robot without topics.
class Skills : public SkillsActuator {
 public:
  explicit Skills(std::unique_ptr<RosRobot> robot)
      : SkillsActuator("jetbot_0", *robot,
                       *LoadSkills(robot->config(), *robot, RegisterAll).entries),
        robot_(std::move(robot)) {}

  bool steps() const { return ticking(); }

 private:
  std::unique_ptr<RosRobot> robot_;
};

std::unique_ptr<Skills> MakeSkills() {
  const auto config =
      ReadSkillsText("robot = \"jetbot_0\"\nkind = \"jetbot\"\nhand = true\n", "/tmp/jetbot_0.toml")
          .config;
  return std::make_unique<Skills>(std::make_unique<RosRobot>(*config));
}

TEST(ASkillsActuatorUnderFaults, StepsSkillsInActiveOnlyAndNeverInAnEmergency) {
  simulation::ActuatorFaultTest<Skills> test;
  test.config_text = kRobot;
  test.make = MakeSkills;
  int stepped = 0;
  test.always = [&stepped](const Skills& skills, const ActuatorReport& report) {
    if (skills.steps()) ++stepped;
    EXPECT_FALSE(skills.steps() && (report.state != kActive || report.emergency_stop != 0))
        << report.state;
  };
  test.after_emergency_stop = [](const Skills& skills, const ActuatorReport&) {
    EXPECT_FALSE(skills.steps());
  };
  test.Run();
  EXPECT_GT(stepped, 100) << "or nothing has been tried";
}

}  // namespace musher::skills::skills_actuator_fault_test
