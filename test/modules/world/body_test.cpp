// The body and its board: which commands it takes, how it moves and what it reports.

#include "musher/modules/world/body/body.hpp"

#include <gmock/gmock.h>

#include "musher/test/modules/world/scenes.hpp"

namespace musher::world::body_test {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::Optional;

class BodyTest : public ::testing::Test {
 protected:
  void Lying() {
    Scene scene = EmptyYard();
    scene.start_standing = false;
    world_ = World(scene);
  }
  const Body& body() const { return world_.body(); }
  Vector3d place() const {
    return {body().pose().position_m.x(), body().pose().position_m.y(), body().pose().yaw_rad};
  }

  World world_{EmptyYard()};
  Commander commander_{world_};
};

TEST_F(BodyTest, TakesUpACommandedSpeedWithItsLag) {
  commander_.Walk({0.5, 0, 0}, world_.scene().body.lag);
  EXPECT_NEAR(body().speed().x(), 0.5 * (1 - std::exp(-1)), 1e-9);
  commander_.Walk({0.5, 0, 0}, Seconds(2));
  EXPECT_NEAR(body().speed().x(), 0.5, 1e-4);
  EXPECT_EQ(body().speed().y(), 0);
}

TEST_F(BodyTest, WalksAheadToTheSideAndTurnsLeftForPositiveYaw) {
  commander_.Walk({0.5, 0, 0}, Seconds(4));
  EXPECT_NEAR(place().x(), 0.5 * 4 - 0.5 * 0.2, 0.01);  // the distance of one lag is lost
  commander_.Walk({0, 0.3, 0}, Seconds(4));
  EXPECT_NEAR(place().y(), 0.3 * 4 - 0.3 * 0.2, 0.01);
  commander_.Walk({0, 0, 0.5}, Seconds(2));
  EXPECT_NEAR(place().z(), 0.5 * 2 - 0.5 * 0.2, 0.01);
}

TEST_F(BodyTest, LosesTheShareOfItsSpeedThatTheGroundTakes) {
  Scene scene = EmptyYard();
  scene.body.slip = 0.1;
  world_ = World(scene);
  commander_.Walk({0.5, 0, 0}, Seconds(3));
  EXPECT_NEAR(body().speed().x(), 0.45, 1e-4);
}

TEST_F(BodyTest, LosesAnotherShareOfItsYawRateIfTheSceneSaysSo) {
  Scene scene = EmptyYard();
  scene.body.slip = 0.1;
  world_ = World(scene);
  commander_.Walk({0.3, 0, 0.5}, Seconds(3));
  EXPECT_NEAR(body().turn_rate().z(), 0.45, 1e-4) << "by default the same";
  scene.body.yaw_slip = 0.2;
  world_ = World(scene);
  commander_.Walk({0.3, 0, 0.5}, Seconds(3));
  EXPECT_NEAR(body().turn_rate().z(), 0.4, 1e-4);
  EXPECT_NEAR(body().speed().x(), 0.27, 1e-4);
}

TEST_F(BodyTest, WalksNoFasterThanItsGaitCan) {
  commander_.Walk({9, -9, 9}, Seconds(3), 2);  // pronk
  EXPECT_NEAR(body().turn_rate().z(), 0.5, 1e-4);
  EXPECT_NEAR(body().speed().head<2>().norm(), std::hypot(0.25, 0.10), 1e-3);
}

TEST_F(BodyTest, StandsStillWhenTheCommandsEnd) {
  commander_.Walk({0.5, 0, 0}, Seconds(2));
  Pass(world_, Seconds(0.9));
  EXPECT_NEAR(body().speed().x(), 0.5, 1e-4);
  Pass(world_, Seconds(2));
  EXPECT_NEAR(body().speed().x(), 0, 1e-3);
  EXPECT_EQ(body().mode(), 11);
}

TEST_F(BodyTest, WalksOnWhileTheSameCommandIsRepeated) {
  BoardCommand command;
  command.mode = 11;
  command.gait = 27;
  command.life_count = 5;
  command.speed = {0.5, 0, 0};
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(world_.Command(command), std::nullopt);
    world_.Step();
  }
  EXPECT_NEAR(body().speed().x(), 0.5, 1e-4);
}

TEST_F(BodyTest, WalksForACommandsDurationAndReportsHowFarItIs) {
  commander_.Do(11, 3, {0.5, 0, 0}, Seconds(3));
  Pass(world_, Seconds(1.5));
  EXPECT_NEAR(body().progress_percent(), 50, 1);
  EXPECT_NEAR(body().speed().x(), 0.5, 1e-3);
  Pass(world_, Seconds(3.5));
  EXPECT_EQ(body().progress_percent(), 100);
  EXPECT_NEAR(place().x(), 1.5, 0.02);
  EXPECT_NEAR(body().speed().x(), 0, 1e-4);
}

