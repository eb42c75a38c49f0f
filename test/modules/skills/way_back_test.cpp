// A body goes back on the path that it has come.

#include "musher/modules/skills/skills/way_back.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "musher/navigation/travelled_path.hpp"

namespace musher::skills::way_back_test {

constexpr double kStepS = 0.02;

// A differential one, whose velocity follows its command with a lag of 0.1 s.
struct Body {
  navigation::Pose pose;
  double ahead_m_s = 0, turn_rad_s = 0;

  void Move(const navigation::Velocity& command) {
    const double share = 1 - std::exp(-kStepS / 0.1);
    ahead_m_s += share * (command.x_m_s - ahead_m_s);
    turn_rad_s += share * (command.yaw_rad_s - turn_rad_s);
    pose.at.x_m += std::cos(pose.yaw_rad) * ahead_m_s * kStepS;
    pose.at.y_m += std::sin(pose.yaw_rad) * ahead_m_s * kStepS;
    pose.yaw_rad = navigation::Wrapped(pose.yaw_rad + turn_rad_s * kStepS);
  }
};

double OffPath(const navigation::Point& at, const navigation::Path& path) {
  double least_m = 1e9;
  for (const navigation::Pose& pose : path) {
    least_m = std::min(least_m, navigation::Distance(at, pose.at));
  }
  return least_m;
}

// Whatever it has done before: ahead, backwards, in bends and on the spot.
RC_GTEST_PROP(WayBack, LeadsOverPlacesWhereTheBodyHasBeen, ()) {
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  std::uniform_real_distribution<double> any(-1, 1);
  Body body;
  navigation::TravelledPath travelled;
  navigation::Path all;
  for (int part = 0; part < 6; ++part) {
    const bool on_the_spot = random() % 4 == 0;
    const navigation::Velocity command{.x_m_s = on_the_spot ? 0 : 0.5 * any(random),
                                       .yaw_rad_s = any(random)};
    for (int i = 0; i < 50; ++i) {
      body.Move(command);
      travelled.Add(body.pose);
      all.push_back(body.pose);
    }
  }
  WayBack way(body.pose, travelled.Back(), 0.4);
  RC_ASSERT(way.length_m() <= 0.4 + 1e-9);
  double farthest_m = 0;
  int steps = 0;
  for (; steps < 600 && !way.over(); ++steps) {
    const navigation::Velocity command = way.Command(body.pose, {0.15, 0.6});
    RC_ASSERT(std::abs(command.x_m_s) <= 0.15 + 1e-9);
    RC_ASSERT(std::abs(command.yaw_rad_s) <= 0.6 + 1e-9);
    body.Move(command);
    farthest_m = std::max(farthest_m, OffPath(body.pose.at, all));
  }
  RC_ASSERT(way.over());
  RC_ASSERT(farthest_m < 0.1);
}

TEST(WayBack, SaysWhatIsLeftOfItInTheFrameOfTheBody) {
  navigation::Path travelled;
  for (int i = 0; i < 20; ++i) travelled.push_back({{0, -0.05 * i, 0}, M_PI / 2});
  const navigation::Pose here{{0, 0, 0}, M_PI / 2};
  const WayBack way(here, travelled, 0.4);
  EXPECT_NEAR(way.length_m(), 0.4, 1e-9);
  const auto left = way.Left(here);
  ASSERT_EQ(left.size(), 9U);
  EXPECT_NEAR(left.back().at.x_m, -0.4, 1e-9) << "behind it";
  EXPECT_NEAR(left.back().at.y_m, 0, 1e-9);
  EXPECT_NEAR(std::abs(left.front().yaw_rad), M_PI, 1e-9);
}

TEST(WayBack, OfABodyThatHasNotMovedIsOver) {
  WayBack way({}, {}, 0.4);
  EXPECT_EQ(way.length_m(), 0);
  EXPECT_TRUE(way.over());
  EXPECT_EQ(way.Command({}, {0.15, 0.6}), navigation::Velocity{});
  EXPECT_EQ(way.Left({}).size(), 1U);
}

}  // namespace musher::skills::way_back_test
