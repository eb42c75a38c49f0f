// The clock of a module's behaviour: steady, or what the topic /clock says.

#include "musher/transport/clock.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::transport::clock_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Log = std::vector<std::string>;
using std::chrono::seconds;
using ClockWriter = std::unique_ptr<Publisher<msg::Clock>>;

TEST(SteadyClock, IsTheLoopsTime) {
  sim::Network network(1);
  const auto node = network.MakeNode("dog");
  const auto clock = Clock::Steady(node->loop());
  Log log;
  const auto once = clock->At(clock->Now() + seconds(2), [&] { log.push_back("once"); });
  const auto always = clock->Every(seconds(1), [&] { log.push_back("tick"); });
  network.RunFor(Milliseconds(2500));
  EXPECT_EQ(clock->Now(), node->loop().Now());
  EXPECT_THAT(log, ElementsAre("tick", "once", "tick"));
}

TEST(SteadyClock, StampsWithTheTimeOfDay) {
  sim::Network network(7);
  const auto node = network.MakeNode("dog");
  const auto before = std::chrono::system_clock::now().time_since_epoch();
  const Duration stamped = msg::FromStamp(Clock::Steady(node->loop())->Stamp());
  EXPECT_GE(stamped, before);
  EXPECT_LE(stamped, std::chrono::system_clock::now().time_since_epoch());
}

TEST(Stamp, HoldsNanosecondsOnBothSidesOfZero) {
  EXPECT_EQ(msg::ToStamp(Milliseconds(1250)), (msg::Stamp{1, 250'000'000}));
  EXPECT_EQ(msg::ToStamp(Milliseconds(-250)), (msg::Stamp{-1, 750'000'000}));
  EXPECT_EQ(msg::FromStamp({-1, 750'000'000}), Milliseconds(-250));
}

// A world that says what time it is, and a module that listens.
class TopicClock : public ::testing::Test {
 protected:
  void SetUp() override { Settle(); }

  // The world shows `ms` since its start.
  void Show(std::int64_t ms) { Show(world_, msg::ToStamp(Milliseconds(ms))); }
  void Show(const ClockWriter& world, const msg::Stamp& stamp) {
    ASSERT_TRUE(world->Publish({stamp}));
    Settle();
  }
  ClockWriter MakeWorld() {
    ClockWriter world = MakePublisher<msg::Clock>(*desk_, kClockTopic, kClockQos).value();
    Settle();
    return world;
  }
  void Settle() { network_.RunFor(Milliseconds(20)); }
  static Time At(std::int64_t ms) { return Time{} + Milliseconds(ms); }
  std::function<void()> Say(const std::string& what) {
    return [this, what] { log_.push_back(what); };
  }

  sim::Network network_{7};
  Log log_;
  std::unique_ptr<Node> desk_ = network_.MakeNode("desk");
  std::unique_ptr<Node> dog_ = network_.MakeNode("dog");
  ClockWriter world_ = MakeWorld();
  std::unique_ptr<Clock> clock_ = Clock::FromTopic(*dog_, Say("restarted")).value();
};

TEST_F(TopicClock, StandsAtZeroAndFiresNothingBeforeTheFirstSample) {
  const auto timer = clock_->At(Time{}, Say("fired"));
  network_.RunFor(seconds(10));
  EXPECT_EQ(clock_->Now(), Time{});
  EXPECT_THAT(log_, IsEmpty());
}

TEST_F(TopicClock, ShowsTheTimeOfTheLastSample) {
  Show(5000);
  EXPECT_EQ(clock_->Now(), At(5000));
  network_.RunFor(seconds(10));
  EXPECT_EQ(clock_->Now(), At(5000));
  Show(5020);
  EXPECT_EQ(clock_->Now(), At(5020));
}

TEST_F(TopicClock, StampsWithTheTimeOfTheWorld) {
  EXPECT_EQ(clock_->Stamp(), msg::Stamp{});
  Show(5020);
  EXPECT_EQ(clock_->Stamp(), (msg::Stamp{5, 20'000'000}));
}

