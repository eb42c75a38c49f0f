// Breaks in which a process could not run, by the times at which it ran.

#include "musher/base/break_watch.hpp"

#include <gtest/gtest.h>

namespace musher::break_watch_test {

using std::chrono::hours;
using std::chrono::seconds;

class ABreak : public ::testing::Test {
 protected:
  // The process runs for so long.
  void Run(Duration duration) {
    for (const Time end = now_ + duration; now_ < end;) {
      now_ += Milliseconds(500);
      watch_.Note(now_, suspended_);
    }
  }
  void Stop(Duration duration) { now_ += duration; }
  void Suspend(Duration duration) { suspended_ += duration; }
  std::optional<Duration> Recent() { return watch_.Recent(now_, suspended_); }
  std::optional<Duration> Take() { return watch_.Take(now_, suspended_); }

  Time now_ = Time{} + hours(1);
  Duration suspended_ = hours(7);  // before the process began
  BreakWatch watch_;
};

TEST_F(ABreak, IsNoneBeforeTheProcessHasRun) {
  EXPECT_FALSE(Recent());
  EXPECT_FALSE(Take());
  Run(seconds(60));
  EXPECT_FALSE(Recent());
  EXPECT_FALSE(Take());
}

TEST_F(ABreak, IsRecentForTwoSecondsAfterItsEnd) {
  Run(seconds(3));
  Stop(seconds(9));
  EXPECT_EQ(Recent(), seconds(9));
  Run(Milliseconds(1500));
  EXPECT_EQ(Recent(), seconds(9));
  Run(Milliseconds(500));
  EXPECT_FALSE(Recent());
}

TEST_F(ABreak, IsLongerThanFiveSeconds) {
  Run(seconds(3));
  Stop(seconds(5));
  EXPECT_FALSE(Recent());
  Stop(seconds(5) + Milliseconds(1));
  EXPECT_TRUE(Recent());
}

TEST_F(ABreak, IsASuspensionOfTheComputerThatTheTimeDoesNotCount) {
  Run(seconds(3));
  Suspend(hours(8));
  EXPECT_EQ(Recent(), hours(8));
  EXPECT_EQ(Take(), hours(8));
  Run(seconds(3));
  Stop(seconds(3));
  Suspend(seconds(3));
  EXPECT_EQ(Recent(), seconds(6));
}

TEST_F(ABreak, MayBeShorterAndCountForLonger) {
  watch_ = BreakWatch(seconds(2), seconds(4));
  Run(seconds(3));
  Stop(seconds(3));
  EXPECT_EQ(Recent(), seconds(3));
  Run(Milliseconds(3500));
  EXPECT_TRUE(Recent());
  Run(Milliseconds(500));
  EXPECT_FALSE(Recent());
}

// A goal of the two seconds after it was accepted, and cancelled by the same break once more.
TEST_F(ABreak, IsTakenOnceAlsoWhileItIsRecent) {
  Run(seconds(3));
  Stop(seconds(70));
  EXPECT_EQ(Take(), seconds(70));
  Run(seconds(1));
  EXPECT_TRUE(Recent());
  EXPECT_FALSE(Take());
}

TEST_F(ABreak, IsTakenHoweverLongAgoItHasEnded) {
  Run(seconds(3));
  Stop(seconds(70));
  Run(seconds(600));
  EXPECT_FALSE(Recent());
  EXPECT_GE(Take(), seconds(70));
  EXPECT_FALSE(Take());
}

// A laptop that was closed for an hour, and once more for ten seconds.
TEST_F(ABreak, ThatIsShortHidesNoLongOneBeforeIt) {
  Run(seconds(3));
  Suspend(hours(1));
  Run(seconds(3));
  Suspend(seconds(10));
  EXPECT_EQ(Recent(), seconds(10));
  EXPECT_GE(Take(), hours(1));
  EXPECT_FALSE(Take());
}

}  // namespace musher::break_watch_test
