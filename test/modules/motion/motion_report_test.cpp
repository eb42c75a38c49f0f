// What the motion manager reports by itself: faults of the body to the machine's manager, and a low
// battery to the people beside the robot.

#include <gmock/gmock.h>

#include "musher/test/modules/motion/harness.hpp"

namespace musher::motion::testing::motion_report_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Error kLowBattery = {3013, "the battery is low"};

TEST(MotionReport, AnnouncesALowBatteryWhenItRefusesACommandForIt) {
  Harness harness;
  harness.refused["back_flip"] = kLowBattery;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3013);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3013);
  EXPECT_THAT(harness.announced, ElementsAre("The battery is low. Charge me first."));
  harness.RunFor(std::chrono::seconds(31));
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3013);
  EXPECT_EQ(harness.announced.size(), 2U) << "half a minute later it is announced again";
  EXPECT_THAT(harness.reported, IsEmpty()) << "nothing is broken";
}

TEST(MotionReport, AnnouncesNothingWhenTheStateForbidsACommand) {
  Harness harness;
  harness.refused["back_flip"] = {3003, "not in LowPower"};
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3003);
  EXPECT_THAT(harness.announced, IsEmpty());
}

TEST(MotionReport, ReportsAHotAndAnOverloadedMotorOnce) {
  Harness harness;
  harness.board.report.motor_error[3] = 1;
  harness.RunFor(std::chrono::seconds(1));
  harness.board.report.motor_error[5] = 2;
  harness.RunFor(std::chrono::seconds(1));
  harness.board.report.motor_error[6] = 4;
  harness.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(harness.reported, ElementsAre(3033, 3034, 3055));
  EXPECT_THAT(harness.log,
              Contains(HasSubstr("motor 3 (front left hip abduction): too hot (3033)")));
}

TEST(MotionReport, NamesTheLegOfAFootThatIsInTheWrongPlace) {
  Harness harness;
  harness.board.report.footpos_error = 1 << 11 | 1 << 0 | 1 << 1;
  harness.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(harness.reported, ElementsAre(3051));
  EXPECT_THAT(harness.log,
              Contains(HasSubstr("feet in the wrong place: rear left (up or down); front right "
                                 "(left or right, fore or aft) (3051)")));
}

TEST(MotionReport, NamesTheFeetOnTheGround) {
  EXPECT_EQ(FeetText(15), "front right, front left, rear right, rear left");
  EXPECT_EQ(FeetText(0b1110), "front left, rear right, rear left") << "front right is raised";
  EXPECT_EQ(FeetText(0), "no foot");
}

TEST(MotionReport, ReportsAnEmergencyStopAs3088OnceInThreeMinutes) {
  Harness harness;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), kCodeOk);
    EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kRecoveryStand)), kCodeOk);
  }
  EXPECT_THAT(harness.reported, ElementsAre(3088));
  harness.RunFor(kLogPause);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), kCodeOk);
  EXPECT_THAT(harness.reported, ElementsAre(3088, 3088));
}

TEST(MotionReport, ReportsNoErrorForAnInvalidCommand) {
  Harness harness;
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(4711)), 3008);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(kEmergencyStop)), kCodeOk);
  EXPECT_EQ(harness.CodeOf(harness.RequestMotion(121)), 3040);
  EXPECT_THAT(harness.reported, ElementsAre(3088));
}

}  // namespace musher::motion::testing::motion_report_test
