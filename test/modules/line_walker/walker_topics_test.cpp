// The walker's topics on a simulated network, in virtual time.

#include "musher/modules/line_walker/walker_topics.hpp"

#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/test/modules/line_walker/s_lane.hpp"
#include "musher/test/modules/module_on_network.hpp"
#include "musher/test/transport/suspended_node.hpp"

namespace musher::line_walker::walker_topics_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class WalkerTopicsTest : public test::ModuleOnNetwork {
 protected:
  WalkerTopicsTest() {
    topics_ = test::Must(
        WalkerTopics::Make({*robot_, *clock_, "dog1",
                            [this](LogLevel, const std::string& line) { log_.push_back(line); }},
                           config_));
    command_ = Publisher<msg::String>("dog1/yellow_line_walker/command");
    left_ = Publisher<msg::YellowLines>("dog1/yellow_line_detector/left");
    right_ = Publisher<msg::YellowLines>("dog1/yellow_line_detector/right");
    front_ = Publisher<msg::YellowLines>("dog1/yellow_line_detector/front");
    odometry_ = Publisher<msg::Odometry>("dog1/odom_out");
    responses_ = Publisher<msg::MotionServoResponse>("dog1/motion_servo_response");
    status_ = test::Must(transport::MakeSubscription<msg::String>(
        *desk_, "dog1/yellow_line_walker/status",
        [this](const msg::String& text, const auto&) { statuses_.push_back(text.data); }));
    frames_in_ = Listen("dog1/motion_servo_cmd", frames_);
    Run(500);  // discovery
  }

  void Run(std::int64_t ms) { ModuleOnNetwork::Run(Milliseconds(ms)); }
  void Command(const std::string& word) {
    EXPECT_TRUE(command_->Publish({word}));
    Run(20);
  }
  // Stands in the middle of a straight lane, for so many pictures, 100 ms each.
  void See(int pictures) {
    const CameraSet cameras;
    for (int i = 0; i < pictures; ++i) {
      const msg::Stamp stamp = Stamp();
      msg::Odometry odometry;
      odometry.header.stamp = stamp;
      EXPECT_TRUE(odometry_->Publish(odometry));
      for (const double side : {1.0, -1.0}) {
        const WorldCamera camera(side > 0 ? cameras.left : cameras.right, Pose{}, 0.29);
        msg::YellowLines lines;
        lines.header.stamp = stamp;
        for (double x = -0.5; x < 1; x += 0.05) {
          const auto share = camera.ShareOf({x, side * 0.415});
          if (!share) continue;
          lines.edge_x.push_back(float((*share)[0]));
          lines.edge_y.push_back(float((*share)[1]));
        }
        EXPECT_TRUE((side > 0 ? left_ : right_)->Publish(lines));
      }
      Run(100);
    }
  }
  int Readers() const {
    return left_->MatchedReaders() + right_->MatchedReaders() + front_->MatchedReaders();
  }
  void StartWalking() {
    topics_->Permit(true, "");
    Command("START");
    Run(200);
    See(5);
    ASSERT_FALSE(frames_.empty());
  }
  int Ends() const {
    return int(std::count_if(frames_.begin(), frames_.end(), [](const msg::MotionServoCmd& frame) {
      return frame.cmd_type == msg::MotionServoCmd::kEnd;
    }));
  }

  WalkerConfig config_;
  std::vector<std::string> log_;
  std::vector<std::string> statuses_;
  std::vector<msg::MotionServoCmd> frames_;
  std::unique_ptr<WalkerTopics> topics_;
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> left_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> right_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> front_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  std::unique_ptr<transport::Publisher<msg::MotionServoResponse>> responses_;
  std::unique_ptr<transport::Subscription> status_;
  std::unique_ptr<transport::Subscription> frames_in_;
};

TEST_F(WalkerTopicsTest, PublishTheStatusTenTimesASecond) {
  statuses_.clear();
  Run(1000);
  EXPECT_NEAR(double(statuses_.size()), 10, 1);
  EXPECT_EQ(statuses_.back(), "State:IDLE,Active:False,ImagesReady:False,Runtime:0.0s");
}

TEST_F(WalkerTopicsTest, SubscribeToTheLinesOnlyDuringAWalk) {
  EXPECT_EQ(Readers(), 0);
  StartWalking();
  EXPECT_EQ(Readers(), 3);
  Command("STOP");
  Run(200);
  EXPECT_EQ(Readers(), 0);
}

// A race that crashed in the lane: no light was watched any more, and no STOP came.
TEST_F(WalkerTopicsTest, EndTheWalkWhoseCommanderIsLost) {
  StartWalking();
  command_.reset();
  Run(100);
  See(5);
  EXPECT_EQ(Ends(), 0);
  See(10);
  EXPECT_EQ(Ends(), 1);
  EXPECT_THAT(statuses_.back(), HasSubstr("End:stopped"));
  EXPECT_THAT(log_.back(), HasSubstr("its commander is lost"));
}

