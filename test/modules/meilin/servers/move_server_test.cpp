// move_to_pose on a simulated network with a simulated body, in virtual time.

#include "musher/modules/meilin/servers/move_server.hpp"

#include <chrono>
#include <cmath>
#include <limits>

#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/test/modules/meilin/servers/server_rig.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::meilin::servers::move_server_test {

using testing::ArrayOf;
using ::testing::HasSubstr;
using transport::GoalEnd;

class MoveServerTest : public testing::ServerRig<msg::MoveToPose> {
 protected:
  MoveServerTest() {
    action_ = "move_to_pose";
    ConnectBoard();
    pose_out_ = Must(transport::MakePublisher<msg::PoseStamped>(*peer_, "transformed/pose"));
    climb_out_ = Must(transport::MakePublisher<msg::Int32>(*peer_, "current_state"));
    body_ticks_ = peer_->loop().Every(Milliseconds(20), [this] { MoveBody(); });
  }
  // The board keeps its last velocity.
  void ConnectBoard() {
    velocity_in_ = Must(transport::MakeSubscription<msg::Float32MultiArray>(
        *peer_, "t0x0101_pid", [this](const msg::Float32MultiArray& v, const auto&) {
          velocity_ = v.data;
          ++velocities_;
        }));
  }
  void MoveBody() {
    constexpr double kStepS = 0.02;
    const double c = std::cos(yaw_);
    const double s = std::sin(yaw_);
    x_ += kStepS * (c * velocity_[0] - s * velocity_[1]);
    y_ += kStepS * (s * velocity_[0] + c * velocity_[1]);
    yaw_ += kStepS * velocity_[2];
    if (silent_) return;
    msg::PoseStamped pose;
    pose.header.frame_id = frame_;
    pose.header.stamp.sec = stamp_s_;
    if (rising_stamps_) {
      pose.header.stamp = msg::ToStamp(Duration(network_.now().time_since_epoch()));
    }
    if (!frozen_) seen_x_ = x_;
    pose.pose.position.x = seen_x_;
    pose.pose.position.y = y_;
    pose.pose.orientation = {0, 0, std::sin(yaw_ / 2), std::cos(yaw_ / 2)};
    EXPECT_TRUE(pose_out_->Publish(pose));
  }
  void ExpectStanding() {
    Run(500);
    EXPECT_EQ(velocity_, (std::vector<float>{0, 0, 0}));
    const int velocities = velocities_;
    Run(1000);
    EXPECT_EQ(velocities_, velocities) << "nothing is sent any more";
  }

  double x_ = 0;
  double y_ = 0;
  double yaw_ = 0;
  bool silent_ = false;
  int stamp_s_ = 0;  // of each pose; 0: none
  bool rising_stamps_ = false;
  bool frozen_ = false;
  double seen_x_ = 0;
  std::string frame_ = "map";
  std::vector<float> velocity_{0, 0, 0};
  int velocities_ = 0;
  std::unique_ptr<transport::Subscription> velocity_in_;
  std::unique_ptr<transport::Publisher<msg::PoseStamped>> pose_out_;
  std::unique_ptr<transport::Publisher<msg::Int32>> climb_out_;
  transport::LoopHandlePtr body_ticks_;
};

constexpr const char* kFile = "server = \"move_to_pose\"\nbrake_m_s2 = 1.5\nclimb_m_s = 0.3\n";

TEST_F(MoveServerTest, MovesTheBodyToThePose) {
  Start(kFile);
  ExpectEnd(Send({1.2, -1.2, 90}), GoalEnd::kSucceeded, "Goal reached");
  EXPECT_NEAR(x_, 1.2, 0.03);
  EXPECT_NEAR(y_, -1.2, 0.03);
  EXPECT_NEAR(yaw_, 1.5708, 0.03);
  ExpectStanding();
}

TEST_F(MoveServerTest, ReportsThePhaseTheErrorsAndTheVelocity) {
  Start(kFile);
  const std::size_t goal = Send({2, 0, 60});
  Run(1000);
  ASSERT_FALSE(feedback_.empty());
  const auto& turning = feedback_.back();
  EXPECT_EQ(turning.phase, "yaw");
  EXPECT_GT(turning.cmd_wz, 0);
  EXPECT_NEAR(turning.target_yaw_deg, 60, 1e-9);
  EXPECT_NEAR(turning.yaw_error_deg, 60 - turning.current_yaw_deg, 1e-6);
  EXPECT_EQ(turning.distance_error, 2);
  Await(goal);
  EXPECT_EQ(feedback_.back().phase, "xy");
  EXPECT_NEAR(feedback_.back().current_x, 2, 0.1);
}

