// The humanoid's motion adapter: poses, gaze, and that nothing ever jumps.

#include "musher/modules/world/body/humanoid.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>

#include "musher/modules/world/scene_file/scene_humanoid.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world::humanoid_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Optional;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kTiny = 1e-9;  // rounding
constexpr std::size_t kRightShoulder = 18;
constexpr std::size_t kRightElbow = 21;

HumanoidSpec Spec() {
  HumanoidSpec spec;
  PosesReading reading = ReadPosesFile(SourceDir() + "/config/motion/humanoid_poses.toml");
  EXPECT_TRUE(reading.poses);
  spec.poses = reading.poses.value();
  return spec;
}

void Pass(Humanoid& humanoid, Duration time) {
  for (Duration done{}; done < time; done += kStep) humanoid.Step(kStep);
}

double Degrees(double rad) {
  return rad * 180 / M_PI;
}

TEST(Humanoid, HasThePosesOfTheShowAndOfItsSecondGeneration) {
  Humanoid humanoid(Spec());
  EXPECT_EQ(humanoid.pose(), "neutral");
  for (const char* name :
       {"heart", "v_sign", "thumbs_up", "wave", "wave_start", "mic_hold", "interview_mic_hold",
        "welcome", "heart_chest", "heart_head", "akimbo", "neutral"}) {
    EXPECT_EQ(humanoid.SetPose(name), std::nullopt) << name;
    EXPECT_EQ(humanoid.pose(), name);
  }
}

