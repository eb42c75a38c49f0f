// The record of an emergency stop names the participant that engaged it, even when the controller
// receives the stop from an actuator first.

#include <algorithm>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::emergency_stop_origin_test {

class EmergencyStopOrigin : public Switching {
 protected:
  EmergencyStopOrigin() : machine_(In("Active").machine()) {}

  std::vector<Action> Feed(const Event& event) {
    return Step(config_, machine_, event, machine_.actuators[1].report.stamp + Milliseconds(1));
  }
  std::vector<Action> ReportThatBHasLatched(StopId id) {
    ActuatorReport report = machine_.actuators[1].report;
    report.emergency_stop = id;
    report.stamp += Milliseconds(1);
    return Feed(event::StatusSeen{1, report});
  }

  const MachineConfig config_ = MachineOf(3);
  Machine machine_;
};

TEST_F(EmergencyStopOrigin, IsUnknownWhileOnlyAnActuatorHasReportedIt) {
  ReportThatBHasLatched(7);
  EXPECT_EQ(machine_.emergency.stop, (EmergencyStop{7, "", "b had latched it"}));
}

TEST_F(EmergencyStopOrigin, IsKnownFromAnActuatorThatHasLatchedIt) {
  ActuatorReport report = machine_.actuators[1].report;
  report.emergency_stop = 7;
  report.emergency_stop_by = "alice";
  report.emergency_stop_reason = "smoke";
  report.stamp += Milliseconds(1);
  Feed(event::StatusSeen{1, report});
  EXPECT_EQ(machine_.emergency.stop, (EmergencyStop{7, "alice", "smoke"}));
}

TEST_F(EmergencyStopOrigin, IsTakenFromTheParticipantThatEngagedItOnceReceived) {
  ReportThatBHasLatched(7);
  const EmergencyStop stop{7, "alice", "smoke"};
  const auto actions = Feed(event::EmergencyStopSeen{stop});
  EXPECT_EQ(machine_.emergency.stop, stop);
  EXPECT_TRUE(std::any_of(actions.begin(), actions.end(), [&](const Action& action) {
    const auto* save = std::get_if<action::SaveEmergencyStops>(&action);
    return save != nullptr && save->stops.engaged == std::vector{stop};
  }));
  EXPECT_TRUE(machine_.emergency.others.empty());
}

TEST_F(EmergencyStopOrigin, StaysThatOfTheFirstWhenAnotherIsEngaged) {
  ReportThatBHasLatched(7);
  Feed(event::EmergencyStopSeen{{7, "alice", "smoke"}});
  Feed(event::EmergencyStopSeen{{8, "bob", "fire"}});
  Feed(event::EmergencyStopSeen{{7, "carol", ""}});
  EXPECT_EQ(machine_.emergency.stop->by, "alice");
  EXPECT_EQ(machine_.emergency.others, (std::vector<EmergencyStop>{{8, "bob", "fire"}}));
}

}  // namespace musher::testing::emergency_stop_origin_test