// A race that was killed is matched until its lease ends, and one that hangs for ever.
TEST_F(WalkerTopicsTest, EndTheWalkWhoseCommanderHasNoHeartbeatAnyMore) {
  StartWalking();
  for (int i = 0; i < 4; ++i) {
    Command("HEARTBEAT");
    See(10);
  }
  EXPECT_EQ(Ends(), 0);
  EXPECT_EQ(command_->MatchedReaders(), 1);
  See(10);
  EXPECT_EQ(Ends(), 1);
  EXPECT_THAT(statuses_.back(), HasSubstr("End:stopped"));
  EXPECT_THAT(log_, ElementsAre("START: walking in the lane",
                                HasSubstr("no heartbeat of its commander for 1.5 s")));
  Command("HEARTBEAT");
  EXPECT_FALSE(topics_->walker().active()) << "it starts no walk";
  Command("START");
  See(20);
  EXPECT_TRUE(topics_->walker().active()) << "of a commander without one";
}

TEST_F(WalkerTopicsTest, SendFramesOfAServoMotionTwentyTimesASecondAndOneEnd) {
  StartWalking();
  frames_.clear();
  See(10);
  EXPECT_NEAR(double(frames_.size()), 20, 1);
  const msg::MotionServoCmd& frame = frames_.back();
  EXPECT_EQ(frame.motion_id, 303);
  EXPECT_EQ(frame.cmd_type, 1);
  EXPECT_EQ(frame.cmd_source, 4);
  EXPECT_THAT(frame.step_height, ElementsAre(0.05F, 0.05F));
  ASSERT_EQ(frame.vel_des.size(), 3U);
  EXPECT_NEAR(frame.vel_des[0], 0.3, 0.01);
  EXPECT_NEAR(frame.vel_des[2], 0, 0.05);
  EXPECT_THAT(statuses_.back(), HasSubstr("State:WALKING,Active:True,ImagesReady:True"));
  Command("STOP");
  Run(500);
  EXPECT_EQ(Ends(), 1);
  EXPECT_EQ(frames_.back().cmd_type, 2);
  EXPECT_THAT(statuses_.back(), HasSubstr("State:IDLE,Active:False"));
  EXPECT_THAT(statuses_.back(), ::testing::EndsWith(",End:stopped"));
}

TEST_F(WalkerTopicsTest, RefuseStartUntilItIsPermitted) {
  Command("START");
  Run(300);
  EXPECT_THAT(log_, ElementsAre("START refused: it is not in Active"));
  EXPECT_EQ(Readers(), 0);
}

// A race that has ended meanwhile sent its STOP to a process that did not exist for it any more.
TEST_F(WalkerTopicsTest, RefuseAStartThatMayHaveWaitedWhileTheComputerWasSuspended) {
  topics_.reset();
  testing::SuspendedNode node(network_.MakeNode("suspended"));
  const auto topics = test::Must(WalkerTopics::Make(
      {node, *clock_, "dog1", [this](LogLevel, const std::string& line) { log_.push_back(line); }},
      config_));
  topics->Permit(true, "");
  Run(500);  // discovery
  node.loop().each_look = std::chrono::seconds(9);
  Command("START");
  EXPECT_FALSE(topics->walker().active());
  EXPECT_THAT(log_, ElementsAre(HasSubstr("START refused: this process could not run for 9.")));
  node.loop().each_look = {};
  Run(2500);
  Command("START");
  EXPECT_TRUE(topics->walker().active());
}

// It walked on at once, by the lane of before.
TEST_F(WalkerTopicsTest, EndTheWalkAfterASuspensionOfTheComputer) {
  topics_.reset();
  testing::SuspendedNode node(network_.MakeNode("suspended"));
  topics_ = test::Must(WalkerTopics::Make(
      {node, *clock_, "dog1", [this](LogLevel, const std::string& line) { log_.push_back(line); }},
      config_));
  Run(500);  // discovery
  StartWalking();
  node.loop().suspended += std::chrono::seconds(9);
  See(1);
  EXPECT_EQ(Ends(), 1);
  EXPECT_THAT(log_.back(), HasSubstr("stopped: this process could not run for 9."));
  topics_.reset();  // before its node
}

