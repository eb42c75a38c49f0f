// Where capabilities run, and the messages of refusals.

#include "musher/lifecycle/actuator/capability.hpp"

#include <gtest/gtest.h>

namespace musher::capability_test {

constexpr auto kStateInvalid = RobotCode(KeyCode::kStateInvalid);
constexpr auto kProtectedError = RobotCode(KeyCode::kProtectedError);

class Capabilities : public ::testing::Test {
 protected:
  Capabilities() {
    for (const char* name : {"legs", "eyes"}) {
      ActuatorConfig actuator;
      actuator.name = name;
      actuator.states = {"SetUp", "Active", "Protected", "LowPower"};
      config_.actuators.push_back(actuator);
    }
    config_.capabilities = {{"flip", "", {"legs"}, {"Active"}, std::nullopt},
                            {"walk", "", {"legs"}, {"Active", "Protected"}, std::nullopt},
                            {"jump", "", {"legs"}, {"Active"}, 30},
                            {"follow", "", {"legs", "eyes"}, {"Active"}, std::nullopt}};
    machine_ = MakeMachine(config_);
    for (KnownActuator& known : machine_.actuators) {
      known.presence = Presence::kPresent;
      known.report.state = kActive;
    }
  }

  Result<> Evaluate(std::string_view capability, std::string_view state,
                    std::string_view target = "", std::optional<int> battery = std::nullopt) const {
    return EvaluateCapability(config_, capability, {"legs", state, target, false, battery});
  }
  CapabilityVerdict Verdict(const std::string& name) const {
    for (const CapabilityVerdict& verdict : EvaluateCapabilities(config_, machine_, battery_)) {
      if (verdict.name == name) return verdict;
    }
    ADD_FAILURE() << "no verdict on " << name;
    return {};
  }

  MachineConfig config_;
  Machine machine_;
  std::optional<int> battery_;
};

TEST_F(Capabilities, RunInTheirStates) {
  EXPECT_TRUE(Evaluate("walk", "Active").ok());
  EXPECT_TRUE(Evaluate("walk", "Protected").ok());
  EXPECT_EQ(Evaluate("walk", "LowPower").error(),
            (Error{kStateInvalid, "walk runs in Active and Protected; legs is in LowPower"}));
}

TEST_F(Capabilities, AreRefusedWhereAReleasedStopHoldsTheirActuator) {
  EXPECT_EQ(EvaluateCapability(config_, "walk", {"legs", "Active", "", false, std::nullopt, true})
                .error(),
            (Error{kStateInvalid,
                   "legs is held by the emergency stop that was released; `musher set "
                   "Active` ends that"}));
  machine_.actuators[0].report.held_by_stop = true;
  EXPECT_FALSE(Verdict("walk").allowed);
}

TEST_F(Capabilities, AreRefusedAsProtectedWhereTheyRunInActiveButNotInProtected) {
  EXPECT_TRUE(Evaluate("flip", "Active").ok());
  EXPECT_EQ(Evaluate("flip", "Protected").error(),
            (Error{kProtectedError, "flip runs in Active only; legs is in Protected"}));
  EXPECT_EQ(Evaluate("flip", "LowPower").error().code, kStateInvalid);
}

TEST_F(Capabilities, HaveTheCodeOfTheCallingModule) {
  const auto refused =
      EvaluateCapability(config_, "flip", {"legs", "Protected", "", false, {}}, ModuleCode{3000});
  EXPECT_EQ(refused.error().code, 3013);
}

TEST_F(Capabilities, RunInActiveOnlyWhereNothingIsDeclared) {
  EXPECT_TRUE(Evaluate("sing", "Active").ok());
  EXPECT_EQ(Evaluate("sing", "Protected").error(),
            (Error{kProtectedError, "sing runs in Active only; legs is in Protected"}));
  EXPECT_EQ(Evaluate("sing", "DeActive").error().code, kStateInvalid);
}

TEST_F(Capabilities, WhileACallbackRunsMustBeAllowedInBothStates) {
  EXPECT_TRUE(Evaluate("walk", "Active", "Protected").ok());
  EXPECT_EQ(Evaluate("walk", "Active", "LowPower").error(),
            (Error{kStateInvalid,
                   "walk runs in Active and Protected; legs is switching from Active to "
                   "LowPower"}));
  EXPECT_EQ(Evaluate("flip", "Active", "Protected").error().code, kProtectedError);
  EXPECT_EQ(Evaluate("flip", "Protected", "Active").error().code, kProtectedError);
  EXPECT_EQ(Evaluate("flip", "LowPower", "Active").error().code, kStateInvalid);
}

TEST_F(Capabilities, AreAllRefusedDuringAnEmergencyStop) {
  for (const char* capability : {"walk", "sing"}) {
    const auto refused = EvaluateCapability(config_, capability, {"legs", "Active", "", true, {}});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, kStateInvalid);
    EXPECT_NE(refused.error().message.find("emergency stop"), std::string::npos);
  }
}

