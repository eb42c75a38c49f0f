// Actuators that run on other hosts are stored for the next controller. Its TearDown lists each of
// them whose status it has not received.

#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::remote_actuator_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class RemoteActuators : public OneController {
 protected:
  static constexpr RequestId kRequest = 71;

  static RemoteActuator On(const std::string& host) { return {"b", host}; }
  // Actuator a runs on this host, b on `host`.
  void StartUpWithBOn(const std::string& host) {
    Begin();
    Come(0);
    ComeFrom(host);
    ObeyBoth(host);
    ASSERT_EQ(machine_.state, kActive);
  }
  ActuatorReport ReportOfB(const std::string& host, const State& state = kSetUp) {
    ActuatorReport report = Report(1, state);
    report.host = host;
    return report;
  }
  void ComeFrom(const std::string& host) {
    ActuatorReport report = ReportOfB(host);
    Say(1, report);
    report.epoch = machine_.epoch;
    Do(event::Replied{1, 0, true, Verdict::kDone, kCodeOk, "", report});
  }
  void ObeyBoth(const std::string& host) {
    for (int rounds = 0; rounds < 10; ++rounds) {
      if (Of(0).command) Obey(0);
      if (!Of(1).command) continue;
      const PendingCommand command = *Of(1).command;
      ActuatorReport report = ReportOfB(host, command.target);
      report.epoch = machine_.epoch;
      report.number = report.outcome_number = command.number;
      Do(event::Replied{1, command.number, false, Verdict::kDone, kCodeOk, "", report});
    }
  }
  // The next controller of this host, which receives no status of b.
  void BeginNext(bool finishes = false) {
    const std::vector<RemoteActuator> stored = Saved();
    machine_ = MakeMachine(config_);
    Forget();
    event::Begin begin;
    begin.running = {true, false};
    begin.host = "here";
    begin.remote = stored;
    begin.stop_intent = begin.restarted = finishes;
    Do(begin);
    Come(0, "Active");
    Pass(std::chrono::seconds(10));
  }
  // What is on disk: the last save.
  std::vector<RemoteActuator> Saved() const {
    const auto saves = Did<action::SaveRemoteActuators>();
    return saves.empty() ? std::vector<RemoteActuator>() : saves.back().actuators;
  }
  SwitchResult SetTearDown() {
    Do(event::SetStateRequested{kRequest, "TearDown", {}});
    return Finish();
  }
  SwitchResult Finish() {
    if (Of(0).command) Obey(0);
    Pass(std::chrono::seconds(10));
    const auto answers = Did<action::AnswerSetState>();
    if (!answers.empty()) return answers.back().result;
    EXPECT_TRUE(machine_.stopping && machine_.stopping->result);
    return machine_.stopping->result.value_or(SwitchResult{});
  }
};

TEST_F(RemoteActuators, AreStoredWithTheirHostAndOnlyWhenThatChanges) {
  StartUpWithBOn("there");
  ASSERT_THAT(Did<action::SaveRemoteActuators>(), ::testing::SizeIs(1));
  EXPECT_THAT(Saved(), ElementsAre(On("there")));
}

TEST_F(RemoteActuators, OfThisHostAreNotStored) {
  StartUpWithBOn("here");
  EXPECT_THAT(Did<action::SaveRemoteActuators>(), IsEmpty());
}

TEST_F(RemoteActuators, WithoutAHostAreStoredWhereThereMayBeOtherHosts) {
  StartUpWithBOn("");
  EXPECT_THAT(Did<action::SaveRemoteActuators>(), IsEmpty());
  config_.transport = TransportProfile::kLan;
  StartUpWithBOn("");
  EXPECT_THAT(Saved(), ElementsAre(On("")));
}

TEST_F(RemoteActuators, ThatAreTornDownAreStoredNoMore) {
  StartUpWithBOn("there");
  Do(event::SetStateRequested{kRequest, "TearDown", {}});
  Do(event::SaveEnded{Stored::kStopIntent, machine_.saves.last, true, {}});
  ObeyBoth("there");
  EXPECT_THAT(Saved(), IsEmpty());
  BeginNext();
  EXPECT_EQ(SetTearDown().outcome, SwitchOutcome::kDone);
}