TEST_F(BodyTest, StandsUpLiesDownAndReportsWhenItIsDone) {
  Lying();
  EXPECT_NEAR(body().attitude().height_m, 0.08, 1e-9);
  commander_.Do(12, 0);
  world_.Step();
  EXPECT_EQ(body().status(), BoardStatus::kTransitioning);
  Pass(world_, Seconds(1));
  EXPECT_EQ(body().status(), BoardStatus::kNormal);
  EXPECT_NEAR(body().progress_percent(), 51, 1);
  Pass(world_, Seconds(1));
  EXPECT_EQ(body().progress_percent(), 100);
  EXPECT_NEAR(body().attitude().height_m, 0.29, 1e-9);
  commander_.Do(7, 1);
  Pass(world_, Seconds(2));
  EXPECT_EQ(body().progress_percent(), 100);
  EXPECT_NEAR(body().attitude().height_m, 0.08, 1e-9);
}

TEST_F(BodyTest, RefusesToWalkLyingSinceTheModeMayNotFollow) {
  Lying();
  EXPECT_THAT(commander_.Do(11, 27, {0.5, 0, 0}), Optional(HasSubstr("may not follow mode 7")));
  Pass(world_, Seconds(1));
  EXPECT_EQ(body().status(), BoardStatus::kBanTrans);
  EXPECT_EQ(body().mode(), 7);
  EXPECT_EQ(place(), Vector3d::Zero());
  EXPECT_EQ(commander_.Do(12, 0), std::nullopt);
  Pass(world_, Seconds(1));
  EXPECT_EQ(body().status(), BoardStatus::kNormal);
}

TEST_F(BodyTest, DoesNotWalkBeforeItHasStoodUp) {
  Lying();
  commander_.Do(12, 0);
  Pass(world_, Seconds(1));
  EXPECT_THAT(commander_.Do(11, 27, {0.5, 0, 0}), Optional(HasSubstr("has not stood up")));
  Pass(world_, Seconds(0.98));
  EXPECT_EQ(body().progress_percent(), 95);  // not done before it is done
  world_.Step();
  EXPECT_EQ(body().progress_percent(), 100);
  EXPECT_EQ(commander_.Do(11, 27, {0.5, 0, 0}), std::nullopt);
}

TEST_F(BodyTest, TakesTheTimeThatTheSceneGivesAMotionLessWhereLittleIsLeftOfTheWay) {
  Scene scene = EmptyYard();
  scene.start_standing = false;
  scene.motion_times = {{12, 0, Seconds(4)}};
  world_ = World(scene);
  commander_.Do(12, 0);
  Pass(world_, Seconds(2));
  EXPECT_EQ(body().progress_percent(), 50);
  Pass(world_, Seconds(2));
  commander_.Do(12, 0);
  Pass(world_, Seconds(0.4));
  EXPECT_EQ(body().progress_percent(), 100);
}

TEST_F(BodyTest, RefusesAnUnknownMode) {
  EXPECT_THAT(commander_.Do(99, 0), Optional(HasSubstr("the board has no such motion")));
  EXPECT_EQ(body().status(), BoardStatus::kBanTrans);
}

TEST_F(BodyTest, EchoesTheAcceptedCommandAndNotTheRefusedOne) {
  Lying();
  commander_.Do(12, 0);  // 1
  EXPECT_EQ(body().life_count(), 1);
  commander_.Do(11, 27);  // 2
  EXPECT_EQ(body().life_count(), 1);
}

TEST_F(BodyTest, JumpsAheadAndLandsAsFarAsInTheTable) {
  commander_.Do(16, 1);
  Pass(world_, Seconds(0.9));
  EXPECT_TRUE(body().in_the_air());
  EXPECT_GT(body().attitude().height_m, 0.45);
  EXPECT_THAT(commander_.Do(7, 1), Optional(HasSubstr("has not ended")));
  Pass(world_, Seconds(0.9));
  EXPECT_EQ(body().progress_percent(), 100);
  EXPECT_NEAR(place().x(), 0.60, 1e-9);
  EXPECT_NEAR(body().attitude().height_m, 0.29, 1e-9);
}

TEST_F(BodyTest, JumpsLeftThenRightAndFacesAheadAgain) {
  commander_.Do(16, 0);
  Pass(world_, Seconds(1.3));
  EXPECT_NEAR(place().z(), M_PI / 2, 1e-9);
  EXPECT_THAT(commander_.Do(16, 3), Optional(HasSubstr("may not follow")));
  commander_.Do(12, 0);
  Pass(world_, Seconds(0.5));
  EXPECT_EQ(commander_.Do(16, 3), std::nullopt);
  Pass(world_, Seconds(1.3));
  EXPECT_NEAR(place().z(), 0, 1e-9);
}

