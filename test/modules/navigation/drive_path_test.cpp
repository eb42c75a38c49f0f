// How a path is made drivable from where a body is.

#include "musher/modules/navigation/controller_server/drive_path.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace musher::navigation::drive_path_test {

using ::testing::IsEmpty;

Path Line(double length_m, double step_m = 0.5) {
  Path path;
  for (int i = 0; i * step_m <= length_m + 1e-9; ++i) path.push_back({{i * step_m, 0, 0}, 0});
  return path;
}

TEST(JoinedPath, BeginsWhereTheBodyIs) {
  const Path joined = JoinedPath(Line(3), {{0, -0.2, 0}, 1}, 2, true);
  ASSERT_EQ(joined.size(), 8U);
  EXPECT_EQ(joined[0], (Pose{{0, -0.2, 0}, 1}));
  EXPECT_EQ(joined[1].at, (Point{0, 0, 0}));
}

TEST(JoinedPath, LeavesOutWhatIsBehindTheBody) {
  const Path joined = JoinedPath(Line(3), {{1.2, 0.1, 0}, 0}, 2, true);
  EXPECT_NEAR(joined[1].at.x_m, 1.2, 1e-9);
  EXPECT_NEAR(joined[2].at.x_m, 1.5, 1e-9);
  EXPECT_EQ(joined.back().at.x_m, 3);
}

TEST(JoinedPath, IsEmptyForAPathFarAway) {
  EXPECT_THAT(JoinedPath(Line(3), {{-2.5, 0, 0}, 0}, 2, true), IsEmpty());
  EXPECT_EQ(JoinedPath(Line(3), {{0, 0, 9}, 0}, 2, true).size(), 8U)
      << "on the ground z is nothing";
  EXPECT_THAT(JoinedPath(Line(3), {{0, 0, 9}, 0}, 2, false), IsEmpty());
}

TEST(JoinedPath, OfOnePoseGoesThere) {
  const Path joined = JoinedPath({{{1, 0, 0}, 2}}, {{0, 0, 0}, 0}, 2, true);
  ASSERT_EQ(joined.size(), 2U);
  EXPECT_EQ(joined[1], (Pose{{1, 0, 0}, 2}));
}

TEST(LookingAhead, TurnsOnTheSpotAtTheBeginAtCornersAndAtTheEnd) {
  const Path path = {{{0, 0, 0}, 2}, {{2, 0, 0}, 7}, {{2, 2, 0}, -1}};
  const Path ahead = LookingAhead(path, false);
  ASSERT_EQ(ahead.size(), 6U);
  EXPECT_EQ(ahead[0], (Pose{{0, 0, 0}, 2}));
  EXPECT_EQ(ahead[1], (Pose{{0, 0, 0}, 0}));
  EXPECT_EQ(ahead[2], (Pose{{2, 0, 0}, 0}));
  EXPECT_EQ(ahead[3], (Pose{{2, 0, 0}, M_PI / 2}));
  EXPECT_EQ(ahead[4], (Pose{{2, 2, 0}, M_PI / 2}));
  EXPECT_EQ(ahead[5], (Pose{{2, 2, 0}, -1}));
}

TEST(LookingAhead, IsAlwaysTurnedAlongItsWay) {
  Path path;
  for (int i = 0; i <= 40; ++i) {
    const double angle = i * 0.05;
    path.push_back({{3 * std::sin(angle), 3 - 3 * std::cos(angle), 0}, 0});
  }
  path.back().yaw_rad = 2;
  const Path ahead = LookingAhead(path, false);
  for (std::size_t i = 2; i + 1 < ahead.size(); ++i) {
    const double way_m =
        std::hypot(ahead[i].at.x_m - ahead[i - 1].at.x_m, ahead[i].at.y_m - ahead[i - 1].at.y_m);
    if (way_m < 1e-6) continue;
    const double direction =
        std::atan2(ahead[i].at.y_m - ahead[i - 1].at.y_m, ahead[i].at.x_m - ahead[i - 1].at.x_m);
    EXPECT_NEAR(Wrapped(ahead[i].yaw_rad - direction), 0, 0.06) << i;
  }
}

TEST(LookingAhead, DoesNotStopABodyThatIsOnItsWay) {
  const Path path = {{{0, 0, 0}, 0.2}, {{2, 0, 0}, 0}};
  EXPECT_EQ(LookingAhead(path, false)[1].at, (Point{0, 0, 0}));
  EXPECT_GT(LookingAhead(path, true)[1].at.x_m, 0.1);
}

TEST(LookingAhead, OfOnePlaceOnlyTurns) {
  const Path ahead = LookingAhead({{{1, 1, 0}, 0}, {{1, 1, 0}, 1}}, false);
  ASSERT_EQ(ahead.size(), 2U);
  EXPECT_EQ(ahead[1], (Pose{{1, 1, 0}, 1}));
}

}  // namespace musher::navigation::drive_path_test
