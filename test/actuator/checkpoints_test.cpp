#include "musher/actuator/checkpoints.hpp"

#include <gtest/gtest.h>

namespace musher::checkpoints_test {

constexpr pid_t kWorker = 11;
constexpr pid_t kOther = 22;

// Checkpoints of a module whose work thread may be silent for 100 ms, in SetUp for 22 s.
class CheckpointsOf : public ::testing::Test {
 protected:
  CheckpointsOf() {
    config_.checkpoint = Milliseconds(100);
    config_.checkpoint_in["SetUp"] = std::chrono::seconds(22);
    now_ = Time(std::chrono::hours(1));
    for (const pid_t thread : {kWorker, kOther}) kernel_.threads[thread] = {};
    points_.emplace(config_, [this](Time now) -> std::optional<ProcessSample> {
      if (blind_) return std::nullopt;
      kernel_.at = now;
      return kernel_;
    });
    points_->OnWorker(kWorker);
  }

  // Time passes, and the loop looks often, as it does.
  Checkpoints::Look After(Duration duration) {
    const Time end = now_ + duration;
    for (; now_ < end; now_ += Milliseconds(10)) points_->Evaluate(now_);
    now_ = end;
    return points_->Evaluate(now_);
  }
  // The same, while a thread waits for a CPU all the time.
  Checkpoints::Look AfterWaiting(pid_t thread, Duration duration) {
    const Time end = now_ + duration;
    for (; now_ < end; now_ += Milliseconds(10)) {
      kernel_.threads[thread].cpu.waited += Milliseconds(10);
      points_->Evaluate(now_);
    }
    return points_->Evaluate(now_);
  }

  ActuatorConfig config_;
  Time now_;
  ProcessSample kernel_;
  bool blind_ = false;
  std::optional<Checkpoints> points_;
};

TEST_F(CheckpointsOf, WatchNoThreadUntilACallbackBeginsOrAThreadGivesACheckpoint) {
  EXPECT_EQ(After(std::chrono::hours(1)).work, Health::kWell);
  EXPECT_FALSE(points_->Period());
}

TEST_F(CheckpointsOf, ACallbackMayBeSilentForItsAllowanceAndNoLonger) {
  points_->Begin("Active", now_);
  EXPECT_EQ(After(Milliseconds(100)).work, Health::kWell);
  const Checkpoints::Look look = After(Milliseconds(1));
  EXPECT_EQ(look.work, Health::kHung);
  EXPECT_EQ(look.during, "Active");
  EXPECT_EQ(look.silent, Milliseconds(101));
}

TEST_F(CheckpointsOf, ACallbackThatHasEndedIsNotWatched) {
  points_->Begin("Active", now_);
  After(Milliseconds(50));
  points_->End();
  EXPECT_EQ(After(std::chrono::hours(1)).work, Health::kWell);
  EXPECT_FALSE(points_->Period());
}

TEST_F(CheckpointsOf, ALongerAllowanceIsDeclaredForAStateThatLoadsForLong) {
  points_->Begin("SetUp", now_);
  EXPECT_EQ(After(std::chrono::seconds(22)).work, Health::kWell);
  EXPECT_EQ(After(Milliseconds(1)).work, Health::kHung);
}

TEST_F(CheckpointsOf, ACallbackThatGivesCheckpointsMayTakeAsLongAsItLikes) {
  points_->Begin("Active", now_);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(After(Milliseconds(90)).work, Health::kWell);
    points_->Mark(kWorker, Duration::zero(), now_);
  }
  EXPECT_EQ(After(Milliseconds(101)).work, Health::kHung);
}

TEST_F(CheckpointsOf, ACheckpointMayExtendItsAllowanceOnceAndTheNextUsesTheUsualOne) {
  points_->Begin("Active", now_);
  points_->Mark(kWorker, std::chrono::seconds(5), now_);
  EXPECT_EQ(After(std::chrono::seconds(5)).work, Health::kWell);
  points_->Mark(kWorker, Duration::zero(), now_);
  EXPECT_EQ(After(Milliseconds(101)).work, Health::kHung);
}

