// With [safety] permit_ms an actuator moves only while permits arrive.

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <map>

#include "musher/test/lifecycle/one_actuator.hpp"

namespace musher::actuator_permit_test {

using namespace actuator_action;  // NOLINT(google-build-using-namespace)
using actuator_event::CallbackEnded;
using actuator_event::EmergencyStopReceived;
using actuator_event::PermitReceived;
using actuator_event::TimePassed;
using testing::Actions;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::VariantWith;

constexpr Duration kPermit = Milliseconds(500);
constexpr Sender kHolder = 42;
const auto kRuns = Contains(VariantWith<RunEmergencyStop>(RunEmergencyStop{}));

class Permitted : public testing::OneActuator {
 protected:
  Permitted() {
    config_.permit = kPermit;
    SetUpIt();
    Switch(1, "DeActive");
  }

  // A permit that was given at `given` by the clock of this actuator; that of each sender is apart
  // from it.
  Actions Give(Time given, Sender sender = kHolder) {
    const std::chrono::minutes own(static_cast<int>(sender.value()));
    return Do(PermitReceived{sender, given + apart_ + own, "alice"});
  }
  Actions Give() { return Give(now_); }
  Actions Wait(Duration time) {
    now_ += time;
    return Do(TimePassed{});
  }
  void Release() { Do(EmergencyStopReceived{core_.report.emergency_stop, false, 1}); }
  // A command that does not become too old while it waits.
  actuator_event::SwitchArrived Lasting(CommandNumber n, const State& target) {
    auto command = Command(n, target);
    command.command.budget = std::chrono::seconds(10);
    return command;
  }
  bool stopped() const { return core_.report.emergency_stop != 0; }
  void Move() {
    Give();
    Switch(2, "Active");
  }

