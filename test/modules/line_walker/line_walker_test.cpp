// The states and ends of the walker, its status, and its waits.

#include "musher/modules/line_walker/line_walker.hpp"

#include <gmock/gmock.h>

#include "musher/messages/stamp.hpp"
#include "musher/test/modules/line_walker/s_lane.hpp"

namespace musher::line_walker::line_walker_test {

using State = LineWalker::State;
using ::testing::EndsWith;
using ::testing::HasSubstr;

constexpr Time kStart{std::chrono::seconds(50)};

Time After(std::int64_t ms) {
  return kStart + Milliseconds(ms);
}

msg::Odometry OdometryAt(Time at, double x_m = 0) {
  msg::Odometry odometry;
  odometry.header.stamp = msg::ToStamp(at.time_since_epoch());
  odometry.pose.pose.position.x = x_m;
  return odometry;
}

TEST(LineWalker, DoesNothingBeforeStart) {
  LineWalker walker{WalkRules()};
  EXPECT_FALSE(walker.Tick(kStart));
  EXPECT_EQ(walker.StatusText(kStart), "State:IDLE,Active:False,ImagesReady:False,Runtime:0.0s");
  walker.Stop(kStart);
  EXPECT_FALSE(walker.Tick(kStart));
}

TEST(LineWalker, StandsWithoutAFrameUntilItSeesALineAndEndsWithoutOne) {
  LineWalker walker{WalkRules()};
  EXPECT_TRUE(walker.Start(kStart));
  EXPECT_FALSE(walker.Start(After(10))) << "it walks already";
  EXPECT_EQ(walker.state(), State::kAdjusting);
  for (int ms = 0; ms < 4900; ms += 50) {
    walker.OnOdometry(OdometryAt(After(ms)), After(ms));
    walker.OnLines(View::kLeft, {}, After(ms));
    EXPECT_FALSE(walker.Tick(After(ms)));
  }
  EXPECT_EQ(walker.StatusText(After(4900)),
            "State:ADJUSTING,Active:True,ImagesReady:True,Runtime:4.9s");
  EXPECT_FALSE(walker.Tick(After(5000))) << "no frame was sent, so none ends it";
  EXPECT_EQ(walker.end(), End::kLost);
  EXPECT_EQ(walker.StatusText(After(5100)),
            "State:IDLE,Active:False,ImagesReady:True,Runtime:5.0s,End:lost");
}

TEST(LineWalker, EndsSilentWithoutPicturesOrOdometry) {
  LineWalker walker{WalkRules()};
  EXPECT_TRUE(walker.Start(kStart));
  EXPECT_FALSE(walker.Tick(After(5000)));
  EXPECT_EQ(walker.end(), End::kSilent);
  EXPECT_THAT(walker.reason(), HasSubstr("no odometry"));
  EXPECT_TRUE(walker.Start(After(6000)));
  EXPECT_FALSE(walker.end());
  walker.OnOdometry(OdometryAt(After(10900)), After(10900));
  EXPECT_FALSE(walker.Tick(After(11000)));
  EXPECT_EQ(walker.end(), End::kSilent);
  EXPECT_THAT(walker.reason(), HasSubstr("no pictures"));
}

TEST(LineWalker, EndsSilentByOdometryThatIsOld) {
  LineWalker walker{WalkRules()};
  EXPECT_TRUE(walker.Start(kStart));
  for (int ms = 0; ms <= 5000; ms += 50) {
    walker.OnOdometry(OdometryAt(After(ms - 3000)), After(ms), Milliseconds(3000));
    walker.OnLines(View::kLeft, {}, After(ms));
    EXPECT_FALSE(walker.Tick(After(ms)));
  }
  EXPECT_EQ(walker.end(), End::kSilent);
  EXPECT_EQ(walker.reason(), "the odometry is 3.0 s old");
}

TEST(LineWalker, EndsSilentInTheMiddleOfAWalkWithOneEndFrame) {
  SLaneRun run(1, 0, 0);
  run.RunFor(Milliseconds(3000));
  EXPECT_EQ(run.walker.state(), State::kWalking);
  EXPECT_THAT(run.walker.StatusText(run.now()),
              ::testing::StartsWith("State:WALKING,Active:True,ImagesReady:True,Runtime:3.0s"));
  const Time later = run.now() + Milliseconds(1500);
  const auto last = run.walker.Tick(later);
  EXPECT_EQ(run.walker.end(), End::kSilent);
  ASSERT_TRUE(last);
  EXPECT_TRUE(last->end);
  EXPECT_EQ(last->velocity, Velocity());
  EXPECT_FALSE(run.walker.Tick(later));
}

TEST(LineWalker, EndsWhenMotionRefusesForLongAndNotByASingleRefusal) {
  SLaneRun run(1, 0, 0);
  run.RunFor(Milliseconds(2000));
  msg::MotionServoResponse refused;
  refused.code = 3001;
  run.walker.OnResponse(refused, run.now());
  run.RunFor(Milliseconds(100));
  run.walker.OnResponse({}, run.now());
  run.RunFor(Milliseconds(1000));
  EXPECT_FALSE(run.walker.end());
  run.walker.OnResponse(refused, run.now());
  run.RunFor(Milliseconds(600));
  EXPECT_EQ(run.walker.end(), End::kRefused);
  EXPECT_THAT(run.walker.reason(), HasSubstr("3001"));
  EXPECT_THAT(run.walker.StatusText(run.now()), EndsWith(",End:refused"));
}

// Its first frames came just after the motion manager could not run, which takes none for 2 s then.
TEST(LineWalker, WaitsWhereMotionRefusesWhatMayBeLate) {
  SLaneRun run(1, 0, 0);
  run.RunFor(Milliseconds(2000));
  msg::MotionServoResponse refused;
  refused.code = 3007;
  run.walker.OnResponse(refused, run.now());
  run.RunFor(Milliseconds(1900));
  EXPECT_FALSE(run.walker.end());
  run.RunFor(Milliseconds(700));
  EXPECT_EQ(run.walker.end(), End::kRefused) << "it does not wait for ever";
}

TEST(LineWalker, IsAdjustingWhereItIsBesideTheMiddle) {
  SLaneRun run(1, 0.12, 0);
  run.RunFor(Milliseconds(600));
  EXPECT_EQ(run.walker.state(), State::kAdjusting);
  run.RunFor(Milliseconds(2500));
  EXPECT_EQ(run.walker.state(), State::kWalking);
}

TEST(LineWalker, StandsAfterAJumpOfTheOdometryUntilItSeesALine) {
  SLaneRun run(1, 0, 0);
  run.RunFor(Milliseconds(2000));
  run.walker.OnOdometry(OdometryAt(run.now() + Milliseconds(20), 70), run.now());
  const auto frame = run.walker.Tick(run.now());
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->velocity, Velocity());
  EXPECT_FALSE(frame->end);
}

