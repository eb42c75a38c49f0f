// Whether a new version stays, by the state of the machine.

#include "musher/ota/trial_boot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::ota::trial_test {

using ::testing::HasSubstr;

class Trials : public ::testing::Test {
 protected:
  Trials() {
    for (const char* name : {"legs", "voice"}) {
      ActuatorConfig actuator;
      actuator.name = name;
      actuator.critical = name == std::string("legs");
      actuator.states = {State(kSetUp), State(kActive)};
      config_.actuators.push_back(actuator);
      KnownActuator known;
      known.presence = Presence::kPresent;
      known.report.state = State(kActive);
      machine_.actuators.push_back(known);
    }
    machine_.phase = Phase::kRunning;
    machine_.state = State(kActive);
  }

  std::string Verdict() const {
    const auto verdict = EvaluateTrialBoot(config_, machine_);
    if (!verdict) return "not known";
    return *verdict ? "kept" : verdict->error().message;
  }

  MachineConfig config_;
  Machine machine_;
};

TEST_F(Trials, SucceedWhenAllActuatorsAreInTheMachinesState) {
  EXPECT_EQ(Verdict(), "kept");
}

TEST_F(Trials, AreNotKnownBeforeTheMachineRuns) {
  for (const Phase phase : {Phase::kIdle, Phase::kStarting}) {
    machine_.phase = phase;
    EXPECT_EQ(Verdict(), "not known");
  }
}

TEST_F(Trials, WaitForALaterStage) {
  machine_.actuators[1].presence = Presence::kStarting;
  EXPECT_EQ(Verdict(), "not known");
  machine_.actuators[1].presence = Presence::kPresent;
  machine_.actuators[1].report.state = State(kSetUp);
  EXPECT_EQ(Verdict(), "not known");
  machine_.actuators[1].report.state = State(kActive);
  EXPECT_EQ(Verdict(), "kept");
}

TEST_F(Trials, AreNotKnownWhereAnEmergencyStopHasKeptTheMachineFromStarting) {
  machine_.phase = Phase::kFailed;
  EXPECT_EQ(Verdict(), "the start-up failed");
  EXPECT_FALSE(EvaluateTrialBoot(config_, machine_, {.start_refused = true, .faults = {}}));
  machine_.actuators[0].fault = ActuatorFault{kCodeFailed, "the motors are gone"};
  EXPECT_TRUE(EvaluateTrialBoot(config_, machine_, {.start_refused = true, .faults = {}}));
}

// The new version's fault was seen only if its actuator stood before the other one in the config.
TEST_F(Trials, FailByACriticalFaultBesideOneFromUnderAnEmergencyStop) {
  config_.actuators[1].critical = true;
  UnderStop stop;
  stop.Note(machine_);
  machine_.emergency.stop = EmergencyStop{7, "alice", "smoke"};
  machine_.actuators[0].fault = ActuatorFault{kCodeFailed, "roll-back failed"};
  stop.Note(machine_);
  machine_.emergency.stop.reset();
  machine_.actuators[1].fault = ActuatorFault{kCodeFailed, "no microphone"};
  stop.Note(machine_);
  const auto verdict = EvaluateTrialBoot(config_, machine_, stop);
  ASSERT_TRUE(verdict);
  EXPECT_THAT(verdict->error().message, HasSubstr("no microphone"));
}

// A person stopped the robot in its trial boot, which failed the switch of an actuator without a
// way back: a good version was rolled back.
TEST_F(Trials, AreNotKnownWhileACriticalActuatorHasAFaultFromUnderAnEmergencyStop) {
  UnderStop stop;
  stop.Note(machine_);
  machine_.emergency.stop = EmergencyStop{7, "alice", "smoke"};
  machine_.actuators[0].fault = ActuatorFault{kCodeFailed, "roll-back failed"};
  stop.Note(machine_);
  EXPECT_FALSE(EvaluateTrialBoot(config_, machine_, stop));
  machine_.emergency.stop.reset();
  stop.Note(machine_);
  EXPECT_FALSE(EvaluateTrialBoot(config_, machine_, stop)) << "a person sets its state again";
  machine_.actuators[0].fault.reset();
  stop.Note(machine_);
  EXPECT_TRUE(EvaluateTrialBoot(config_, machine_, stop));
  machine_.actuators[0].fault = ActuatorFault{kCodeFailed, "the motors are gone"};
  stop.Note(machine_);
  const auto verdict = EvaluateTrialBoot(config_, machine_, stop);
  ASSERT_TRUE(verdict);
  EXPECT_FALSE(*verdict);
}

TEST_F(Trials, EndBadlyWithACriticalActuator) {
  machine_.actuators[0].fault = ActuatorFault{kCodeFailed, "the motors are gone"};
  EXPECT_THAT(Verdict(), HasSubstr("critical legs: the motors are gone"));
}

TEST_F(Trials, WaitForACriticalActuatorThatIsStartedAgain) {
  machine_.actuators[0].fault = ActuatorFault{kCodeFailed, "it crashed"};
  machine_.actuators[0].restart.at = Time{};
  EXPECT_EQ(Verdict(), "not known");
}

TEST_F(Trials, SucceedWithoutANonCriticalActuator) {
  machine_.actuators[1].fault = ActuatorFault{kCodeFailed, "no loudspeaker"};
  machine_.actuators[1].presence = Presence::kLost;
  EXPECT_EQ(Verdict(), "kept");
}

TEST_F(Trials, EndBadlyWhenTheStartFails) {
  machine_.phase = Phase::kFailed;
  EXPECT_EQ(Verdict(), "the start-up failed");
}

TEST_F(Trials, AreUndecidedWhileTheMachineIsTakenDown) {
  for (const Phase phase : {Phase::kStopping, Phase::kStopped, Phase::kFenced}) {
    machine_.phase = phase;
    machine_.actuators[0].fault = ActuatorFault{kCodeFailed, "it is torn down"};
    EXPECT_EQ(Verdict(), "not known");
  }
}

}  // namespace musher::ota::trial_test
