// The positions of a humanoid's limbs by its joints, and the shapes of its poses.

#include "musher/modules/world/body/humanoid_kinematics.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/body/humanoid.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::world::humanoid_kinematics_test {

using Eigen::Vector3d;

constexpr double kTiny = 1e-9;  // rounding
constexpr std::size_t kLeft = 0, kRight = 1;
constexpr std::size_t kKneeLeft = 3, kShoulderPitchLeft = 13, kShoulderRollLeft = 14,
                      kShoulderYawLeft = 15, kElbowPitchLeft = 16;
const Vector3d kHead(0, 0, 0.6);
const Vector3d kShoulderLeft(0, 0.21, 0.4);

const Scene& Wedding() {
  static const Scene scene =
      ReadSceneFile(SourceDir() + "/config/scenes/wedding.toml").scene.value();
  return scene;
}

const PoseSpec& Pose(const std::string& name) {
  const auto& poses = Wedding().humanoid->poses;
  const auto has_name = [&](const PoseSpec& pose) {
    return std::find(pose.names.begin(), pose.names.end(), name) != pose.names.end();
  };
  return *std::find_if(poses.begin(), poses.end(), has_name);
}

Skeleton In(const std::string& pose) {
  return SkeletonOf(Pose(pose).angles);
}

Vector3d Mirrored(const Vector3d& point) {
  return {point.x(), -point.y(), point.z()};
}

// Each joint at random within its limits.
Angles AnyAngles() {
  Angles angles;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Joint& joint = JointTable()[i];
    const double share = *rc::gen::inRange(0, 10'001) / 10'000.0;
    angles[i] = joint.least_rad + share * (joint.most_rad - joint.least_rad);
  }
  return angles;
}

MATCHER_P(IsNear, point, "") {
  return (arg - Vector3d(point)).norm() < 1e-9;
}

TEST(HumanoidKinematics, HasArmsAndLegsHangDownAtZero) {
  const Skeleton skeleton = SkeletonOf({});
  EXPECT_THAT(skeleton.arms[kLeft].elbow_m, IsNear(kShoulderLeft - Vector3d(0, 0, 0.27)));
  EXPECT_THAT(skeleton.arms[kLeft].hand_m, IsNear(kShoulderLeft - Vector3d(0, 0, 0.57)));
  EXPECT_THAT(skeleton.legs[kLeft].ankle_m, IsNear(Vector3d(0, 0.09, kAnkleM - kTrunkM)));
  EXPECT_THAT(skeleton.head.translation(), IsNear(kHead));
}

TEST(HumanoidKinematics, LiftsTurnsAndBendsTheWayThatTheJointsSay) {
  const auto left_hand = [](std::initializer_list<std::pair<std::size_t, double>> joints) {
    Angles angles{};
    for (const auto& [joint, degrees] : joints) angles[joint] = degrees * M_PI / 180;
    return Vector3d(SkeletonOf(angles).arms[kLeft].hand_m - kShoulderLeft);
  };
  EXPECT_THAT(left_hand({{kShoulderPitchLeft, -90}}), IsNear(Vector3d(0.57, 0, 0)));
  EXPECT_THAT(left_hand({{kShoulderRollLeft, 90}}), IsNear(Vector3d(0, 0.57, 0)));
  EXPECT_THAT(left_hand({{kElbowPitchLeft, -90}}), IsNear(Vector3d(0.3, 0, -0.27)));
  EXPECT_THAT(left_hand({{kElbowPitchLeft, -90}, {kShoulderYawLeft, -90}}),
              IsNear(Vector3d(0, -0.3, -0.27)));
  Angles knee{};
  knee[kKneeLeft] = M_PI / 2;
  EXPECT_THAT(SkeletonOf(knee).legs[kLeft].ankle_m,
              IsNear(SkeletonOf({}).legs[kLeft].knee_m + Vector3d(-kShankM, 0, 0)));
}

