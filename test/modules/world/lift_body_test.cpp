// The lift chassis on platforms: its motion, its sensors, climbs, bumps and falls.

#include "musher/modules/world/body/lift_body.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "musher/test/modules/world/climber.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::world::lift_body_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(LiftBody, ReachesItsSpeedWithinItsAccelerationAndStopsWithoutCommands) {
  Climber climber(Stairs({0, 0, 0, 0, 0}));
  climber.Drive({3, 0, 0});
  climber.For(0.2);
  EXPECT_NEAR(climber.robot().velocity().x(), 0.5, 0.03);
  climber.For(1);
  EXPECT_NEAR(climber.robot().velocity().x(), 1.5, 1e-9) << "its highest speed";
  climber.ReleaseControl();
  climber.For(0.14);
  EXPECT_NEAR(climber.robot().velocity().x(), 1.5, 1e-9) << "a command is valid for 0.2 s";
  climber.For(1);
  EXPECT_EQ(climber.robot().velocity().norm(), 0);
}

TEST(LiftBody, MovesInEveryDirectionOfItsOwnFrame) {
  FieldSpec field = Stairs({0});
  field.robot.start_yaw_rad = M_PI / 2;
  Climber climber(field);
  climber.Drive({0.2, 0.4, 0});
  climber.For(3);
  EXPECT_NEAR(climber.robot().position_m().x(), -1.2, 0.08);
  EXPECT_NEAR(climber.robot().position_m().y(), 0.6, 0.05);
  climber.Drive({0, 0, 0.5});
  climber.For(2);
  EXPECT_NEAR(climber.robot().yaw_rad(), M_PI / 2 + 1, 0.08);
}

TEST(LiftBody, RefusesWhatIsNotANumberAndKeepsItsLastCommand) {
  Climber climber(Stairs({0}));
  EXPECT_TRUE(climber.field().Drive({kNan, 0, 0}, climber.now()));
  climber.Lift(100);
  EXPECT_TRUE(climber.field().Lift({100, 100, kNan, 100}));
  climber.For(1);
  EXPECT_EQ(climber.robot().wheels_mm()[2], 100);
}

TEST(LiftBody, MovesItsWheelsWithTheirSpeedUpToTheirMost) {
  Climber climber(Stairs({0}));
  climber.Lift(1000);
  climber.For(0.5);
  EXPECT_NEAR(climber.robot().wheels_mm()[0], 220, 1e-6) << "0.5 s at 400 mm/s from 20 mm";
  EXPECT_NEAR(climber.robot().height_mm(), 220, 1e-6);
  climber.For(1);
  EXPECT_EQ(climber.robot().wheels_mm()[3], 420);
  climber.Lift(-50);
  climber.For(2);
  EXPECT_EQ(climber.robot().wheels_mm()[3], 0);
}

TEST(LiftBody, BumpsOnceIntoAPlatformThatItIsNotAboutToClimb) {
  Climber climber(Stairs({0, 200}));
  climber.Drive({0.5, 0, 0});
  climber.For(3);
  EXPECT_NEAR(climber.robot().position_m().x(), 0.3, 0.011) << "its hull is at the edge";
  EXPECT_EQ(climber.robot().bumps(), 1);
  EXPECT_FALSE(climber.robot().waits());
  EXPECT_THAT(climber.log(), Contains(HasSubstr("bumped into a platform of 200 mm at (0.")));
  climber.Drive({-0.5, 0, 0});
  climber.For(1);
  EXPECT_LT(climber.robot().position_m().x(), 0) << "nothing blocks the way back";
}

TEST(LiftBody, WaitsAtAPlatformThatItIsAboutToClimb) {
  FieldSpec field = Stairs({0, 400});
  field.robot.start_m.x() = 0.25;
  Climber climber(field);
  climber.Lift(410);
  climber.Drive({0.5, 0, 0});
  climber.For(0.5);
  EXPECT_NEAR(climber.robot().position_m().x(), 0.3, 0.011);
  EXPECT_TRUE(climber.robot().waits());
  climber.For(2);
  EXPECT_NEAR(climber.robot().position_m().x(), 0.34, 0.011) << "the legs are at the edge";
  EXPECT_TRUE(climber.robot().waits());
  EXPECT_EQ(climber.robot().bumps(), 0);
  EXPECT_FALSE(climber.robot().fallen());
}

TEST(LiftBody, SlidesAlongAnEdge) {
  Climber climber(Stairs({0, 200}));
  climber.Drive({0.5, 0.5, 0});
  climber.For(2.5);
  EXPECT_GT(climber.robot().position_m().y(), 0.9);
  EXPECT_GT(climber.robot().position_m().x(), 0.5) << "beside the platform it goes on";
}

