// Tests new_app without a robot, in virtual time.

#include "new_app.hpp"

#include <gtest/gtest.h>

#include "musher/simulation/actuator_fault_test.hpp"

class NewAppMachine : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(BuildNewApp(machine_, data_));
    ASSERT_TRUE(machine_.Start(now_));
  }
  void Wait(musher::Duration time) {
    for (const musher::Time end = now_ + time; now_ < end;) machine_.RunOnce(now_ += 20ms);
  }

  NewAppData data_;
  fsm::Machine machine_{{.name = "new_app"}};
  musher::Time now_;
};

TEST_F(NewAppMachine, WorksForThreeSecondsAfterGo) {
  ASSERT_TRUE(machine_.Send("go"));
  Wait(1500ms);
  EXPECT_EQ(machine_.Path(), "WORKING");
  EXPECT_NEAR(data_.progress, 0.5, 0.05);
  Wait(2s);
  EXPECT_EQ(machine_.Path(), "IDLE");
}

TEST_F(NewAppMachine, WaitsWhileThereIsAnObstacle) {
  ASSERT_TRUE(machine_.Send("go"));
  Wait(1s);
  data_.obstacle = true;
  Wait(1s);
  EXPECT_EQ(machine_.mode(), fsm::Mode::kSafeStop);
  data_.obstacle = false;
  Wait(3s);
  EXPECT_EQ(machine_.Path(), "IDLE");
}

TEST(NewApp, IsPausedOutsideOfActiveUnderInjectedFaults) {
  musher::simulation::ActuatorFaultTest<NewApp> test;
  test.config_file = "robot.toml";
  test.always = [](const NewApp& new_app, const musher::ActuatorReport& report) {
    EXPECT_FALSE(new_app.ticking() && report.state != "Active") << "it runs in " << report.state;
  };
  test.after_emergency_stop = [](const NewApp& new_app, const musher::ActuatorReport&) {
    EXPECT_FALSE(new_app.ticking());
  };
  test.Run();
}