TEST_F(BodyTest, TurnsOverOnceInABackFlip) {
  commander_.Do(17, 1);
  double turned = 0;
  for (int i = 0; i < 150; ++i) {
    world_.Step();
    turned += body().turn_rate().y() * 0.02;
  }
  EXPECT_NEAR(turned, -2 * M_PI, 0.01);
  EXPECT_NEAR(body().attitude().pitch_rad, 0, 1e-9);
  EXPECT_NEAR(place().x(), -0.4, 1e-9);
}

TEST_F(BodyTest, TakesUpTheCommandedPose) {
  BoardCommand command;
  command.mode = 21;
  command.life_count = 1;
  command.attitude = {0.1, -0.2, 0};
  command.raised_m = -0.05;
  command.duration = Seconds(1);
  EXPECT_EQ(world_.Command(command), std::nullopt);
  Pass(world_, Seconds(1));
  EXPECT_EQ(body().progress_percent(), 100);
  EXPECT_NEAR(body().attitude().roll_rad, 0.1, 0.005);
  EXPECT_NEAR(body().attitude().pitch_rad, -0.2, 0.005);
  EXPECT_NEAR(body().attitude().height_m, 0.24, 0.005);
}

TEST_F(BodyTest, SinksDownWithoutMotorPowerAndRefusesUntilItIsBack) {
  commander_.Walk({0.5, 0, 0}, Seconds(2));
  world_.SetMotorPower(false);
  Pass(world_, Seconds(2));
  EXPECT_EQ(body().mode(), 0);
  EXPECT_EQ(body().status(), BoardStatus::kDamped);
  EXPECT_NEAR(body().attitude().height_m, 0.08, 1e-9);
  EXPECT_NEAR(body().speed().norm(), 0, 1e-3);
  EXPECT_THAT(commander_.Do(12, 0), Optional(HasSubstr("no power")));
  world_.SetMotorPower(true);
  world_.Step();
  EXPECT_EQ(commander_.Do(12, 0), std::nullopt);
}

TEST_F(BodyTest, SinksDownAtAnEmergencyStopAndNeedsToStandUpFirst) {
  commander_.Walk({0.5, 0, 0}, Seconds(2));
  EXPECT_EQ(commander_.Do(0, 0), std::nullopt);
  Pass(world_, Seconds(1));
  EXPECT_EQ(body().mode(), 0);
  EXPECT_EQ(body().progress_percent(), 100);
  EXPECT_EQ(body().status(), BoardStatus::kNormal);
  EXPECT_THAT(commander_.Do(11, 27), Optional(HasSubstr("may not follow")));
}

TEST_F(BodyTest, ReportsAFaultAndOnlyLiesDownWithIt) {
  commander_.Walk({0.5, 0, 0}, Seconds(1));
  world_.SetFault(*FindFault("lifted"), 0);
  commander_.Walk({0.5, 0, 0}, Seconds(2));
  EXPECT_EQ(body().status(), BoardStatus::kLifted);
  EXPECT_NEAR(body().speed().norm(), 0, 1e-3);
  EXPECT_THAT(commander_.Do(12, 0), Optional(HasSubstr("lifted")));
  EXPECT_EQ(commander_.Do(7, 1), std::nullopt);
  Pass(world_, Seconds(2));
  EXPECT_EQ(body().progress_percent(), 100);
  world_.SetFault(*FindFault("none"), 0);
  EXPECT_EQ(body().status(), BoardStatus::kNormal);
}

TEST_F(BodyTest, NamesTheMotorThatFails) {
  world_.SetFault(*FindFault("motor"), 7);
  EXPECT_EQ(body().status(), BoardStatus::kMotor);
  EXPECT_NE(body().motor_errors()[7], 0);
  EXPECT_EQ(body().motor_errors()[6], 0);
}

TEST_F(BodyTest, WarmsItsMotorsByWalking) {
  const double before = body().motor_temperature_c(0);
  commander_.Walk({0.3, 0, 0.5}, Seconds(60));
  EXPECT_GT(body().motor_temperature_c(0), before + 5);
}

TEST_F(BodyTest, DriftsInItsOdometryOnly) {
  Scene scene = EmptyYard();
  scene.body.odometry_scale = 1.1;
  scene.body.odometry_yaw_drift_rad_per_m = 0.02;
  world_ = World(scene);
  commander_.Walk({0.5, 0, 0}, Seconds(4));
  EXPECT_NEAR(place().z(), 0, 1e-12);
  EXPECT_NEAR(body().odometry().yaw_rad, place().x() * 0.02, 1e-6);
  EXPECT_NEAR(body().odometry().position_m.norm(), place().x() * 1.1, 0.01);
}

TEST_F(BodyTest, MeasuresGravityAndItsOwnAcceleration) {
  Pass(world_, Seconds(1));
  EXPECT_NEAR(body().acceleration().z(), 9.81, 1e-9);
  commander_.Do(11, 27, {0.5, 0, 0});
  world_.Step();
  EXPECT_NEAR(body().acceleration().x(), 0.5 * (1 - std::exp(-0.1)) / 0.02, 1e-6);
}

}  // namespace musher::world::body_test
