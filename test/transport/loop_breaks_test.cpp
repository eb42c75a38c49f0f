// Breaks in which the process of a loop could not run, in virtual time.

#include "musher/transport/loop_breaks.hpp"

#include <gtest/gtest.h>

#include "musher/test/transport/suspended_node.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::transport::loop_breaks_test {

using std::chrono::hours;
using std::chrono::seconds;

class BreaksOfALoop : public ::testing::Test {
 protected:
  void StopFor(Duration duration) {
    network_.Pause(node_.simulated());
    network_.RunFor(duration);
    network_.Resume(node_.simulated());
  }

  sim::Network network_{1};
  musher::testing::SuspendedNode node_{network_.MakeNode("dog")};
};

TEST_F(BreaksOfALoop, AreNoneWhileItsTimersRun) {
  LoopBreaks breaks(node_.loop());
  network_.RunFor(hours(1));
  EXPECT_FALSE(breaks.Recent());
  EXPECT_FALSE(breaks.Take());
}

TEST_F(BreaksOfALoop, AreSeenByItsTimerAndCountForTwoSeconds) {
  LoopBreaks breaks(node_.loop());
  network_.RunFor(seconds(3));
  StopFor(seconds(9));
  network_.RunFor(Milliseconds(1900));
  const auto recent = breaks.Recent();
  ASSERT_TRUE(recent);
  EXPECT_GE(*recent, seconds(9));
  EXPECT_LT(*recent, seconds(10));
  network_.RunFor(Milliseconds(200));
  EXPECT_FALSE(breaks.Recent());
  EXPECT_EQ(breaks.Take(), recent);
  EXPECT_FALSE(breaks.Take());
}

// A sample may be handled before the timer.
TEST_F(BreaksOfALoop, AreSeenBeforeItsTimerComes) {
  LoopBreaks breaks(node_.loop());
  network_.RunFor(seconds(3));
  node_.loop().suspended += hours(8);
  EXPECT_GE(breaks.Recent(), hours(8));
  EXPECT_GE(breaks.Take(), hours(8));
  network_.RunFor(seconds(1));
  EXPECT_FALSE(breaks.Take());
}

TEST_F(BreaksOfALoop, CountFromItsConstructionOn) {
  node_.loop().suspended += hours(8);
  network_.RunFor(seconds(9));
  LoopBreaks breaks(node_.loop());
  EXPECT_FALSE(breaks.Recent());
  StopFor(seconds(9));
  EXPECT_TRUE(breaks.Recent()) << "its timer has not run yet";
}

TEST_F(BreaksOfALoop, MayBeShorter) {
  LoopBreaks standard(node_.loop());
  LoopBreaks breaks(node_.loop(), seconds(2));
  network_.RunFor(seconds(3));
  StopFor(Milliseconds(1500));
  EXPECT_FALSE(breaks.Recent());
  network_.RunFor(seconds(3));
  StopFor(seconds(3));
  EXPECT_TRUE(breaks.Recent());
  EXPECT_FALSE(standard.Recent());
}

}  // namespace musher::transport::loop_breaks_test