// A /clock of another computer that stood for longer: its walk went on when the clock did.
TEST_F(WalkerTopicsTest, EndTheWalkAfterASuspensionAlsoWhereItsClockStands) {
  topics_.reset();
  testing::SuspendedNode node(network_.MakeNode("suspended"));
  const auto clock = test::Must(transport::Clock::FromTopic(node));
  const auto world = Publisher<msg::Clock>(transport::kClockTopic, transport::kClockQos);
  bool stands = false;
  topics_ = test::Must(WalkerTopics::Make(
      {node, *clock, "dog1", [this](LogLevel, const std::string& line) { log_.push_back(line); }},
      config_));
  const auto sending = desk_->loop().Every(Milliseconds(20), [&] {
    if (stands) return;
    EXPECT_TRUE(world->Publish({msg::ToStamp(network_.now().time_since_epoch())}));
  });
  Run(500);  // discovery
  StartWalking();
  stands = true;
  Run(100);
  node.loop().suspended += std::chrono::seconds(9);
  Run(1000);
  EXPECT_EQ(Ends(), 1);
  EXPECT_FALSE(topics_->walker().active());
  topics_.reset();  // before its node
}

TEST_F(WalkerTopicsTest, EndAWalkAtOnceWhenItIsNotPermittedAnyMore) {
  StartWalking();
  topics_->Permit(false, "an emergency stop holds it");
  EXPECT_FALSE(topics_->walker().active());
  Run(100);
  EXPECT_EQ(Ends(), 1);
  EXPECT_EQ(frames_.back().cmd_type, 2);
  EXPECT_THAT(log_.back(), HasSubstr("stopped: an emergency stop holds it"));
  topics_->Permit(true, "");
  Run(1000);
  EXPECT_FALSE(topics_->walker().active()) << "START is needed again";
}

TEST_F(WalkerTopicsTest, IgnoreASecondStartAndSaySo) {
  StartWalking();
  Command("START");
  EXPECT_TRUE(topics_->walker().active());
  EXPECT_THAT(log_.back(), HasSubstr("START ignored"));
}

TEST_F(WalkerTopicsTest, RefuseUnknownWordsWithoutFillingTheLog) {
  topics_->Permit(true, "");
  for (int i = 0; i < 100; ++i) Command("start\n");
  EXPECT_THAT(log_.front(), "unknown command \"start?\" refused: expected START or STOP");
  EXPECT_LE(log_.size(), 3U);
  EXPECT_FALSE(topics_->walker().active());
}

TEST_F(WalkerTopicsTest, EndWhenTheMotionManagerRefuses) {
  StartWalking();
  msg::MotionServoResponse refused;
  refused.code = 3040;
  for (int i = 0; i < 7; ++i) {
    EXPECT_TRUE(responses_->Publish(refused));
    See(1);
  }
  EXPECT_THAT(statuses_.back(), HasSubstr(",End:refused"));
  EXPECT_EQ(Ends(), 1);
}

TEST_F(WalkerTopicsTest, EndWhenThePicturesStop) {
  StartWalking();
  for (int i = 0; i < 15; ++i) {
    msg::Odometry odometry;
    odometry.header.stamp = Stamp();
    EXPECT_TRUE(odometry_->Publish(odometry));
    Run(100);
  }
  EXPECT_THAT(statuses_.back(), HasSubstr(",End:silent"));
  EXPECT_THAT(log_.back(), HasSubstr("no pictures of the left and right line for 1000 ms"));
}

// The vision of a second robot, for which the topic has the same name: it walked by both cameras.
TEST_F(WalkerTopicsTest, EndTheWalkWhereTwoPublishersOfALineTakeTurns) {
  StartWalking();
  const auto other = Publisher<msg::YellowLines>("dog1/yellow_line_detector/left");
  See(5);
  EXPECT_TRUE(topics_->walker().active());
  EXPECT_TRUE(other->Publish({}));
  See(2);
  EXPECT_EQ(Ends(), 1);
  EXPECT_THAT(statuses_.back(), HasSubstr("End:stopped"));
  EXPECT_THAT(log_.back(), HasSubstr("two publishers of yellow_line_detector/left take turns"));
}

TEST_F(WalkerTopicsTest, CheckThatALineHasOnePublisher) {
  const auto other = Publisher<msg::YellowLines>("dog1/yellow_line_detector/left");
  EXPECT_TRUE(topics_->SetChecked(true));
  Run(500);
  const Result<> checked = topics_->Check();
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().message, "more than one publisher of yellow_line_detector/left");
}

TEST_F(WalkerTopicsTest, CheckThatMotionAndTheDetectorsAreThere) {
  EXPECT_TRUE(topics_->SetChecked(true));
  Run(300);
  EXPECT_TRUE(topics_->Check());
  EXPECT_EQ(Readers(), 3);
  right_.reset();
  frames_in_.reset();
  Run(300);
  const Result<> checked = topics_->Check();
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().code, 4109);
  EXPECT_EQ(checked.error().message,
            "no subscriber of motion_servo_cmd, no publisher of yellow_line_detector/right");
  EXPECT_TRUE(topics_->SetChecked(false));
  Run(300);
  EXPECT_EQ(left_->MatchedReaders(), 0);
}

}  // namespace musher::line_walker::walker_topics_test
