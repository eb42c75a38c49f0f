// The real motion manager with [board] kind = "lcm", and a motion board that is written with LCM's
// own library and nothing of Musher; each as a process. The multicast groups are of this test only.

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <memory>

#include "musher/modules/motion/board_message.hpp"
#include "musher/test/modules/motion/robot_rig.hpp"
#include "musher/test/support/lcm_group.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/lcm_socket.hpp"
#include "musher/transport/lcm_type.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher_lcm/robot_control_response_lcmt.hpp"

namespace musher::motion::testing::lcm_process_test {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

class LcmProcess : public ::testing::Test {
 protected:
  LcmProcess() {
    for (int i = 0; i < 3; ++i) urls_.push_back(transport::NextTestLcmUrl());
  }
  void SetUp() override {
    transport::LinuxEventLoop loop;
    const auto opened = transport::LcmSocket::Open(
        loop, {transport::ReadLcmUrl(urls_[0]).value(), "", 0}, [](const transport::LcmSample&) {});
    if (!opened) GTEST_SKIP() << "LCM's library needs a route: " << opened.error().message;
  }
  std::string Config() const {
    return "kind = \"lcm\"\nttl = 0\ncommand_url = \"" + urls_[0] + "\"\nresponse_url = \"" +
           urls_[1] + "\"\nlocalization_url = \"" + urls_[2] + "\"\n";
  }
  // `silent_ms`: it takes frames for that time before its first response.
  std::unique_ptr<Process> StartBoard(const std::string& mode, const std::string& gait,
                                      const std::string& silent_ms = "0") const {
    std::vector<std::string> argv = {BinDir() + "/plain_board"};
    for (const std::string& url : urls_) argv.push_back(url + "?ttl=0");
    argv.insert(argv.end(), {mode, gait, silent_ms});
    auto board = std::make_unique<Process>(argv);
    EXPECT_NE(board->LineWith("board ready"), "");
    return board;
  }

