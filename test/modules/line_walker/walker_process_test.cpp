// musher-line-walker as a controller and the robot's other modules use it: the real program over
// DDS.

#include <gmock/gmock.h>

#include <csignal>
#include <memory>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/actuator_peer.hpp"
#include "musher/test/modules/line_walker/s_lane.hpp"

namespace musher::line_walker::walker_process_test {

using msg::ActuatorCommand;
using ::testing::HasSubstr;

const std::vector<std::string> kAllStates = {"SetUp",    "TearDown", "SelfCheck",
                                             "Active",   "DeActive", "Protected",
                                             "LowPower", "OTA",      "Error"};

class WalkerProcess : public ::testing::Test {
 protected:
  void Start(const std::string& file = "self_check_ms = 15000\n") {
    peer_.Start(file);
    ASSERT_TRUE(peer_.AwaitVisible()) << peer_.Output();
  }
  // The programs around it: detectors of a straight lane, odometry, and a motion manager.
  void StartRobot() {
    command_ = Publish<msg::String>("yellow_line_walker/command");
    left_ = Publish<msg::YellowLines>("yellow_line_detector/left");
    right_ = Publish<msg::YellowLines>("yellow_line_detector/right");
    front_ = Publish<msg::YellowLines>("yellow_line_detector/front");
    odometry_ = Publish<msg::Odometry>("odom_out");
    status_in_ = transport::MakeSubscription<msg::String>(
                     peer_.node(), "yellow_line_walker/status",
                     [this](const msg::String& text, const auto&) { status_ = text.data; })
                     .value();
    frames_in_ = transport::MakeSubscription<msg::MotionServoCmd>(
                     peer_.node(), "motion_servo_cmd",
                     [this](const msg::MotionServoCmd& frame, const auto&) {
                       ends_ += frame.cmd_type == msg::MotionServoCmd::kEnd ? 1 : 0;
                       ++frames_;
                     })
                     .value();
    ticker_ = peer_.node().loop().Every(Milliseconds(50), [this] { Send(); });
  }
  void Send() {
    const msg::Stamp stamp = msg::ToStamp(peer_.node().loop().Now().time_since_epoch());
    msg::Odometry odometry;
    odometry.header.stamp = stamp;
    static_cast<void>(odometry_->Publish(odometry));
    const WorldCamera camera(CameraSet().left, Pose{}, 0.29);
    msg::YellowLines lines;
    lines.header.stamp = stamp;
    for (double x = -0.5; x < 1; x += 0.05) {
      const auto share = camera.ShareOf({x, 0.415});
      if (!share) continue;
      lines.edge_x.push_back(float((*share)[0]));
      lines.edge_y.push_back(float((*share)[1]));
    }
    static_cast<void>(left_->Publish(lines));
  }
  template <msg::Message M>
  std::unique_ptr<transport::Publisher<M>> Publish(const std::string& topic) {
    return transport::MakePublisher<M>(peer_.node(), topic).value();
  }
  void ExpectDone(const State& state) {
    const auto done = peer_.Switch(state);
    ASSERT_TRUE(done) << state;
    EXPECT_EQ(done.value().verdict, ActuatorCommand::kVerdictDone)
        << state << ": " << done.value().message << peer_.Output();
  }
  bool AwaitStatus(const std::string& part) {
    return peer_.Until([&] { return status_.find(part) != std::string::npos; });
  }
  void Command(const std::string& word) {
    ASSERT_TRUE(peer_.Until([&] { return command_->MatchedReaders() > 0; }));
    EXPECT_TRUE(command_->Publish({word}));
  }

  test::ActuatorPeer peer_{"yellow_line_walker", kAllStates, "musher-line-walker"};
  std::string status_;
  int frames_ = 0;
  int ends_ = 0;
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> left_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> right_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> front_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  std::unique_ptr<transport::Subscription> status_in_;
  std::unique_ptr<transport::Subscription> frames_in_;
  transport::LoopHandlePtr ticker_;
};

TEST_F(WalkerProcess, WalksInActiveFromStartToStop) {
  StartRobot();
  Start();
  ExpectDone("SelfCheck");
  EXPECT_TRUE(peer_.Until([&] { return left_->MatchedReaders() == 0; }));
  ExpectDone("Active");
  Command("START");
  EXPECT_TRUE(AwaitStatus("State:WALKING")) << status_ << peer_.Output();
  EXPECT_TRUE(peer_.Until([&] { return frames_ > 10; }));
  EXPECT_EQ(left_->MatchedReaders(), 1);
  Command("STOP");
  EXPECT_TRUE(AwaitStatus(",End:stopped")) << status_;
  EXPECT_TRUE(peer_.Until([&] { return ends_ == 1 && left_->MatchedReaders() == 0; }));
  ExpectDone("TearDown");
  EXPECT_EQ(peer_.AwaitExit(), 0) << peer_.Output();
  EXPECT_EQ(ends_, 1);
}

TEST_F(WalkerProcess, ThatWasKilledStandsInActiveUntilTheCommand) {
  StartRobot();
  Start();
  ExpectDone("SelfCheck");
  ExpectDone("Active");
  Command("START");
  ASSERT_TRUE(peer_.Until([&] { return frames_ > 3; })) << peer_.Output();
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  Start();
  frames_ = 0;
  ExpectDone("SelfCheck");
  ExpectDone("Active");
  Command("FLY");
  EXPECT_TRUE(peer_.Until([&] { return peer_.Output().find("FLY") != std::string::npos; }));
  EXPECT_EQ(frames_, 0);
  Command("START");
  EXPECT_TRUE(peer_.Until([&] { return frames_ > 3; })) << peer_.Output();
}

TEST_F(WalkerProcess, EndsAWalkInEveryOtherState) {
  StartRobot();
  Start();
  ExpectDone("SelfCheck");
  int ends = 0;
  for (const BuiltInState state : {kDeActive, kProtected, kLowPower, kOta, kError}) {
    ExpectDone("Active");
    Command("START");
    ASSERT_TRUE(AwaitStatus("State:WALKING")) << state << status_ << peer_.Output();
    ExpectDone(state);
    ++ends;
    EXPECT_TRUE(peer_.Until([&] { return ends_ == ends; })) << state;
    EXPECT_TRUE(AwaitStatus(",End:stopped")) << state;
  }
  EXPECT_THAT(peer_.Output(), HasSubstr("stopped: it is in LowPower"));
}

TEST_F(WalkerProcess, FailsItsSelfCheckWithoutDetectorsAndMotion) {
  Start("self_check_ms = 100\n");
  const auto done = peer_.Switch("SelfCheck");
  ASSERT_TRUE(done);
  EXPECT_EQ(done.value().verdict, ActuatorCommand::kVerdictFailed);
  EXPECT_EQ(done.value().code, 4109);
  EXPECT_THAT(done.value().message, HasSubstr("no subscriber of motion_servo_cmd, no publisher of "
                                              "/yellow_line_detector/left"));
}

TEST_F(WalkerProcess, IsNotStartedWithAnInvalidFile) {
  peer_.Start("[lane]\nwidth_m = -1\n");
  EXPECT_EQ(peer_.AwaitExit(), 2);
  EXPECT_THAT(peer_.Output(), HasSubstr("yellow_line_walker.toml:2:11: error: lane.width_m"));
}

}  // namespace musher::line_walker::walker_process_test