TEST_F(TopicClock, CountsTimersMadeBeforeTheFirstSampleFromIt) {
  const auto timer = clock_->At(clock_->Now() + seconds(1), Say("fired"));
  Show(60'000);
  EXPECT_THAT(log_, IsEmpty());
  Show(60'999);
  EXPECT_THAT(log_, IsEmpty());
  Show(61'000);
  EXPECT_THAT(log_, ElementsAre("fired"));
}

TEST_F(TopicClock, FiresTimersInTheOrderOfTheirTimes) {
  Show(0);
  const auto late = clock_->At(At(300), Say("late"));
  const auto soon = clock_->At(At(100), Say("soon"));
  const auto with_late = clock_->At(At(300), Say("with late"));
  const auto later = clock_->At(At(301), Say("later"));
  Show(300);
  EXPECT_THAT(log_, ElementsAre("soon", "late", "with late"));
}

TEST_F(TopicClock, RepeatsWithoutDrift) {
  Show(0);
  const auto ticks = clock_->Every(Milliseconds(100), Say("tick"));
  Show(130);  // late by 30 ms
  Show(199);
  EXPECT_THAT(log_, ElementsAre("tick"));
  Show(200);
  EXPECT_THAT(log_, ElementsAre("tick", "tick"));
}

TEST_F(TopicClock, DoesNotMakeUpForMissedPeriods) {
  Show(0);
  const auto ticks = clock_->Every(Milliseconds(100), Say("tick"));
  Show(1050);
  EXPECT_THAT(log_, ElementsAre("tick"));
  Show(1099);
  EXPECT_THAT(log_, ElementsAre("tick"));
  Show(1100);
  EXPECT_THAT(log_, ElementsAre("tick", "tick"));
}

TEST_F(TopicClock, LeavesTimersTheirRestWhenTheWorldIsRestarted) {
  Show(60'000);
  const auto ticks = clock_->Every(seconds(10), Say("tick"));
  const auto once = clock_->At(At(65'000), Say("once"));
  Show(61'000);  // 4 s and 9 s are left
  Show(20);
  EXPECT_EQ(clock_->Now(), At(20));
  EXPECT_THAT(log_, ElementsAre("restarted"));
  Show(4019);
  EXPECT_THAT(log_, ElementsAre("restarted"));
  Show(4020);
  EXPECT_THAT(log_, ElementsAre("restarted", "once"));
  Show(9020);
  EXPECT_THAT(log_, ElementsAre("restarted", "once", "tick"));
  Show(19'020);
  EXPECT_THAT(log_, ElementsAre("restarted", "once", "tick", "tick"));
}

// A recording that a person skips: nothing was seen of the time between.
TEST_F(TopicClock, LeavesTimersTheirRestWhenARecordingIsSkipped) {
  Show(1000);
  const auto ticks = clock_->Every(seconds(10), Say("tick"));
  const auto once = clock_->At(At(5000), Say("once"));
  Show(2000);
  Show(302'000);
  EXPECT_EQ(clock_->Now(), At(302'000));
  EXPECT_THAT(log_, ElementsAre("restarted"));
  Show(304'999);
  EXPECT_THAT(log_, ElementsAre("restarted"));
  Show(305'000);
  EXPECT_THAT(log_, ElementsAre("restarted", "once"));
  Show(311'000);
  EXPECT_THAT(log_, ElementsAre("restarted", "once", "tick"));
}

// Else nothing would ever become due.
TEST_F(TopicClock, CountsTheStepsOfAClockThatHasLongOnesOnly) {
  Show(0);
  const auto once = clock_->At(At(50'000), Say("once"));
  for (const int minute : {1, 2, 3}) Show(60'000 * minute);
  EXPECT_THAT(log_, ElementsAre("restarted", "once"));
}

TEST_F(TopicClock, DetectsARestartedWorldByItsWriterHoweverShortTheLastRunWas) {
  Show(500);
  world_.reset();
  world_ = MakeWorld();
  Show(480);
  EXPECT_EQ(clock_->Now(), At(480));
  EXPECT_THAT(log_, ElementsAre("restarted"));
}

// With two of them a walk ended because "the world was restarted".
TEST_F(TopicClock, NamesTheNumberOfItsPublishersWhereTheyPublishBesideEachOther) {
  Show(500'000);
  const ClockWriter other = MakeWorld();
  Show(other, msg::ToStamp(Milliseconds(100)));
  EXPECT_EQ(clock_->JumpText(),
            "2 programs publish /clock, and its time went back by 499.90 s; stop all but one");
  Show(500'020);
  EXPECT_EQ(clock_->JumpText(),
            "2 programs publish /clock, and its time skipped 499.92 s; stop all but one");
}

TEST_F(TopicClock, NamesAJumpOfItsOnlyPublisher) {
  Show(60'000);
  EXPECT_EQ(clock_->JumpText(), "");
  Show(20);
  EXPECT_EQ(clock_->JumpText(), "the time of /clock went back by 59.98 s");
  Show(40);
  Show(300'040);
  EXPECT_EQ(clock_->JumpText(), "the time of /clock skipped 300.00 s");
  world_.reset();
  world_ = MakeWorld();
  Show(40);
  EXPECT_EQ(clock_->JumpText(), "the time of /clock went back by 300.00 s");
}

// Its end is not known yet.
TEST_F(TopicClock, TakesAWorldThatIsRestartedAfterACrashForOne) {
  Show(60'000);
  network_.RunFor(seconds(3));
  const ClockWriter next = MakeWorld();
  Show(next, msg::ToStamp(Milliseconds(20)));
  EXPECT_EQ(clock_->JumpText(), "the time of /clock went back by 59.98 s");
}

TEST_F(TopicClock, IgnoresADuplicateAndASampleThatWasOvertaken) {
  Show(1000);
  const auto timer = clock_->At(At(1000), Say("fired"));
  Show(1000);
  Show(980);
  EXPECT_EQ(clock_->Now(), At(1000));
  EXPECT_THAT(log_, IsEmpty());
  Show(1020);
  EXPECT_THAT(log_, ElementsAre("fired"));
}

TEST_F(TopicClock, IgnoresStampsThatAreNoTimeOfAWorld) {
  Show(1000);
  Show(world_, {-1, 0});
  Show(world_, {2, 1'000'000'000});
  EXPECT_EQ(clock_->Now(), At(1000));
  EXPECT_THAT(log_, IsEmpty());
}

TEST_F(TopicClock, LetsACallbackDropAnyHandle) {
  Show(0);
  LoopHandlePtr own, other;
  own = clock_->Every(Milliseconds(100), [&] {
    log_.push_back("own");
    own.reset();
    other.reset();
  });
  other = clock_->At(At(100), Say("other"));
  Show(100);
  Show(200);
  EXPECT_THAT(log_, ElementsAre("own"));
}

TEST_F(TopicClock, FiresInTheSameSampleWhatACallbackMadeDue) {
  Show(0);
  LoopHandlePtr second;
  const auto first = clock_->At(At(100), [&] { second = clock_->At(At(150), Say("second")); });
  Show(200);
  EXPECT_THAT(log_, ElementsAre("second"));
}

TEST_F(TopicClock, LetsTheHookOfARestartEndTimers) {
  LoopHandlePtr timer;
  const auto clock = Clock::FromTopic(*dog_, [&] { timer.reset(); }).value();
  Settle();
  Show(60'000);
  timer = clock->At(At(60'001), Say("fired"));
  Show(0);
  Show(1000);
  EXPECT_THAT(log_, ElementsAre("restarted"));  // clock_'s hook
}

}  // namespace musher::transport::clock_test
