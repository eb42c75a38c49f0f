// The conditions of nav2 on the robot itself, in virtual time.

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::robot_state_test {

using testing::HasSubstr;

using AnIsStopped = Nav2Tree;
TEST_F(AnIsStopped, RunsUntilTheRobotHasStoodForLongEnough) {
  Make("<IsStopped/>");
  robot.moves = Motion{.speed_m_s = 0.3};
  EXPECT_EQ(TickAt(0), "F ");
  robot.moves = Motion{};
  EXPECT_EQ(TickAt(100), "R ");
  EXPECT_EQ(TickAt(1090), "R ");
  EXPECT_EQ(TickAt(1100), "S ");
  robot.moves = Motion{.speed_m_s = 0.01};
  EXPECT_EQ(TickAt(1200), "F ") << "it has to be below the threshold";
}
TEST_F(AnIsStopped, CountsATurnOnTheSpotAsMotionAndAnUnknownMotionToo) {
  Make("<IsStopped velocity_threshold=\"0.1\" duration_stopped=\"0\"/>");
  EXPECT_EQ(Next(), "S ");
  robot.moves = Motion{.turn_rad_s = -0.2};
  EXPECT_EQ(Next(), "F ");
  robot.moves.reset();
  EXPECT_EQ(Next(), "F ");
}
TEST_F(AnIsStopped, CountsOnlyTheTimeSinceItBegan) {
  Make("<Sequence>" + SayXml("a", "RS") + "<IsStopped duration_stopped=\"100\"/></Sequence>");
  EXPECT_EQ(TickAt(0), "R a^ ");
  EXPECT_EQ(TickAt(500), "R a ");
  EXPECT_EQ(TickAt(590), "R ");
  EXPECT_EQ(TickAt(600), "S ");
}
TEST_F(AnIsStopped, BeginsAgainWhereTheRobotHasMovedInBetween) {
  Make("<CheckStopStatus duration_stopped=\"100\"/>");
  EXPECT_EQ(TickAt(0), "R ");
  robot.moves = Motion{.speed_m_s = 1};
  EXPECT_EQ(TickAt(50), "F ");
  robot.moves = Motion{};
  EXPECT_EQ(TickAt(100), "R ");
  EXPECT_EQ(TickAt(190), "R ");
  EXPECT_EQ(TickAt(200), "S ");
}
TEST_F(AnIsStopped, RefusesAThresholdThatIsNone) {
  Make("<IsStopped velocity_threshold=\"nan\"/>");
  EXPECT_EQ(Next(), "! ");
  EXPECT_THAT(fault, HasSubstr("'velocity_threshold' has to be a number from 0"));
}

using AnIsStuck = Nav2Tree;
TEST_F(AnIsStuck, IsOneThatIsDrivenAndStaysInItsPlaceForThreeSeconds) {
  Make("<ReactiveFallback><IsStuck/>" + SayXml("a", "R") + "</ReactiveFallback>");
  const auto tick_until = [this](std::int64_t from_ms, std::int64_t to_ms) {
    std::string letters;
    for (std::int64_t ms = from_ms; ms < to_ms; ms += 100) letters += TickAt(ms).substr(0, 1);
    return letters;
  };
  EXPECT_EQ(tick_until(0, 5000), std::string(50, 'R')) << "nothing drives it";
  robot.is_driven = true;
  EXPECT_EQ(tick_until(5000, 8000), std::string(30, 'R'));
  robot.at = Pose{.x_m = 0.11};
  EXPECT_EQ(tick_until(8000, 11000), std::string(30, 'R')) << "it has moved";
  robot.at = Pose{.x_m = 0.11, .yaw_rad = 0.3};
  EXPECT_EQ(tick_until(11000, 14000), std::string(30, 'R')) << "it has turned";
  EXPECT_EQ(TickAt(14000), "S a! ");
}
TEST_F(AnIsStuck, IsNoneWithoutAPoseAndBeginsAgainAfterwards) {
  Make("<ReactiveFallback><IsStuck/>" + SayXml("a", "R") + "</ReactiveFallback>");
  robot.is_driven = true;
  EXPECT_EQ(TickAt(0), "R a^ ");
  robot.at.reset();
  EXPECT_EQ(TickAt(3000), "R a ");
  robot.at = Pose{};
  EXPECT_EQ(TickAt(4000), "R a ");
  EXPECT_EQ(TickAt(6990), "R a ");
  EXPECT_EQ(TickAt(7000), "S a! ");
}

using ABattery = Nav2Tree;
TEST_F(ABattery, IsLowAtItsLimitAndBelow) {
  Make("<IsBatteryLow min_battery=\"0.2\"/>");
  EXPECT_EQ(Next(), "F ") << "nothing is known";
  robot.batteries[""] = {.share = 0.21, .voltage_v = 0.1};
  EXPECT_EQ(Next(), "F ");
  robot.batteries[""].share = 0.2;
  EXPECT_EQ(Next(), "S ");
  robot.batteries[""].share.reset();
  EXPECT_EQ(Next(), "F ");
}
TEST_F(ABattery, IsLowByItsVoltageWhereThatCounts) {
  Make("<IsBatteryLow min_battery=\"22.2\" is_voltage=\"true\" battery_topic=\"/pack\"/>");
  robot.batteries[""] = {.share = 0.0, .voltage_v = 20};
  EXPECT_EQ(Next(), "F ") << "another battery";
  robot.batteries["/pack"] = {.share = 0.5, .voltage_v = 22};
  EXPECT_EQ(Next(), "S ");
  robot.batteries["/pack"].voltage_v.reset();
  EXPECT_EQ(Next(), "F ");
}
TEST_F(ABattery, ChargesWhereItSaysSo) {
  Make("<IsBatteryCharging/>");
  EXPECT_EQ(Next(), "F ");
  robot.batteries[""] = {.share = 0.5};
  EXPECT_EQ(Next(), "F ");
  robot.batteries[""].charges = true;
  EXPECT_EQ(Next(), "S ");
}
TEST_F(ABattery, RefusesALimitThatIsNone) {
  Make("<IsBatteryLow min_battery=\"nan\"/>");
  EXPECT_EQ(Next(), "! ");
  EXPECT_THAT(Findings(Main("<IsBatteryLow/>"), factory), HasSubstr("min_battery"));
}

using ATransform = Nav2Tree;
TEST_F(ATransform, IsAvailableForEverOnceItWas) {
  Make("<TransformAvailable child=\"base_link\" parent=\"map\"/>");
  EXPECT_EQ(Next(), "F ");
  robot.frames["base_link"] = "odom";
  EXPECT_EQ(Next(), "F ");
  robot.frames["base_link"] = "map";
  EXPECT_EQ(Next(), "S ");
  robot.frames.clear();
  EXPECT_EQ(Next(), "S ");
}

}  // namespace musher::tree::nav2::robot_state_test