TEST_F(RemoteActuators, ThatAreLostStayStored) {
  StartUpWithBOn("there");
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  EXPECT_THAT(Saved(), ElementsAre(On("there")));
}

// Found by scenarios: the host of the controller was rebooted while its link to the other host was
// cut.
TEST_F(RemoteActuators, OutOfReachOfTheNextControllerAreListedByItsTearDown) {
  StartUpWithBOn("there");
  BeginNext();
  const SwitchResult result = SetTearDown();
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(result.code, kCodeNetError);
  EXPECT_THAT(result.degraded, ElementsAre("b"));
  EXPECT_THAT(result.reason, HasSubstr("b: " + texts::MayStillRunOn("there").message));
}

TEST_F(RemoteActuators, OutOfReachOfAControllerThatFinishesATearDownAreListed) {
  StartUpWithBOn("there");
  BeginNext(/*finishes=*/true);
  EXPECT_EQ(machine_.phase, Phase::kStopped);
  EXPECT_EQ(Finish().outcome, SwitchOutcome::kDoneDegraded);
  ASSERT_TRUE(Of(1).fault);
  EXPECT_THAT(Of(1).fault, Is(texts::MayStillRunOn("there")));
}

TEST_F(RemoteActuators, OutOfReachOfEveryControllerSinceStayStored) {
  StartUpWithBOn("there");
  BeginNext();
  EXPECT_THAT(Did<action::SaveRemoteActuators>(), IsEmpty()) << "it is on disk";
  ASSERT_TRUE(Of(1).elsewhere);
  SetTearDown();
  EXPECT_EQ(Of(1).elsewhere, "there");
}

TEST_F(RemoteActuators, ThatRunOnThisHostAgainAreStoredNoMore) {
  StartUpWithBOn("there");
  BeginNext();
  Come(1);
  ASSERT_THAT(Did<action::SaveRemoteActuators>(), ::testing::SizeIs(1));
  EXPECT_THAT(Saved(), IsEmpty());
}

TEST_F(RemoteActuators, ThatAnotherControllerHasTornDownAreStoredNoMore) {
  StartUpWithBOn("there");
  BeginNext();
  ActuatorReport report = ReportOfB("there", "TearDown");
  Say(1, report);
  ASSERT_THAT(Did<action::SaveRemoteActuators>(), ::testing::SizeIs(1));
  EXPECT_THAT(Saved(), IsEmpty());
  EXPECT_EQ(SetTearDown().outcome, SwitchOutcome::kDone);
}

TEST_F(RemoteActuators, StayStoredThoughAProcessOnAThirdHostReportsTearDown) {
  StartUpWithBOn("there");
  BeginNext();
  Say(1, ReportOfB("a third host", "TearDown"));
  EXPECT_THAT(Did<action::SaveRemoteActuators>(), IsEmpty());
  EXPECT_EQ(Of(1).elsewhere, "there");
}

TEST_F(RemoteActuators, ThatHaveExitedAreStoredNoMore) {
  StartUpWithBOn("there");
  Do(event::Vanished{1, kFirst + 1, true, "its process ended"});
  EXPECT_THAT(Did<action::SaveRemoteActuators>(), ::testing::SizeIs(2));
  EXPECT_THAT(Saved(), IsEmpty());
}

TEST_F(RemoteActuators, ThatTheConfigDoesNotNameAreIgnored) {
  machine_ = MakeMachine(config_);
  event::Begin begin;
  begin.running = {false, false};
  begin.host = "here";
  begin.remote = {{"of an older config", "there"}};
  Do(begin);
  for (ActuatorIndex i = 0; i < 2; ++i) EXPECT_FALSE(Of(i).elsewhere);
}

}  // namespace musher::testing::remote_actuator_test
