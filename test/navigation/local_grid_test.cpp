// What a body remembers of what it has seen: marks, clearing, decay, and a square that moves.

#include "musher/navigation/grid/local_grid.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace musher::navigation::local_grid_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// One ray in the direction of the sensor.
Scan Ray(float range_m) {
  return {0, 0.01, 0.05, 8, {range_m}};
}

class Grid : public ::testing::Test {
 protected:
  void See(float range_m, const Pose& sensor = {}) { grid_.Add(Ray(range_m), sensor, now_); }
  std::vector<Point> Points() const { return grid_.Points(now_); }
  void Pass(double seconds) { now_ += FromSeconds(seconds); }

  LocalGrid grid_{LocalGridRules{}};
  Time now_ = Time{} + std::chrono::seconds(1);
};

TEST_F(Grid, RemembersWhatIsOutOfSight) {
  See(2);
  Pass(5);
  See(9, {{0, 0, 0}, M_PI});  // it looks away
  ASSERT_THAT(Points(), SizeIs(1));
  EXPECT_NEAR(Points()[0].x_m, 2, 1e-6);
}

TEST_F(Grid, ForgetsWhatARayPasses) {
  See(2);
  See(4);
  ASSERT_THAT(Points(), SizeIs(1));
  EXPECT_NEAR(Points()[0].x_m, 4, 1e-6);
  See(9);
  EXPECT_THAT(Points(), IsEmpty()) << "a ray that hits nothing clears as well";
}

TEST_F(Grid, LearnsNothingFromRaysThatSayNothing) {
  See(2);
  See(kNan);
  See(0.01F);
  EXPECT_THAT(Points(), SizeIs(1));
  grid_.Add(Ray(3), {{std::nan(""), 0, 0}, 0}, now_);
  grid_.Add(Ray(3), {{1e308, 0, 0}, 0}, now_);
  EXPECT_THAT(Points(), SizeIs(1));
}

TEST_F(Grid, ForgetsWhatNothingConfirms) {
  See(2);
  Pass(29);
  EXPECT_THAT(Points(), SizeIs(1));
  Pass(2);
  EXPECT_THAT(Points(), IsEmpty());
}

TEST_F(Grid, MovesWithTheBody) {
  See(2);
  See(9, {{3, 0, 0}, M_PI / 2});
  EXPECT_THAT(Points(), SizeIs(1)) << "2 m away, 1 m behind it";
  See(9, {{8, 0, 0}, M_PI / 2});
  EXPECT_THAT(Points(), IsEmpty()) << "6 m behind it";
  See(2, {{-500, 700, 0}, 0});
  EXPECT_THAT(Points(), SizeIs(1));
}

TEST_F(Grid, SharesNoCellWithAPlaceFarAway) {
  See(2);
  See(2, {{10, 0, 0}, 0});  // its cell has the same place in memory
  ASSERT_THAT(Points(), SizeIs(1));
  EXPECT_NEAR(Points()[0].x_m, 12, 1e-6);
}

TEST_F(Grid, ForgetsWhatIsElsewhereAfterAJumpOfTheLocalisation) {
  grid_.NotePlace({0, 0, 0});
  See(2);
  grid_.NotePlace({0.4, 0, 0});
  EXPECT_THAT(Points(), SizeIs(1)) << "it has driven";
  grid_.NotePlace({1, 0, 0});
  EXPECT_THAT(Points(), IsEmpty());
}

TEST_F(Grid, ForgetsWhatTheNearestOfManyRaysPasses) {
  Scan round{-M_PI, M_PI / 180, 0.05, 8, std::vector<float>(360, 2.0F)};
  grid_.Add(round, {}, now_);
  EXPECT_GT(Points().size(), 200U);
  for (float& range_m : round.ranges_m) range_m = 9;
  grid_.Add(round, {{0.3, 0, 0}, 0.4}, now_);
  EXPECT_THAT(Points(), IsEmpty()) << "also where the circle closes";
}

TEST_F(Grid, IsEmptyAfterAClear) {
  See(2);
  grid_.Clear();
  EXPECT_THAT(Points(), IsEmpty());
}

}  // namespace musher::navigation::local_grid_test
