// The motion manager and the simulated body, with the datagrams of LCM between them, in real time
// and on the loopback of this computer; and the motion board of a world alone. What holds for every
// kind of board is in motion_board_test.cpp.

#include <gmock/gmock.h>

#include <chrono>
#include <optional>

#include "musher/modules/motion/lcm_backend.hpp"
#include "musher/modules/motion/motion_shell.hpp"
#include "musher/modules/world/process/world_host.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/lcm_group.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/test/transport/suspended_node.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/lcm_type.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher_lcm/robot_control_response_lcmt.hpp"

namespace musher::world::lcm_board_test {

using std::chrono::seconds;
using ::testing::HasSubstr;
using ::testing::Not;

class LcmBoard : public ::testing::Test {
 protected:
  LcmBoard() {
    BoardSpec& board = scene_.motion_board;
    board.lcm = true;
    board.command_url = transport::NextTestLcmUrl();
    board.response_url = transport::NextTestLcmUrl();
    board.localization_url = transport::NextTestLcmUrl();
    board.network_interface = "lo";
    config_.board = motion::BoardKind::kLcm;
    config_.lcm = {board.command_url, board.response_url, board.localization_url, "lo", 0, ""};
  }
  void StartWorld() {
    HostOptions options;
    options.log = [this](const std::string& line) { log_ += "world: " + line + "\n"; };
    options.in_background = [](const std::function<void()>& work) { work(); };
    options.shooter = &shooter_;
    auto world = WorldHost::Start(*node_, scene_, options);
    ASSERT_TRUE(world) << world.error().message;
    world_ = std::move(world).value();
  }
  void StartMotion() {
    auto shell = motion::MotionShell::Make(
        {*node_, *clock_, Table(), config_, "", [](const std::string&) -> Result<> { return Ok(); },
         [this](const std::string& line) { log_ += "motion: " + line + "\n"; }},
        [this](motion::MotionBackend::OnBody on_body) { return Backend(std::move(on_body)); });
    ASSERT_TRUE(shell) << shell.error().message;
    motion_ = std::move(shell).value();
    motion_->Do(motion::motion_event::Opened{});
  }
  Result<std::unique_ptr<motion::MotionBackend>> Backend(motion::MotionBackend::OnBody on_body) {
    motion::LcmBackend::Events events;
    events.on_body = [this, on_body](const motion::BodyState& body) {
      last_ = body;
      ++reports_;
      on_body(body);
    };
    events.on_restart = [] {};
    events.on_held = [](const std::string&) {};
    events.on_fault = [this](std::int32_t, const std::string& text) { log_ += text + "\n"; };
    return std::unique_ptr<motion::MotionBackend>(
        std::make_unique<motion::LcmBackend>(backend_loop_, *clock_, config_, std::move(events)));
  }
  bool RunUntil(const std::function<bool()>& done) {
    return loop_.RunUntil(done, testing::In(seconds(60)));
  }
  void Servo(float speed) {
    motion::ServoCommand command;
    command.requested.id = motion::kUserTrot;
    command.requested.arguments.vel_des = {speed, 0, 0};
    motion_->Do(motion::motion_event::ServoArrived{command});
  }
  static const motion::MotionTable& Table() {
    static const motion::MotionTable table =
        motion::ReadTableFile(SourceDir() + "/config/motion/motions.toml").table.value();
    return table;
  }

