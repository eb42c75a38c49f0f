// Where the robot looks: low pass, the camera that turns with the head, and the trail of the head.

#include "musher/modules/wedding/data/gaze.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding::perception_test {

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

TEST(GazeTest, RecoversFromNan) {
  const double nan = std::nan("");
  EXPECT_EQ(Follow({nan, nan}, {1, 0}, 0.3, Milliseconds(20)), Gaze{});
  EXPECT_EQ(Follow({0.2, 0.2}, {nan, 0.2}, 0.3, Milliseconds(20)).x, 0.5);
  EXPECT_EQ(GazeAt({0.5, 0.5}, {nan, 0}, OnTheHead()).x, 0.5);
}

TEST(GazeTest, TakesThePointOfThePictureWhereTheCameraStandsStill) {
  EXPECT_EQ(GazeAt({0.2, 0.8}, {1.0, 0.5}, {}), (Gaze{0.2, 0.8}));
}

TEST(GazeTest, IsTheSameHoweverTheHeadStoodWhenItTurnsWithIt) {
  const double expected = 0.5 - 0.4 / (2 * kYawLimit);  // 0.4 rad to the left
  for (const double head : {-0.1, 0.0, 0.4, 0.9}) {
    const Gaze gaze = GazeAt(InPicture(0.4, head, 1.2), {head, 0}, OnTheHead());
    EXPECT_NEAR(gaze.x, expected, 1e-9) << head;
  }
}

TEST(GazeTest, StopsAtTheLimitsOfTheHead) {
  EXPECT_EQ(GazeAt({0, 0.5}, {kYawLimit, 0}, OnTheHead()).x, 0);
  EXPECT_EQ(GazeAt({1, 0.5}, {-kYawLimit, 0}, OnTheHead()).x, 1);
}

TEST(GazeTest, TurnsHeightIntoANodWhereTheRobotCanNod) {
  GazeRules rules = OnTheHead();
  EXPECT_EQ(GazeAt({0.5, 0.8}, {}, rules).y, 0.8);
  rules.pitch_limit_rad = 0.5;
  const double down = std::atan(0.6 * std::tan(0.6) * 0.75);
  EXPECT_NEAR(GazeAt({0.5, 0.8}, {}, rules).y, 0.5 + down, 1e-9);
}

TEST(GazeTest, ComputesHowFarAHeadHasNodded) {
  GazeRules rules;
  rules.pitch_limit_rad = 0.4;
  EXPECT_NEAR(Nod(0, {0.5, 1}, rules, Milliseconds(20)), 0.01, 1e-12);
  EXPECT_NEAR(Nod(0.39, {0.5, 1}, rules, Milliseconds(1000)), 0.4, 1e-12);
  EXPECT_EQ(Nod(0.1, {0.5, 0}, rules, Milliseconds(-20)), 0.1);
}

TEST(AngleTrailTest, InterpolatesBetweenTwoMeasurements) {
  AngleTrail trail;
  EXPECT_FALSE(trail.At(Milliseconds(100)));
  trail.Add(Milliseconds(100), 0.1);
  trail.Add(Milliseconds(120), 0.2);
  EXPECT_FALSE(trail.At(Milliseconds(99))) << "before it begins";
  EXPECT_NEAR(trail.At(Milliseconds(105)).value(), 0.125, 1e-12);
  EXPECT_EQ(trail.At(Milliseconds(500)), 0.2) << "after its end";
}

TEST(AngleTrailTest, GoesBackASecondHoweverOftenTheHeadIsMeasured) {
  AngleTrail trail;
  for (int ms = 0; ms <= 3000; ++ms) trail.Add(Milliseconds(ms), ms / 1000.0);
  EXPECT_NEAR(trail.At(Milliseconds(2000)).value(), 2, 1e-9);
  EXPECT_EQ(trail.Last(), 3);
}

TEST(AngleTrailTest, BeginsAgainWhenTheClockWasSetBack) {
  AngleTrail trail;
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

// Its picture comes ten times a second and is a tenth of a second old: a robot that took the point
// itself for the gaze would nod to and fro.
TEST_F(HeadCamera, NodsToATallGuestWithoutSwinging) {
  ShowConfig config;
  config.gaze = OnTheHead();
  config.gaze.pitch_limit_rad = 0.35;
  Begin(config);
  const double up = 0.2;
  const double edge = std::tan(0.6) * 0.75;
  double pitch = 0;  // of the robot, as commanded, at its limited speed
  std::vector<std::pair<Duration, double>> shots;
  std::vector<double> pitches;
  for (int i = 0; i < 300; ++i) {
    const Duration stamp = now_.time_since_epoch();
    Head(0, stamp);
    if (i % 5 == 0) shots.emplace_back(stamp, 0.5 + std::tan(-up - pitch) / edge / 2);
    if (i % 5 == 0 && i > 5) {
      const auto& [taken, y] = shots.at(shots.size() - 2);
      show_->OnTarget({{0.5, y}, 1.5, taken}, now_);
    }
    Tick();
    pitch = Nod(pitch, data().motion.look_at_target, config.gaze, step_);
    pitches.push_back(pitch);
  }
  EXPECT_NEAR(pitch, -up, 0.002);
  for (const double each : pitches) EXPECT_GT(each, -up - 0.02) << "it does not swing";
}

// Stamps of the system's clock, a nod computed by the machine's.
TEST_F(HeadCamera, UnderstandsAPictureOfANodWhateverClockStampsIt) {
  for (const Duration ahead : {Duration(0), Duration(std::chrono::hours(24 * 365 * 50))}) {
    ShowConfig config;
    config.gaze = OnTheHead();
    config.gaze.pitch_limit_rad = 0.35;
    Begin(config);
    const double down = 0.2;
    const double edge = std::tan(0.6) * 0.75;
    double pitch = 0;
    double most = 0;
    std::vector<std::pair<Duration, double>> past;
    for (int i = 0; i < 300; ++i) {
      past.emplace_back(now_.time_since_epoch() + ahead, pitch);
      Head(0, past.back().first);
      if (i % 5 == 0 && i >= 10) {
        const auto& [stamp, stood] = past.at(past.size() - 11);  // 200 ms ago
        show_->OnTarget({{0.5, 0.5 + std::tan(down - stood) / edge / 2}, 1.5, stamp}, now_);
      }
      Tick();
      pitch = Nod(pitch, data().motion.look_at_target, config.gaze, step_);
      most = std::max(most, pitch);
    }
    EXPECT_NEAR(pitch, down, 0.002) << ahead.count();
    EXPECT_LT(most, down + 0.02) << ahead.count() << ": it does not swing";
  }
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

TEST_F(HeadCamera, HoldsItsGazeWhileTheHeadsAnglesAreUnknown) {
  Face({0.9, 0.5});
  Tick();
  ASSERT_EQ(state(), "TRACKING");
  for (int i = 0; i < 10; ++i) TickWithFace(1, {0.9, 0.5});
  EXPECT_EQ(data().motion.look_at_target, Gaze{});
  Head(0, now_.time_since_epoch());
  TickWithFace(3, {0.9, 0.5});
  EXPECT_GT(data().motion.look_at_target.x, 0.5);
}

}  // namespace musher::wedding::perception_test
