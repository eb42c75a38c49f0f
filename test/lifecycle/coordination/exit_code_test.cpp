// An actuator that exits with one of its restart_prevent_exit_codes is not restarted automatically:
// a restart does not fix a configuration error.

#include <gmock/gmock.h>

#include <algorithm>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::exit_code_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Ne;
using ::testing::Not;

constexpr const char* kWords = "b.toml:7:1: error: unknown key 'sped'; did you mean 'speed'?";

// How the process of b has ended.
std::string How() {
  return std::string("exit code 2: ") + kWords;
}
// Why it is not restarted.
RecordText Prevented() {
  return texts::RestartPrevented(How(), 2, "b");
}

class ExitCode : public Switching {
 protected:
  // From now on the process of b exits as soon as it has read its config.
  static void Misconfigure(Harness& t) {
    t.On("b", "exec").exit_code = kUsageExitCode;
    t.On("b", "exec").message = kWords;
  }
  static void Fix(Harness& t) { t.On("b", "exec").exit_code = 0; }

  static std::ptrdiff_t StartsOf(const Harness& t, const std::string& name) {
    return std::ranges::count_if(t.records, [&](const action::Record& record) {
      return Says(record, EventName::kProcessStarted) &&
             record.actuator == t.config().IndexOf(name);
    });
  }

  static Result<> RestartByHand(Harness& t, const std::string& name) {
    const RequestId call = t.Restart(name);
    EXPECT_TRUE(t.RunUntil([&] { return t.calls.count(call) > 0; })) << "no answer";
    return t.calls.at(call);
  }
};

TEST_F(ExitCode, TwoIsNotRestartedAndRecordedWithTheLastLinesOfItsOutput) {
  Harness& t = In("Active", Ours(2));
  t.Exit("b", 2, kWords);
  t.Rest();
  EXPECT_EQ(StartsOf(t, "b"), 1);
  EXPECT_TRUE(t.RecordOf("b").restart.given_up);
  EXPECT_EQ(t.RecordOf("b").fault->code, kCodeFailed);
  EXPECT_THAT(t.RecordOf("b").fault, Is(Prevented()));
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  EXPECT_EQ(t.machine().state, "Active");
}

TEST_F(ExitCode, IsRecordedOnce) {
  Harness& t = In("Active", Ours(2));
  t.Exit("b", 2, kWords);
  t.Rest();
  const auto fault =
      AllOf(Field(&action::Record::kind, "actuator"), Field(&action::Record::code, Ne(kCodeOk)));
  EXPECT_THAT(t.records, Contains(fault).Times(1));
  EXPECT_THAT(t.records, Contains(Is(texts::Degraded("b", Prevented()))));
}

TEST_F(ExitCode, OtherCodesAndSignalsAreRestarted) {
  Harness& t = In("Active", Ours(2));
  t.Exit("b", 1, "the port is gone");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_EQ(StartsOf(t, "b"), 3);
}

TEST_F(ExitCode, ZeroIsNotRecordedAsAFailureAndAnyOtherIs) {
  Harness& t = In("Active", Ours(2));
  const auto code_of_end = [&] {
    std::int32_t code = -1;
    for (const action::Record& record : t.whole_records) {
      if (Says(record, EventName::kProcessExited)) code = record.code;
    }
    return code;
  };
  t.Exit("b", 1, "the port is gone");
  t.Rest();
  EXPECT_EQ(code_of_end(), kCodeFailed);
  t.Feed(event::ProcessEnded{1, t.RecordOf("b").process.pid, true, "exit code 0"});
  EXPECT_EQ(code_of_end(), kCodeOk);
}

// So that a recording from before the field exit_code existed is replayed unchanged.
TEST_F(ExitCode, ThatIsUnknownIsNotReadFromTheText) {
  Harness& t = In("Active", Ours(2));
  t.Feed(event::ProcessEnded{1, t.RecordOf("b").process.pid, false, "exit code 2: no such map"});
  EXPECT_TRUE(t.RecordOf("b").restart.at);
}

TEST_F(ExitCode, ThatTheConfigNamesCountsInsteadOfTwo) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").restart.prevent_exit_codes = {3, 78};
  Harness& t = In("Active", config);
  t.Exit("b", 2, "panic: no such map");
  t.Rest();
  ASSERT_EQ(t.StateOf("b"), "Active");
  t.Exit("b", 78, "no licence");
  t.Rest();
  EXPECT_FALSE(t.IsAlive("b"));
  EXPECT_THAT(t.RecordOf("b").fault,
              Is(texts::RestartPrevented("exit code 78: no licence", 78, "b")));
}

TEST_F(ExitCode, NoneMeansThatAllAreRestarted) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").restart.prevent_exit_codes = {};
  Harness& t = In("Active", config);
  t.Exit("b", 2, kWords);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(ExitCode, CountsForAlwaysToo) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").restart.policy = RestartPolicy::kAlways;
  Harness& t = In("Active", config);
  t.Exit("b", 2, kWords);
  t.Rest();
  EXPECT_FALSE(t.IsAlive("b"));
}

TEST_F(ExitCode, OfACriticalActuatorTakesTheMachineToItsOnLostAtOnce) {
  Harness& t = In("Active", OursWithCriticalB());
  t.Exit("b", 2, kWords);
  t.RunFor(Milliseconds(50));
  EXPECT_EQ(t.machine().state, "Protected") << "its first restart would come after 100 ms";
  EXPECT_THAT(t.Set("Active").reason, HasSubstr("critical b"));
}

