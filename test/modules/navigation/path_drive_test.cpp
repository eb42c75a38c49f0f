// Drives of one robot, step by step: what it remembers of its scans.

#include "musher/modules/navigation/controller_server/path_drive.hpp"

#include <gmock/gmock.h>

namespace musher::navigation::path_drive_test {

using ::testing::HasSubstr;

class Drive : public ::testing::Test {
 protected:
  static ControllerRobot Robot() {
    ControllerRobot robot;
    robot.name = "r";
    robot.odometry = "r/odom";
    robot.scanners = {{.topic = "r/scan"}};
    robot.gate.unknown_m_s = robot.limits.speed_m_s;  // no ray looks ahead
    return robot;
  }
  // One ray at this angle, which hits at a range.
  void See(double angle_rad, float range_m) {
    drive_.OnScan(0, {angle_rad, 0.01, 0.05, 8, {range_m}}, now_.time_since_epoch(), now_);
  }
  void BeHere() { drive_.OnOdometry({pose_, velocity_}, now_.time_since_epoch(), now_); }
  // Until it ends, with scans of one ray that looks aside, where nothing is. A correction of the
  // localisation moves it once it is so far along x.
  std::optional<DriveEnd> RunOut(double longest_s, double corrected_at_m = 1e9,
                                 const Point& correction = {}) {
    for (int i = 0; i < 60 * longest_s; ++i) {
      now_ += FromSeconds(1.0 / 60);
      BeHere();
      if (i % 6 == 0) See(1.5, 9);
      const PathDrive::Step step = drive_.Update(now_);
      if (step.end) return step.end;
      velocity_ = InBodyFrame(step.command, -pose_.yaw_rad);
      pose_.at.x_m += velocity_.x_m_s / 60;
      pose_.at.y_m += velocity_.y_m_s / 60;
      pose_.yaw_rad += velocity_.yaw_rad_s / 60;
      if (pose_.at.x_m < corrected_at_m) continue;
      corrected_at_m = 1e9;
      pose_.at = {pose_.at.x_m + correction.x_m, pose_.at.y_m + correction.y_m, 0};
    }
    return std::nullopt;
  }

  Time now_ = Time{} + std::chrono::seconds(10);
  Pose pose_;
  Velocity velocity_;
  PathDrive drive_{Robot(), {}};
};

// A flyer on its way down sees only with its sensor who is there.
TEST(ADriveOfAFlyer, EndsWithItsReasonAboveAPersonBelowIt) {
  ControllerRobot robot;
  robot.name = "r";
  robot.flies = true;
  robot.differential = false;
  robot.gate.down.topic = "r/range_down";
  PathDrive drive(robot, {});
  Time now = Time{} + std::chrono::seconds(10);
  Pose pose{{0, 0, 2.8}, 0};
  Velocity velocity;
  std::optional<DriveEnd> end;
  for (int i = 0; i < 60 * 30 && !end; ++i) {
    now += FromSeconds(1.0 / 60);
    drive.OnOdometry({pose, velocity}, now.time_since_epoch(), now);
    if (i % 3 == 0) {
      const double range_m = pose.at.z_m - 1.6 + 0.001 * (i % 2);
      drive.OnRange({range_m, 0.05, 4, 1}, now.time_since_epoch(), now);
    }
    const bool starts = i == 10;
    ASSERT_FALSE(starts && drive.Start({pose, {{0, 0, 1}, 0}}, now));
    const PathDrive::Step step = drive.Update(now);
    end = step.end;
    velocity = step.command;
    pose.at.z_m += velocity.z_m_s / 60;
    EXPECT_GT(pose.at.z_m, 1.6 + 0.3);
  }
  ASSERT_TRUE(end);
  EXPECT_THAT(end->reason, HasSubstr("something 1.6 m high"));
  EXPECT_THAT(end->reason, HasSubstr("it does not descend, for 2.0 s"));
}

// The gate knows only the last scan; what is out of its sight the grid remembers, which the planner
// has as well.
TEST_F(Drive, StopsBeforeWhatItHasSeenAndSeesNoMore) {
  BeHere();
  See(0, 3);
  ASSERT_FALSE(drive_.Start({pose_, {{5, 0, 0}, 0}}, now_));
  const auto end = RunOut(20);
  ASSERT_TRUE(end);
  EXPECT_THAT(end->reason, HasSubstr("an obstacle at (3.00, 0.00"));
  EXPECT_LT(pose_.at.x_m, 2.8);
}

// A body that turns is elsewhere when the scan comes: by 0.9 m, 3 m away.
TEST_F(Drive, TakesAScanFromWhereItWasTaken) {
  BeHere();
  const Duration taken = now_.time_since_epoch();
  for (int i = 0; i < 15; ++i) {
    now_ += Milliseconds(20);
    pose_.yaw_rad += 0.02;
    BeHere();
  }
  drive_.OnScan(0, {0, 0.01, 0.05, 8, {3.0F}}, taken, now_);
  ASSERT_FALSE(drive_.Start({pose_, {{5, 0, 0}, 0}}, now_));
  const auto end = RunOut(20);
  ASSERT_TRUE(end);
  EXPECT_THAT(end->reason, HasSubstr("an obstacle at (3.00, 0.00"));
  EXPECT_LT(pose_.at.x_m, 2.8);
}

TEST_F(Drive, PassesWhatItHasForgottenOnRequest) {
  BeHere();
  See(0, 3);
  See(1.5, 9);  // else the gate, which has no memory, stops it
  drive_.ClearMemory();
  ASSERT_FALSE(drive_.Start({pose_, {{5, 0, 0}, 0}}, now_));
  const auto end = RunOut(20);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->reason, "");
}

