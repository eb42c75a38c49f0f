// What holds after every step, and faults that broke it once.

#include "musher/lifecycle/machine/machine_invariants.hpp"

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::machine_invariants_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class BrokenInvariants : public ::testing::Test {
 protected:
  BrokenInvariants() : running_(Ours(2)) {
    running_.Begin();
    running_.Rest();
    machine_ = running_.machine();
  }
  std::string Broken() const { return BrokenInvariant(running_.config(), machine_); }
  KnownActuator& first() { return machine_.actuators[0]; }

  Harness running_;
  Machine machine_;
};

TEST_F(BrokenInvariants, AreNoneInARunningMachine) {
  EXPECT_THAT(Broken(), IsEmpty());
}

TEST_F(BrokenInvariants, AreReportedWithTheActuatorAndItsState) {
  first().presence = Presence::kLost;
  first().due = true;
  EXPECT_EQ(Broken(), "a: an actuator that is not present is to be driven; lost in Active");
}

TEST_F(BrokenInvariants, AreFoundInEveryPartOfTheMachine) {
  const auto broken_by = [this](const auto& damage) {
    machine_ = running_.machine();
    damage();
    return Broken();
  };
  EXPECT_THAT(broken_by([&] { machine_.actuators.resize(1); }), HasSubstr("1 actuator,"));
  EXPECT_THAT(broken_by([&] { first().process.termination = Termination{}; }), HasSubstr("no pid"));
  EXPECT_THAT(broken_by([&] { first().restart.at = Time{}; }), HasSubstr("started again"));
  EXPECT_THAT(broken_by([&] {
                first().command = PendingCommand{1'000'000, State("Active")};
              }),
              HasSubstr("number"));
  EXPECT_THAT(broken_by([&] { machine_.phase = Phase::kStopping; }), HasSubstr("no deadlines"));
  EXPECT_THAT(broken_by([&] {
                machine_.emergency.others.push_back({7, "", ""});
              }),
              HasSubstr("emergency stops"));
  EXPECT_THAT(broken_by([&] {
                machine_.emergency.stop = EmergencyStop{7, "", ""};
                machine_.emergency.released = {7};
              }),
              HasSubstr("released"));
  EXPECT_THAT(broken_by([&] { machine_.state = State("Protected"); }), HasSubstr("not recorded"));
  EXPECT_THAT(broken_by([&] { machine_.start_up.requests = {1}; }), HasSubstr("not answered"));
  EXPECT_THAT(broken_by([&] {
                machine_.current.emplace();
                machine_.current->number = machine_.last_switch + 1;
              }),
              HasSubstr("not given yet"));
  EXPECT_THAT(broken_by([&] {
                machine_.current.emplace();
                machine_.phase = Phase::kFenced;
              }),
              HasSubstr("idle, stopped or fenced"));
  Switch lost_command;
  lost_command.number = machine_.number;
  lost_command.legs.push_back({});
  lost_command.legs.front().progress = Leg::Progress::kUnderWay;
  machine_.last_switch = machine_.number;
  EXPECT_THAT(broken_by([&] {
                machine_.last_switch = machine_.number;
                machine_.current = lost_command;
              }),
              HasSubstr("has no command"));
}

// A takeover came before the fallback.
TEST_F(BrokenInvariants, AreNoneInAFencedMachineThatWasAboutToFallBack) {
  machine_.fallback.target = State("Protected");
  machine_.phase = Phase::kFenced;
  EXPECT_THAT(Broken(), IsEmpty());
  machine_.phase = Phase::kFailed;
  EXPECT_THAT(Broken(), HasSubstr("is to fall back"));
}

// The fault stays in the machine; it is recorded once, and the machine goes on.
TEST_F(BrokenInvariants, AreNotRecordedAgainByStepsThatDidNotBreakThem) {
  first().presence = Presence::kLost;
  first().due = true;
  const auto actions =
      Step(running_.config(), machine_, event::TimePassed{}, running_.now() + Milliseconds(1));
  for (const Action& action : actions) {
    const auto* record = std::get_if<action::Record>(&action);
    if (record == nullptr) continue;
    EXPECT_NE(record->event, EventName::kInvariantBroken) << record->message;
  }
}