  ProcessGuard guard_;  // of the boards; a RobotRig has its own
  std::vector<std::string> urls_;
};

TEST_F(LcmProcess, StandsWalksAndStopsOnABoardOfLcmsOwnLibrary) {
  const auto board = StartBoard("7", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  EXPECT_EQ(
      board->NextLine(musher::testing::In(std::chrono::seconds(120))).value_or("").substr(0, 14),
      "command mode 7")
      << "its first frame is no motion";
  EXPECT_EQ(robot.RequestMotion(111), (msg::MotionResultCmd::Response{111, true, 0}));
  EXPECT_NE(board->LineWith("command mode 12 gait 0"), "");
  const Ended walk = RunProgram("musher-motion", {"servo", "--vx", "0.3", "--seconds", "1"});
  EXPECT_EQ(walk.exit, 0) << walk.out;
  EXPECT_THAT(board->LineWith("mode 11 gait 27"), HasSubstr("speed 0.30"));
  EXPECT_THAT(board->LineWith("mode 11 gait 1"), HasSubstr("speed 0.00"));
  const Ended square = RunProgram("musher-motion", {"walk", "--square", "0.1", "--speed", "0.5"});
  EXPECT_EQ(square.exit, 0) << square.out;
  EXPECT_EQ(robot.RequestMotion(0), (msg::MotionResultCmd::Response{0, true, 0}));
  EXPECT_NE(board->LineWith("command mode 0 gait 0"), "");
}

TEST_F(LcmProcess, GivesTheGaitOfAUserToABoardOfLcmsOwnLibrary) {
  const auto board = StartBoard("12", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  msg::MotionSequenceShow::Request sequence;
  sequence.motion_id = 400;
  sequence.gait_list = {{true, false, false, true, 12}};
  sequence.pace_list.emplace_back();
  sequence.pace_list[0].right_forefoot.w = 0.05;
  sequence.pace_list[0].duration = 300;
  const auto shown = robot.Show(sequence);
  EXPECT_EQ(shown.code, 0) << shown.describe << robot.Log();
  EXPECT_EQ(board->LineWith("# Gait Def"),
            "# Gait Def|[[section]]|contact = [1, 0, 0, 1]|duration = 12|");
  EXPECT_THAT(board->LineWith("# Gait Params"), HasSubstr("|step_height = [50.0, 0.0]|"));
  EXPECT_NE(board->LineWith("command mode 62 gait 110"), "");
}

TEST_F(LcmProcess, AdoptsABodyThatWalksAndStopsIt) {
  const auto board = StartBoard("11", "27");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  EXPECT_THAT(board->LineWith("command"), HasSubstr("mode 11 gait 27"));
  EXPECT_THAT(board->LineWith("command"), HasSubstr("speed 0.00"));
}

TEST_F(LcmProcess, LetsTheBodyLieDownWhenTheManagerHangs) {
  const auto board = StartBoard("12", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  EXPECT_NE(board->LineWith("command mode 12"), "");
  const pid_t manager = robot.ManagerPid();
  ASSERT_GT(manager, 0);
  kill(manager, SIGSTOP);
  EXPECT_NE(board->LineWith("no frame: lies down"), "");
  kill(manager, SIGCONT);
}

TEST_F(LcmProcess, DoesNotConfirmAnEmergencyStopBeforeItsBoardReportsIt) {
  const auto board = StartBoard("12", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  kill(board->pid(), SIGSTOP);
  const Ended stop = RunProgram("musher", {"--timeout", "10", "estop"});
  kill(board->pid(), SIGCONT);
  EXPECT_EQ(stop.exit, 1) << stop.out;
  EXPECT_THAT(stop.out, AllOf(HasSubstr("motion_manager"), HasSubstr("the motion board")));
  EXPECT_NE(board->LineWith("command mode 0 gait 0"), "");
  const Ended again = RunProgram("musher", {"--timeout", "30", "estop"});
  EXPECT_EQ(again.exit, 0) << again.out;
  EXPECT_EQ(RunProgram("musher", {"--timeout", "30", "estop", "--release"}).exit, 0);
}

// The board lets the body lie down by its own rule meanwhile.
TEST_F(LcmProcess, KeepsAnEmergencyStopThatTheBoardHasLeftWhileTheManagerHung) {
  const auto board = StartBoard("12", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  EXPECT_EQ(RunProgram("musher", {"--timeout", "30", "estop"}).exit, 0);
  EXPECT_NE(board->LineWith("command mode 0 gait 0"), "");
  const pid_t manager = robot.ManagerPid();
  ASSERT_GT(manager, 0);
  kill(manager, SIGSTOP);
  EXPECT_NE(board->LineWith("no frame: lies down"), "");
  kill(manager, SIGCONT);
  EXPECT_NE(board->LineWith("command mode 0 gait 0"), "");
  EXPECT_EQ(RunProgram("musher", {"--timeout", "30", "estop", "--release"}).exit, 0);
}

// A second machine, of another domain, at the same board: it fails, and is shut down again.
TEST_F(LcmProcess, LeavesTheWalkOfAnotherMotionManagerAloneUpToItsTearDown) {
  const auto board = StartBoard("12", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  const Process streamer({BinDir() + "/musher-motion", "servo", "--vx", "0.3", "--seconds", "600"});
  EXPECT_NE(board->LineWith("mode 11 gait 27"), "");
  const auto domain = transport::LockFreeDomain(transport::TestDomain());
  const TempFolder folder;
  WriteRobot(folder.path(), Config());
  const auto musher = [&](const std::string& command) {
    return RunToEnd({"sh", "-c",
                     "ROS_DOMAIN_ID=" + std::to_string(domain.id) + " exec " + BinDir() +
                         "/musher --timeout 60 " + command + " 2>&1"});
  };
  const Ended up = musher("up --detach " + folder / "robot.toml");
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.out, HasSubstr("another program commands the motion board"));
  const Ended down = musher("down");
  EXPECT_THAT(down.out, HasSubstr("the body does not lie"));
  // The board itself may let a body lie down whose manager gets no CPU for half a second.
  while (const auto line = board->NextLine(musher::testing::In(Milliseconds(1)))) {
    EXPECT_THAT(*line, Not(HasSubstr("command mode 7 gait 0"))) << "passive get-down";
  }
}

// 10,000 responses a second from another port, and as much of what is no message.
TEST_F(LcmProcess, NamesAFloodAndBeginsNoMotionInIt) {
  const auto board = StartBoard("12", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  transport::LinuxEventLoop loop;
  const auto open = [&](const std::string& url) {
    return transport::LcmSocket::Open(loop, {transport::ReadLcmUrl(url).value(), "", 0},
                                      [](const transport::LcmSample&) {})
        .value();
  };
  const std::array sockets = {open(urls_[0]), open(urls_[1]), open(urls_[2])};
  const std::array channels = {kCommandChannel, kResponseChannel, kLocalizationChannel};
  musher_lcm::robot_control_response_lcmt response{};
  response.mode = 12;
  const auto bytes = transport::EncodeLcm(response);
  const std::vector<std::byte> junk(40);
  const Time end = loop.Now() + std::chrono::seconds(3);
  const auto flood = loop.Every(Milliseconds(1), [&] {
    for (int i = 0; i < 10; ++i) {
      static_cast<void>(sockets[1]->Send(kResponseChannel, bytes));
      static_cast<void>(sockets.at(i % 3)->Send(channels.at(i % 3), junk));
    }
  });
  loop.RunUntil([&] { return loop.Now() >= end; }, musher::testing::In(std::chrono::seconds(60)));
  while (const auto line = board->NextLine(musher::testing::In(Milliseconds(1)))) {
    EXPECT_THAT(*line, AnyOf(HasSubstr("command mode 12 gait 0"), HasSubstr("mode 7 gait 1"),
                             HasSubstr("no frame: lies down")))
        << "nothing but its hold";
  }
  EXPECT_TRUE(robot.AwaitLog("responses a second, expected 50")) << robot.Log();
  EXPECT_TRUE(robot.AwaitLog("fingerprint 0x0000000000000000 is not that of")) << robot.Log();
}

TEST_F(LcmProcess, DoesNotStandABodyUpThatLiesSinceItsBoardHasRestarted) {
  auto board = StartBoard("7", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  EXPECT_EQ(robot.RequestMotion(111), (msg::MotionResultCmd::Response{111, true, 0}));
  board.reset();
  board = StartBoard("7", "0", "1000");
  EXPECT_TRUE(robot.AwaitLog("has restarted")) << robot.Log();
  for (std::string line;
       (line = board->NextLine(musher::testing::In(Milliseconds(500))).value_or("")) != "";) {
    EXPECT_THAT(line, HasSubstr("mode 7"));
  }
}

TEST_F(LcmProcess, DoesNotCommandAWalkToABodyThatLiesAfterTheManagerHung) {
  const auto board = StartBoard("12", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  Process streamer({BinDir() + "/musher-motion", "servo", "--vx", "0.3", "--seconds", "60"});
  EXPECT_NE(board->LineWith("mode 11 gait 27"), "");
  const pid_t manager = robot.ManagerPid();
  ASSERT_GT(manager, 0);
  kill(manager, SIGSTOP);
  EXPECT_NE(board->LineWith("no frame: lies down"), "");
  kill(manager, SIGCONT);
  EXPECT_TRUE(robot.AwaitLog("is stopped: the body lies")) << robot.Log();
  for (std::string line;
       (line = board->NextLine(musher::testing::In(Milliseconds(1000))).value_or("")) != "";) {
    EXPECT_THAT(line, HasSubstr("mode 7"));
  }
}

TEST_F(LcmProcess, NamesAnotherProgramThatCommandsTheBoard) {
  const auto board = StartBoard("12", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  transport::LinuxEventLoop loop;
  const auto app =
      transport::LcmSocket::Open(loop, {transport::ReadLcmUrl(urls_[0]).value(), "", 0},
                                 [](const transport::LcmSample&) {})
          .value();
  BodyCommand frame;
  frame.mode = 12;
  frame.life_count = 99;
  const auto sending = loop.Every(Milliseconds(20), [&] {
    static_cast<void>(app->Send(kCommandChannel, EncodeCommand(frame)));
  });
  const std::string named = "another program commands the motion board: " + app->sender();
  EXPECT_TRUE(loop.RunUntil([&] { return robot.Log().find(named) != std::string::npos; },
                            musher::testing::In(std::chrono::seconds(120))));
  std::int32_t code = 0;
  loop.RunUntil([&] { return (code = robot.RequestMotion(132).code) != 0; },
                musher::testing::In(std::chrono::seconds(120)));
  EXPECT_EQ(code, 3011);
}

TEST_F(LcmProcess, NamesAProgramThatMovesTheMotorsOfABoardThatIgnoresStopsThen) {
  const auto board = StartBoard("12", "0");
  RobotRig robot(Config());
  ASSERT_TRUE(robot.BringUp()) << robot.Log();
  transport::LinuxEventLoop loop;
  const auto other =
      transport::LcmSocket::Open(loop, {transport::ReadLcmUrl(urls_[2]).value(), "", 0},
                                 [](const transport::LcmSample&) {})
          .value();
  ASSERT_TRUE(other->Send(kMotorChannel, std::vector<std::byte>(248)));
  EXPECT_NE(board->LineWith("motor_ctrl: commands are ignored"), "");
  const std::string named = other->sender() + " moves the motors directly";
  EXPECT_TRUE(robot.AwaitLog(named)) << robot.Log();
  EXPECT_EQ(robot.RequestMotion(111).code, 3011);
  const Ended stop = RunProgram("musher", {"--timeout", "10", "estop"});
  EXPECT_EQ(stop.exit, 1);
  EXPECT_THAT(stop.out, AllOf(HasSubstr("motion_manager"), HasSubstr("restart the board")));
  RunProgram("musher", {"--timeout", "30", "estop", "--release"});
}

// LCM's own library receives whatever is sent to its port, of every group of this host.
TEST_F(LcmProcess, IsNotDisturbedByTheSameTestInAnotherProcess) {
  const auto board = StartBoard("7", "0");
  const auto neighbour = transport::LockFreeDomain(transport::TestDomain());
  ASSERT_NE(neighbour.id, transport::TestDomain());
  transport::LinuxEventLoop loop;
  BodyCommand frame;
  frame.mode = 12;
  frame.life_count = 99;
  for (int i = 0; i < 100; ++i) {
    transport::LcmUrl url = transport::ReadLcmUrl(urls_[0]).value();
    url.group = transport::LcmGroup(neighbour.id);
    url.port = static_cast<std::uint16_t>(transport::LcmPort(neighbour.id, i));
    const auto other =
        transport::LcmSocket::Open(loop, {url, "", 0}, [](const transport::LcmSample&) {});
    ASSERT_TRUE(other) << other.error().message;
    ASSERT_TRUE(other.value()->Send(kCommandChannel, EncodeCommand(frame)));
  }
  frame.mode = 7;
  const auto own = transport::LcmSocket::Open(
      loop, {transport::ReadLcmUrl(urls_[0]).value(), "", 0}, [](const transport::LcmSample&) {});
  ASSERT_TRUE(own.value()->Send(kCommandChannel, EncodeCommand(frame)));
  EXPECT_THAT(board->LineWith("command"), HasSubstr("command mode 7"));
}

TEST_F(LcmProcess, LeavesNoMotionManagerBehindThatHangs) {
  const auto board = StartBoard("7", "0");
  pid_t manager = 0;
  {
    RobotRig robot(Config());
    ASSERT_TRUE(robot.BringUp()) << robot.Log();
    manager = robot.ManagerPid();
    ASSERT_GT(manager, 0);
    kill(manager, SIGSTOP);
  }
  EXPECT_TRUE(musher::testing::AwaitEnd(manager));
}

TEST_F(LcmProcess, LeavesNoMotionManagerBehindWhenTheTestIsKilled) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const pid_t test = fork();
  if (test == 0) {
    const auto board = StartBoard("7", "0");
    RobotRig robot(Config());
    const pid_t manager = robot.BringUp() ? robot.ManagerPid() : 0;
    if (write(ends[1], &manager, sizeof manager) > 0) pause();
    _exit(1);
  }
  pid_t manager = 0;
  ASSERT_EQ(read(ends[0], &manager, sizeof manager), static_cast<ssize_t>(sizeof manager));
  ASSERT_GT(manager, 0);
  kill(test, SIGKILL);
  waitpid(test, nullptr, 0);
  EXPECT_TRUE(musher::testing::AwaitEnd(manager));
}

TEST_F(LcmProcess, AwaitsTheNetworkToItsBoardAndSaysWhatIsMissing) {
  RobotRig robot(Config() + "interface = \"dog77\"\nwait_ms = 5000\n");
  EXPECT_FALSE(robot.BringUp());
  const std::string log = robot.Log();
  EXPECT_THAT(log, HasSubstr("this computer has no network interface 'dog77'"));
  EXPECT_THAT(log, HasSubstr("(3005)")) << "at the second try";
}

TEST_F(LcmProcess, SaysWhereItExpectsASilentBoard) {
  RobotRig robot(Config() + "wait_ms = 300\n");
  EXPECT_FALSE(robot.BringUp());
  EXPECT_THAT(robot.Log(), HasSubstr("expected on robot_control_response of " + urls_[1] + " by "));
}

}  // namespace musher::motion::testing::lcm_process_test