  transport::LinuxEventLoop loop_;
  testing::SuspendedLoop backend_loop_{loop_};
  std::unique_ptr<transport::Node> node_ =
      transport::MakeDdsNode(loop_, {.domain_id = transport::TestDomain()}).value();
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(loop_);
  std::string log_;
  Scene scene_ = EmptyYard();
  motion::MotionConfig config_;
  PromptWorker shooter_;
  std::unique_ptr<WorldHost> world_;
  motion::BodyState last_;
  int reports_ = 0;
  std::unique_ptr<motion::MotionShell> motion_;
};

TEST_F(LcmBoard, WalksTheBodyByTheMotionManager) {
  StartWorld();
  StartMotion();
  ASSERT_TRUE(RunUntil([&] { return reports_ > 15; })) << log_;
  const auto stream = loop_.Every(Milliseconds(50), [&] { Servo(0.5F); });
  EXPECT_TRUE(RunUntil([&] { return last_.motion.X_OB.translation().x() > 0.3; })) << log_;
  EXPECT_EQ(world_->world().body().gait(), 27);
  EXPECT_GT(last_.motion.v_B.x(), 0.2);
  EXPECT_GT(last_.report.motor_temperature[0], 10);
}

TEST_F(LcmBoard, LiesDownWithoutFramesAndStandsUpByThemAgain) {
  StartWorld();
  StartMotion();
  ASSERT_TRUE(RunUntil([&] { return reports_ > 15; })) << log_;
  EXPECT_EQ(world_->world().body().mode(), 12) << "it is held standing";
  motion_.reset();
  EXPECT_TRUE(RunUntil([&] { return world_->world().body().mode() == 7; })) << log_;
  EXPECT_THAT(log_, HasSubstr("no frame for 500 ms"));
  StartMotion();
  std::optional<bool> done;
  reports_ = 0;
  ASSERT_TRUE(RunUntil([&] { return reports_ > 15; }));
  motion_->Do(motion::motion_event::PlayArrived{0, 0, {{motion::kRecoveryStand, {}}}});
  EXPECT_TRUE(RunUntil([&] { return world_->world().body().mode() == 12; })) << log_;
}

TEST_F(LcmBoard, LetsABodyLieThatStoodBeforeItsBoardWasStartedAgain) {
  scene_.start_standing = false;
  StartWorld();
  StartMotion();
  ASSERT_TRUE(RunUntil([&] { return reports_ > 15; })) << log_;
  motion_->Do(motion::motion_event::PlayArrived{0, 0, {{motion::kRecoveryStand, {}}}});
  ASSERT_TRUE(RunUntil([&] { return last_.report.mode == 12 && last_.report.bar == 100; })) << log_;
  world_.reset();
  const auto end = loop_.Now() + Milliseconds(300);
  loop_.RunUntil([&] { return loop_.Now() > end; }, testing::In(seconds(60)));
  StartWorld();
  reports_ = 0;
  ASSERT_TRUE(RunUntil([&] { return reports_ > 100; })) << log_;
  EXPECT_EQ(world_->world().body().mode(), 7) << log_;
  EXPECT_THAT(log_, Not(HasSubstr("lies down"))) << "the manager sends heartbeats";
}

TEST_F(LcmBoard, TakesAFrameOfModeMinusOneAsAHeartbeatOnly) {
  StartWorld();
  const auto manager = transport::LcmSocket::Open(
                           loop_, {transport::ReadLcmUrl(config_.lcm.command_url).value(), "lo", 0},
                           [](const transport::LcmSample&) {})
                           .value();
  motion::BodyCommand frame;
  frame.mode = 12;
  const auto sending = loop_.Every(Milliseconds(20), [&] {
    ++frame.life_count;
    static_cast<void>(manager->Send(motion::kCommandChannel, motion::EncodeCommand(frame)));
    frame.mode = -1;
  });
  EXPECT_TRUE(RunUntil([&] { return world_->world().now() > seconds(2); })) << log_;
  EXPECT_EQ(world_->world().body().mode(), 12);
  EXPECT_THAT(log_, Not(HasSubstr("refused")));
  EXPECT_THAT(log_, Not(HasSubstr("lies down")));
}

// It stands, and answers.
class LcmBoardThatTakesNothing : public LcmBoard {
 protected:
  LcmBoardThatTakesNothing() {
    response_.mode = 12;
    sending_ = loop_.Every(Milliseconds(20), [this] {
      static_cast<void>(
          responses_->Send("robot_control_response", transport::EncodeLcm(response_)));
    });
  }
  std::unique_ptr<transport::LcmSocket> Open(const std::string& url,
                                             transport::LcmSocket::OnSample on_sample) {
    return transport::LcmSocket::Open(loop_, {transport::ReadLcmUrl(url).value(), "lo", 0},
                                      std::move(on_sample))
        .value();
  }
  void OnCommand(const transport::LcmSample& sample) {
    const auto frame = motion::DecodeCommand(sample.packet->data);
    if (frame && frame.value().mode == 16) ++jumps_;
  }
  void RequestAJump() {
    StartMotion();
    ASSERT_TRUE(RunUntil([&] { return reports_ > 30; })) << log_;
    motion_->Do(motion::motion_event::PlayArrived{0, 0, {{132, {}}}});
  }
  void ExpectNoJumpFromNowOn() {
    const auto end = loop_.Now() + Milliseconds(40);  // datagrams on their way
    loop_.RunUntil([&] { return loop_.Now() > end; }, testing::In(seconds(60)));
    jumps_ = 0;
    reports_ = 0;
    ASSERT_TRUE(RunUntil([&] { return reports_ > 30; })) << log_;
    EXPECT_EQ(jumps_, 0);
  }