TEST(Humanoid, RefusesAnUnknownPoseAndKeepsItsOwn) {
  Humanoid humanoid(Spec());
  ASSERT_EQ(humanoid.SetPose("heart"), std::nullopt);
  EXPECT_THAT(humanoid.SetPose("salto"),
              Optional(AllOf(HasSubstr("\"salto\" is refused"), HasSubstr("thumbs_up"))));
  EXPECT_EQ(humanoid.pose(), "heart");
  EXPECT_EQ(humanoid.SetPose("salto"), std::nullopt) << "logged already";
  EXPECT_THAT(humanoid.SetPose(std::string(10'000, 'x')), Optional(HasSubstr("xxx...")));
}

TEST(Humanoid, DoesNotFillTheLogWithUnknownPoses) {
  Humanoid humanoid(Spec());
  int logged = 0;
  for (int i = 0; i < 1000; ++i) {
    logged += humanoid.SetPose(i % 2 == 0 ? "salto" : "dive") ? 1 : 0;
    ASSERT_EQ(humanoid.SetPose("heart"), std::nullopt);
  }
  EXPECT_EQ(logged, 2) << "each once";
  std::string last;
  for (int i = 0; i < 1000; ++i) {
    const auto reason = humanoid.SetPose("pose" + std::to_string(i));
    logged += reason ? 1 : 0;
    if (reason) last = *reason;
  }
  EXPECT_EQ(logged, 16);
  EXPECT_THAT(last, HasSubstr("further ones are not logged"));
}

TEST(Humanoid, ComesToRestInItsPose) {
  const HumanoidSpec spec = Spec();
  Humanoid humanoid(spec);
  ASSERT_EQ(humanoid.SetPose("v_sign"), std::nullopt);
  Pass(humanoid, Seconds(15));
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Axis& joint = humanoid.joints()[i];
    const auto& pose = *std::find_if(spec.poses.begin(), spec.poses.end(),
                                     [](const PoseSpec& p) { return p.names[0] == "v_sign"; });
    EXPECT_NEAR(joint.position_rad, pose.angles[i], kTiny) << JointTable()[i].name;
    EXPECT_NEAR(joint.speed_rad_s, 0, kTiny);
  }
}

TEST(Humanoid, RaisesAnArmAtItsSpeedWhichTakesAsLongAsATrapezoidDoes) {
  Humanoid humanoid(Spec());
  ASSERT_EQ(humanoid.SetPose("wave"), std::nullopt);
  // 71 degrees at 0.3 rad/s, and 0.3 / 0.5 s to take the speed up and to lose it.
  const double way = 71 * M_PI / 180;
  const double time_s = way / 0.3 + 0.3 / 0.5;
  Pass(humanoid, Seconds(time_s - 0.1));
  EXPECT_GT(humanoid.joints()[kRightShoulder].position_rad, -way + 0.001);
  Pass(humanoid, Seconds(0.2));
  EXPECT_NEAR(humanoid.joints()[kRightShoulder].position_rad, -way, 1e-3);
}

TEST(Humanoid, WavesToAndFroAsLongAsThePoseIsHeld) {
  HumanoidSpec spec = Spec();
  spec.limits[static_cast<std::size_t>(JointGroup::kArm)] = {2, 8};
  Humanoid humanoid(spec);
  ASSERT_EQ(humanoid.SetPose("wave"), std::nullopt);
  Pass(humanoid, Seconds(10));
  double least = 0, most = -180;
  for (int i = 0; i < 140; ++i) {  // two periods
    humanoid.Step(kStep);
    const double angle = Degrees(humanoid.joints()[kRightElbow].position_rad);
    least = std::min(least, angle);
    most = std::max(most, angle);
  }
  EXPECT_NEAR(least, -127, 0.5);
  EXPECT_NEAR(most, -91, 0.5);
  ASSERT_EQ(humanoid.SetPose("neutral"), std::nullopt);
  Pass(humanoid, Seconds(10));
  EXPECT_NEAR(humanoid.joints()[kRightElbow].speed_rad_s, 0, kTiny);
}

TEST(Humanoid, TurnsWaistAndHeadToWhereItLooksAndNods) {
  Humanoid humanoid(Spec());
  ASSERT_EQ(humanoid.LookAt({0, 0}), std::nullopt);  // to the left, up
  Pass(humanoid, Seconds(10));
  EXPECT_NEAR(Degrees(humanoid.joints()[kHeadYaw].position_rad), 70, 1e-6);
  EXPECT_NEAR(Degrees(humanoid.joints()[kWaistYaw].position_rad), 50, 1e-6);
  EXPECT_NEAR(Degrees(humanoid.gaze().yaw_rad), 120, 1e-6);
  EXPECT_NEAR(Degrees(humanoid.gaze().pitch_rad), -20, 1e-6);
  ASSERT_EQ(humanoid.LookAt({0.625, 0.75}), std::nullopt);
  Pass(humanoid, Seconds(20));
  EXPECT_NEAR(Degrees(humanoid.gaze().yaw_rad), -30, 1e-6);
  EXPECT_NEAR(Degrees(humanoid.gaze().pitch_rad), 10, 1e-6);
}

TEST(Humanoid, RefusesANanGazeAndLogsItOnce) {
  Humanoid humanoid(Spec());
  ASSERT_EQ(humanoid.LookAt({0.25, 0.5}), std::nullopt);
  EXPECT_THAT(humanoid.LookAt({kNan, 0.5}), Optional(HasSubstr("refused")));
  EXPECT_EQ(humanoid.LookAt({0.5, -std::numeric_limits<double>::infinity()}), std::nullopt);
  Pass(humanoid, Seconds(10));
  EXPECT_NEAR(Degrees(humanoid.gaze().yaw_rad), 60, 1e-6);
}

TEST(Humanoid, ClampsAGazeOutsideItsRangeAndLogsItOnce) {
  Humanoid humanoid(Spec());
  EXPECT_THAT(humanoid.LookAt({1.5, 0.5}), Optional(HasSubstr("brought within")));
  EXPECT_EQ(humanoid.LookAt({-7, 0.5}), std::nullopt);
  EXPECT_EQ(humanoid.LookAt({1.5, 0.5}), std::nullopt);
  Pass(humanoid, Seconds(10));
  EXPECT_NEAR(Degrees(humanoid.gaze().yaw_rad), -120, 1e-6);
}

TEST(Humanoid, CommandsItsJointsAStepBeforeTheyMove) {
  Humanoid humanoid(Spec());
  ASSERT_EQ(humanoid.SetPose("heart"), std::nullopt);
  for (int i = 0; i < 100; ++i) {
    const auto logged = humanoid.commands();
    humanoid.Step(kStep);
    EXPECT_EQ(humanoid.joints(), logged);
  }
}

TEST(Trapezoid, StopsAtItsGoalWithoutGoingPastIt) {
  const MotionLimits limits{0.5, 1.0};
  for (const double goal : {0.0001, 0.003, 0.02, 0.1, 0.37, 2.0}) {
    Axis axis;
    for (int i = 0; i < 500; ++i) {
      axis = Approach(axis, goal, limits, 0.02);
      ASSERT_LE(axis.position_rad, goal + kTiny);
    }
    EXPECT_NEAR(axis.position_rad, goal, kTiny);
    EXPECT_NEAR(axis.speed_rad_s, 0, kTiny);
  }
}

// Poses and looks at random, also wrong ones, each for a random while.
RC_GTEST_PROP(HumanoidProperty, NeverMovesFasterOrMoreAbruptlyThanItsLimits, ()) {
  const HumanoidSpec spec = Spec();
  Humanoid humanoid(spec);
  const auto commands = *rc::gen::container<std::vector<std::tuple<int, int, int, int>>>(
      40, rc::gen::tuple(rc::gen::inRange(0, 14), rc::gen::inRange(-20, 120),
                         rc::gen::inRange(-20, 120), rc::gen::inRange(1, 150)));
  const double dt = 0.02;
  Gaze gaze = humanoid.gaze();
  double pitch_speed = 0;
  for (const auto& [pose, x, y, steps] : commands) {
    const std::size_t index = static_cast<std::size_t>(pose);
    humanoid.SetPose(index < spec.poses.size() ? spec.poses[index].names[0] : "nonsense");
    humanoid.LookAt({pose == 13 ? kNan : x / 100.0, y / 100.0});
    for (int step = 0; step < steps; ++step) {
      const auto before = humanoid.joints();
      humanoid.Step(kStep);
      for (std::size_t i = 0; i < kJoints; ++i) {
        const Joint& joint = JointTable()[i];
        const MotionLimits& limits = spec.limits[static_cast<std::size_t>(joint.group)];
        const Axis& now = humanoid.joints()[i];
        const double speed = (now.position_rad - before[i].position_rad) / dt;
        RC_ASSERT(std::abs(speed - now.speed_rad_s) < 1e-9);
        RC_ASSERT(std::abs(speed) <= limits.speed_rad_s + kTiny);
        RC_ASSERT(std::abs(speed - before[i].speed_rad_s) <=
                  limits.acceleration_rad_s2 * dt + kTiny);
        RC_ASSERT(now.position_rad >= joint.least_rad - kTiny);
        RC_ASSERT(now.position_rad <= joint.most_rad + kTiny);
      }
      const MotionLimits& head = spec.limits[static_cast<std::size_t>(JointGroup::kHead)];
      const double speed = (humanoid.gaze().pitch_rad - gaze.pitch_rad) / dt;
      RC_ASSERT(std::abs(speed) <= head.speed_rad_s + kTiny);
      RC_ASSERT(std::abs(speed - pitch_speed) <= head.acceleration_rad_s2 * dt + 1e-9);
      gaze = humanoid.gaze();
      pitch_speed = speed;
    }
  }
}

}  // namespace musher::world::humanoid_test