// A controller begins once only; a second Begin leaves the deadlines of the TearDown behind.
TEST_F(BrokenInvariants, AreRecordedAsFailedByTheStepThatBreaksThem) {
  machine_.phase = Phase::kStopped;
  machine_.stopping.emplace();
  ASSERT_THAT(Broken(), IsEmpty());
  std::vector<std::int32_t> codes;
  for (const Action& action :
       Step(running_.config(), machine_, event::Begin{}, running_.now() + Milliseconds(1))) {
    const auto* record = std::get_if<action::Record>(&action);
    if (record != nullptr && record->event == EventName::kInvariantBroken) {
      codes.push_back(record->code);
    }
  }
  EXPECT_THAT(codes, ::testing::ElementsAre(kCodeFailed));
}

// The retry of a switch of the policy stayed the next deadline of a machine that is torn down: the
// controller's loop did not sleep any more until the machine was down.
TEST_F(BrokenInvariants, ARetryOfThePolicyIsNoDeadlineOfATearDown) {
  machine_.policy.retry_at = running_.now();
  machine_.phase = Phase::kStopping;
  machine_.stopping.emplace();
  machine_.stopping->kill_at = running_.now() + std::chrono::seconds(1);
  EXPECT_EQ(NextDeadline(running_.config(), machine_), machine_.stopping->kill_at);
}

// A late refusal by an actuator that is lost since then.
TEST(ALostActuator, IsNotTakenByALateReply) {
  Harness t(Ours(2));
  t.Begin();
  t.Rest();
  t.Mute("b", true, true);
  const ActuatorReport before = t.RecordOf("b").report;
  t.Feed(event::Vanished{1, before.incarnation, false, kOutOfReach});
  ASSERT_EQ(t.RecordOf("b").presence, Presence::kLost);
  ActuatorReport report = before;
  report.epoch += 1;
  t.Feed(event::Replied{1, 1, true, Verdict::kRefused, kCodePermissionDenied, "", report});
  EXPECT_FALSE(t.RecordOf("b").control.again);
}

// A node that another party has started, and whose protocol does not name its process: a restart
// started a second one beside it.
TEST(AnActuatorOfUnknownProcess, IsNotRestarted) {
  Harness t(Ours(2));
  t.Begin();
  t.Rest();
  ActuatorReport report = t.RecordOf("b").report;
  t.Feed(event::ProcessEnded{1, t.RecordOf("b").process.pid, true, "exit code 0"});
  report.incarnation += 1;
  report.stamp = t.now();
  report.host.clear();
  report.pid = 0;
  t.Feed(event::StatusSeen{1, report});
  t.Feed(event::Replied{1, report.number, true, Verdict::kDone, kCodeOk, "", report});
  ASSERT_EQ(t.RecordOf("b").presence, Presence::kPresent);
  const RequestId call = t.Restart("b");
  ASSERT_EQ(t.calls.count(call), 1U);
  EXPECT_EQ(t.calls.at(call).error().code, kCodeUnSupport);
  EXPECT_THAT(t.calls.at(call).error().message, HasSubstr("its process is not known"));
}

// With a time of zero the command was not given, and the loop did not sleep any more.
TEST(APowerOffWithoutTime, IsCommandedAtOnceWhereTheMachineHasNoTearDown) {
  MachineConfig config = Ours(1);
  std::erase(config.states, State("TearDown"));
  std::erase(config.actuators[0].states, State("TearDown"));
  config.policy.emplace();
  config.policy->battery.emplace().tear_down_after = Duration::zero();
  config.policy->power.delay = Duration::zero();
  config.policy->power.force_after = Duration::zero();
  Harness t(config);
  t.Begin();
  t.Rest();
  for (int i = 0; i < kConfirmingSamples; ++i) t.Feed(event::BatterySeen{0, false});
  t.Rest();
  EXPECT_EQ(t.power.size(), 1U) << ::testing::PrintToString(t.records);
}

}  // namespace musher::testing::machine_invariants_test
