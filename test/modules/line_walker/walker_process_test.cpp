// musher-line-walker as a controller and the robot's other modules use it: the real program over
// DDS.

#include <unistd.h>

#include <csignal>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/line_walker/s_lane.hpp"
#include "musher/test/modules/module_process.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::line_walker::walker_process_test {

using ::testing::HasSubstr;

// A walk does not end because a busy computer lets the lines or the odometry wait.
constexpr const char* kFile = R"(
self_check_ms = 15000
[limits]
start_ms = 60000
stale_ms = 10000
lost_ms = 20000
)";

class WalkerProcess : public test::ModuleProcess {
 protected:
  WalkerProcess() : ModuleProcess("yellow_line_walker", "musher-line-walker") {}

  // The programs around it: detectors of a straight lane, odometry, and a motion manager.
  void StartRobot() {
    command_ = Publisher<msg::String>("yellow_line_walker/command");
    left_ = Publisher<msg::YellowLines>("yellow_line_detector/left");
    right_ = Publisher<msg::YellowLines>("yellow_line_detector/right");
    front_ = Publisher<msg::YellowLines>("yellow_line_detector/front");
    odometry_ = Publisher<msg::Odometry>("odom_out");
    Subscribe<msg::String>("yellow_line_walker/status", [this](const msg::String& text) {
      status_ = text.data;
      ++statuses_;
    });
    Subscribe<msg::MotionServoCmd>("motion_servo_cmd", [this](const msg::MotionServoCmd& frame) {
      ends_ += frame.cmd_type == msg::MotionServoCmd::kEnd ? 1 : 0;
      ++frames_;
    });
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
  bool AwaitStatus(const std::string& part) {
    return peer_.Until([&] { return status_.find(part) != std::string::npos; });
  }
  void Command(const std::string& word) {
    ASSERT_TRUE(peer_.Until([&] { return command_->MatchedReaders() > 0; }));
    EXPECT_TRUE(command_->Publish({word}));
  }

  std::string status_;
  int statuses_ = 0;
  int frames_ = 0;
  int ends_ = 0;
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> left_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> right_;
  std::unique_ptr<transport::Publisher<msg::YellowLines>> front_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  transport::LoopHandlePtr ticker_;
};

TEST_F(WalkerProcess, WalksInActiveFromStartToStop) {
  StartRobot();
  Start(kFile);
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
  ExpectTornDown();
  EXPECT_EQ(ends_, 1);
}

TEST_F(WalkerProcess, EndsAWalkInEveryOtherState) {
  StartRobot();
  Start(kFile);
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

TEST_F(WalkerProcess, ThatIsKilledInAWalkStandsUntilTheNextStart) {
  StartRobot();
  Start(kFile);
  ExpectDone("SelfCheck");
  ExpectDone("Active");
  Command("START");
  ASSERT_TRUE(AwaitStatus("State:WALKING")) << status_ << peer_.Output();
  // So that the status of its successor is known from its own.
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  Start(kFile);
  frames_ = 0;
  ExpectDone("SelfCheck");
  ExpectDone("Active");
  const int before = statuses_;
  ASSERT_TRUE(peer_.Until([&] { return statuses_ >= before + 10; }));  // a second
  EXPECT_THAT(status_, ::testing::StartsWith("State:IDLE,Active:False"));
  EXPECT_EQ(frames_, 0) << "the lines are there, and no person has begun a walk";
  // More than once: the reader of the killed process counts until its lease has expired.
  const auto starts = peer_.node().loop().Every(
      Milliseconds(200), [this] { static_cast<void>(command_->Publish({"START"})); });
  EXPECT_TRUE(AwaitStatus("State:WALKING")) << status_ << peer_.Output();
}

// The process that the test below starts and kills: it sends START, and heartbeats until its end.
TEST(WalkerCommander, DISABLED_SendsHeartbeatsUntilItIsKilled) {
  const auto node = transport::NodeThread::Start().value();
  std::unique_ptr<transport::Publisher<msg::String>> command;
  transport::LoopHandlePtr ticker;
  bool started = false;
  node->RunOnLoop([&] {
    command =
        transport::MakePublisher<msg::String>(node->node(), "yellow_line_walker/command").value();
    ticker = node->loop().Every(Milliseconds(100), [&] {
      if (command->MatchedReaders() < 2) return;  // the walker, and the test
      static_cast<void>(command->Publish({std::exchange(started, true) ? "HEARTBEAT" : "START"}));
    });
  });
  for (;;) pause();
}

// On one machine its publisher counts as matched for 10 s more, and here that of the test always.
TEST_F(WalkerProcess, WhoseCommanderIsKilledEndsItsWalk) {
  StartRobot();
  int heartbeats = 0;
  Subscribe<msg::String>("yellow_line_walker/command", [&](const msg::String& word) {
    if (word.data == "HEARTBEAT") ++heartbeats;
  });
  Start(kFile);
  ExpectDone("SelfCheck");
  ExpectDone("Active");
  exec::Child commander =
      Launch({"line_walker_test", "--gtest_also_run_disabled_tests",
              "--gtest_filter=WalkerCommander.DISABLED_SendsHeartbeatsUntilItIsKilled"});
  ASSERT_TRUE(AwaitStatus("State:WALKING")) << status_ << peer_.Output() << Said();
  ASSERT_TRUE(peer_.Until([&] { return heartbeats >= 4; })) << Said();
  EXPECT_THAT(status_, ::testing::StartsWith("State:WALKING"));
  kill(commander.pid(), SIGKILL);
  EXPECT_EQ(Await(commander), -SIGKILL);
  const int before = statuses_;
  EXPECT_TRUE(AwaitStatus(",End:stopped")) << status_;
  EXPECT_LE(statuses_ - before, 30) << "3 s";
  EXPECT_TRUE(peer_.Until([&] { return ends_ == 1; }));
  EXPECT_TRUE(AwaitOutput("no heartbeat of its commander for 1.5 s")) << peer_.Output();
}

TEST_F(WalkerProcess, FailsItsSelfCheckWithoutDetectorsAndMotion) {
  Start("self_check_ms = 100\n");
  EXPECT_THAT(Failure(kSelfCheck),
              ::testing::AllOf(::testing::StartsWith("4109 "),
                               HasSubstr("no subscriber of motion_servo_cmd, no publisher of "
                                         "yellow_line_detector/left")));
}

}  // namespace musher::line_walker::walker_process_test