  Duration apart_ = std::chrono::minutes(7);
};

TEST_F(Permitted, ItMovesWhileTheyArrive) {
  Move();
  for (int i = 0; i < 100; ++i) {
    Wait(Milliseconds(50));
    Give();
  }
  EXPECT_FALSE(stopped());
}

TEST_F(Permitted, ItStopsWhenNoneArrives) {
  Move();
  EXPECT_THAT(Wait(kPermit - Milliseconds(1)), IsEmpty());
  EXPECT_EQ(NextDeadline(config_, 0, core_), now_ + Milliseconds(1));
  EXPECT_THAT(Wait(Milliseconds(1)), kRuns);
  EXPECT_EQ(core_.report.emergency_stop_by, "[safety] permit_ms");
  EXPECT_EQ(core_.report.emergency_stop_reason, "no permit of alice has arrived for 500 ms");
}

TEST_F(Permitted, ItStaysStoppedWhenTheyArriveAgainUntilThatIsReleased) {
  Move();
  Wait(kPermit);
  Give();
  EXPECT_TRUE(stopped());
  Release();
  EXPECT_FALSE(stopped());
  EXPECT_TRUE(core_.report.held_by_stop);
  Do(Command(3, "Active"));
  Do(CallbackEnded{});
  EXPECT_FALSE(core_.report.held_by_stop);
}

TEST_F(Permitted, ItStopsAgainAtTheReleaseWhileNoneArrives) {
  Move();
  Wait(kPermit);
  const StopId first = core_.report.emergency_stop;
  Release();
  EXPECT_EQ(core_.report.released_stop, first);
  EXPECT_THAT(Wait({}), kRuns);
  EXPECT_TRUE(stopped());
  EXPECT_NE(core_.report.emergency_stop, first);
}

TEST_F(Permitted, UnderAnotherStopItEngagesNoneUntilThatIsReleased) {
  Move();
  Do(EmergencyStopReceived{StopId(7), true, 5});
  EXPECT_EQ(NextDeadline(config_, 0, core_), std::nullopt);
  EXPECT_THAT(Wait(std::chrono::hours(1)), IsEmpty());
  EXPECT_EQ(core_.stops.size(), 1U);
  Release();
  EXPECT_THAT(Wait({}), kRuns) << "there is still no permit";
}

TEST_F(Permitted, ADroppedStopAmongManyIsNotForgottenAtTheRelease) {
  Move();
  Wait(kPermit);
  for (int i = 0; i < 100; ++i)
    Do(EmergencyStopReceived{StopId(static_cast<std::uint64_t>(1000 + i)), true, 5});
  while (stopped()) Release();
  EXPECT_THAT(Wait({}), kRuns) << "there is still no permit";
}

TEST_F(Permitted, ItNeedsNoneBelowAndInDeActive) {
  EXPECT_THAT(Wait(std::chrono::hours(1)), IsEmpty());
  EXPECT_EQ(NextDeadline(config_, 0, core_), std::nullopt);
  EXPECT_FALSE(stopped());
}

TEST_F(Permitted, ACommandToAProcessThatHasJustStartedWaitsForTheFirstOne) {
  EXPECT_THAT(AnswersIn(Do(Command(2, "Active"))), IsEmpty());
  EXPECT_THAT(Wait(Milliseconds(80)), IsEmpty());
  EXPECT_THAT(Give(), Contains(VariantWith<RunCallback>(RunCallback{"Active"})));
}

TEST_F(Permitted, ACommandThatWaitsForTheFirstOneInVainIsRefusedByAStop) {
  Do(Lasting(2, "Active"));
  EXPECT_EQ(NextDeadline(config_, 0, core_), now_ + std::chrono::seconds(1));
  const Actions actions = Wait(std::chrono::seconds(1));
  EXPECT_THAT(actions, kRuns);
  EXPECT_EQ(AnswerIn(actions).code, kCodeProtectedError);
}

TEST_F(Permitted, ACommandDownReplacesOneThatWaits) {
  Do(Command(2, "Active"));
  const Actions actions = Do(Command(3, "LowPower"));
  EXPECT_THAT(actions, Contains(VariantWith<RunCallback>(RunCallback{"LowPower"})));
  EXPECT_EQ(core_.waiting, std::nullopt);
}

TEST_F(Permitted, WithoutOneACommandUpIsRefusedByAStop) {
  now_ += std::chrono::seconds(1);
  const Actions actions = Do(Command(2, "Active"));
  EXPECT_EQ(AnswerIn(actions).code, kCodeProtectedError);
  EXPECT_EQ(core_.report.emergency_stop_reason, "no permit to move has arrived");
  EXPECT_THAT(actions, Not(Contains(VariantWith<RunCallback>(RunCallback{"Active"}))));
}

TEST_F(Permitted, WithoutOneACommandThatIsOutdatedStopsNothing) {
  auto old = Command(2, "Active");
  now_ += std::chrono::seconds(1);
  EXPECT_EQ(AnswerIn(Do(old)).code, kCodeTimeout);
  EXPECT_FALSE(stopped());
}

TEST_F(Permitted, ItStopsInTheMiddleOfACallbackThatLeadsUp) {
  Give();
  Do(Command(2, "Active"));
  const Actions actions = Wait(kPermit);
  EXPECT_THAT(actions, kRuns);
  EXPECT_THAT(actions, Contains(VariantWith<RequestStop>(RequestStop{})));
  Do(CallbackEnded{});
  EXPECT_EQ(core_.report.state, "DeActive");
}

TEST_F(Permitted, ItGoesDownWithoutOne) {
  Move();
  Wait(kPermit);
  Switch(3, "DeActive");
  Release();
  EXPECT_THAT(Wait(kPermit), IsEmpty());
  EXPECT_FALSE(stopped());
}

TEST_F(Permitted, ARepeatedOneCountsOnce) {
  Move();
  const Time given = now_;
  for (int i = 0; i < 10; ++i) {
    now_ += Milliseconds(45);
    Give(given);
  }
  EXPECT_THAT(Wait(Milliseconds(51)), kRuns) << "a bridge repeats what it has received";
}

TEST_F(Permitted, OneThatWasHeldBackOnTheWayCountsFromWhenItWasGiven) {
  Move();
  const Time given = now_ + Milliseconds(100);
  now_ += Milliseconds(400);
  Give(given);
  EXPECT_LE(NextDeadline(config_, 0, core_), given + kPermit + Milliseconds(1));
}

// Its process was frozen. The first one counted, and its stop was another one than that of others.
TEST_F(Permitted, OfThoseThatComeTogetherTheLastOneCounts) {
  const Time first = now_;
  now_ += std::chrono::seconds(4);
  for (Time given = first; given <= now_; given += Milliseconds(50)) Give(given);
  const std::chrono::minutes own(static_cast<int>(kHolder.value()));
  EXPECT_EQ(core_.permit.stamp, now_ + apart_ + own);
  EXPECT_EQ(core_.permit.until, now_ + kPermit);
}

TEST_F(Permitted, ClocksThatDivergeByATenThousandthDoNotStopIt) {
  Move();
  for (int i = 0; i < 200'000; ++i) {  // 2.8 hours
    now_ += Milliseconds(50);
    apart_ -= std::chrono::microseconds(5);
    Give();
    ASSERT_GT(*NextDeadline(config_, 0, core_), now_ + Milliseconds(490)) << i;
  }
}

TEST_F(Permitted, OneWithAStampThatNoClockHasCountsForNothing) {
  now_ += std::chrono::seconds(1);
  for (const Time stamp : {Time(), Time() - Milliseconds(1), Time::max(), Time::min()}) {
    Do(PermitReceived{kHolder, stamp, "mallory"});
  }
  Do(Command(2, "Active"));
  EXPECT_TRUE(stopped());
}

TEST_F(Permitted, AnotherPersonMayGoOnGivingThem) {
  Move();
  Wait(Milliseconds(300));
  apart_ = -std::chrono::minutes(20);
  Give(now_, 43);
  Wait(Milliseconds(300));
  EXPECT_FALSE(stopped());
  EXPECT_THAT(Wait(Milliseconds(200)), kRuns);
}

// Each sample of one console made the next one of the other console count as fresh.
TEST_F(Permitted, TwoSendersThatAlternateMakeNoOldOneFresh) {
  Move();
  Give(now_, 43);
  const Time moved = now_;
  Time given = now_;
  for (int i = 0; i < 18; ++i) {  // both links hold back ever more
    now_ += Milliseconds(25);
    given += Milliseconds(2);
    Give(given, i % 2 == 0 ? kHolder : Sender(43));
  }
  EXPECT_FALSE(stopped());
  EXPECT_LE(NextDeadline(config_, 0, core_), given + kPermit + Milliseconds(1));
  now_ = moved + kPermit;
  EXPECT_THAT(Wait(Milliseconds(40)), kRuns);
}

TEST_F(Permitted, AThirdSenderMakesNoOldOneOfTheOthersFresh) {
  Move();
  Give(now_, 43);
  Wait(Milliseconds(100));
  Give(now_, 44);
  const Time newest = now_;
  for (const Sender sender : {kHolder, Sender(43), Sender(44)}) {
    Wait(Milliseconds(100));
    Give(newest - Milliseconds(50), sender);
  }
  EXPECT_LE(NextDeadline(config_, 0, core_), newest + kPermit + Milliseconds(1));
}

TEST_F(Permitted, OfTooManySendersTheOneSilentForLongestIsForgotten) {
  Move();
  const Time first = now_;
  for (std::uint64_t i = 1; i <= 100; ++i) {
    now_ += Milliseconds(1);
    Give(now_, Sender(kHolder.value() + i));
    if (i == 50) Give();
  }
  EXPECT_EQ(core_.permit.senders.size(), 64U);
  const Time newest = now_;
  Wait(Milliseconds(400));
  Give(first);
  EXPECT_LE(NextDeadline(config_, 0, core_), newest + kPermit + Milliseconds(2))
      << "the holder was received after most of the others";
}

TEST_F(Permitted, OneOfAnUnknownSenderCountsForNothing) {
  now_ += std::chrono::seconds(1);
  Give(now_, 0);
  Do(Command(2, "Active"));
  EXPECT_TRUE(stopped());
}

TEST_F(Permitted, WithoutTheKeyNoneIsNeededAndNoneIsKept) {
  config_.permit.reset();
  Move();
  EXPECT_EQ(NextDeadline(config_, 0, core_), std::nullopt);
  EXPECT_EQ(core_.permit.until, Time());
  EXPECT_EQ(core_.permit.senders, std::vector<PermitSender>());
}

// Whatever arrives, late, repeated, in whichever order, of several senders: an actuator in Active
// has received a permit that was given within permit_ms, or it is stopped. The first of a sender
// is not late: a delay of all its samples looks like a difference of the clocks.
RC_GTEST_FIXTURE_PROP(Permitted, ItNeverMovesOnAnOlderOne, ()) {
  Move();
  Time newest = now_;
  std::map<Sender, std::vector<Time>> given = {{kHolder, {now_}}};
  const int steps = *rc::gen::inRange(1, 60);
  for (int i = 0; i < steps; ++i) {
    const Time next = now_ + Milliseconds(*rc::gen::inRange(0, 300));
    for (auto due = NextDeadline(config_, 0, core_); due && *due <= next;
         due = NextDeadline(config_, 0, core_)) {
      now_ = std::max(now_, *due);
      Do(TimePassed{});
    }
    now_ = next;
    const Sender sender(*rc::gen::inRange<std::uint64_t>(kHolder.value(), kHolder.value() + 4));
    std::vector<Time>& of_sender = given[sender];
    if (of_sender.empty() || *rc::gen::inRange(0, 3) == 0) of_sender.push_back(now_);
    const Time sent = of_sender[*rc::gen::inRange<std::size_t>(0, of_sender.size())];
    Give(sent, sender);
    newest = std::max(newest, sent);
    if (*rc::gen::inRange(0, 10) == 0) Release();
    if (core_.report.emergency_stop == 0 && NextDeadline(config_, 0, core_) > now_) {
      RC_ASSERT(now_ - newest < kPermit + Milliseconds(20));  // of clocks that may diverge
    }
  }
}

}  // namespace musher::actuator_permit_test
