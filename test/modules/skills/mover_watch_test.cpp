// Who has come into the way lately, and what has stood there all the time.

#include "musher/modules/skills/skills/mover_watch.hpp"

#include <gtest/gtest.h>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::mover_watch_test {

using navigation::Point;
using skills::MoverWatch;

// The side of a person that a robot at x = 0 sees.
std::vector<Point> PersonAt(double x_m, double y_m) {
  return {{x_m - 0.1, y_m - 0.1, 0}, {x_m - 0.2, y_m, 0}, {x_m - 0.1, y_m + 0.1, 0}};
}

class AMoverWatch : public ::testing::Test {
 protected:
  void See(std::vector<Point> points, double seconds) {
    robot_.points = std::move(points);
    for (double at_s = 0; at_s < seconds; at_s += 0.1) watch_.Note(robot_, Milliseconds(100));
  }
  bool HaveCome() const { return watch_.HaveCome(robot_, robot_.points); }

  skills::testing::MovingRobot robot_;
  MoverWatch watch_;
};

TEST_F(AMoverWatch, TakesWhoHasComeForAMoverAndNotWhatHasStoodThere) {
  See(PersonAt(1, 1), 2);
  EXPECT_FALSE(HaveCome()) << "it stands there since it is seen";
  See(PersonAt(1, 0), 2);
  EXPECT_TRUE(HaveCome());
  See(PersonAt(1, 0), 9);
  EXPECT_FALSE(HaveCome()) << "who stands for long is a thing";
}

TEST_F(AMoverWatch, TakesNothingForOneWhoHasCome) {
  EXPECT_FALSE(HaveCome());
  See({}, 3);
  EXPECT_FALSE(HaveCome());
}

TEST_F(AMoverWatch, DoesNotTakeForFreeWhatWasHidden) {
  See(PersonAt(0.7, 0), 2);
  robot_.points = PersonAt(1.5, 0);
  EXPECT_FALSE(HaveCome()) << "it may have stood behind the person";
}

TEST_F(AMoverWatch, DoesNotTakeForFreeWhatWasFarAwayOrOutsideOfTheScan) {
  See({}, 2);
  robot_.points = PersonAt(4, 0);
  EXPECT_FALSE(HaveCome());
  robot_.points = PersonAt(-1, 0);
  EXPECT_TRUE(HaveCome());
  robot_.scan_covers_rad = M_PI / 2;
  EXPECT_FALSE(HaveCome());
}

TEST_F(AMoverWatch, DoesNotTakeASideThatComesIntoSightForAMover) {
  const std::vector<Point> side = {{1.9, 0.5, 0}, {1.9, 0.6, 0}, {1.9, 0.7, 0}};
  See(side, 2);
  robot_.points = {{2.0, 0.5, 0}, {2.0, 0.6, 0}, {2.05, 0.7, 0}};
  EXPECT_FALSE(HaveCome());
}

}  // namespace musher::mover_watch_test
