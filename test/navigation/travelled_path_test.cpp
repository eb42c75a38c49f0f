// The path that a body has come on, for a way back.

#include "musher/navigation/travelled_path.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

namespace musher::navigation::travelled_path_test {

using ::testing::IsEmpty;

// Straight on, in steps of 3 cm, without the first place.
void Move(TravelledPath& path, const Point& from, const Point& to) {
  const double length_m = Distance(from, to);
  const double yaw_rad = std::atan2(to.y_m - from.y_m, to.x_m - from.x_m);
  for (double at_m = 0.03; at_m < length_m; at_m += 0.03) {
    path.Add({Between(from, to, at_m / length_m), yaw_rad});
  }
  path.Add({to, yaw_rad});
}

double LengthOf(const Path& path) {
  double length_m = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length_m += Distance(path[i - 1].at, path[i].at);
  }
  return length_m;
}

TEST(TravelledPath, LeadsBackAroundTheCornersThatTheBodyHasCome) {
  TravelledPath path;
  EXPECT_THAT(path.Back(), IsEmpty());
  path.Add({});
  Move(path, {}, {0.6, 0, 0});
  Move(path, {0.6, 0, 0}, {0.6, 0.6, 0});
  const Path back = path.Back();
  ASSERT_FALSE(back.empty());
  EXPECT_LT(Distance(back.front().at, {0.6, 0.6, 0}), 0.06);
  EXPECT_EQ(back.back(), Pose{});
  EXPECT_NEAR(LengthOf(back), 1.2, 0.1);
  for (const Pose& pose : back) {
    EXPECT_LT(std::min(std::abs(pose.at.y_m), std::abs(pose.at.x_m - 0.6)), 0.04);
  }
}

TEST(TravelledPath, KeepsTheLastTwoMetres) {
  TravelledPath path;
  path.Add({});
  Move(path, {}, {9, 0, 0});
  EXPECT_NEAR(LengthOf(path.Back()), TravelledPath::kLongestM, 0.5);
  EXPECT_NEAR(path.Back().front().at.x_m, 9, 0.06);
}

// Two recoveries in turn would lead to and fro, and the second one to the obstacle.
TEST(TravelledPath, IsShorterAfterTheBodyHasGoneBackAlongIt) {
  TravelledPath path;
  path.Add({});
  Move(path, {}, {1, 0, 0});
  Move(path, {1, 0, 0}, {0.6, 0.02, 0});
  for (const Pose& pose : path.Back()) EXPECT_LT(pose.at.x_m, 0.7);
  Move(path, {0.6, 0.02, 0}, {0.6, 0.8, 0});
  EXPECT_NEAR(LengthOf(path.Back()), 1.4, 0.15);
}

TEST(TravelledPath, BeginsAgainAfterAJumpAndTakesNoPlaceThatIsNoNumber) {
  TravelledPath path;
  path.Add({});
  Move(path, {}, {1, 0, 0});
  path.Add({{NAN, 0, 0}, 0});
  EXPECT_GT(path.Back().size(), 10U);
  path.Add({{5, 0, 0}, 0});
  EXPECT_THAT(path.Back(), ::testing::SizeIs(1));
}

// The noise of a body at rest.
TEST(TravelledPath, DoesNotGrowWhileTheBodyStands) {
  TravelledPath path;
  path.Add({});
  Move(path, {}, {1, 0, 0});
  const std::size_t size = path.Back().size();
  for (int i = 0; i < 1000; ++i) path.Add({{1 + (i % 2 ? 0.02 : -0.02), 0, 0}, 0});
  EXPECT_NEAR(double(path.Back().size()), double(size), 2);
}

}  // namespace musher::navigation::travelled_path_test
