// The estimate of the lane, and the velocity that leads back to its middle.

#include "musher/modules/line_walker/lane.hpp"

#include <gmock/gmock.h>

#include "musher/modules/line_walker/steering.hpp"

namespace musher::line_walker::lane_test {

SideLine LineAt(double distance_m, double heading_rad = 0, double curvature_per_m = 0) {
  return {distance_m, heading_rad, curvature_per_m, 1};
}

TEST(Lane, IsKnownByOneLineAloneAndItsWidth) {
  const InLane by_left = InLaneBy(LineAt(0.3, 0.1), Side::kLeft, 0.83);
  EXPECT_NEAR(by_left.offset_m, 0.115, 1e-9);
  EXPECT_NEAR(by_left.heading_rad, -0.1, 1e-9);
  const InLane by_right = InLaneBy(LineAt(0.53, 0.1), Side::kRight, 0.83);
  EXPECT_NEAR(by_right.offset_m, 0.115, 1e-9);
  EXPECT_NEAR(by_right.heading_rad, -0.1, 1e-9);
}

TEST(Lane, HasACurvatureBetweenThoseOfItsLines) {
  EXPECT_NEAR(InLaneBy(LineAt(0.4, 0, 1 / 1.185), Side::kLeft, 0.83).curvature_per_m, 1 / 1.6,
              1e-9);
  EXPECT_NEAR(InLaneBy(LineAt(0.4, 0, 1 / 2.015), Side::kRight, 0.83).curvature_per_m, 1 / 1.6,
              1e-9);
}

TEST(Lane, ContinuesAsAnArcByOdometry) {
  LaneEstimate lane({});
  const Pose start{3, 4, 0.5};
  EXPECT_FALSE(lane.known());
  EXPECT_TRUE(lane.See(start, LineAt(0.415, 0, 1 / 1.185), Side::kLeft, true));
  ASSERT_TRUE(lane.known());
  // A quarter of the circle of the middle.
  Pose pose = start;
  for (int i = 0; i < 1000; ++i) pose = Moved(pose, {1.6 * M_PI / 2, 0, M_PI / 2}, 0.001);
  const InLane later = lane.At(pose);
  EXPECT_NEAR(later.offset_m, 0, 1e-3);
  EXPECT_NEAR(later.heading_rad, 0, 1e-3);
  EXPECT_NEAR(lane.At(Moved(pose, {0, 0.1, 0}, 1)).offset_m, 0.1, 1e-3) << "the left is inwards";
}

TEST(Lane, IsLedByTheLeftLine) {
  LaneEstimate both({});
  const Pose pose;
  EXPECT_TRUE(both.See(pose, LineAt(0.415), Side::kLeft, false));
  for (int i = 0; i < 50; ++i) {
    EXPECT_TRUE(both.See(pose, LineAt(0.415), Side::kLeft, false));
    EXPECT_TRUE(both.See(pose, LineAt(0.465), Side::kRight, false));
  }
  EXPECT_LT(both.At(pose).offset_m, 0.02) << "nearer to 0 than to the right line's 0.05";
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(both.See(pose, LineAt(0.465), Side::kRight, true));
  EXPECT_NEAR(both.At(pose).offset_m, 0.05, 1e-3) << "alone it decides";
}

TEST(Lane, DoesNotBelieveAJumpAtOnce) {
  LaneEstimate lane({});
  const Pose pose;
  EXPECT_TRUE(lane.See(pose, LineAt(0.415), Side::kLeft, false));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(lane.See(pose, LineAt(0.15), Side::kLeft, false));
  EXPECT_NEAR(lane.At(pose).offset_m, 0, 1e-9);
  EXPECT_TRUE(lane.See(pose, LineAt(0.15), Side::kLeft, false)) << "the fourth";
  EXPECT_NEAR(lane.At(pose).offset_m, 0.265, 1e-9);
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(lane.See(pose, LineAt(0.1), Side::kRight, false));
}

TEST(LaneEstimate, BeginsWithALineOfTheLaneAheadAndNotOfAnotherOneBesideIt) {
  const LaneEstimate lane{LaneRules()};
  const auto line = [](double distance_m, double heading_rad) {
    SideLine seen;
    seen.distance_m = distance_m;
    seen.heading_rad = heading_rad;
    return seen;
  };
  EXPECT_TRUE(lane.MayBeFirst(line(0.415, 0), Side::kLeft)) << "in the middle of it";
  EXPECT_TRUE(lane.MayBeFirst(line(0.65, 0.3), Side::kRight));
  EXPECT_FALSE(lane.MayBeFirst(line(0.85, 0), Side::kLeft)) << "a lane that begins behind its end";
  EXPECT_FALSE(lane.MayBeFirst(line(0.415, 0.8), Side::kRight)) << "a lane that crosses";
}

TEST(Steering, TurnsToTheRightWhereTheBodyIsLeftOfTheMiddleOrTurnedToTheLeft) {
  const SteeringRules rules;
  EXPECT_LT(Steer({0.1, 0, 0}, 1, rules).yaw_rad_s, -0.2);
  EXPECT_LT(Steer({0.1, 0, 0}, 1, rules).left_m_s, -0.02);
  EXPECT_GT(Steer({-0.1, 0, 0}, 1, rules).yaw_rad_s, 0.2);
  EXPECT_LT(Steer({0, 0.2, 0}, 1, rules).yaw_rad_s, -0.2);
  EXPECT_GT(Steer({0, -0.2, 0}, 1, rules).yaw_rad_s, 0.2);
}

TEST(Steering, TurnsWithTheLane) {
  const Velocity velocity = Steer({0, 0, 0.625}, 1, {});
  EXPECT_NEAR(velocity.forward_m_s, 0.3, 1e-9);
  EXPECT_NEAR(velocity.yaw_rad_s, 0.3 * 0.625, 1e-9) << "to the left is positive";
  EXPECT_LT(Steer({0, 0, -0.625}, 1, {}).yaw_rad_s, 0);
}

TEST(Steering, StaysWithinItsLimits) {
  SteeringRules rules;
  const Velocity far = Steer({0.5, 0.5, 0}, 1, rules);
  EXPECT_EQ(far.yaw_rad_s, -rules.yaw_rad_s);
  EXPECT_EQ(far.left_m_s, -rules.side_m_s);
  EXPECT_LT(Steer({0, 0.5, 0}, 1, rules).forward_m_s, 0.2) << "turned";
  EXPECT_EQ(Steer({0, 2, 0}, 1, rules).forward_m_s, rules.slow_m_s) << "turned far";
  EXPECT_NEAR(Steer({0, 0, 2}, 1, rules).forward_m_s, 0.21, 1e-9) << "a tight curve";
  EXPECT_EQ(Steer({0, 0, 0}, 0.15, rules).forward_m_s, 0.15);
}

}  // namespace musher::line_walker::lane_test