  int jumps_ = 0;
  musher_lcm::robot_control_response_lcmt response_{};
  std::unique_ptr<transport::LcmSocket> responses_ =
      Open(config_.lcm.response_url, [](const transport::LcmSample&) {});
  std::unique_ptr<transport::LcmSocket> commands_ =
      Open(config_.lcm.command_url, [this](const transport::LcmSample& s) { OnCommand(s); });
  transport::LoopHandlePtr sending_;
};

TEST_F(LcmBoardThatTakesNothing, GetsACommandNoLongerThatHasBeenAnsweredAsFailed) {
  RequestAJump();
  ASSERT_TRUE(RunUntil([&] { return log_.find("has not taken it") != std::string::npos; }));
  EXPECT_GT(jumps_, 0);
  ExpectNoJumpFromNowOn();
}

// It would have jumped when the computer ran again.
TEST_F(LcmBoardThatTakesNothing, GetsACommandNoLongerAfterWhichTheComputerWasSuspended) {
  config_.board_feedback = seconds(60);
  RequestAJump();
  ASSERT_TRUE(RunUntil([&] { return jumps_ > 2; })) << log_;
  backend_loop_.suspended += std::chrono::hours(1);
  ExpectNoJumpFromNowOn();
}

TEST_F(LcmBoard, DoesNotLieDownWhereTimeIsFasterThanItsHeartbeats) {
  scene_.speed = 15;  // a frame of each 50 ms is 750 ms of world time after the last one
  StartWorld();
  StartMotion();
  EXPECT_TRUE(RunUntil([&] { return world_->world().now() > seconds(20); })) << log_;
  EXPECT_EQ(world_->world().body().mode(), 12) << log_;
  EXPECT_THAT(log_, Not(HasSubstr("lies down")));
}

TEST_F(LcmBoard, LiesDownAfterAJumpWhoseManagerHasEnded) {
  scene_.motion_times = {{16, 1, seconds(2)}};
  StartWorld();
  StartMotion();
  // The frames that hold it let it stand up once more.
  ASSERT_TRUE(RunUntil([&] { return reports_ > 50 && last_.report.bar == 100; })) << log_;
  motion_->Do(motion::motion_event::PlayArrived{0, 0, {{132, {}}}});
  ASSERT_TRUE(RunUntil([&] { return world_->world().body().in_the_air(); })) << log_;
  motion_.reset();
  EXPECT_TRUE(RunUntil([&] { return world_->world().body().mode() == 7; })) << log_;
  EXPECT_THAT(log_, HasSubstr("no frame for 500 ms"));
}

TEST_F(LcmBoard, ReportsABodyThatIsTiltedAsDamped) {
  StartWorld();
  StartMotion();
  auto fault = transport::MakePublisher<msg::String>(*node_, "world/fault").value();
  const auto sending = loop_.Every(Milliseconds(100), [&] {
    msg::String text;
    text.data = "orientation";
    static_cast<void>(fault->Publish(text));
  });
  EXPECT_TRUE(RunUntil([&] { return last_.report.switch_status == 3; })) << log_;
  EXPECT_EQ(last_.report.ori_error, 1);
}

TEST(LcmBoardScene, ReadsItsKeys) {
  const SceneReading reading = ReadSceneText(
      "[motion_board]\nkind = \"lcm\"\ncommand_url = \"udpm://239.1.2.3:1\"\ninterface = \"lo\"\n"
      "ttl = 1\n",
      "scene.toml");
  ASSERT_TRUE(reading.scene);
  EXPECT_TRUE(reading.scene->motion_board.lcm);
  EXPECT_EQ(reading.scene->motion_board.command_url, "udpm://239.1.2.3:1");
  EXPECT_EQ(reading.scene->motion_board.response_url, "udpm://239.255.76.67:7670");
  EXPECT_EQ(reading.scene->motion_board.network_interface, "lo");
  EXPECT_EQ(reading.scene->motion_board.ttl, 1);
  const SceneReading wrong =
      ReadSceneText("[motion_board]\nresponse_url = \"239.1.2.3:1\"\n", "scene.toml");
  ASSERT_EQ(wrong.diagnostics.size(), 1U);
  EXPECT_EQ(wrong.diagnostics[0].line, 2);
}

}  // namespace musher::world::lcm_board_test
