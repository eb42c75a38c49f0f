// How long TearDown waits for its intent to be on disk, and the controller that finishes a TearDown
// waits for actuators.

#include <gmock/gmock.h>

#include <algorithm>
#include <utility>

#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::stop_intent_test {

using ::testing::ElementsAre;
using ::testing::StartsWith;

using StopIntent = Switching;

TEST_F(StopIntent, IsAwaitedThoughAnotherSaveEnds) {
  Harness& t = In("Active", Ours(1));
  t.disk_takes.reset();
  t.StopAll(7);
  t.RunFor(Milliseconds(1));
  ASSERT_EQ(t.machine().saves.unsaved.size(), 1U);
  const Unsaved stop = t.machine().saves.unsaved[0];
  t.RequestSwitch("TearDown");
  t.Feed(event::SaveEnded{stop.what, stop.save, true, ""});
  t.RunFor(Milliseconds(20));
  EXPECT_THAT(t.log(), ElementsAre());
}

TEST_F(StopIntent, IsAwaitedForHalfASecondAndForATenthOfTheBudgetAtMost) {
  for (const auto& [budget, wait] : {std::pair(10'000, 500), std::pair(1000, 100)}) {
    MachineConfig config = Ours(1);
    config.shutdown_budget = Milliseconds(budget);
    Harness& t = In("Active", config);
    t.disk_takes.reset();
    const Time begun = t.now();
    t.RequestSwitch("TearDown");
    ASSERT_TRUE(t.RunUntil([&] { return !t.log().empty(); }));
    EXPECT_EQ(ToMilliseconds(t.now() - begun), wait);
  }
}

// It was in the history only: a supervisor started the robot up that a person had taken down.
TEST_F(StopIntent, ThatIsNotOnDiskIsNamedByTheAnswer) {
  Harness& t = In("Active", Ours(1));
  t.disk_fails = "read-only file system";
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDone) << "the machine is down";
  EXPECT_EQ(result.code, kCodeOk);
  EXPECT_EQ(result.reason,
            "not on disk: intent to stop (read-only file system); a supervisor that starts the "
            "controller again brings the machine up");
}

TEST_F(StopIntent, ThatADiskHasNotAnsweredIsNamedByTheAnswer) {
  Harness& t = In("Active", Ours(1));
  t.disk_takes.reset();
  EXPECT_THAT(t.Set("TearDown").reason, StartsWith("not on disk: intent to stop; a supervisor"));
}

TEST_F(StopIntent, ThatIsOnDiskIsNotNamed) {
  EXPECT_EQ(In("Active", Ours(1)).Set("TearDown").reason, "");
}

// The supervisor that sends it decides about the next start.
TEST_F(StopIntent, OfASignalIsNotNamed) {
  Harness& t = In("Active", Ours(1));
  t.disk_fails = "read-only file system";
  constexpr RequestId kSignal = 1000;
  t.Feed(event::SetStateRequested{kSignal, "TearDown", {}, AfterTearDown::kMayStart});
  ASSERT_TRUE(t.RunUntil([&] { return t.answers.contains(kSignal); }));
  EXPECT_EQ(t.answers.at(kSignal).reason, "");
}

TEST(FinishingATearDown, WaitsThreeSecondsForAnActuatorThatRunsAndIsSilent) {
  MachineConfig config = MachineOf(1);
  config.actuators[0].times.assign(config.states.size(), std::chrono::seconds(10));
  Harness t(config);
  t.disk().stop_intent = true;
  const Time begun = t.now();
  t.Begin(false, 0, /*restarted=*/true);
  t.Mute("a", true, true);
  ASSERT_TRUE(t.RunUntil([&] { return t.machine().phase != Phase::kStarting; }));
  EXPECT_EQ(t.now() - begun, std::chrono::seconds(3));
}

TEST(FinishingATearDown, IsRecordedWithTheStartOfTheSupervisor) {
  Harness t(MachineOf(1));
  t.disk().stop_intent = true;
  t.Begin(false, 0, /*restarted=*/true);
  ASSERT_GE(t.whole_records.size(), 2U);
  const action::Record& resumed = t.whole_records[1];
  EXPECT_THAT(resumed, Is(texts::TearDownResumedBySupervisor()));
  EXPECT_EQ(resumed.code, kCodeOk);
  EXPECT_EQ(resumed.cause, t.whole_records[0].id);
}

TEST(FinishingATearDown, DoesNotWaitForAMusherActuatorThatDoesNotRun) {
  MachineConfig config = Ours(1);
  config.actuators[0].times.assign(config.states.size(), std::chrono::seconds(10));
  Harness t(config);
  t.disk().stop_intent = true;
  const Time begun = t.now();
  t.Begin(false, 0, /*restarted=*/true);
  ASSERT_TRUE(t.RunUntil([&] { return t.stopped(); }));
  EXPECT_LT(t.now() - begun, std::chrono::seconds(1));
}

// After a controller that was killed in a TearDown, which its processes go on with.
class FinishingATearDownOfProcesses : public Switching {
 protected:
  // Until the TearDown of `a` runs.
  Harness& InTearDown(Duration takes) {
    MachineConfig config = Ours(2);
    for (ActuatorConfig& actuator : config.actuators) {
      actuator.times.assign(config.states.size(), std::chrono::seconds(10));
    }
    Harness& t = In("Active", config);
    t.On("a", "TearDown").takes = takes;
    t.RequestSwitch("TearDown");
    EXPECT_TRUE(t.RunUntil([&] { return std::ranges::count(t.log(), "a:TearDown") > 0; }));
    t.ClearLog();
    return t;
  }
  // Within a second, and without a start.
  static void ExpectDown(Harness& t) {
    t.RunFor(std::chrono::seconds(1));
    EXPECT_TRUE(t.stopped());
    EXPECT_THAT(t.log(), ::testing::Not(::testing::Contains("a:SetUp")));
    for (const char* name : {"a", "b"}) EXPECT_FALSE(t.IsAlive(name)) << name;
  }
};

TEST_F(FinishingATearDownOfProcesses, NeitherStartsNorAwaitsOneThatExitsBeforeItAnswers) {
  Harness& t = InTearDown(Milliseconds(20));
  t.DelayReports("a", std::chrono::seconds(2));
  t.RestartController(false, /*restarted=*/true);
  ExpectDown(t);
}

TEST_F(FinishingATearDownOfProcesses, StartsNoneThatIsKilledWhileAnotherOneIsAwaited) {
  Harness& t = InTearDown(Milliseconds(600));
  t.DelayReports("b", Milliseconds(500));
  t.RestartController(false, /*restarted=*/true);
  ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("a").presence == Presence::kPresent; }));
  ASSERT_NE(t.RecordOf("b").presence, Presence::kPresent);
  t.Crash("a");
  ExpectDown(t);
}

