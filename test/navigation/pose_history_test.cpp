// Where a body was: by the stamps of its odometry, which may be late, repeated, or of a clock that
// was set.

#include "musher/navigation/pose_history.hpp"

#include <gmock/gmock.h>

namespace musher::navigation::pose_history_test {

Pose At(double x_m) {
  return {{x_m, 0, 0}, 0};
}

TEST(PoseHistory, HasThePoseNearestInTime) {
  PoseHistory poses;
  for (int i = 1; i <= 50; ++i) EXPECT_TRUE(poses.Add(At(i), Milliseconds(20 * i)));
  EXPECT_EQ(poses.At(Milliseconds(405)), At(20));
  EXPECT_EQ(poses.At(Milliseconds(9000)), At(50));
  EXPECT_EQ(poses.At({}), At(50)) << "a scan without a stamp is of now";
}

TEST(PoseHistory, RefusesWhatIsRepeatedOrLate) {
  PoseHistory poses;
  EXPECT_TRUE(poses.Add(At(1), Milliseconds(5000)));
  EXPECT_FALSE(poses.Add(At(2), Milliseconds(5000)));
  EXPECT_FALSE(poses.Add(At(2), Milliseconds(4500)));
  EXPECT_EQ(poses.At({}), At(1));
}

TEST(PoseHistory, BeginsAgainWithAClockThatWasSet) {
  PoseHistory poses;
  EXPECT_TRUE(poses.Add(At(1), std::chrono::seconds(100)));
  EXPECT_FALSE(poses.Add(At(2), Milliseconds(2980)));
  EXPECT_TRUE(poses.Add(At(2), std::chrono::seconds(3)));
  EXPECT_EQ(poses.At(std::chrono::seconds(100)), At(2));
  EXPECT_TRUE(poses.Add(At(3), std::chrono::hours(1000)));
  EXPECT_EQ(poses.At(std::chrono::seconds(3)), At(3)) << "what is older than a second is dropped";
}

// Each of them began again with a clock that was set.
TEST(PoseHistory, TakesNoPosesWhoseStampsGoBackAndBack) {
  PoseHistory poses;
  EXPECT_TRUE(poses.Add(At(1), std::chrono::seconds(100)));
  for (int i = 1; i < 20; ++i) {
    EXPECT_FALSE(poses.Add(At(2), std::chrono::seconds(100 - 2 * i))) << i;
  }
  EXPECT_EQ(poses.At({}), At(1));
}

}  // namespace musher::navigation::pose_history_test
