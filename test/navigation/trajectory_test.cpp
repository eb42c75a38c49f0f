// The motion along a path: its limits, its time, and paths of every kind.

#include "musher/navigation/trajectory/trajectory.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <limits>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation::trajectory_test {

using ::testing::HasSubstr;

constexpr double kStepS = 0.02;
constexpr MotionLimits kLimits;

double Norm(double x, double y, double z) {
  return std::hypot(x, y, z);
}

// What a body would measure between two points, and what the points say. Empty: within the limits.
std::string ExceededLimit(const Trajectory& trajectory) {
  const auto& points = trajectory.points;
  const auto over = [](double value, double limit) {
    return !(value <= limit * (1 + 1e-6) + 1e-9);
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Velocity &v = points[i].velocity, &a = points[i].acceleration;
    const std::string where = " at point " + std::to_string(i);
    if (over(Speed(v), kLimits.speed_m_s)) return "speed" + where;
    if (over(std::abs(v.yaw_rad_s), kLimits.yaw_rad_s)) return "yaw rate" + where;
    if (over(Speed(a), kLimits.acceleration_m_s2)) return "acceleration" + where;
    if (over(std::abs(a.yaw_rad_s), kLimits.yaw_rad_s2)) return "yaw acceleration" + where;
    if (i == 0) continue;
    const TrajectoryPoint& before = points[i - 1];
    if (over(Distance(before.pose.at, points[i].pose.at), kLimits.speed_m_s * kStepS)) {
      return "distance" + where;
    }
    if (over(std::abs(points[i].pose.yaw_rad - before.pose.yaw_rad), kLimits.yaw_rad_s * kStepS)) {
      return "turn" + where;
    }
    if (over(Norm(v.x_m_s - before.velocity.x_m_s, v.y_m_s - before.velocity.y_m_s,
                  v.z_m_s - before.velocity.z_m_s),
             kLimits.acceleration_m_s2 * kStepS)) {
      return "change of velocity" + where;
    }
    if (over(std::abs(v.yaw_rad_s - before.velocity.yaw_rad_s), kLimits.yaw_rad_s2 * kStepS)) {
      return "change of yaw rate" + where;
    }
  }
  return {};
}

Trajectory Made(const Path& path) {
  return MakeTrajectory(path, {}).value();
}

double SecondsOf(const Trajectory& trajectory) {
  return ToSeconds(trajectory.duration());
}

TEST(Trajectory, TakesTheLeastTimeOnAStraightLine) {
  // 1.5 m/s by 0.8 m/s² twice takes 3.75 s and 2.8125 m; the rest of 10 m is driven at 1.5 m/s.
  const Trajectory trajectory = Made({{{0, 0, 0}, 0}, {{10, 0, 0}, 0}});
  EXPECT_NEAR(SecondsOf(trajectory), 3.75 + (10 - 2.8125) / 1.5, 0.04);
  // Too short for 1.5 m/s.
  EXPECT_NEAR(SecondsOf(Made({{{0, 0, 0}, 0}, {{1, 0, 0}, 0}})), 2 * std::sqrt(1 / 0.8), 0.04);
}

TEST(Trajectory, TakesTheLeastTimeForATurnOnTheSpot) {
  // 1 rad/s by 1.5 rad/s² twice takes 1.33 s and 0.67 rad.
  EXPECT_NEAR(SecondsOf(Made({{{2, 1, 0}, 0}, {{2, 1, 0}, 3}})), 4.0 / 3 + 3 - 2.0 / 3, 0.04);
}

TEST(Trajectory, DrivesARoundCornerWithoutAStop) {
  Path path;
  for (int i = 0; i <= 90; ++i) {
    const double angle = i * M_PI / 180;
    path.push_back({{2 * std::sin(angle), 2 - 2 * std::cos(angle), 0}, 0});
  }
  const Trajectory trajectory = Made(path);
  double highest_m_s = 0;
  for (const TrajectoryPoint& point : trajectory.points) {
    highest_m_s = std::max(highest_m_s, Speed(point.velocity));
    EXPECT_NEAR(std::hypot(point.pose.at.x_m, point.pose.at.y_m - 2), 2, 0.001);
  }
  EXPECT_NEAR(highest_m_s, std::sqrt(0.8 * 2), 0.06) << "of 0.8 m/s² at a radius of 2 m";
  EXPECT_LT(SecondsOf(trajectory), 4.2);
}