// The intent was lost, as with a full disk, or cleared by a person's start: only an actuator says
// that the machine is being torn down, and exits before all have announced themselves.
class StartBesideATearDown : public Switching, public ::testing::WithParamInterface<bool> {};

TEST_P(StartBesideATearDown, FinishesItAlsoWhenItsActuatorHasExited) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "a").after = {"b"};  // b is torn down after it
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.times.assign(config.states.size(), std::chrono::seconds(10));
  }
  Harness& t = In("Active", config);
  t.On("a", "TearDown").takes = Milliseconds(200);
  t.RequestSwitch("TearDown");
  ASSERT_TRUE(t.RunUntil([&] { return !t.log().empty(); }));
  t.ClearLog();
  t.disk().stop_intent = false;
  t.DelayReports("b", Milliseconds(1000));
  t.RestartController(false, /*restarted=*/GetParam());
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("b:TearDown"));
  EXPECT_TRUE(t.stopped());
  EXPECT_TRUE(t.disk().stop_intent);
  for (const char* name : {"a", "b"}) EXPECT_FALSE(t.IsAlive(name)) << name;
}

INSTANTIATE_TEST_SUITE_P(By, StartBesideATearDown, ::testing::Bool(), [](const auto& restarted) {
  return restarted.param ? "ASupervisor" : "APerson";
});

// What a controller that is torn down searches for once the known processes have exited.
class SearchAtTheEnd : public OneController {
 protected:
  SearchAtTheEnd() {
    for (ActuatorConfig& actuator : config_.actuators) actuator.command = {"run", actuator.name};
  }
  // Ends with the exit of the last process of the controller.
  void TearDownWithProcesses() {
    Begin();
    for (ActuatorIndex i = 0; i < 2; ++i) {
      Do(event::ProcessStarted{i, static_cast<std::int32_t>(700 + i.value())});
    }
    for (ActuatorIndex i = 0; i < 2; ++i) Come(i);
    ObeyAll();
    Do(event::SetStateRequested{1, "TearDown", {}});
    ObeyAll();
    EXPECT_TRUE(Did<action::FindProcesses>().empty()) << "known processes are left";
    for (ActuatorIndex i = 0; i < 2; ++i) {
      Do(event::ProcessEnded{i, static_cast<std::int32_t>(700 + i.value()), true, "exit code 0"});
    }
  }
};

TEST_F(SearchAtTheEnd, BeginsAtOnceWhenTheLastProcessHasExited) {
  processes_ = {0, 0};
  TearDownWithProcesses();
  EXPECT_EQ(Did<action::FindProcesses>().size(), 1U);
  EXPECT_EQ(machine_.phase, Phase::kStopped);
}

TEST_F(SearchAtTheEnd, IsRepeatedWhenAProcessThatWasFoundHasExited) {
  processes_ = {900, 0};
  TearDownWithProcesses();
  ASSERT_EQ(machine_.phase, Phase::kStopping);
  processes_ = {0, 901};
  Do(event::ProcessEnded{0, 900, false, "killed by SIGTERM"});
  EXPECT_EQ(Did<action::FindProcesses>().size(), 2U);
  EXPECT_EQ(machine_.phase, Phase::kStopping) << "another one runs";
  processes_ = {0, 0};
  Do(event::ProcessEnded{1, 901, false, "killed by SIGTERM"});
  EXPECT_EQ(machine_.phase, Phase::kStopped);
}

TEST_F(SearchAtTheEnd, IsFollowedByNoCommandToAnActuatorThatArrivesLater) {
  processes_ = {0, 0};
  TearDownWithProcesses();
  ASSERT_EQ(machine_.phase, Phase::kStopped);
  Forget();
  ActuatorReport report = Report(0);
  report.incarnation = 90;
  Say(0, report);
  EXPECT_TRUE(Did<action::SendQuery>().empty());
  EXPECT_FALSE(Of(0).set_up_by);
}

}  // namespace musher::testing::stop_intent_test