TEST(HumanoidKinematics, TurnsTheArmsWithTheWaistAndTheHeadWithBoth) {
  Angles angles{};
  angles[kWaistYaw] = M_PI / 2;
  angles[kHeadYaw] = M_PI / 6;
  const Skeleton skeleton = SkeletonOf(angles);
  EXPECT_THAT(skeleton.arms[kLeft].shoulder_m, IsNear(Vector3d(-0.21, 0, 0.4)));
  EXPECT_THAT(skeleton.head.linear() * Vector3d::UnitX(),
              IsNear(Vector3d(std::cos(2 * M_PI / 3), std::sin(2 * M_PI / 3), 0)));
  EXPECT_THAT(skeleton.legs[kLeft].ankle_m, IsNear(SkeletonOf({}).legs[kLeft].ankle_m));
}

RC_GTEST_PROP(HumanoidKinematicsProperty, NeverChangesTheLengthOfALink, ()) {
  const Skeleton skeleton = SkeletonOf(AnyAngles());
  for (const Arm& arm : skeleton.arms) {
    RC_ASSERT(std::abs((arm.elbow_m - arm.shoulder_m).norm() - kUpperArmM) < kTiny);
    RC_ASSERT(std::abs((arm.hand_m - arm.elbow_m).norm() - kForearmM) < kTiny);
  }
  for (const Leg& leg : skeleton.legs) {
    RC_ASSERT(std::abs((leg.knee_m - leg.hip_m).norm() - kThighM) < kTiny);
    RC_ASSERT(std::abs((leg.ankle_m - leg.knee_m).norm() - kShankM) < kTiny);
  }
}

// A side's rolls and yaws have mirrored signs on the other side.
RC_GTEST_PROP(HumanoidKinematicsProperty, MirrorsWhatIsMirrored, ()) {
  const Angles angles = AnyAngles();
  Angles mirrored = angles;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::string name(JointTable()[i].name.substr(4));
    const auto ends = [&](const char* end) { return name.ends_with(end); };
    const std::string other = ends("_l")   ? name.substr(0, name.size() - 2) + "_r"
                              : ends("_r") ? name.substr(0, name.size() - 2) + "_l"
                                           : name;
    for (std::size_t k = 0; k < kJoints; ++k) {
      if (JointTable()[k].name.substr(4) != other) continue;
      mirrored[k] = name.find("pitch") == std::string::npos ? -angles[i] : angles[i];
    }
  }
  const Skeleton skeleton = SkeletonOf(angles);
  const Skeleton other = SkeletonOf(mirrored);
  for (const std::size_t side : {kLeft, kRight}) {
    RC_ASSERT((skeleton.arms[side].hand_m - Mirrored(other.arms[1 - side].hand_m)).norm() < kTiny);
    RC_ASSERT((skeleton.legs[side].ankle_m - Mirrored(other.legs[1 - side].ankle_m)).norm() <
              kTiny);
  }
}

// The head that is drawn and the camera on it are one.
RC_GTEST_PROP(HumanoidKinematicsProperty, HasItsHeadWhereTheHeadCameraIs, ()) {
  const Angles angles = AnyAngles();
  const CameraSpec& front = Wedding().cameras.cameras[0];
  const Gaze gaze{angles[kWaistYaw] + angles[kHeadYaw], 0};
  const Eigen::Isometry3d camera = CameraInPlace(front, {}, {}, gaze);
  const Vector3d on_head = front.position_m - kHead;
  RC_ASSERT((SkeletonOf(angles).head * on_head - camera.translation()).norm() < kTiny);
}

TEST(HumanoidPoses, ThatUseBothArmsAlikeAreSymmetric) {
  for (const char* pose : {"neutral", "heart", "heart_chest", "welcome", "akimbo"}) {
    const Skeleton skeleton = In(pose);
    EXPECT_THAT(skeleton.arms[kLeft].hand_m, IsNear(Mirrored(skeleton.arms[kRight].hand_m)))
        << pose;
    EXPECT_EQ(Pose(pose).hands[kLeft], Pose(pose).hands[kRight]) << pose;
  }
}

