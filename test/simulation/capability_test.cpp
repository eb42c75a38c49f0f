// What a simulated robot publishes of its capabilities, and what its actuators allow.

#include <gtest/gtest.h>

#include "musher/lifecycle/actuator/capability.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::capability_test {

using simulation::SimRobot;

MachineConfig Robot() {
  MachineConfig config = MachineOf(2);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.command = {"run", actuator.name};
    actuator.restart.policy = RestartPolicy::kOnFailure;
    actuator.restart.limit = 100;
  }
  config.capabilities = {{"walk", "", {"a"}, {"Active", "LowPower"}, std::nullopt},
                         {"guide", "", {"a", "b"}, {"Active"}, std::nullopt},
                         {"jump", "", {"a"}, {"Active", "LowPower"}, 30}};
  return config;
}

// A robot, and a node that subscribes to its capabilities and publishes its battery's status.
class SimulatedCapabilities : public ::testing::Test {
 protected:
  explicit SimulatedCapabilities(std::uint64_t seed = 1) : robot_(seed, Robot()) {
    node_ = robot_.network().MakeNode("listener");
    subscription_ = transport::MakeSubscription<msg::Capabilities>(
                        *node_, transport::CapabilitiesTopic(""),
                        [this](const msg::Capabilities& message, const transport::SampleInfo&) {
                          published_ = message;
                          ++samples_;
                          times_.push_back(robot_.network().now());
                        },
                        transport::kLatchedQos)
                        .value();
    battery_ = transport::MakePublisher<msg::BmsStatus>(*node_, "bms_status").value();
  }

  void BringUp() {
    robot_.StartController();
    ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
    Settle();
  }
  void Settle() { robot_.RunFor(std::chrono::seconds(1)); }
  void SetBattery(std::uint8_t percent) {
    msg::BmsStatus status;
    status.batt_soc = percent;
    ASSERT_TRUE(battery_->Publish(status).ok());
    Settle();
  }

  const msg::Capability& Published(const std::string& name) const {
    for (const msg::Capability& capability : published_.capabilities) {
      if (capability.name == name) return capability;
    }
    ADD_FAILURE() << name << " is not published";
    static const msg::Capability none;
    return none;
  }

  SimRobot robot_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Subscription> subscription_;
  std::unique_ptr<transport::Publisher<msg::BmsStatus>> battery_;
  msg::Capabilities published_;
  int samples_ = 0;
  std::vector<Time> times_;
};

TEST_F(SimulatedCapabilities, ArePublishedAtEveryChange) {
  BringUp();
  EXPECT_TRUE(Published("guide").allowed);
  ASSERT_TRUE(robot_.Set("LowPower")->done());
  Settle();
  EXPECT_TRUE(Published("walk").allowed);
  EXPECT_EQ(Published("guide").reason, "guide runs in Active only; a is in LowPower");
  EXPECT_EQ(Published("guide").code, kCodeStateInvalid);
  const int before = samples_;
  robot_.RunFor(std::chrono::seconds(60));
  EXPECT_EQ(samples_, before) << "nothing has changed";
}

TEST_F(SimulatedCapabilities, ArePublishedTwentyTimesASecondAtMost) {
  BringUp();
  for (int i = 0; i < 100; ++i) {
    robot_.Set(i % 2 == 0 ? kLowPower : kActive);
    robot_.RunFor(Milliseconds(i % 37));
  }
  ASSERT_GT(times_.size(), 10U);
  for (std::size_t i = 1; i < times_.size(); ++i) {
    EXPECT_GE(times_[i] - times_[i - 1], Milliseconds(45)) << "apart from the transit time";
  }
}

TEST_F(SimulatedCapabilities, OfAnActuatorThatIsLostAreRefused) {
  BringUp();
  robot_.FreezeActuator("b");
  ASSERT_TRUE(robot_.RunUntil([&] { return !Published("guide").allowed; }));
  EXPECT_EQ(Published("guide").reason.rfind("b is ", 0), 0U) << Published("guide").reason;
  EXPECT_TRUE(Published("walk").allowed);
}

TEST_F(SimulatedCapabilities, FollowTheBatteryUntilItIsSilent) {
  BringUp();
  EXPECT_FALSE(Published("jump").allowed);
  SetBattery(80);
  EXPECT_TRUE(Published("jump").allowed);
  SetBattery(200);  // out of range: ignored
  EXPECT_TRUE(Published("jump").allowed);
  SetBattery(29);
  EXPECT_EQ(Published("jump").reason, "jump needs at least 30 % of the battery; it has 29 %");
  SetBattery(30);
  EXPECT_FALSE(Published("jump").allowed) << "one sample permits nothing";
  for (int i = 0; i < 6; ++i) SetBattery(30);
  EXPECT_TRUE(Published("jump").allowed);
  robot_.RunFor(std::chrono::seconds(10));
  EXPECT_EQ(Published("jump").reason,
            "jump needs at least 30 % of the battery; its level is not known");
}

TEST_F(SimulatedCapabilities, AreRefusedDuringAnEmergencyStop) {
  BringUp();
  robot_.EngageEmergencyStop(77);
  Settle();
  EXPECT_FALSE(Published("walk").allowed);
  robot_.ReleaseEmergencyStop();
  Settle();
  EXPECT_FALSE(Published("walk").allowed) << "the stop has switched off what walks";
  EXPECT_NE(Published("walk").reason.find("held by the emergency stop"), std::string::npos);
  robot_.Set("Active");
  Settle();
  EXPECT_TRUE(Published("walk").allowed);
}

class OfSeed : public SimulatedCapabilities, public ::testing::WithParamInterface<std::uint64_t> {
 protected:
  OfSeed() : SimulatedCapabilities(GetParam()) {}
};

// The published value of each capability is what its actuators themselves allow.
TEST_P(OfSeed, ThePublishedCapabilitiesAreWhatTheActuatorsAllow) {
  BringUp();
  transport::sim::LinkFaults faults;
  faults.loss = 0.2;
  faults.delay_max = Milliseconds(20);
  robot_.network().SetFaults(faults);
  for (const BuiltInState target : {kLowPower, kOta, kActive, kLowPower, kActive}) {
    robot_.Set(target);
    if (GetParam() % 2 == 0) robot_.CrashActuator("b");
    robot_.RunFor(std::chrono::seconds(20));  // it is available again, in the machine's state
    for (const CapabilityConfig& declared : robot_.config().capabilities) {
      bool allowed = true;
      for (const std::string& name : declared.actuators) {
        const auto report = robot_.ReportOf(name);
        ASSERT_TRUE(report);
        allowed &= EvaluateCapability(robot_.config(), declared.name,
                                      {name, report->state, report->target,
                                       report->emergency_stop != 0, std::nullopt})
                       .ok();
      }
      EXPECT_EQ(Published(declared.name).allowed, allowed) << declared.name << " in " << target;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, OfSeed, ::testing::Range<std::uint64_t>(1, 9));

}  // namespace musher::testing::capability_test