TEST_F(MoveServerTest, RejectsGoalsThatAreNotFinite) {
  Start(kFile);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const msg::MoveToPose::Goal goal :
       {msg::MoveToPose::Goal{nan, 0, 0}, {0, inf, 0}, {0, 0, -inf}}) {
    ExpectRejected(goal, "x, y or yaw_deg is not a finite number");
  }
}

TEST_F(MoveServerTest, FailsWithoutAPoseAndWhenItIsLost) {
  silent_ = true;
  Start(kFile);
  EXPECT_EQ(server_->Missing(), "no pose yet on transformed/pose");
  ExpectEnd(Send({1, 0, 0}), GoalEnd::kAborted, "Timed out waiting for relocation pose");
  silent_ = false;
  Run(100);
  EXPECT_EQ(server_->Missing(), "");
  const std::size_t goal = Send({3, 0, 0});
  Run(500);
  silent_ = true;
  EXPECT_THAT(Await(goal).result.message, HasSubstr("Pose lost: no pose for 0."));
  ExpectStanding();
}

TEST_F(MoveServerTest, TakesAPoseThatIsPublishedAgainForNone) {
  Start(kFile);
  const std::size_t goal = Send({3, 0, 0});
  Run(500);
  stamp_s_ = 7;  // from now on
  EXPECT_THAT(Await(goal).result.message, HasSubstr("Pose lost: no pose for 0."));
  ExpectStanding();
}

TEST_F(MoveServerTest, DoesNotDriveOnBesideAPoseThatStandsStill) {
  rising_stamps_ = true;
  Start(kFile);
  const std::size_t goal = Send({3, 0, 0});
  ASSERT_TRUE(RunUntil([this] { return x_ > 2.2; }));
  frozen_ = true;
  EXPECT_THAT(Await(goal).result.message, HasSubstr("its odometry does not change at all"));
  ExpectStanding();
  EXPECT_LT(x_, 3.2);
}

TEST_F(MoveServerTest, StopsTheBodyAtAStopAlsoWithoutAGoal) {
  Start(kFile);
  Run(500);
  velocity_ = {1, 0, 0};  // as a process before this one has left it
  const int velocities = velocities_;
  server_->Permit(false, "an emergency stop holds it");
  ExpectStanding();
  EXPECT_GE(velocities_ - velocities, 10) << "one alone may be lost";
}

TEST_F(MoveServerTest, StopsTheBodyThatAProcessBeforeItHasLeftDriving) {
  velocity_ = {1, 0, 0};
  Start(kFile);
  EXPECT_EQ(velocity_, (std::vector<float>{0, 0, 0})) << "from its start on";
  Run(500);
  velocity_ = {1, 0, 0};
  server_->Permit(true, "");
  ExpectStanding();
}

TEST_F(MoveServerTest, StopsTheBodyOnceItsBoardIsThere) {
  velocity_in_.reset();
  Start(kFile);
  Run(5000);
  velocity_ = {1, 0, 0};
  ConnectBoard();
  Run(1000);
  ExpectStanding();
  EXPECT_GE(velocities_, 10);
}

TEST_F(MoveServerTest, EndsNoDriveWhereItIsPermittedOnceMore) {
  Start(kFile);
  const std::size_t goal = Send({1, 0, 0});
  Run(300);
  server_->Permit(true, "");
  ExpectEnd(goal, GoalEnd::kSucceeded, "Goal reached");
}

TEST_F(MoveServerTest, IgnoresPosesOfOtherFrames) {
  frame_ = "odom";
  Start(kFile);
  ExpectEnd(Send({1, 0, 0}), GoalEnd::kAborted, "Timed out waiting for relocation pose");
  EXPECT_THAT(log_, ::testing::Contains("a pose is ignored: its frame is 'odom', expected 'map'"));
}

TEST_F(MoveServerTest, StandsWhenAGoalIsCancelled) {
  Start(kFile);
  const std::size_t goal = Send({3, 0, 0});
  Run(1000);
  Cancel(goal);
  ExpectEnd(goal, GoalEnd::kCanceled, "Goal canceled during xy phase");
  ExpectStanding();
}

TEST_F(MoveServerTest, DrivesToANewerGoal) {
  Start(kFile);
  const std::size_t first = Send({3, 0, 0});
  Run(1000);
  const std::size_t second = Send({0, 1, 0});
  ExpectEnd(first, GoalEnd::kAborted, "Preempted by a newer goal");
  ExpectEnd(second, GoalEnd::kSucceeded, "Goal reached");
  EXPECT_NEAR(y_, 1, 0.03);
}