// Only half a metre between two samples was noticed, and no turn.
TEST(LineWalker, StandsAfterAJumpThatNoBodyMakes) {
  for (const Velocity& jump : {Velocity{0.3, 0, 0}, Velocity{0, 0, 1}, Velocity{0, -0.3, 0}}) {
    SLaneRun run(1, 0, 0);
    run.RunFor(Milliseconds(2000));
    const Pose pose = Moved(run.odometry(), jump, 1);
    msg::Odometry odometry = OdometryAt(run.now() + Milliseconds(20), pose.x_m);
    odometry.pose.pose.position.y = pose.y_m;
    odometry.pose.pose.orientation.z = std::sin(pose.yaw_rad / 2);
    odometry.pose.pose.orientation.w = std::cos(pose.yaw_rad / 2);
    run.walker.OnOdometry(odometry, run.now());
    const auto frame = run.walker.Tick(run.now());
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->velocity, Velocity());
  }
}

TEST(LineWalker, IgnoresOdometryThatIsNoPose) {
  LineWalker walker{WalkRules()};
  msg::Odometry broken = OdometryAt(kStart);
  broken.pose.pose.orientation = {0, 0, 0, 0};
  walker.OnOdometry(broken, kStart);
  broken = OdometryAt(kStart, std::numeric_limits<double>::quiet_NaN());
  walker.OnOdometry(broken, kStart);
  EXPECT_TRUE(walker.Start(kStart));
  walker.OnLines(View::kLeft, {}, kStart);
  EXPECT_FALSE(walker.in_lane());
}

TEST(LineWalker, WalksAgainAfterAnEnd) {
  SLaneRun run(1, 0, 0);
  run.RunFor(Milliseconds(2000));
  run.walker.Stop(run.now());
  run.RunFor(Milliseconds(500));
  EXPECT_TRUE(run.walker.Start(run.now()));
  EXPECT_FALSE(run.walker.end());
  run.RunFor(Milliseconds(1000));
  EXPECT_FALSE(run.frames.back().end);
  EXPECT_GT(run.frames.back().velocity.forward_m_s, 0.25);
}

}  // namespace musher::line_walker::line_walker_test