TEST_F(Capabilities, NeedTheBatteryThatTheConfigGives) {
  EXPECT_TRUE(Evaluate("jump", "Active", "", 30).ok());
  EXPECT_EQ(Evaluate("jump", "Active", "", 29).error(),
            (Error{kProtectedError, "jump needs at least 30 % of the battery; it has 29 %"}));
  EXPECT_EQ(
      Evaluate("jump", "Active").error(),
      (Error{kProtectedError, "jump needs at least 30 % of the battery; its level is not known"}));
  EXPECT_TRUE(Evaluate("flip", "Active", "", 1).ok()) << "it has no min_battery";
}

TEST_F(Capabilities, AreRefusedByAnActuatorThatTheyAreNotDeclaredFor) {
  const auto refused = EvaluateCapability(config_, "flip", {"eyes", "Active", "", false, {}});
  EXPECT_EQ(refused.error(), (Error{kStateInvalid, "flip is not declared for eyes"}));
}

TEST_F(Capabilities, OfSeveralActuatorsAreAllowedWhenAllAllowThem) {
  EXPECT_EQ(Verdict("follow"), (CapabilityVerdict{"follow", true, kCodeOk, ""}));
  machine_.actuators[1].report.state = kLowPower;
  EXPECT_EQ(Verdict("follow"),
            (CapabilityVerdict{"follow", false, kStateInvalid,
                               "follow runs in Active only; eyes is in LowPower"}));
  EXPECT_TRUE(Verdict("walk").allowed) << "which takes the legs alone";
}

TEST_F(Capabilities, OfAnUnavailableActuatorAreRefused) {
  machine_.actuators[0].presence = Presence::kLost;
  EXPECT_EQ(Verdict("walk"), (CapabilityVerdict{"walk", false, kStateInvalid, "legs is lost"}));
  machine_.actuators[0].fault = ActuatorFault{3101, "crashed"};
  EXPECT_EQ(Verdict("walk").reason, "legs is lost; legs is degraded: crashed");
}

TEST_F(Capabilities, OfADegradedActuatorHaveItsFaultAsReasonAndDependOnItsState) {
  machine_.actuators[0].fault = ActuatorFault{3009, "a motor is hot"};
  EXPECT_EQ(Verdict("walk"),
            (CapabilityVerdict{"walk", true, kCodeOk, "legs is degraded: a motor is hot"}));
  machine_.actuators[0].report.state = kLowPower;
  EXPECT_EQ(Verdict("walk").reason,
            "walk runs in Active and Protected; legs is in LowPower; legs is degraded: a motor is "
            "hot");
}

TEST_F(Capabilities, AreRefusedByAStopOfTheMachineOrOfTheActuator) {
  machine_.emergency.stop = EmergencyStop{7, "me", ""};
  EXPECT_FALSE(Verdict("walk").allowed);
  machine_.emergency.stop.reset();
  EXPECT_TRUE(Verdict("walk").allowed);
  machine_.actuators[0].report.emergency_stop = 7;
  EXPECT_FALSE(Verdict("walk").allowed);
}

TEST_F(Capabilities, ArePublishedInTheOrderOfTheConfigWithThePresentBattery) {
  battery_ = 12;
  std::string names;
  for (const CapabilityVerdict& verdict : EvaluateCapabilities(config_, machine_, battery_)) {
    names += verdict.name + (verdict.allowed ? "+ " : "- ");
  }
  EXPECT_EQ(names, "flip+ walk+ jump- follow+ ");
}

}  // namespace musher::capability_test