TEST_F(CheckpointsOf, MarksOfOtherThreadsDoNotSaveACallbackThatHangs) {
  points_->Begin("Active", now_);
  for (int i = 0; i < 10; ++i) {
    After(Milliseconds(20));
    points_->Mark(kOther, Duration::zero(), now_);
  }
  const Checkpoints::Look look = points_->Evaluate(now_);
  EXPECT_EQ(look.work, Health::kHung);
  EXPECT_EQ(look.during, "Active");
}

TEST_F(CheckpointsOf, AThreadOfTheModuleThatHasMadeOneMustMakeTheNext) {
  points_->Mark(kOther, Duration::zero(), now_);
  EXPECT_EQ(After(Milliseconds(100)).work, Health::kWell);
  const Checkpoints::Look look = After(Milliseconds(1));
  EXPECT_EQ(look.work, Health::kHung);
  EXPECT_EQ(look.during, "") << "no callback runs";
}

TEST_F(CheckpointsOf, AThreadWithoutFurtherCheckpointsIsNotMonitored) {
  points_->Mark(kOther, Duration::zero(), now_);
  points_->Mark(kOther, Duration::max(), now_);
  EXPECT_EQ(After(std::chrono::hours(1)).work, Health::kWell);
  EXPECT_FALSE(points_->Period());
}

TEST_F(CheckpointsOf, AThreadThatMakesProgressDoesNotHideAnotherThatHangs) {
  constexpr pid_t kThird = 33;
  points_->Mark(kOther, Duration::zero(), now_);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NE(After(Milliseconds(15)).work, Health::kHung);
    points_->Mark(kThird, Milliseconds(500), now_);
    After(Milliseconds(5));
    points_->Mark(kThird, Duration::max(), now_);
  }
  EXPECT_EQ(After(Milliseconds(5)).work, Health::kHung);
  points_->Mark(kOther, Duration::max(), now_);
  EXPECT_EQ(After(Milliseconds(500)).work, Health::kWell);
  EXPECT_FALSE(points_->Period());
}

TEST_F(CheckpointsOf, ACallbackWithoutFurtherCheckpointsIsMonitoredAgainFromItsNextMark) {
  points_->Begin("SetUp", now_);
  points_->Mark(kWorker, Duration::max(), now_);
  EXPECT_EQ(After(std::chrono::hours(1)).work, Health::kWell);
  points_->Mark(kWorker, Duration::zero(), now_);
  EXPECT_EQ(After(std::chrono::seconds(22)).work, Health::kWell) << "as declared for its state";
  const Checkpoints::Look look = After(Milliseconds(1));
  EXPECT_EQ(look.work, Health::kHung);
  EXPECT_EQ(look.during, "SetUp");
}

TEST_F(CheckpointsOf, TheBeginAndTheEndOfACallbackVoidTheCheckpointsOfModuleThreads) {
  points_->Mark(kOther, Duration::zero(), now_);
  points_->Begin("SetUp", now_);
  EXPECT_EQ(After(std::chrono::seconds(10)).work, Health::kWell);
  points_->Mark(kOther, Duration::zero(), now_);
  points_->End();
  EXPECT_EQ(After(std::chrono::seconds(10)).work, Health::kWell);
}

TEST_F(CheckpointsOf, WithoutAllowancesOnlyAnExplicitCheckpointCounts) {
  config_.checkpoint.reset();
  points_->Begin("Active", now_);
  EXPECT_EQ(After(std::chrono::hours(1)).work, Health::kWell);
  points_->Mark(kWorker, Milliseconds(40), now_);
  EXPECT_EQ(After(Milliseconds(41)).work, Health::kHung);
}

TEST_F(CheckpointsOf, AThreadThatWaitedForACpuIsStarvedAndNotHung) {
  points_->Begin("Active", now_);
  const Checkpoints::Look look = AfterWaiting(kWorker, Milliseconds(120));
  EXPECT_EQ(look.work, Health::kStarved);
  EXPECT_GE(look.waited, Milliseconds(50));
}

TEST_F(CheckpointsOf, TheCpuWaitOfAnotherThreadDoesNotCount) {
  points_->Begin("Active", now_);
  EXPECT_EQ(AfterWaiting(kOther, Milliseconds(120)).work, Health::kHung);
}