TEST_F(MoveServerTest, StandsAndRejectsGoalsOutsideOfActive) {
  Start(kFile);
  const std::size_t goal = Send({3, 0, 0});
  Run(1000);
  server_->Permit(false, "it is in Protected");
  ExpectEnd(goal, GoalEnd::kAborted, "Aborted: it is in Protected");
  ExpectStanding();
  ExpectRejected({1, 0, 0}, "it is in Protected");
  server_->Permit(true, "");
  ExpectEnd(Send({1, 0, 0}), GoalEnd::kSucceeded, "Goal reached");
}

// It had waited in the kernel, and its client had long gone.
TEST_F(MoveServerTest, RejectsAGoalThatMayHaveWaitedWhileItsProcessCouldNotRun) {
  Start(kFile);
  Run(500);  // until it no longer says that the body is to stand
  network_.Pause(*node_);
  Send({1, 0, 0});
  Run(9000);
  const int velocities = velocities_;
  network_.Resume(*node_);
  Run(1000);
  EXPECT_EQ(velocities_, velocities);
  EXPECT_THAT(log_,
              ::testing::Contains(musher::testing::HasRefusal(ApplicationRefusal::kMayBeLate)));
  Run(2000);
  ExpectEnd(Send({1, 0, 0}), GoalEnd::kSucceeded, "Goal reached");
}

// The client of the late goal no longer follows the drive before it.
TEST_F(MoveServerTest, EndsTheDriveThatARejectedLateGoalWasToReplace) {
  Duration& suspended = MakeSuspendable();
  Start(kFile);
  const std::size_t drive = Send({3, 0, 0});
  Run(1000);
  ASSERT_GT(velocity_[0], 0);
  suspended += std::chrono::seconds(9);
  EXPECT_EQ(Await(Send({0, 1, 0})).end, GoalEnd::kRejected);
  const Outcome ended = Await(drive);
  EXPECT_EQ(ended.end, GoalEnd::kAborted);
  EXPECT_THAT(ended.result.message, musher::testing::HasRefusal(ApplicationRefusal::kMayBeLate));
  ExpectStanding();
}

TEST_F(MoveServerTest, EndsTheDriveThatWasUnderWayBeforeALongBreakOfItsProcess) {
  Duration& suspended = MakeSuspendable();
  Start(kFile);
  const std::size_t drive = Send({3, 0, 0});
  Run(500);
  suspended += std::chrono::seconds(50);
  Run(100);
  EXPECT_FALSE(ends_[drive]);
  suspended += std::chrono::minutes(2);
  ExpectEnd(drive, GoalEnd::kAborted, "Aborted: this server could not run for 120 s");
  ExpectStanding();
  Run(2000);  // until goals are accepted again
  ExpectEnd(Send({1, 0, 0}), GoalEnd::kSucceeded, "Goal reached");
}

// The break does not end the drive that begins after it.
TEST_F(MoveServerTest, DrivesAfterALongBreakInWhichNoGoalRan) {
  Duration& suspended = MakeSuspendable();
  Start(kFile);
  suspended += std::chrono::minutes(2);
  Run(3000);  // until goals are accepted again
  ExpectEnd(Send({1, 0, 0}), GoalEnd::kSucceeded, "Goal reached");
}

TEST_F(MoveServerTest, StandsWhenTheWorldIsRestarted) {
  Start(kFile);
  const std::size_t goal = Send({3, 0, 0});
  Run(1000);
  server_->OnTimeJump("the time has jumped");
  ExpectEnd(goal, GoalEnd::kAborted, "Aborted: the time has jumped");
  ExpectStanding();
}

TEST_F(MoveServerTest, StandsWhenTheServerEnds) {
  Start(kFile);
  Send({3, 0, 0});
  Run(1000);
  EXPECT_GT(velocity_[0], 0);
  server_.reset();
  Run(100);
  EXPECT_EQ(velocity_, (std::vector<float>{0, 0, 0}));
}

TEST_F(MoveServerTest, IsSlowWhileTheSuspensionClimbs) {
  Start(kFile);
  Send({3, 0, 0});
  msg::Int32 state;
  state.data = 12;
  EXPECT_TRUE(climb_out_->Publish(state));
  Run(1000);
  EXPECT_NEAR(velocity_[0], 0.3, 1e-6);
}

}  // namespace musher::meilin::servers::move_server_test
