// What CyberDog's manager publishes by itself.

#include "musher/test/cyberdog/managed_robot.hpp"

namespace musher::testing::announcements_test {

class CyberdogAnnouncements : public ManagedRobot {
 protected:
  explicit CyberdogAnnouncements(MachineConfig config = ManagedMachine(),
                                 simulation::Script script = {})
      : ManagedRobot(std::move(config), std::move(script)) {
    Subscribe<msg::Bool>("ready_notify", [this](const msg::Bool& ready) {
      EXPECT_TRUE(ready.data);
      ++times_ready_;
    });
  }
  int times_ready_ = 0;
};

TEST_F(CyberdogAnnouncements, TheStateIsPublishedWhenItIsReachedOrWhenTheSwitchBegins) {
  robot_.StartController();
  Settle();
  EXPECT_EQ(States().back(), '0') << "it is up";
  ASSERT_TRUE(robot_.Set("Protected")->done());
  EXPECT_EQ(States(), "1");
  for (const auto& [target, number] : {std::pair(kLowPower, "2"), std::pair(kOta, "3"),
                                       std::pair(kActive, "0"), std::pair(kDeActive, "-1")}) {
    ASSERT_TRUE(robot_.Set(target)->done());
    EXPECT_EQ(States(), number);
  }
  EXPECT_FALSE(robot_.Set("SelfCheck") == std::nullopt);
  EXPECT_EQ(States(), "") << "a check changes nothing";
  robot_.Set("TearDown");
  EXPECT_EQ(States(), "4");
}

class ARobotThatFails : public CyberdogAnnouncements {
 protected:
  ARobotThatFails()
      : CyberdogAnnouncements(Critical(), [this](const std::string& name, const State& state) {
          simulation::Act act;
          if (name == "b" && state == fails_in_) act.error = {5001, "by the test"};
          return act;
        }) {}
  static MachineConfig Critical() {
    MachineConfig config = ManagedMachine();
    config.actuators[1].critical = true;
    return config;
  }
  State fails_in_;
};

TEST_F(ARobotThatFails, PublishesAnUndoneSwitchWithItsCode) {
  BringUp();
  Take("LowPower");
  fails_in_ = kActive;
  EXPECT_FALSE(robot_.Set("Active")->done());
  EXPECT_EQ(States(), "-2(5001)");
}

TEST_F(ARobotThatFails, PublishesTheCodeOfADegradedSwitch) {
  BringUp();
  fails_in_ = kLowPower;
  robot_.Set("LowPower");
  EXPECT_EQ(States(), "2 2(5001)");
}

TEST_F(ARobotThatFails, AnnouncesThatACriticalActuatorPreventsItsStart) {
  fails_in_ = kSelfCheck;
  robot_.StartController();
  robot_.RunFor(std::chrono::seconds(5));
  ASSERT_FALSE(self_checks_.empty());
  EXPECT_EQ(self_checks_.back().code, msg::SelfCheckStatus::kCriticalFailed);
  EXPECT_EQ(times_ready_, 0);
}

TEST_F(ARobotThatFails, AnnouncesALaterFailure) {
  BringUp();
  fails_in_ = kLowPower;
  robot_.Set("LowPower");
  robot_.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(self_checks_.back().code, msg::SelfCheckStatus::kFailedStarted);
  EXPECT_NE(self_checks_.back().description.find(R"("b":5001)"), std::string::npos)
      << self_checks_.back().description;
}

TEST_F(CyberdogAnnouncements, TheSelfCheckIsPublishedEverySecond) {
  robot_.StartController();
  robot_.RunFor(Milliseconds(10'500));
  EXPECT_EQ(self_checks_.size(), 10U);
  EXPECT_EQ(self_checks_.back().code, msg::SelfCheckStatus::kAllFine);
}

// An actuator whose self-check takes two seconds, and one of the second stage that takes as long.
class ASlowRobot : public CyberdogAnnouncements {
 protected:
  ASlowRobot()
      : CyberdogAnnouncements(Staged(), [](const std::string&, const State& state) {
          simulation::Act act;
          if (state == kSelfCheck) act.takes = std::chrono::seconds(2);
          return act;
        }) {}
  static MachineConfig Staged() {
    MachineConfig config = ManagedMachine();
    for (ActuatorConfig& actuator : config.actuators) {
      actuator.times.assign(actuator.states.size(), std::chrono::seconds(5));
    }
    config.actuators[1].stage = 2;
    return config;
  }
};

TEST_F(ASlowRobot, PublishesTheProgressOfTheStart) {
  robot_.StartController();
  robot_.RunFor(std::chrono::seconds(8));
  std::string codes;
  for (const msg::SelfCheckStatus& status : self_checks_) {
    const char code = static_cast<char>('0' + status.code);
    if (codes.empty() || codes.back() != code) codes += code;
  }
  EXPECT_EQ(codes, "130") << "checking, software starting, all fine";
}

TEST_F(CyberdogAnnouncements, ReadinessIsPublishedTenTimesASecondForFiveMinutes) {
  BringUp();
  robot_.RunFor(std::chrono::seconds(10));
  EXPECT_NEAR(times_ready_, 105, 2);
  robot_.RunFor(std::chrono::minutes(10));
  EXPECT_EQ(times_ready_, 3000);
}

TEST_F(CyberdogAnnouncements, ReadinessIsNotPublishedForATornDownMachine) {
  BringUp();
  robot_.Set("TearDown");
  const int before = times_ready_;
  robot_.RunFor(std::chrono::seconds(1));
  EXPECT_LE(times_ready_, before + 1);
}

}  // namespace musher::testing::announcements_test