TEST_F(CheckpointsOf, AStarvedThreadThatThenHangsIsFoundOut) {
  points_->Begin("Active", now_);
  EXPECT_EQ(AfterWaiting(kWorker, Milliseconds(150)).work, Health::kStarved);
  EXPECT_EQ(After(Milliseconds(100)).work, Health::kHung);
}

TEST_F(CheckpointsOf, WithoutSchedstatsSilenceIsAHang) {
  blind_ = true;
  points_->Begin("Active", now_);
  EXPECT_EQ(After(Milliseconds(101)).work, Health::kHung);
}

// The loop wakes up first, before the thread has had a chance.
TEST_F(CheckpointsOf, AProcessThatWasStoppedAsAWholeIsNotHung) {
  points_->Begin("Active", now_);
  now_ += Milliseconds(700);
  const Checkpoints::Look look = points_->Evaluate(now_);
  EXPECT_EQ(look.work, Health::kStarved);
  EXPECT_EQ(look.silent, Milliseconds(700));
  EXPECT_EQ(look.waited, Milliseconds(675)) << "all but the period after which a look was due";
  points_->Mark(kWorker, Duration::zero(), now_);
  EXPECT_EQ(After(Milliseconds(100)).work, Health::kWell);
}

TEST_F(CheckpointsOf, AProcessThatStandsStillAgainAndAgainIsNotHung) {
  points_->Begin("Active", now_);
  After(Milliseconds(40));
  for (int i = 0; i < 2; ++i) {
    now_ += Milliseconds(500);
    EXPECT_EQ(points_->Evaluate(now_).work, Health::kStarved);
  }
  points_->Mark(kWorker, Duration::zero(), now_);
  EXPECT_EQ(After(Milliseconds(100)).work, Health::kWell);
}

TEST_F(CheckpointsOf, AThreadThatHangsWhileItsProcessStandsStillIsFoundOutAfterIt) {
  points_->Begin("Active", now_);
  now_ += Milliseconds(700);
  EXPECT_EQ(points_->Evaluate(now_).work, Health::kStarved);
  EXPECT_EQ(After(Milliseconds(75)).work, Health::kStarved);
  EXPECT_EQ(After(Milliseconds(1)).work, Health::kHung);
}

TEST_F(CheckpointsOf, AHangIsFoundWithinFiveLooksEvenIfEachComesLate) {
  points_->Begin("Active", now_);
  for (int i = 0; i < 4; ++i) {
    now_ += Milliseconds(300);
    EXPECT_EQ(points_->Evaluate(now_).work, Health::kStarved);
  }
  now_ += Milliseconds(300);
  EXPECT_EQ(points_->Evaluate(now_).work, Health::kHung);
}

// A quota that takes most of the time makes the looks late, too.
TEST_F(CheckpointsOf, TimeWithoutACpuIsNotForgivenTwice) {
  points_->Begin("Active", now_);
  After(Milliseconds(60));
  kernel_.throttled += Milliseconds(200);
  now_ += Milliseconds(200);
  EXPECT_EQ(points_->Evaluate(now_).waited, Milliseconds(200));
}

TEST_F(CheckpointsOf, AreLookedAtSeveralTimesWithinTheShortestAllowance) {
  points_->Begin("SetUp", now_);
  EXPECT_EQ(points_->Period(), Duration(std::chrono::seconds(22)) / 4);
  points_->Mark(kOther, Milliseconds(80), now_);
  EXPECT_EQ(points_->Period(), Milliseconds(20));
  points_->Mark(kOther, Milliseconds(1), now_);
  EXPECT_EQ(points_->Period(), Milliseconds(5)) << "but never so often that it costs";
}

// It loads a model from a disk that is busy.
TEST_F(CheckpointsOf, AThreadThatWaitsForTheDiskIsStarvedAndForLongerThanADiskIsBusyHung) {
  kernel_.threads[kWorker].blocked = true;
  points_->Begin("Active", now_);
  EXPECT_EQ(After(std::chrono::seconds(9)).work, Health::kStarved);
  EXPECT_EQ(After(std::chrono::seconds(2)).work, Health::kHung);
}

}  // namespace musher::checkpoints_test
