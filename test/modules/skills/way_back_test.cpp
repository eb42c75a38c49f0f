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

// Along x, ahead or backwards, in steps of 5 cm; the newest first.
navigation::Path Straight(double from_m, double to_m, double yaw_rad) {
  const int steps = int(std::round(std::abs(to_m - from_m) / 0.05));
  navigation::Path path;
  for (int i = 0; i <= steps; ++i) {
    path.push_back({{from_m + (to_m - from_m) * i / steps, 0, 0}, yaw_rad});
  }
  return path;
}

struct RandomWay {
  Body body;
  navigation::TravelledPath travelled;
  navigation::Path all;
};

// Ahead, backwards, in bends and on the spot; then it stands.
RandomWay Moved(std::mt19937_64& random, double noise_m) {
  std::uniform_real_distribution<double> any(-1, 1);
  RandomWay way;
  for (int part = 0; part < 6; ++part) {
    const bool on_the_spot = random() % 4 == 0, ahead = random() % 2 == 0;
    navigation::Velocity command{.x_m_s = 0.5 * any(random), .yaw_rad_s = any(random)};
    if (ahead) command.x_m_s = std::abs(command.x_m_s);
    if (on_the_spot) command.x_m_s = 0;
    for (int i = 0; i < 50 + (part == 5 ? 50 : 0); ++i) {
      way.body.Move(i < 50 ? command : navigation::Velocity{});
      navigation::Pose seen = way.body.pose;
      seen.at.x_m += noise_m * any(random);
      seen.at.y_m += noise_m * any(random);
      way.travelled.Add(seen);
      way.all.push_back(way.body.pose);
    }
  }
  return way;
}

// It drove ahead where it had turned, towards the person for whom it made room.
RC_GTEST_PROP(WayBack, NeverLeadsAheadOverPlacesWhereTheBodyHasBeen, ()) {
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  const double noise_m = random() % 2 == 0 ? 0 : 0.01;
  RandomWay moved = Moved(random, noise_m);
  Body& body = moved.body;
  body.ahead_m_s = body.turn_rad_s = 0;
  const navigation::Pose begin = body.pose;
  const auto ahead_m = [&] {
    return std::cos(begin.yaw_rad) * (body.pose.at.x_m - begin.at.x_m) +
           std::sin(begin.yaw_rad) * (body.pose.at.y_m - begin.at.y_m);
  };
  WayBack way(begin, moved.travelled.Back(), 0.4);
  RC_ASSERT(way.length_m() <= 0.4 + 1e-9);
  double farthest_m = 0;
  int steps = 0;
  for (; steps < 400 && !way.over() && !way.lost(); ++steps) {
    const navigation::Velocity command = way.Command(body.pose, {0.15, 0.6});
    RC_ASSERT(command.x_m_s <= 0);
    RC_ASSERT(command.x_m_s >= -0.15 - 1e-9);
    RC_ASSERT(std::abs(command.yaw_rad_s) <= 0.6 + 1e-9);
    const double before_m = ahead_m();
    body.Move(command);
    RC_ASSERT(ahead_m() <= before_m + 1e-9);
    farthest_m = std::max(farthest_m, OffPath(body.pose.at, moved.all));
  }
  RC_CLASSIFY(way.length_m() >= 0.2, "leads back");
  RC_CLASSIFY(way.lost(), "lost");
  RC_ASSERT(way.over() || way.lost());
  RC_ASSERT(farthest_m < 0.1);
}

TEST(WayBack, HasNoLengthWhereThePathLeadsAheadOrAside) {
  const navigation::Path came = Straight(0, -1, 0);
  EXPECT_NEAR(WayBack({}, came, 0.4).length_m(), 0.4, 1e-9);
  for (const double turned_rad : {M_PI, M_PI / 2, -M_PI / 2, 1.1, -1.1}) {
    EXPECT_EQ(WayBack({{}, turned_rad}, came, 0.4).length_m(), 0) << turned_rad;
  }
  const navigation::Path backwards = Straight(0, 1, 0);
  EXPECT_EQ(WayBack({}, backwards, 0.4).length_m(), 0) << "ahead of it";
  EXPECT_EQ(WayBack({{}, M_PI}, backwards, 0.4).length_m(), 0) << "it has turned since";
}

TEST(WayBack, EndsAtTheFirstCuspAndAtACorner) {
  navigation::Path cusp = Straight(0, -0.2, 0);
  for (const navigation::Pose& pose : Straight(-0.25, -0.6, M_PI)) cusp.push_back(pose);
  EXPECT_NEAR(WayBack({}, cusp, 0.4).length_m(), 0.2, 1e-9);
  navigation::Path corner = Straight(0, -0.2, 0);
  for (int i = 1; i < 10; ++i) corner.push_back({{-0.2, 0.05 * i, 0}, -M_PI / 2});
  EXPECT_NEAR(WayBack({}, corner, 0.4).length_m(), 0.2, 1e-9);
}

TEST(WayBack, IsLostForABodyThatTurnsAway) {
  WayBack way({}, Straight(0, -1, 0), 0.4);
  EXPECT_LT(way.Command({}, {0.15, 0.6}).x_m_s, 0);
  EXPECT_FALSE(way.lost());
  EXPECT_EQ(way.Command({{}, 1.5}, {0.15, 0.6}), navigation::Velocity{});
  EXPECT_TRUE(way.lost());
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