TEST(Trajectory, RoundsASharpCornerByThePermittedDistance) {
  TrajectoryRules rules;
  rules.corner_m = 0.1;
  const Trajectory trajectory =
      MakeTrajectory({{{0, 0, 0}, 0}, {{5, 0, 0}, 0}, {{5, 5, 0}, 0}}, rules).value();
  double nearest_m = 1, slowest_m_s = 9;
  for (const TrajectoryPoint& point : trajectory.points) {
    nearest_m = std::min(nearest_m, Distance(point.pose.at, {5, 0, 0}));
    const double from_end_m =
        std::min(Distance(point.pose.at, {0, 0, 0}), Distance(point.pose.at, {5, 5, 0}));
    if (from_end_m > 2) slowest_m_s = std::min(slowest_m_s, Speed(point.velocity));
  }
  EXPECT_GT(nearest_m, 0.05);
  EXPECT_LE(nearest_m, 0.101);
  EXPECT_GT(slowest_m_s, 0.3);
}

TEST(Trajectory, StopsAtAReversalAndGoesBack) {
  const Trajectory trajectory = Made({{{0, 0, 0}, 0}, {{2, 0, 0}, 0}, {{1, 0, 0}, 0}});
  double farthest_m = 0;
  for (const TrajectoryPoint& point : trajectory.points) {
    farthest_m = std::max(farthest_m, point.pose.at.x_m);
  }
  EXPECT_NEAR(farthest_m, 2, 0.001);
  EXPECT_NEAR(trajectory.points.back().pose.at.x_m, 1, 1e-9);
  EXPECT_NEAR(SecondsOf(trajectory), 2 * std::sqrt(2 / 0.8) + 2 * std::sqrt(1 / 0.8), 0.06);
}

TEST(Trajectory, OfOnePlaceIsOnePoint) {
  for (const Path& path : {Path{{{1, 2, 0}, 0.5}}, Path(7, {{1, 2, 0}, 0.5})}) {
    const Trajectory trajectory = Made(path);
    ASSERT_EQ(trajectory.points.size(), 1u);
    EXPECT_EQ(trajectory.points[0].pose, (Pose{{1, 2, 0}, 0.5}));
    EXPECT_EQ(trajectory.duration(), Duration::zero());
  }
}

TEST(Trajectory, TurnsTheShorterWay) {
  const Trajectory trajectory = Made({{{0, 0, 0}, 3}, {{0, 0, 0}, -3}});
  EXPECT_NEAR(trajectory.points.back().pose.yaw_rad, 2 * M_PI - 3, 1e-9);
}

TEST(Trajectory, BeginsWithTheSpeedOfABodyOnItsWay) {
  TrajectoryRules rules;
  rules.start_speed_m_s = 1.2;
  const Path path = {{{0, 0, 0}, 0}, {{5, 0, 0}, 0}};
  EXPECT_NEAR(MakeTrajectory(path, rules).value().points[0].velocity.x_m_s, 1.2, 1e-6);
  // Not so fast that it could not stop in time.
  EXPECT_NEAR(
      MakeTrajectory({{{0, 0, 0}, 0}, {{0.4, 0, 0}, 0}}, rules).value().points[0].velocity.x_m_s,
      0.8, 0.001);
}

TEST(Trajectory, IsSmoothBetweenItsPoints) {
  const Trajectory trajectory = Made({{{0, 0, 0}, 0}, {{3, 1, 0}, 1}});
  for (int ms = 0; ms < 4000; ms += 7) {
    const TrajectoryPoint a = trajectory.At(Milliseconds(ms));
    const TrajectoryPoint b = trajectory.At(Milliseconds(ms + 1));
    EXPECT_LE(Distance(a.pose.at, b.pose.at), 0.0016);
    EXPECT_NEAR((b.pose.at.x_m - a.pose.at.x_m) * 1000, a.velocity.x_m_s, 0.01);
  }
  EXPECT_EQ(trajectory.At(Milliseconds(-5)).pose, trajectory.points.front().pose);
  EXPECT_EQ(trajectory.At(std::chrono::hours(1)).pose, trajectory.points.back().pose);
}

