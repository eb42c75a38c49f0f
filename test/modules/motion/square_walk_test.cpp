// The square that musher-motion walks, on a body that lags, slips and turns a little by itself.

#include "musher/modules/motion/tool/square_walk.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace musher::motion::tool::square_walk_test {

// A body in steps of 50 ms.
struct Walker {
  PlanarPose pose;
  double slip = 0;     // share of the speed that is lost
  double veer = 0;     // rad/s that it turns by itself while it moves
  double lag_s = 0.2;  // time constant of its speed
  Eigen::Vector3d speed = Eigen::Vector3d::Zero();

  void Step(const std::array<float, 3>& wanted) {
    constexpr double kSeconds = 0.05;
    const Eigen::Vector3d target(wanted[0], wanted[1], wanted[2]);
    speed += (target * (1 - slip) - speed) * (1 - std::exp(-kSeconds / lag_s));
    pose.at += Eigen::Rotation2Dd(pose.yaw) * Eigen::Vector2d(speed.head<2>()) * kSeconds;
    pose.yaw = WrapAngle(pose.yaw + (speed.z() + veer * speed.x()) * kSeconds);
  }
};

// Walks to the end, or to a time limit; returns the path, step by step.
int StepsToTheEnd(SquareWalk& walk, Walker& walker, std::vector<PlanarPose>* way = nullptr) {
  int steps = 0;
  for (; !walk.done() && steps < 4000; ++steps) {
    walker.Step(walk.Step(walker.pose));
    if (way != nullptr) way->push_back(walker.pose);
  }
  return steps;
}

TEST(SquareWalk, EndsWhereItBeganLookingAsItDid) {
  Walker walker;
  SquareWalk walk(walker.pose, 1.0, 0.3);
  const int steps = StepsToTheEnd(walk, walker);
  EXPECT_TRUE(walk.done());
  EXPECT_LT(walk.Gap(walker.pose), 0.03);
  EXPECT_NEAR(walker.pose.yaw, 0, 0.05);
  EXPECT_LT(steps, 30 * 20) << "in half a minute";
}

TEST(SquareWalk, GoesToTheLeftAroundItsFourCorners) {
  Walker walker;
  SquareWalk walk(walker.pose, 1.0, 0.3);
  std::vector<PlanarPose> way;
  StepsToTheEnd(walk, walker, &way);
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(1, 0), Eigen::Vector2d(1, 1), Eigen::Vector2d(0, 1)}) {
    const auto at_corner = [&](const PlanarPose& pose) { return (pose.at - corner).norm() < 0.06; };
    EXPECT_TRUE(std::any_of(way.begin(), way.end(), at_corner)) << corner.transpose();
  }
}

TEST(SquareWalk, HoldsItsLinesThoughTheBodySlipsAndVeers) {
  for (const double veer : {-0.5, 0.5}) {
    Walker walker;
    walker.slip = 0.2;
    walker.veer = veer;
    walker.pose = {{3, -2}, 2.5};
    SquareWalk walk(walker.pose, 1.0, 0.3);
    StepsToTheEnd(walk, walker);
    EXPECT_TRUE(walk.done());
    EXPECT_LT(walk.Gap(walker.pose), 0.05);
    EXPECT_NEAR(WrapAngle(walker.pose.yaw - 2.5), 0, 0.06);
  }
}

TEST(SquareWalk, IsNeverFasterThanItsSpeed) {
  Walker walker;
  SquareWalk walk(walker.pose, 2.0, 0.25);
  for (int i = 0; i < 4000 && !walk.done(); ++i) {
    const auto speed = walk.Step(walker.pose);
    EXPECT_LE(std::abs(speed[0]), 0.25F);
    EXPECT_LE(std::abs(speed[2]), 1.25F) << "the limit of the slow trot";
    walker.Step(speed);
  }
  EXPECT_EQ(walk.Step(walker.pose), (std::array<float, 3>{})) << "what is done stands";
}

TEST(SquareWalk, TakesTheYawOfATiltedBody) {
  const Eigen::Isometry3d X_OB = Eigen::Translation3d(1, 2, 0.3) *
                                 Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY());
  const PlanarPose pose = PlanarPoseOf(X_OB);
  EXPECT_NEAR(pose.yaw, 2.0, 1e-9);
  EXPECT_TRUE(pose.at.isApprox(Eigen::Vector2d(1, 2)));
  EXPECT_NEAR(WrapAngle(3 * std::numbers::pi / 2), -std::numbers::pi / 2, 1e-12);
}

}  // namespace musher::motion::tool::square_walk_test
