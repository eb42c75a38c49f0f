// During an emergency stop no actuator goes to another state of the same rank, either: its callback
// may switch on again what the stop has switched off.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::emergency_stop_level_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

// Machines with Dancing, which is as active as Active.
MachineConfig Dancers() {
  MachineConfig config = MachineOf(2);
  config.states.emplace_back("Dancing");
  config.ranks["Dancing"] = *BuiltInRank(kActive);
  config.flow = DefaultFlow(config.states);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.states = config.states;
    actuator.times.push_back(Milliseconds(100));
  }
  return config;
}

class StoppedDancers : public Switching {
 protected:
  static void Stop(Harness& t) {
    t.StopAll(5);
    t.RunFor(Milliseconds(1));
  }
};

TEST_F(StoppedDancers, StayInTheirState) {
  Harness& t = In("Active", Dancers());
  Stop(t);
  EXPECT_EQ(t.Set("Dancing").code, kCodeProtectedError);
  EXPECT_EQ(t.Set("Dancing", "b").code, kCodeProtectedError);
  EXPECT_THAT(t.log(), IsEmpty());
  t.Release();
  EXPECT_TRUE(t.Set("Dancing").done());
}

TEST_F(StoppedDancers, AreBroughtBackToTheStateOfTheMachineAfterTheRelease) {
  Harness& t = In("Active", Dancers());
  Stop(t);
  ActuatorReport report = t.CoreOf("b").report;
  report.stamp = t.now();
  report.state = "Dancing";  // by itself
  t.Feed(event::StatusSeen{1, report});
  t.Rest();
  EXPECT_THAT(t.log(), IsEmpty());
  EXPECT_FALSE(t.RecordOf("b").fault) << "it was not commanded, and has refused nothing";
  t.Release();
  t.Rest();
  EXPECT_EQ(t.RecordOf("b").state(), "Active");
}

// A module of another protocol would run the callback: it does not receive the stop.
using DancersOfAnyProtocol = OneController;

TEST_F(DancersOfAnyProtocol, AreNotCommandedOnceTheStopIsEngaged) {
  config_ = Dancers();
  config_.actuators[1].after = {"a"};
  StartUp();
  Do(event::SetStateRequested{1, "Dancing", {}});
  ASSERT_TRUE(Of(0).command);
  Do(event::EmergencyStopSeen{{7, "alice", "smoke"}});
  Obey(0);
  EXPECT_FALSE(Of(1).command);
  ASSERT_THAT(Did<action::AnswerSetState>(), SizeIs(1));
  const SwitchResult result = Did<action::AnswerSetState>()[0].result;
  EXPECT_EQ(result.actuators.at(1).outcome, ActuatorOutcome::kRefused);
  EXPECT_EQ(result.actuators.at(1).code, kCodeProtectedError);
}

}  // namespace musher::testing::emergency_stop_level_test