TEST_F(ExitCode, IsTheCauseOfWhatFollowsFromIt) {
  Harness& t = In("Active", OursWithCriticalB());
  const std::int32_t pid = t.RecordOf("b").process.pid;
  t.Exit("b", 2, kWords);
  t.Rest();
  EXPECT_THAT(Why(t.whole_records, EventName::kFallbackStarted),
              Are(texts::FallbackStarted("Protected"), texts::Degraded("b", Prevented()),
                  texts::ProcessExited("b", pid, How())));
}

TEST_F(ExitCode, InACrashLoopEndsIt) {
  Harness& t = In("Active", Ours(2));
  Misconfigure(t);
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(StartsOf(t, "b"), 2);
  EXPECT_THAT(t.RecordOf("b").fault, Is(Prevented()));
}

TEST_F(ExitCode, InASwitchUpUndoesIt) {
  Harness& t = In("Protected", Ours(3));
  t.On("b", "Active").takes = Milliseconds(80);
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(30));
  t.Exit("b", 2, kWords);
  t.Rest();
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
  EXPECT_THAT(Of(t.answers.at(request), "b").message, HasSubstr(kWords));
  EXPECT_EQ(StartsOf(t, "b"), 1);
}

TEST_F(ExitCode, OfAnActuatorTornDownAloneCountsLikeAnyOther) {
  Harness& t = In("Active", Ours(2));
  EXPECT_TRUE(t.Set("TearDown", "b").done());
  t.Exit("b", 2, kWords);
  t.Rest();
  EXPECT_THAT(t.RecordOf("b").fault, Is(EventName::kTornDownAlone));
}

// By request

TEST_F(ExitCode, IsClearedByARestartRequest) {
  Harness& t = In("Active", OursWithCriticalB());
  Misconfigure(t);
  t.Exit("b", 2, kWords);
  t.Rest();
  const Result<> in_vain = RestartByHand(t, "b");
  ASSERT_FALSE(in_vain);
  EXPECT_THAT(in_vain.error().message, HasSubstr(kWords));
  EXPECT_EQ(StartsOf(t, "b"), 2) << "once for each request";
  Fix(t);
  EXPECT_TRUE(RestartByHand(t, "b"));
  EXPECT_FALSE(t.RecordOf("b").restart.given_up);
  EXPECT_EQ(t.StateOf("b"), "Protected") << "where the machine is";
  EXPECT_TRUE(t.Set("Active").done());
}

TEST_F(ExitCode, OfAProcessTerminatedForARestartDoesNotPreventTheRestart) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "TearDown").hangs = true;
  const RequestId call = t.Restart("b");
  t.RunFor(Milliseconds(20));
  t.Exit("b", 2, "interrupted");
  t.Rest();
  ASSERT_EQ(t.calls.count(call), 1U);
  EXPECT_TRUE(t.calls.at(call));
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(ExitCode, OfAProcessTerminatedForARestartIsNotRecordedAsFinal) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "TearDown").hangs = true;
  t.Restart("b");
  t.RunFor(Milliseconds(20));
  const std::int32_t pid = t.RecordOf("b").process.pid;
  t.Exit("b", 2, "interrupted");
  t.Rest();
  EXPECT_THAT(t.records, Contains(Is(texts::ProcessExited("b", pid, "exit code 2: interrupted"))));
  EXPECT_THAT(t.records, Not(Contains(Is(EventName::kRestartPrevented))));
}

TEST_F(ExitCode, IsRetriedByTheNextController) {
  Harness& t = In("Active", Ours(2));
  t.Exit("b", 2, kWords);
  t.Rest();
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
}

// While the machine starts

TEST_F(ExitCode, AtTheStartOfACriticalActuatorFailsTheStartUpAtOnce) {
  Harness t(OursWithCriticalB());
  Misconfigure(t);
  t.Begin();
  t.RunFor(Milliseconds(90));
  ASSERT_TRUE(t.start_up()) << "its first restart would come after 100 ms";
  EXPECT_FALSE(t.usable());
  EXPECT_THAT(t.start_up()->message,
              HasSubstr("critical b: 101 (Robot: Failed), " + Prevented().message));
  EXPECT_EQ(StartsOf(t, "b"), 1);
  Fix(t);
  EXPECT_TRUE(RestartByHand(t, "b"));
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
}

TEST_F(ExitCode, AtTheStartOfANonCriticalActuatorLeavesTheMachineWithoutIt) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "c").after = {"b"};
  Harness t(config);
  Misconfigure(t);
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_EQ(t.StateOf("a"), "Active");
  EXPECT_FALSE(t.IsAlive("c"));
  EXPECT_THAT(t.RecordOf("c").fault, Is(texts::DependencyDegraded("b", Prevented().message)));
  Fix(t);
  EXPECT_TRUE(RestartByHand(t, "b"));
  t.Rest();
  EXPECT_EQ(t.StateOf("c"), "Active") << "what was missing is there";
  EXPECT_THAT(Degraded(t.config(), t.machine()), IsEmpty());
}

TEST_F(ExitCode, OfAnActuatorOfALaterStageLeavesTheFirstStageAsItIs) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").stage = 2;
  Harness t(config);
  Misconfigure(t);
  t.Begin();
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(StartsOf(t, "b"), 1);
  EXPECT_THAT(t.records, Not(Contains(Is(EventName::kRestartScheduled))));
}

}  // namespace musher::testing::exit_code_test
