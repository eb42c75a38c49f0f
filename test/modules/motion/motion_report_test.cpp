// What the motion manager reports by itself: faults of the body to the machine's manager, and a low
// battery to the people beside the robot.

#include <gmock/gmock.h>

#include "musher/test/modules/motion/stage.hpp"

namespace musher::motion::testing::motion_report_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Error kLowBattery = {3013, "the battery is low"};

TEST(MotionReport, SaysThatTheBatteryIsLowWhenACommandIsRefusedForIt) {
  Stage stage;
  stage.refused["back_flip"] = kLowBattery;
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3013);
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3013);
  EXPECT_THAT(stage.said, ElementsAre("The battery is low. Charge me first."));
  stage.RunFor(std::chrono::seconds(31));
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3013);
  EXPECT_EQ(stage.said.size(), 2U) << "half a minute later it is said again";
  EXPECT_THAT(stage.reported, IsEmpty()) << "nothing is broken";
}

TEST(MotionReport, SaysNothingWhenTheStateForbidsACommand) {
  Stage stage;
  stage.refused["back_flip"] = {3003, "not in LowPower"};
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3003);
  EXPECT_THAT(stage.said, IsEmpty());
}

TEST(MotionReport, ReportsAHotAndAnOverloadedMotorOnce) {
  Stage stage;
  stage.board.report.motor_error[3] = 1;
  stage.RunFor(std::chrono::seconds(1));
  stage.board.report.motor_error[5] = 2;
  stage.RunFor(std::chrono::seconds(1));
  stage.board.report.motor_error[6] = 4;
  stage.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(stage.reported, ElementsAre(3033, 3034, 3055));
  EXPECT_THAT(stage.log, Contains(HasSubstr("motor 3: a motor reports that it is too hot (3033)")));
}

TEST(MotionReport, ReportsAnEmergencyStopAs3088OnceInThreeMinutes) {
  Stage stage;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop)), kCodeOk);
    EXPECT_EQ(stage.CodeOf(stage.Ask(kRecoveryStand)), kCodeOk);
  }
  EXPECT_THAT(stage.reported, ElementsAre(3088));
  stage.RunFor(kLogPause);
  EXPECT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop)), kCodeOk);
  EXPECT_THAT(stage.reported, ElementsAre(3088, 3088));
}

TEST(MotionReport, ReportsNoCommandThatIsOnlyWrong) {
  Stage stage;
  EXPECT_EQ(stage.CodeOf(stage.Ask(4711)), 3008);
  EXPECT_EQ(stage.CodeOf(stage.Ask(kEmergencyStop)), kCodeOk);
  EXPECT_EQ(stage.CodeOf(stage.Ask(121)), 3040);
  EXPECT_THAT(stage.reported, ElementsAre(3088));
}

}  // namespace musher::motion::testing::motion_report_test
