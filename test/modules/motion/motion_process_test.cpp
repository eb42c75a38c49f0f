// The real motion manager and musher-motion, each as a process, over DDS.

#include <gmock/gmock.h>

#include <csignal>
#include <cstdlib>

#include "musher/actuator/callback_harness.hpp"
#include "musher/actuator/program/await.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/modules/motion/motion_manager.hpp"
#include "musher/test/modules/motion/harness.hpp"
#include "musher/test/modules/motion/robot_rig.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::motion::testing::motion_process_test {

using ::testing::HasSubstr;

constexpr int kLying = 7;

TEST(MotionProcess, StandsWalksASquareAndLiesDownForLowPower) {
  RobotRig robot;
  ASSERT_TRUE(robot.BringUp());
  const Ended stand = RunProgram("musher-motion", {"result", "111"});
  EXPECT_EQ(stand.exit, 0) << stand.out;
  EXPECT_THAT(stand.out, HasSubstr("motion 111 (RECOVERYSTAND) is done"));

  const Ended walk = RunProgram("musher-motion", {"walk", "--square", "0.1", "--speed", "0.5"});
  EXPECT_EQ(walk.exit, 0) << walk.out;
  EXPECT_THAT(walk.out, HasSubstr("walked a square of 0.10 m"));
  EXPECT_TRUE(robot.Await([](const TopicBoard& board) { return board.last.gait == 1; }))
      << "it stands at the end";

  EXPECT_TRUE(robot.controller().Switch("LowPower").done());
  robot.OnBoard([](TopicBoard& board) { EXPECT_EQ(board.board.report.mode, kLying); });
  const Ended flip = RunProgram("musher-motion", {"result", "121"});
  EXPECT_EQ(flip.exit, 1);
  EXPECT_THAT(flip.out, HasSubstr("(3003)"));
  EXPECT_TRUE(robot.controller().Switch("Active").done());
  robot.OnBoard([](TopicBoard& board) {
    EXPECT_EQ(board.board.report.mode, kLying) << "nothing moves by itself";
  });
  EXPECT_EQ(robot.RequestMotion(121), (msg::MotionResultCmd::Response{121, true, 0}));
}

TEST(MotionProcess, WalksInProtectedButDoesNoFlip) {
  RobotRig robot;
  ASSERT_TRUE(robot.BringUp());
  ASSERT_TRUE(robot.controller().Switch("Protected").done());
  EXPECT_EQ(robot.RequestMotion(121), (msg::MotionResultCmd::Response{121, false, 3013}));
  const Ended walk = RunProgram("musher-motion", {"servo", "--vx", "0.3", "--seconds", "0.3"});
  EXPECT_EQ(walk.exit, 0) << walk.out;
  EXPECT_TRUE(robot.AwaitLog("motion 121 of App is refused"));
}

TEST(MotionProcess, ReportsThatTheBodyDidNotLieDown) {
  RobotRig robot;
  ASSERT_TRUE(robot.BringUp());
  ASSERT_TRUE(robot.RequestMotion(111).result);
  robot.OnBoard([](TopicBoard& board) { board.board.deaf = true; });
  const SwitchResult low_power = robot.controller().Switch("LowPower");
  ASSERT_EQ(low_power.actuators.size(), 1U);
  EXPECT_EQ(low_power.actuators[0].code, 3035);
  EXPECT_THAT(low_power.actuators[0].message, HasSubstr("the body does not lie"));
  EXPECT_EQ(robot.RequestMotion(111).code, 3003) << "and lets nothing move it meanwhile";
  robot.OnBoard([](TopicBoard& board) { board.board.deaf = false; });
}

TEST(MotionProcess, FailsItsSelfCheckWith3009WhenAMotorHasAnError) {
  RobotRig robot;
  ASSERT_TRUE(robot.BringUp());
  int reports = 0;
  robot.OnBoard([&](TopicBoard& board) {
    board.board.report.motor_error[3] = 11;
    reports = board.reports;
  });
  ASSERT_TRUE(robot.Await([&](const TopicBoard& board) { return board.reports > reports + 5; }));
  const SwitchResult check = robot.controller().Switch("SelfCheck");
  ASSERT_EQ(check.actuators.size(), 1U);
  EXPECT_EQ(check.actuators[0].code, 3009);
}

