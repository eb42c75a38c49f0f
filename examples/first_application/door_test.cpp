// [machine]
// Tests the door without a robot, in virtual time.

#include "door.hpp"

#include <gtest/gtest.h>

#include "musher/simulation/actuator_fault_test.hpp"

TEST(Door, OpensInTwoSecondsAndShutsItselfAfterFive) {
  DoorData door;
  fsm::Machine machine({.name = "door"});
  ASSERT_TRUE(BuildDoor(machine, door));
  musher::Time now;
  const auto wait = [&](musher::Duration time) {
    for (const musher::Time end = now + time; now < end;) machine.RunOnce(now += 20ms);
  };
  ASSERT_TRUE(machine.Start(now));
  ASSERT_TRUE(machine.Send("open"));
  wait(1s);
  EXPECT_NEAR(door.opening, 0.5, 0.02);
  wait(1s + 100ms);
  EXPECT_EQ(machine.Path(), "OPEN");
  wait(8s);
  EXPECT_EQ(machine.Path(), "CLOSED");
}

TEST(Door, StopsWhereItIsAtAnObstacleAndOpensOnceTheWayIsFree) {
  DoorData door;
  fsm::Machine machine({.name = "door"});
  ASSERT_TRUE(BuildDoor(machine, door));
  musher::Time now;
  ASSERT_TRUE(machine.Start(now));
  ASSERT_TRUE(machine.Send("open"));
  for (int i = 0; i < 50; ++i) machine.RunOnce(now += 20ms);
  const double before = door.opening;
  door.obstacle = true;
  for (int i = 0; i < 50; ++i) machine.RunOnce(now += 20ms);
  EXPECT_EQ(machine.mode(), fsm::Mode::kSafeStop);
  EXPECT_EQ(door.opening, before);
  door.obstacle = false;
  for (int i = 0; i < 50; ++i) machine.RunOnce(now += 20ms);
  EXPECT_NEAR(door.opening, (before + 1) / 2, 0.02) << "half of the rest in half of the time";
  for (int i = 0; i < 60; ++i) machine.RunOnce(now += 20ms);
  EXPECT_EQ(machine.Path(), "OPEN");
}
// [machine end]

// [fault_test]
TEST(Door, IsPausedOutsideOfActiveUnderInjectedFaults) {
  musher::simulation::ActuatorFaultTest<Door> test;
  test.config_file = "robot.toml";
  test.always = [](const Door& door, const musher::ActuatorReport& report) {
    EXPECT_FALSE(door.ticking() && report.state != "Active") << "it moves in " << report.state;
  };
  test.after_emergency_stop = [](const Door& door, const musher::ActuatorReport&) {
    EXPECT_FALSE(door.ticking()) << "it moves in an emergency";
  };
  test.Run();
}
// [fault_test end]
