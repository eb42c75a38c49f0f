// The JSON of `self_check_status`: CyberDog's keys, from the codes of the actuators.

#include "musher/cyberdog/self_check.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <nlohmann/json.hpp>

#include "musher/cyberdog/numbers.hpp"

namespace musher::cyberdog::self_check_test {

using Json = nlohmann::json;

class SelfChecks : public ::testing::Test {
 protected:
  SelfChecks() { Add({"motion_manager", "device_manager", "sensor_manager", "tail"}); }

  // Actuators that have passed their self-check.
  void Add(std::initializer_list<const char*> names) {
    for (const char* name : names) {
      ActuatorConfig actuator;
      actuator.name = name;
      config_.actuators.push_back(actuator);
    }
    machine_ = MakeMachine(config_);
    for (KnownActuator& known : machine_.actuators) {
      known.presence = Presence::kPresent;
      known.checked = true;
    }
  }
  Json Described() const { return Json::parse(SelfCheckOf(config_, machine_).description); }
  void Fail(const char* name, std::int32_t code) {
    machine_.actuators[*config_.IndexOf(name)].fault = ActuatorFault{code, ""};
  }

  MachineConfig config_;
  Machine machine_;
};

TEST_F(SelfChecks, HaveCyberdogsKeysAndThoseOfTheRobotsOwnActuators) {
  const Json json = Described();
  for (const char* key : {"audio", "algorithm_manager", "vp_engine", "RealSenseActuator"}) {
    EXPECT_EQ(json[key], -1) << key << " is not there";
  }
  EXPECT_EQ(json["motion_manager"], 0);
  EXPECT_EQ(json["tail"], 0);
  EXPECT_EQ(
      json["device"],
      Json({{"bms", 0}, {"led", 0}, {"touch", 0}, {"uwb", 0}, {"bluetooth", -1}, {"others", 0}}));
  EXPECT_EQ(json["sensor"], Json({{"lidar", 0}, {"tof", 0}, {"others", 0}}));
}

TEST_F(SelfChecks, OfADegradedActiveActuatorNameThePartAndThatTheStartContinues) {
  machine_.phase = Phase::kRunning;
  ActuatorReport& report = machine_.actuators[1].report;
  report.state = kActive;
  report.degraded_code = 1109;
  report.degraded_reason = "led: silent, 1109";
  EXPECT_EQ(Described()["device"]["led"], 1109);
  EXPECT_EQ(Described()["device"]["bms"], 0);
  EXPECT_EQ(SelfCheckOf(config_, machine_).code, msg::SelfCheckStatus::kFailedStarting);
  machine_.policy.loaded = true;
  EXPECT_EQ(SelfCheckOf(config_, machine_).code, msg::SelfCheckStatus::kFailedStarted);
}

TEST_F(SelfChecks, HaveNoResultOfAnUncheckedActuator) {
  machine_.actuators[0].checked = false;
  machine_.actuators[1].checked = false;
  const Json json = Described();
  EXPECT_EQ(json["motion_manager"], -1);
  EXPECT_EQ(json["device"]["bms"], -1);
  EXPECT_EQ(json["device"]["others"], -1);
}

TEST_F(SelfChecks, SplitASumIntoTheDevicesThatFailed) {
  Fail("motion_manager", 3009);
  Fail("device_manager", 2718);
  Fail("sensor_manager", 4318);
  const Json json = Described();
  EXPECT_EQ(json["motion_manager"], 3009);
  EXPECT_EQ(json["device"], Json({{"bms", 0},
                                  {"led", 1109},
                                  {"touch", 0},
                                  {"uwb", 1609},
                                  {"bluetooth", -1},
                                  {"others", 0}}));
  EXPECT_EQ(json["sensor"], Json({{"lidar", 2109}, {"tof", 2209}, {"others", 0}}));
}

// Found when the device manager gave one code for several devices: the others were reported as
// well.
TEST_F(SelfChecks, FindThePartsThatOnlyTheMessageNames) {
  machine_.actuators[1].fault = ActuatorFault{1109, "led: no driver, 1109; uwb: silent, 1609"};
  machine_.actuators[2].fault = ActuatorFault{2309, "ultrasonic: silent, 2309; gps: silent, 2409"};
  const Json json = Described();
  EXPECT_EQ(json["device"]["led"], 1109);
  EXPECT_EQ(json["device"]["uwb"], 1609);
  EXPECT_EQ(json["device"]["bms"], 0);
  EXPECT_EQ(json["sensor"], Json({{"lidar", 0}, {"tof", 0}, {"others", 2309}}));
}

TEST_F(SelfChecks, CoverTheVoiceTheSensorsAndTheCamerasOfTheRobot) {
  Add({"audio", "RealSenseActuator"});
  EXPECT_EQ(Described()["audio"], 0);
  Fail("audio", 5109);
  Fail("RealSenseActuator", 4409);
  Fail("sensor_manager", 2109);
  const Json json = Described();
  EXPECT_EQ(json["audio"], 5109);
  EXPECT_EQ(json["RealSenseActuator"], 4409);
  EXPECT_EQ(json["sensor"]["lidar"], 2109);
}

TEST_F(SelfChecks, PublishACodeOfNoPartAsAnotherFault) {
  Fail("device_manager", 101);
  const Json json = Described();
  EXPECT_EQ(json["device"]["bms"], -1);
  EXPECT_EQ(json["device"]["others"], 101);
}

TEST_F(SelfChecks, SayWhetherTheStartIsOverAndWell) {
  const auto code = [&] { return SelfCheckOf(config_, machine_).code; };
  EXPECT_EQ(code(), -1) << "nothing has begun";
  machine_.phase = Phase::kStarting;
  EXPECT_EQ(code(), 1);
  machine_.phase = Phase::kFailed;
  EXPECT_EQ(code(), 2);
  machine_.phase = Phase::kRunning;
  EXPECT_EQ(code(), 3);
  Fail("tail", 1);
  EXPECT_EQ(code(), 4);
  machine_.policy.loaded = true;
  EXPECT_EQ(code(), 6);
  machine_.actuators[3].fault.reset();
  EXPECT_EQ(code(), 0);
}

TEST(Numbers, OfStatesAndTextsAreCyberdogs) {
  EXPECT_EQ(StateOfNumber(0), "Active");
  EXPECT_EQ(StateOfNumber(4), "TearDown");
  EXPECT_EQ(StateOfNumber(7), "Error");
  EXPECT_EQ(StateOfNumber(8), std::nullopt);
  EXPECT_EQ(StateOfNumber(255), std::nullopt);
  EXPECT_EQ(TextOf("Uninitialized"), "unkown");
  EXPECT_EQ(TextOf("Dancing"), "unkown");
  EXPECT_EQ(StatusNumberOf("Error"), -2);
  EXPECT_EQ(StatusNumberOf("Dancing"), -1);
}

}  // namespace musher::cyberdog::self_check_test