TEST_F(Drive, RemembersAlsoWhatANewMapContains) {
  BeHere();
  See(0, 3);
  ASSERT_FALSE(drive_.Start({pose_, {{5, 0, 0}, 0}}, now_));
  CellMap map;
  map.resolution_m = 0.1;
  map.origin = {{-2, -5, 0}, 0};
  map.size_x = map.size_y = 100;
  map.blocked.assign(100 * 100, 0);
  map.blocked[map.IndexOf(map.CellOf({3.05, 0, 0}))] = 1;
  drive_.SetMap(std::make_shared<const Clearance>(std::move(map)), now_);
  const auto end = RunOut(20);
  ASSERT_TRUE(end);
  EXPECT_LT(pose_.at.x_m, 2.8) << end->reason;
}

// A client that plans twice a second.
TEST_F(Drive, EndsWithoutProgressAlsoWhereItsPathIsReplaced) {
  std::optional<DriveEnd> end;
  for (int i = 0; i < 60 * 3 && !end; ++i) {
    now_ += FromSeconds(1.0 / 60);
    BeHere();
    if (i % 6 == 0) See(1.5, 9);
    if (i % 30 == 0) {
      drive_.Check(0.2, 0.1, ProgressRules{0.5, Milliseconds(1200)});
      ASSERT_FALSE(drive_.Start({pose_, {{5, 0.001 * i, 0}, 0}}, now_));
    }
    end = drive_.Update(now_).end;
  }
  ASSERT_TRUE(end);
  EXPECT_EQ(end->error_code, FollowCode::kFailedToMakeProgress);
  EXPECT_THAT(end->reason, HasSubstr("not moved by 0.50 m within 1.2 s"));
}

// A differential body came to rest beside its goal, and the drive failed as late.
TEST_F(Drive, ArrivesAlsoWhereItsLocalisationIsCorrectedToTheSide) {
  for (const double at_m : {1.0, 2.5, 2.9, 2.99}) {
    for (const double aside_m : {-0.45, -0.3, -0.21, 0.25, 0.4}) {
      pose_ = {};
      velocity_ = {};
      now_ += std::chrono::seconds(10);
      drive_.Forget();
      BeHere();
      See(1.5, 9);
      ASSERT_FALSE(drive_.Start({pose_, {{3, 0, 0}, 0}}, now_));
      const auto end = RunOut(30, at_m, {0, aside_m, 0});
      ASSERT_TRUE(end);
      EXPECT_EQ(end->reason, "") << aside_m << " m at " << at_m << " m";
      EXPECT_LT(Distance(pose_.at, {3, 0, 0}), 0.21);
    }
  }
}

}  // namespace musher::navigation::path_drive_test
