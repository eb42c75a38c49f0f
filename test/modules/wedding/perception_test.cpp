// Where the robot looks: low pass, the camera that turns with the head, and the trail of the head.

#include "musher/modules/wedding/gaze.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding {
namespace {

constexpr double kYawLimit = 2.0;

GazeRules OnTheHead() {
  GazeRules rules;
  rules.camera = Mount::kHead;
  rules.hfov_rad = 1.2;
  rules.yaw_limit_rad = kYawLimit;
  return rules;
}

// Where a face that stands `left_rad` to the left of the robot's front is in the picture.
Gaze InPicture(double left_rad, double head_yaw_rad, double hfov_rad) {
  return {0.5 - std::tan(left_rad - head_yaw_rad) / std::tan(hfov_rad / 2) / 2, 0.5};
}

TEST(GazeTest, GoesThreeTenthsOfTheWayInTwentyMilliseconds) {
  const Gaze gaze = Follow({0.5, 0.5}, {1, 0}, 0.3, Milliseconds(20));
  EXPECT_NEAR(gaze.x, 0.65, 1e-12);
  EXPECT_NEAR(gaze.y, 0.35, 1e-12);
}

TEST(GazeTest, StandsStillWhenNoTimePassesOrItWentBack) {
  EXPECT_EQ(Follow({0.5, 0.5}, {1, 0}, 0.3, Duration(0)), (Gaze{0.5, 0.5}));
  EXPECT_EQ(Follow({0.5, 0.5}, {1, 0}, 0.3, Milliseconds(-20)), (Gaze{0.5, 0.5}));
}

TEST(GazeTest, TakesThePointOfThePictureWhereTheCameraStandsStill) {
  EXPECT_EQ(GazeAt({0.2, 0.8}, 1.0, {}), (Gaze{0.2, 0.8}));
}

TEST(GazeTest, IsTheSameHoweverTheHeadStoodWhenItTurnsWithIt) {
  const double expected = 0.5 - 0.4 / (2 * kYawLimit);  // 0.4 rad to the left
  for (const double head : {-0.1, 0.0, 0.4, 0.9}) {
    const Gaze gaze = GazeAt(InPicture(0.4, head, 1.2), head, OnTheHead());
    EXPECT_NEAR(gaze.x, expected, 1e-9) << head;
  }
}

TEST(GazeTest, StopsAtTheLimitsOfTheHead) {
  EXPECT_EQ(GazeAt({0, 0.5}, kYawLimit, OnTheHead()).x, 0);
  EXPECT_EQ(GazeAt({1, 0.5}, -kYawLimit, OnTheHead()).x, 1);
}

TEST(GazeTest, TurnsHeightIntoANodWhereTheRobotCanNod) {
  GazeRules rules = OnTheHead();
  EXPECT_EQ(GazeAt({0.5, 0.8}, 0, rules).y, 0.8);
  rules.pitch_limit_rad = 0.5;
  const double down = std::atan(0.6 * std::tan(0.6) * 0.75);
  EXPECT_NEAR(GazeAt({0.5, 0.8}, 0, rules).y, 0.5 + down, 1e-9);
}

TEST(YawTrailTest, TellsHowTheHeadStoodBetweenTwoMeasurements) {
  YawTrail trail;
  EXPECT_FALSE(trail.At(Milliseconds(100)));
  trail.Add(Milliseconds(100), 0.1);
  trail.Add(Milliseconds(120), 0.2);
  EXPECT_FALSE(trail.At(Milliseconds(99))) << "before it begins";
  EXPECT_NEAR(trail.At(Milliseconds(105)).value(), 0.125, 1e-12);
  EXPECT_EQ(trail.At(Milliseconds(500)), 0.2) << "after its end";
}

TEST(YawTrailTest, GoesBackASecondHoweverOftenTheHeadIsMeasured) {
  YawTrail trail;
  for (int ms = 0; ms <= 3000; ++ms) trail.Add(Milliseconds(ms), ms / 1000.0);
  EXPECT_NEAR(trail.At(Milliseconds(2000)).value(), 2, 1e-9);
  EXPECT_EQ(trail.Last(), 3);
}

TEST(YawTrailTest, BeginsAnewWhenTheClockWasSetBack) {
  YawTrail trail;
  trail.Add(Milliseconds(5000), 1);
  trail.Add(Milliseconds(100), 0.5);
  EXPECT_EQ(trail.At(Milliseconds(5000)), 0.5);
}

class HeadCamera : public ShowRig {
 protected:
  void SetUp() override {
    ShowConfig config;
    config.gaze = OnTheHead();
    Begin(config);
  }
  void Head(double yaw_rad, Duration stamp) {
    const std::vector<std::string> names = {"j12_waist_yaw", "j23_head_yaw"};
    const std::vector<double> positions = {yaw_rad / 4, yaw_rad * 3 / 4};
    show_->OnJointStates(names, positions, stamp, now_);
  }
};

TEST_F(HeadCamera, TurnsToAFaceAndStaysThereWhileThePictureMovesWithTheHead) {
  const GazeRules rules = OnTheHead();
  double head = 0;
  for (int i = 0; i < 300; ++i) {
    const Duration stamp = now_.time_since_epoch();
    Head(head, stamp);
    show_->OnTarget({InPicture(0.4, head, rules.hfov_rad), 1.5, stamp}, now_);
    Tick();
    const double wanted = (0.5 - data().motion.look_at_target.x) * 2 * kYawLimit;
    head += std::clamp(wanted - head, -0.01, 0.01);  // 0.5 rad/s
  }
  EXPECT_NEAR(head, 0.4, 0.001);
}

TEST_F(HeadCamera, UnderstandsAPictureThatWasOnItsWayForATenthOfASecond) {
  const Duration shot = now_.time_since_epoch();
  const Gaze point = InPicture(0.4, 0.1, 1.2);
  for (int i = 0; i <= 10; ++i) {
    Head(0.1 + i * 0.01, shot + Milliseconds(i * 10));
  }
  show_->OnTarget({point, 1.5, shot}, now_);
  Tick(2);
  EXPECT_NEAR(data().perception.face_gaze.x, 0.5 - 0.4 / (2 * kYawLimit), 1e-9);
}

TEST_F(HeadCamera, HoldsItsGazeWhileNobodySaysHowTheHeadStands) {
  Face({0.9, 0.5});
  Tick();
  ASSERT_EQ(state(), "TRACKING");
  for (int i = 0; i < 10; ++i) TickWithFace(1, {0.9, 0.5});
  EXPECT_EQ(data().motion.look_at_target, Gaze{});
  Head(0, now_.time_since_epoch());
  TickWithFace(3, {0.9, 0.5});
  EXPECT_GT(data().motion.look_at_target.x, 0.5);
}

}  // namespace
}  // namespace musher::wedding