TEST(Trajectory, RefusesAPathThatIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error_of = [](const Path& path) {
    const auto trajectory = MakeTrajectory(path, {});
    EXPECT_FALSE(trajectory.ok());
    return trajectory.ok() ? Error{} : trajectory.error();
  };
  EXPECT_THAT(error_of({}).message, HasSubstr("no pose"));
  EXPECT_THAT(error_of({{{0, 0, 0}, 0}, {{0, nan, 0}, 0}}).message, HasSubstr("pose 1 of 2"));
  EXPECT_THAT(error_of({{{0, 0, 0}, 0}, {{1e300, 0, 0}, 0}}).message, HasSubstr("at most"));
  EXPECT_THAT(error_of({{{0, 0, 0}, 0}, {{1e9, 0, 0}, 0}}).message, HasSubstr("at most 10000 m"));
  EXPECT_TRUE(Is(error_of({}), Fault::kInput));
}

TEST(Trajectory, RefusesLimitsThatAreNone) {
  TrajectoryRules rules;
  rules.limits.acceleration_m_s2 = 0;
  const auto trajectory = MakeTrajectory({{{0, 0, 0}, 0}}, rules);
  ASSERT_FALSE(trajectory.ok());
  EXPECT_THAT(trajectory.error().message, HasSubstr("0 m/s²"));
}

// Steps of all sizes: none, tiny, along, across, back, up, and turns.
Path RandomPath() {
  const auto share = [] { return *rc::gen::inRange(-1000, 1001) / 1000.0; };
  const int count = *rc::gen::inRange(1, 40);
  Path path = {{{share() * 5, share() * 5, 0}, share() * 4}};
  const bool flies = *rc::gen::arbitrary<bool>();
  for (int i = 1; i < count; ++i) {
    Pose next = path.back();
    const double size_m = *rc::gen::element(0.0, 1e-7, 1e-3, 0.03, 0.3, 3.0);
    const int kind = *rc::gen::inRange(0, 4);
    if (kind == 0 && path.size() > 1) {
      next.at = path[path.size() - 2].at;
    } else {
      next.at.x_m += size_m * share();
      next.at.y_m += kind == 1 ? 0 : size_m * share();
      if (flies) next.at.z_m += size_m * share();
    }
    next.yaw_rad += *rc::gen::element(0.0, 0.0, 1e-4, 0.2, 3.1) * share();
    path.push_back(next);
  }
  return path;
}

double ToLine(const Point& point, const Point& a, const Point& b) {
  const double length_m = Distance(a, b);
  if (length_m < 1e-12) return Distance(point, a);
  const double along =
      ((point.x_m - a.x_m) * (b.x_m - a.x_m) + (point.y_m - a.y_m) * (b.y_m - a.y_m) +
       (point.z_m - a.z_m) * (b.z_m - a.z_m)) /
      (length_m * length_m);
  return Distance(point, Between(a, b, std::clamp(along, 0.0, 1.0)));
}

double FromPath(const Point& point, const Path& path) {
  double nearest_m = Distance(point, path[0].at);
  for (std::size_t i = 1; i < path.size(); ++i) {
    nearest_m = std::min(nearest_m, ToLine(point, path[i - 1].at, path[i].at));
  }
  return nearest_m;
}

RC_GTEST_PROP(Trajectory, KeepsItsLimitsOnEveryPath, ()) {
  const Path path = RandomPath();
  const auto trajectory = MakeTrajectory(path, {});
  RC_ASSERT(trajectory.ok());
  RC_ASSERT(ExceededLimit(trajectory.value()) == "");
}

RC_GTEST_PROP(Trajectory, StaysOnThePathFromItsBeginToItsEnd, ()) {
  const Path path = RandomPath();
  const Trajectory trajectory = Made(path);
  RC_ASSERT(Distance(trajectory.points.front().pose.at, path.front().at) < 1e-4);
  RC_ASSERT(Distance(trajectory.points.back().pose.at, path.back().at) < 1e-3);
  RC_ASSERT(std::abs(Wrapped(trajectory.points.back().pose.yaw_rad - path.back().yaw_rad)) < 1e-3);
  RC_ASSERT(Speed(trajectory.points.back().velocity) == 0);
  for (const TrajectoryPoint& point : trajectory.points) {
    RC_ASSERT(FromPath(point.pose.at, path) < 0.031);
  }
}

}  // namespace musher::navigation::trajectory_test