TEST(LiftBody, ClimbsUpAndDownInEveryDirectionByItsSensorsAtEverySpeed) {
  int run = 0;
  for (std::size_t side = 0; side < 4; ++side) {
    for (const double step_mm : {200.0, 400.0}) {
      for (const double speed : {0.15, 0.4, 1.5}) {
        // In the gate every seventh: each direction, height and speed is among them.
        if (run++ % 7 != 0 && !testing::Nightly()) continue;
        SCOPED_TRACE("side " + std::to_string(side) + ", " + std::to_string(step_mm) + " mm, " +
                     std::to_string(speed) + " m/s");
        FieldSpec field = Stairs({0, step_mm, 0, 0, 0, 0});
        const Eigen::Vector2d way = ClimbSides()[side].way;
        field.robot.start_yaw_rad = -std::atan2(way.y(), way.x());
        Climber climber(field);
        const double high_mm = step_mm > 300 ? 410 : 205;
        ASSERT_TRUE(climber.Up(ClimbSides()[side], high_mm, speed))
            << climber.robot().position_m().x() << climber.robot().fall();
        EXPECT_NEAR(climber.robot().height_mm(), step_mm + 20, 40);
        ASSERT_TRUE(climber.Down(ClimbSides()[side], high_mm, speed))
            << climber.robot().position_m().x() << climber.robot().fall();
        climber.For(0.5);
        EXPECT_NEAR(climber.robot().height_mm(), 20, 1);
        EXPECT_GT(climber.robot().position_m().x(), 2.09);
        EXPECT_EQ(climber.robot().bumps(), 0);
        EXPECT_EQ(climber.robot().falls(), 0);
        ASSERT_GE(climber.field().events().size(), 2u);
        EXPECT_EQ(climber.field().events()[0].kind, FieldEvent::Kind::kUp);
        EXPECT_EQ(climber.field().events()[1].kind, FieldEvent::Kind::kDown);
      }
    }
  }
}

TEST(LiftBody, FallsOverAnEdgeWhenItsWheelsAreNotExtended) {
  Climber climber(Stairs({200, 0}));
  climber.Drive({0.5, 0, 0});
  climber.For(12);
  EXPECT_TRUE(climber.robot().fallen());
  EXPECT_EQ(climber.robot().falls(), 1);
  EXPECT_EQ(climber.robot().fall(), "the front wheels had nothing to stand on");
  EXPECT_THAT(climber.log(), Contains(HasSubstr("the robot fell: the front wheels had nothing")));
  const Eigen::Vector2d at = climber.robot().position_m();
  climber.For(1);
  EXPECT_EQ(climber.robot().position_m(), at) << "a fallen robot does not move";
  EXPECT_FALSE(climber.field().PutDown({1.2, 0}, 0, climber.now()));
  climber.For(1);
  EXPECT_GT(climber.robot().position_m().x(), 1.3);
  EXPECT_FALSE(climber.robot().fallen());
}

TEST(LiftBody, FallsWhenItsFrontWheelsAreRetractedWithNoPlatformBelow) {
  Climber climber(Stairs({0, 200}));
  climber.Lift(205);
  climber.For(1);
  EXPECT_FALSE(climber.field().Lift({5, 5, 205, 205}));
  climber.For(1);
  EXPECT_TRUE(climber.robot().fallen());
}

TEST(LiftBody, IsNotPutDownOnAnEdge) {
  Climber climber(Stairs({0, 200}));
  EXPECT_THAT(climber.field().PutDown({0.5, 0}, 0, climber.now()).value_or(""),
              HasSubstr("it would be on an edge"));
  EXPECT_TRUE(climber.field().PutDown({kNan, 0}, 0, climber.now()));
  EXPECT_FALSE(climber.field().PutDown({1.2, 0}, 1, climber.now()));
  EXPECT_EQ(climber.robot().height_mm(), 220);
}

TEST(LiftBody, MeasuresThePlatformsAheadAndBelowOfEverySide) {
  Climber climber(Stairs({200, 0, 400}));
  ASSERT_FALSE(climber.field().PutDown({0.2, 0}, 0, climber.now()));
  climber.Step();
  EXPECT_NEAR(climber.reading().distances_mm[0], 30, 1e-6) << "its own platform";
  EXPECT_NEAR(climber.reading().distances_mm[1], 1300, 15) << "the edge at 1.8 m, from 0.5 m";
  EXPECT_EQ(climber.reading().distances_mm[5], 2000) << "nothing behind it";
  ASSERT_FALSE(climber.field().PutDown({1.2, 0}, M_PI / 2, climber.now()));
  climber.Step();
  EXPECT_NEAR(climber.reading().distances_mm[3], 300, 15) << "the riser of 200 mm to its left";
  EXPECT_NEAR(climber.reading().distances_mm[7], 300, 15) << "the riser of 400 mm to its right";
  climber.Lift(205);
  climber.For(1);
  EXPECT_EQ(climber.reading().distances_mm[3], 2000) << "lifted over 200 mm";
  EXPECT_NEAR(climber.reading().distances_mm[7], 300, 15) << "but not over 400 mm";
  EXPECT_NEAR(climber.reading().distances_mm[0], 215, 1e-6);
  EXPECT_THAT(climber.reading().switches, ::testing::Each(false));
  climber.Lift(20);
  climber.For(1);
  EXPECT_THAT(climber.reading().switches, ::testing::Each(true));
}

TEST(LiftBody, MovesNothingWhileItsPartsAreStuck) {
  Climber climber(Stairs({0}));
  climber.faults() = {"suspension stuck", "base stuck"};
  climber.Lift(100);
  climber.Drive({1, 0, 0});
  climber.For(1);
  EXPECT_EQ(climber.robot().position_m().x(), 0);
  EXPECT_EQ(climber.robot().wheels_mm()[0], 20);
  climber.faults().clear();
  climber.For(1);
  EXPECT_GT(climber.robot().position_m().x(), 0.3);
  EXPECT_EQ(climber.robot().wheels_mm()[0], 100);
}

}  // namespace musher::world::lift_body_test