TEST(HumanoidPoses, MakeAHeartOverTheHeadWithTheElbowsOut) {
  const Arm arm = In("heart").arms[kLeft];
  EXPECT_GT(arm.hand_m.z(), kHead.z() + 0.15) << "over the head";
  EXPECT_LT(arm.hand_m.y(), 0.16) << "over its middle";
  EXPECT_GT(arm.elbow_m.y(), arm.shoulder_m.y() + 0.1);
  EXPECT_NEAR(arm.hand_m.x(), 0, 0.1) << "beside it, not before it";
}

TEST(HumanoidPoses, MakeAHeartBeforeTheChest) {
  const Arm arm = In("heart_chest").arms[kLeft];
  EXPECT_GT(arm.hand_m.x(), 0.15) << "before the chest";
  EXPECT_LT(arm.hand_m.y(), 0.15) << "at its middle";
  EXPECT_GT(arm.hand_m.z(), arm.elbow_m.z()) << "pointing up";
}

TEST(HumanoidPoses, RaiseTheRightHandForSignsAndLeaveTheLeftOneDown) {
  for (const auto& [pose, shape] :
       {std::pair("v_sign", HandShape::kV), std::pair("thumbs_up", HandShape::kThumb),
        std::pair("wave", HandShape::kOpen)}) {
    const Skeleton skeleton = In(pose);
    EXPECT_GT(skeleton.arms[kRight].hand_m.z(), 0.3) << pose;
    EXPECT_LT(skeleton.arms[kLeft].hand_m.z(), 0) << pose;
    EXPECT_EQ(Pose(pose).hands[kRight], shape) << pose;
  }
  const Eigen::Matrix3d hand = In("thumbs_up").arms[kRight].hand;
  EXPECT_GT((hand * Vector3d::UnitX()).z(), 0.7) << "the thumb is up";
  EXPECT_GT(-(In("v_sign").arms[kRight].hand * Vector3d::UnitZ()).z(), 0.9) << "fingers, too";
}

TEST(HumanoidPoses, WaveTheHandToAndFroBesideTheHead) {
  Humanoid humanoid(*Wedding().humanoid);
  ASSERT_EQ(humanoid.SetPose("wave"), std::nullopt);
  const auto hand = [&] {
    Angles angles;
    for (std::size_t i = 0; i < kJoints; ++i) angles[i] = humanoid.joints()[i].position_rad;
    return SkeletonOf(angles).arms[kRight].hand_m;
  };
  const auto pass = [&](double seconds, auto each) {
    for (Duration done{}; done < Seconds(seconds); done += kStep) {
      humanoid.Step(kStep);
      each(hand());
    }
  };
  pass(1.2, [](const Vector3d&) {});  // it waves well before a farewell is over
  Vector3d least = hand(), most = hand();
  pass(3, [&](const Vector3d& at) {
    least = least.cwiseMin(at);
    most = most.cwiseMax(at);
  });
  EXPECT_GT(most.y() - least.y(), 0.12) << "to its sides";
  EXPECT_LT(most.x() - least.x(), 0.1) << "not ahead";
  EXPECT_NEAR(least.z(), kHead.z(), 0.12);
  EXPECT_LT(most.y(), -0.2) << "beside the head, not before it";
}

// The photo's pose phase and the farewell are that short.
TEST(HumanoidPoses, AreTakenInTheTimeThatTheShowHasForThem) {
  for (const char* pose : {"heart", "v_sign", "thumbs_up"}) {
    Humanoid humanoid(*Wedding().humanoid);
    ASSERT_EQ(humanoid.SetPose(pose), std::nullopt);
    for (Duration done{}; done < Seconds(1.6); done += kStep) humanoid.Step(kStep);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(humanoid.joints()[i].position_rad, Pose(pose).angles[i], 0.02)
          << pose << " " << JointTable()[i].name;
    }
  }
}

}  // namespace musher::world::humanoid_kinematics_test
