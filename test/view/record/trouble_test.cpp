#include "musher/view/record/trouble.hpp"

#include <gtest/gtest.h>

namespace musher::view::trouble_test {

msg::MachineStatus Well() {
  msg::MachineStatus status;
  status.state = "Active";
  status.actuators.resize(1);
  status.actuators[0].name = "audio";
  status.actuators[0].presence = "present";
  status.actuators[0].health = "well";
  return status;
}

std::string After(TroubleWatch& watch, const msg::MachineStatus& status) {
  return watch.On(status).value_or("");
}

TEST(Trouble, AnEmergencyStopIsTroubleOnce) {
  TroubleWatch watch;
  msg::MachineStatus status = Well();
  EXPECT_EQ(After(watch, status), "");
  status.emergency_stop = true;
  EXPECT_EQ(After(watch, status), "emergency-stop");
  EXPECT_EQ(After(watch, status), "");
  status.emergency_stop = false;
  EXPECT_EQ(After(watch, status), "");
  status.emergency_stop = true;
  EXPECT_EQ(After(watch, status), "emergency-stop");
}

TEST(Trouble, AnActuatorThatCrashesHangsOrIsLostIsNamed) {
  for (const std::string health : {"crashed", "hung", "partitioned"}) {
    TroubleWatch watch;
    msg::MachineStatus status = Well();
    EXPECT_EQ(After(watch, status), "");
    status.actuators[0].health = health;
    EXPECT_EQ(After(watch, status), "audio-" + health);
    EXPECT_EQ(After(watch, status), "");
  }
  TroubleWatch watch;
  msg::MachineStatus status = Well();
  EXPECT_EQ(After(watch, status), "");
  status.actuators[0].presence = "lost";
  EXPECT_EQ(After(watch, status), "audio-lost");
}

TEST(Trouble, AStarvedActuatorIsNoTrouble) {
  TroubleWatch watch;
  msg::MachineStatus status = Well();
  EXPECT_EQ(After(watch, status), "");
  status.actuators[0].health = "starved";
  EXPECT_EQ(After(watch, status), "");
}

TEST(Trouble, ADegradedActuatorAndTheStateErrorAreTrouble) {
  TroubleWatch watch;
  msg::MachineStatus status = Well();
  EXPECT_EQ(After(watch, status), "");
  status.degraded = {"audio"};
  EXPECT_EQ(After(watch, status), "audio-degraded");
  status.state = "Error";
  EXPECT_EQ(After(watch, status), "error");
  status.state = "Active";
  EXPECT_EQ(After(watch, status), "");
}

TEST(Trouble, WhatWasWrongBeforeTheRecorderStartedIsNotNew) {
  TroubleWatch watch;
  msg::MachineStatus status = Well();
  status.emergency_stop = true;
  status.degraded = {"audio"};
  EXPECT_EQ(After(watch, status), "");
  EXPECT_EQ(After(watch, status), "");
}

TEST(Trouble, ASwitchThatWasUndoneOrRefusedIsTrouble) {
  EXPECT_EQ(TroubleOf("switch_undone"), "switch-undone");
  EXPECT_EQ(TroubleOf("switch_refused"), "switch-refused");
  EXPECT_EQ(TroubleOf("switch_done"), std::nullopt);
  EXPECT_EQ(TroubleOf(""), std::nullopt);
}

}  // namespace musher::view::trouble_test