TEST(MotionProcess, StopsTheBodyWhenTheStreamerCrashes) {
  RobotRig robot;
  ASSERT_TRUE(robot.BringUp());
  Process streamer({BinDir() + "/musher-motion", "servo", "--vx", "0.3", "--seconds", "600"});
  EXPECT_TRUE(robot.Await([](const TopicBoard& board) { return board.last.vel[0] > 0.2F; }));
  streamer.Signal(SIGKILL);
  EXPECT_TRUE(robot.Await([](const TopicBoard& board) { return board.last.gait == 1; }));
  EXPECT_TRUE(robot.AwaitLog("no frame for 200 ms"));
}

// It walked on by itself when a laptop was opened again.
TEST(MotionProcess, DoesNotWalkOnOnceAStreamerThatWasStoppedRunsAgain) {
  constexpr int kReports = 300;  // of six seconds
  RobotRig robot;
  ASSERT_TRUE(robot.BringUp());
  Process streamer({BinDir() + "/musher-motion", "servo", "--vx", "0.3", "--seconds", "600"});
  EXPECT_TRUE(robot.Await([](const TopicBoard& board) { return board.last.vel[0] > 0.2F; }));
  streamer.Signal(SIGSTOP);
  EXPECT_TRUE(robot.Await([](const TopicBoard& board) { return board.last.gait == 1; }));
  int reports = 0;
  robot.OnBoard([&](TopicBoard& board) { reports = board.reports; });
  ASSERT_TRUE(
      robot.Await([&](const TopicBoard& board) { return board.reports > reports + kReports; }));
  streamer.Signal(SIGCONT);
  EXPECT_TRUE(streamer.AwaitError("this command could not run for "));
  EXPECT_EQ(streamer.Wait().exit, 1);
  robot.OnBoard([](TopicBoard& board) { EXPECT_EQ(board.last.gait, 1); });
}

TEST(MotionProcess, StopsTheBodyWhenTheStreamerIsInterrupted) {
  RobotRig robot;
  ASSERT_TRUE(robot.BringUp());
  robot.SubscribeToFrames();
  Process streamer({BinDir() + "/musher-motion", "servo", "--vx", "0.3", "--seconds", "600"});
  EXPECT_TRUE(robot.AwaitFrame(msg::MotionServoCmd::kData));
  EXPECT_TRUE(robot.Await([](const TopicBoard& board) { return board.last.vel[0] > 0.2F; }));
  streamer.Signal(SIGINT);
  EXPECT_EQ(streamer.Wait().exit, 130);
  EXPECT_TRUE(robot.AwaitFrame(msg::MotionServoCmd::kEnd)) << "the watchdog is not needed";
  EXPECT_TRUE(robot.Await([](const TopicBoard& board) { return board.last.gait == 1; }));
}

TEST(MotionProcess, DoesNotConfirmAnEmergencyStopBeforeItsBoardReportsIt) {
  RobotRig robot;
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  robot.OnBoard([](TopicBoard& board) { board.board.deaf = true; });
  const Ended stop = RunProgram("musher", {"--timeout", "10", "estop"});
  EXPECT_EQ(stop.exit, 1) << stop.out;
  EXPECT_THAT(stop.out, HasSubstr("motion_manager"));
  EXPECT_THAT(stop.out, HasSubstr("the motion board has not taken the stop: it reports mode 7"));
  robot.OnBoard([](TopicBoard& board) { board.board.deaf = false; });
  const Ended again = RunProgram("musher", {"--timeout", "30", "estop"});
  EXPECT_EQ(again.exit, 0) << again.out;
  EXPECT_EQ(RunProgram("musher", {"--timeout", "30", "estop", "--release"}).exit, 0);
}

