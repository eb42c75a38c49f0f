// What a simulated robot publishes of its capabilities, and what its actuators allow.

#include <gtest/gtest.h>

#include "musher/lifecycle/capability.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/lifecycle_wire.hpp"

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

// A robot, and somebody who listens to what it can do and plays its battery.
class SimulatedCapabilities : public ::testing::Test {
 protected:
  explicit SimulatedCapabilities(std::uint64_t seed = 1) : robot_(seed, Robot()) {
    node_ = robot_.network().MakeNode("listener");
    listening_ = transport::MakeSubscription<msg::Capabilities>(
                     *node_, transport::CapabilitiesTopic(""),
                     [this](const msg::Capabilities& told, const transport::SampleInfo&) {
                       told_ = told;
                       ++times_told_;
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

  const msg::Capability& Told(const std::string& name) const {
    for (const msg::Capability& capability : told_.capabilities) {
      if (capability.name == name) return capability;
    }
    ADD_FAILURE() << name << " is not told of";
    static const msg::Capability none;
    return none;
  }

  SimRobot robot_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Subscription> listening_;
  std::unique_ptr<transport::Publisher<msg::BmsStatus>> battery_;
  msg::Capabilities told_;
  int times_told_ = 0;
  std::vector<Time> times_;
};

TEST_F(SimulatedCapabilities, AreToldAtEveryChange) {
  BringUp();
  EXPECT_TRUE(Told("guide").allowed);
  ASSERT_TRUE(robot_.Set("LowPower")->done());
  Settle();
  EXPECT_TRUE(Told("walk").allowed);
  EXPECT_EQ(Told("guide").reason, "guide runs in Active only; a is in LowPower");
  EXPECT_EQ(Told("guide").code, kCodeStateInvalid);
  const int before = times_told_;
  robot_.RunFor(std::chrono::seconds(60));
  EXPECT_EQ(times_told_, before) << "nothing has changed";
}

TEST_F(SimulatedCapabilities, AreToldTwentyTimesASecondAtMost) {
  BringUp();
  for (int i = 0; i < 100; ++i) {
    robot_.Set(i % 2 == 0 ? "LowPower" : "Active");
    robot_.RunFor(Milliseconds(i % 37));
  }
  ASSERT_GT(times_.size(), 10U);
  for (std::size_t i = 1; i < times_.size(); ++i) {
    EXPECT_GE(times_[i] - times_[i - 1], Milliseconds(45)) << "but for the way it takes";
  }
}

TEST_F(SimulatedCapabilities, OfAnActuatorThatIsLostAreRefused) {
  BringUp();
  robot_.FreezeActuator("b");
  ASSERT_TRUE(robot_.RunUntil([&] { return !Told("guide").allowed; }));
  EXPECT_EQ(Told("guide").reason.rfind("b is ", 0), 0U) << Told("guide").reason;
  EXPECT_TRUE(Told("walk").allowed);
}

TEST_F(SimulatedCapabilities, GoByTheBatteryUntilItFallsSilent) {
  BringUp();
  EXPECT_FALSE(Told("jump").allowed);
  SetBattery(80);
  EXPECT_TRUE(Told("jump").allowed);
  SetBattery(200);  // which no battery has
  EXPECT_TRUE(Told("jump").allowed);
  SetBattery(29);
  EXPECT_EQ(Told("jump").reason, "jump needs at least 30 % of the battery; it has 29 %");
  SetBattery(30);
  EXPECT_TRUE(Told("jump").allowed);
  robot_.RunFor(std::chrono::seconds(10));
  EXPECT_EQ(Told("jump").reason, "jump needs at least 30 % of the battery; its level is not known");
}

TEST_F(SimulatedCapabilities, AreRefusedDuringAnEmergencyStop) {
  BringUp();
  robot_.EngageEmergencyStop(77);
  Settle();
  EXPECT_FALSE(Told("walk").allowed);
  robot_.ReleaseEmergencyStop();
  Settle();
  EXPECT_FALSE(Told("walk").allowed) << "the stop has switched off what walks";
  EXPECT_NE(Told("walk").reason.find("held by the emergency stop"), std::string::npos);
  robot_.Set("Active");
  Settle();
  EXPECT_TRUE(Told("walk").allowed);
}

class OfSeed : public SimulatedCapabilities, public ::testing::WithParamInterface<std::uint64_t> {
 protected:
  OfSeed() : SimulatedCapabilities(GetParam()) {}
};

// What is told of each capability is what its actuators, asked themselves, would say.
TEST_P(OfSeed, WhatIsToldIsWhatTheActuatorsAllow) {
  BringUp();
  transport::sim::LinkFaults faults;
  faults.loss = 0.2;
  faults.delay_max = Milliseconds(20);
  robot_.network().SetFaults(faults);
  for (const char* target : {"LowPower", "OTA", "Active", "LowPower", "Active"}) {
    robot_.Set(target);
    if (GetParam() % 2 == 0) robot_.CrashActuator("b");
    robot_.RunFor(std::chrono::seconds(20));  // it is back, and where the machine is
    for (const CapabilityConfig& declared : robot_.config().capabilities) {
      bool allowed = true;
      for (const std::string& name : declared.actuators) {
        const auto report = robot_.ReportOf(name);
        ASSERT_TRUE(report);
        allowed &= CheckCapability(robot_.config(), declared.name,
                                   {name, report->state, report->target,
                                    report->emergency_stop != 0, std::nullopt})
                       .ok();
      }
      EXPECT_EQ(Told(declared.name).allowed, allowed) << declared.name << " in " << target;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, OfSeed, ::testing::Range<std::uint64_t>(1, 9));

}  // namespace musher::testing::capability_test