TEST(MotionProcess, ReportsThePlacesOfErrorsInAFile) {
  TempFolder folder;
  const Ended ran = RunProgram("musher-motion-manager",
                               {"--actuator", "motion_manager", "--config",
                                SourceDir() + "/config/cyberdog.toml", folder / "absent.toml"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr("absent.toml: error: the file cannot be read"));
}

TEST(MotionTool, ReportsACommandLineError) {
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{},
                                                {"fly"},
                                                {"result"},
                                                {"result", "stand"},
                                                {"walk", "--square", "nan"},
                                                {"servo", "--seconds", "-1"},
                                                {"servo", "--vx", "inf"},
                                                {"result", "111", "--source", "unknown"},
                                                {"status", "--clock", "sun"}}) {
    const Ended ran = RunProgram("musher-motion", wrong);
    EXPECT_EQ(ran.exit, 2) << ran.out;
    EXPECT_THAT(ran.out, HasSubstr("musher-motion: "));
  }
}

TEST(MotionTool, ListsTheTable) {
  const Ended text = RunProgram("musher-motion", {"list"});
  EXPECT_EQ(text.exit, 0);
  EXPECT_THAT(text.out, HasSubstr("121  BACK_FLIP"));
  const Ended json = RunProgram("musher-motion", {"list", "--json"});
  EXPECT_THAT(json.out, HasSubstr("\"WALK_USERTROT\""));
}

TEST(MotionTool, ReportsThatThereIsNoMotionManager) {
  const std::string domain = std::to_string(transport::TestDomain());
  const Ended ran =
      RunProgram("musher-motion", {"--namespace", "nowhere_at_all", "--domain", domain, "status"});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.out, HasSubstr("no motion manager in namespace 'nowhere_at_all'"));
}

// The class of the motion manager over DDS, without a machine, and a body that stands.
class MotionManagerSetUp : public ::testing::Test {
 protected:
  MotionManagerSetUp() {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    node_ = transport::NodeThread::Start().value();
    node_->RunOnLoop([&] {
      board_ = std::make_unique<TopicBoard>(node_->node());
      board_->board.report.mode = TheTable().Find(kRecoveryStand)->mode;
      board_->board.report.bar = 100;
    });
    config_.board_silent = std::chrono::seconds(5);
    config_.board_feedback = std::chrono::seconds(2);
    manager_ = std::make_unique<MotionManager>("motion_manager", config_, TheTable());
    harness_ = std::make_unique<CallbackHarness>(*manager_);
  }
  ~MotionManagerSetUp() override {
    harness_.reset();
    manager_.reset();
    node_->RunOnLoop([&] { board_.reset(); });
  }
  void SetUp() override {
    const musher::ConfigReading robot =
        musher::ReadConfigFile(SourceDir() + "/config/cyberdog2.toml");
    ASSERT_TRUE(robot.config);
    ASSERT_TRUE(harness_->Adopt(*robot.config));
    harness_->SetNode(node_);
  }
  bool AwaitMode(int mode) {
    const Error another{kCodeTimeout, "the body is in another mode"};
    return program::AwaitOnLoop(
               *node_, std::chrono::seconds(120),
               [&] { return board_->board.report.mode == mode ? Ok() : Result<>(another); },
               [] { return false; })
        .ok();
  }

  std::shared_ptr<transport::NodeThread> node_;
  std::unique_ptr<TopicBoard> board_;
  MotionConfig config_;
  std::unique_ptr<MotionManager> manager_;
  std::unique_ptr<CallbackHarness> harness_;
};

TEST_F(MotionManagerSetUp, LetsABodyStandAfterAnEmergencyStopThatWasReleasedBefore) {
  ASSERT_TRUE(harness_->EmergencyStop());  // and released
  ASSERT_TRUE(harness_->Run(kSetUp));
  EXPECT_TRUE(harness_->Run(kLowPower)) << "it is not stopped";
  EXPECT_TRUE(AwaitMode(kLying));
}

TEST_F(MotionManagerSetUp, StopsTheBodyDuringAnEmergencyStop) {
  ActuatorReport report;
  report.emergency_stop = 1;
  harness_->SetReport(report);
  ASSERT_TRUE(harness_->EmergencyStop());
  ASSERT_TRUE(harness_->Run(kSetUp));
  EXPECT_TRUE(AwaitMode(0));
}

}  // namespace musher::motion::testing::motion_process_test
