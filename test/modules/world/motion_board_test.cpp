// The contract between the motion manager and a motion board, the same for each kind of board: on
// topics, and on LCM with its datagrams on the loopback of this computer. Every motion of the
// robot's table is requested as its app does, on the simulated network and in virtual time.

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <ostream>
#include <string_view>
#include <utility>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/protocol/motion_sequence.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/yaw.hpp"
#include "musher/modules/motion/board_message.hpp"
#include "musher/modules/motion/lcm_backend.hpp"
#include "musher/modules/motion/motion_shell.hpp"
#include "musher/modules/motion/motion_table.hpp"
#include "musher/modules/motion/tool/square_walk.hpp"
#include "musher/modules/motion/topic_backend.hpp"
#include "musher/modules/motion/user_gait.hpp"
#include "musher/modules/world/process/world_host.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/socket_node.hpp"
#include "musher/test/support/lcm_group.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/lcm_type.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher_lcm/danger_states_lcmt.hpp"
#include "musher_lcm/file_send_lcmt.hpp"
#include "musher_lcm/localization_lcmt.hpp"
#include "musher_lcm/robot_control_response_lcmt.hpp"

namespace musher::world::motion_board_test {

using std::chrono::seconds;

const motion::MotionTable& Table() {
  static const motion::MotionTable table =
      motion::ReadTableFile(SourceDir() + "/config/motion/motions.toml").table.value();
  return table;
}

class MotionBoard : public ::testing::TestWithParam<motion::BoardKind> {
 protected:
  bool OnLcm() const { return GetParam() == motion::BoardKind::kLcm; }

  MotionBoard() {
    scene_.start_standing = false;
    config_.gaits = SourceDir() + "/config/motion/gaits";
    if (OnLcm()) {
      BoardSpec& board = scene_.motion_board;
      board.lcm = true;
      board.command_url = transport::NextTestLcmUrl();
      board.response_url = transport::NextTestLcmUrl();
      board.localization_url = transport::NextTestLcmUrl();
      board.network_interface = "lo";
      config_.board = motion::BoardKind::kLcm;
      config_.lcm = {board.command_url, board.response_url, board.localization_url, "lo", 0, ""};
    }
    clock_ = transport::Clock::FromTopic(*robot_).value();
    client_ = transport::MakeClient<msg::MotionResultCmd>(*desk_, "motion_result_cmd").value();
    gaits_ = transport::MakeClient<msg::MotionCustomCmd>(*desk_, "motion_custom_cmd").value();
    sequences_ =
        transport::MakeClient<msg::MotionSequenceShow>(*desk_, "motion_sequence_cmd").value();
    temperatures_ = transport::MakeClient<msg::MotorTemp>(*desk_, "motor_temp").value();
    odometry_ = transport::MakeSubscription<msg::Odometry>(
                    *desk_, "odom_out",
                    [this](const msg::Odometry& odometry, const transport::SampleInfo&) {
                      last_ = odometry;
                    })
                    .value();
    StartWorld();
    StartMotion();
  }

  void StartWorld() {
    HostOptions options;
    options.log = [this](const std::string& line) { log_ += "world: " + line + "\n"; };
    options.in_background = [](const std::function<void()>& work) { work(); };
    options.shooter = &shooter_;
    world_ = WorldHost::Start(*world_node_, scene_, options).value();
  }
  void StartMotion() {
    motion_ =
        motion::MotionShell::Make(
            {*robot_, *clock_, Table(), config_, "",
             [](const std::string&) -> Result<> { return Ok(); },
             [this](const std::string& line) { log_ += "motion: " + line + "\n"; }},
            [this](motion::MotionBackend::OnBody on_body) { return Backend(std::move(on_body)); })
            .value();
    motion_->Do(motion::motion_event::Opened{});
    network_.RunFor(seconds(1));
  }

  Result<std::unique_ptr<motion::MotionBackend>> Backend(motion::MotionBackend::OnBody on_body) {
    using Made = std::unique_ptr<motion::MotionBackend>;
    if (OnLcm()) {
      motion::LcmBackend::Events events;
      events.on_body = std::move(on_body);
      events.on_restart = [this] { motion_->Do(motion::motion_event::BoardRestarted{}); };
      events.on_held = [this](const std::string& why) {
        motion_->Do(motion::motion_event::BoardHeld{why});
      };
      events.on_fault = [this](std::int32_t code, const std::string& text) {
        motion_->Do(motion::motion_event::BoardFault{code, text});
      };
      events.on_other_gait = [this](const std::string& why) {
        motion_->Do(motion::motion_event::OtherGait{why});
      };
      return Made(std::make_unique<motion::LcmBackend>(robot_->loop(), *clock_, config_,
                                                       std::move(events)));
    }
    return Made(
        motion::TopicBackend::Make(*robot_, "", std::move(on_body),
                                   [this](std::int32_t code, const std::string& text) {
                                     motion_->Do(motion::motion_event::BoardFault{code, text});
                                   })
            .value());
  }

  template <msg::Service S>
  typename S::Response Call(transport::Client<S>& client, const typename S::Request& request) {
    std::optional<typename S::Response> reply;
    client.Call(request, seconds(300), [&](const Result<typename S::Response>& response) {
      reply = response ? response.value() : typename S::Response{};
    });
    network_.RunUntil([&] { return reply.has_value(); }, network_.now() + seconds(400));
    return reply.value_or(typename S::Response{});
  }
  // CyberDog's code.
  std::int32_t Do(std::int32_t id, std::int32_t duration_ms = 0, std::vector<float> speed = {}) {
    msg::MotionResultCmd::Request request;
    request.motion_id = id;
    request.duration = duration_ms;
    request.vel_des = std::move(speed);
    const msg::MotionResultCmd::Response response = Call(*client_, request);
    return response.result || response.code != 0 ? response.code : -1;
  }
  void Frame(const std::array<float, 3>& speed) {
    motion::ServoCommand command;
    command.requested.id = motion::kUserTrot;
    command.requested.arguments.vel_des = {speed[0], speed[1], speed[2]};
    motion_->Do(motion::motion_event::ServoArrived{command});
    network_.RunFor(Milliseconds(50));
  }
  void Stream(Duration duration, float speed) {
    for (const Time end = network_.now() + duration; network_.now() < end;) Frame({speed, 0, 0});
  }
  motion::tool::PlanarPose Odometry() const {
    const msg::Pose& pose = last_.pose.pose;
    return {{pose.position.x, pose.position.y}, msg::YawOf(pose.orientation)};
  }
  // As `musher-motion walk --square`; returns how far its end is from its beginning, by odometry.
  double WalkSquare(double side_m, double speed_m_s) {
    motion::tool::SquareWalk walk(Odometry(), side_m, speed_m_s);
    for (const Time end = network_.now() + seconds(120); !walk.done() && network_.now() < end;) {
      Frame(walk.Step(Odometry()));
    }
    EXPECT_TRUE(walk.done());
    network_.RunFor(seconds(2));  // until it stands still
    return walk.Gap(Odometry());
  }
  // As in LowPower, OTA and TearDown. CyberDog's code.
  std::int32_t LieDown(const State& state, std::int32_t id) {
    motion_->Do(motion::motion_event::Closed{state});
    std::optional<std::int32_t> code;
    motion_->LieDown(id, 0, [&](const motion::motion_action::Answer& a) { code = a.code; });
    network_.RunUntil([&] { return code.has_value(); }, network_.now() + seconds(60));
    return code.value_or(-1);
  }
  void SetFault(const std::string& fault) {
    static_cast<void>(faults_->Publish({fault}));
    network_.RunFor(seconds(1));
  }
  const Body& TheBody() const { return world_->world().body(); }
  double SpeedOfBody() const { return TheBody().speed().norm(); }

  transport::sim::Network network_{5};
  std::string log_;
  Scene scene_ = EmptyYard();
  motion::MotionConfig config_;
  PromptWorker shooter_;
  std::unique_ptr<transport::Node> world_node_ =
      std::make_unique<transport::SocketNode>(network_.MakeNode("world"));
  std::unique_ptr<transport::Node> robot_ =
      std::make_unique<transport::SocketNode>(network_.MakeNode("robot"));
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::unique_ptr<WorldHost> world_;
  std::unique_ptr<transport::Clock> clock_;
  msg::Odometry last_;
  std::unique_ptr<transport::Client<msg::MotionResultCmd>> client_;
  std::unique_ptr<transport::Client<msg::MotionCustomCmd>> gaits_;
  std::unique_ptr<transport::Client<msg::MotionSequenceShow>> sequences_;
  std::unique_ptr<transport::Client<msg::MotorTemp>> temperatures_;
  std::unique_ptr<transport::Publisher<msg::String>> faults_ =
      transport::MakePublisher<msg::String>(*desk_, "world/fault").value();
  std::unique_ptr<transport::Subscription> odometry_;
  std::unique_ptr<motion::MotionShell> motion_;
};

INSTANTIATE_TEST_SUITE_P(Boards, MotionBoard,
                         ::testing::Values(motion::BoardKind::kTopic, motion::BoardKind::kLcm),
                         [](const auto& kind) {
                           return kind.param == motion::BoardKind::kLcm ? "Lcm" : "Topic";
                         });

TEST(MotionBoardTable, HasEveryMotionOfTheRobotsTable) {
  for (const motion::Motion& motion : Table().motions()) {
    EXPECT_NE(FindMotion(motion.mode, motion.gait), nullptr) << motion.id;
  }
}

TEST(MotionBoardTable, AllowsEveryModeToFollowThatTheRobotsTableAllows) {
  constexpr std::int8_t kUnknownToTheTable = 15;
  for (const motion::Motion& motion : Table().motions()) {
    for (const std::int8_t next : motion.next) {
      if (next == kUnknownToTheTable) continue;
      EXPECT_TRUE(MayFollow(motion.mode, motion.gait, next))
          << motion.id << " may go to mode " << static_cast<int>(next);
    }
  }
}

TEST_P(MotionBoard, DoesEveryMotionWithinTheTimeThatTheRobotGivesIt) {
  for (const motion::Motion& motion : Table().motions()) {
    const bool takes_duration = motion.min_exec_time_ms <= 0;
    // A board that takes gaits has none yet.
    const bool undefined = motion::PlaysUserGait(motion) && OnLcm();
    EXPECT_EQ(Do(motion.id, takes_duration ? 1000 : 0), undefined ? 3031 : 0)
        << motion.id << " " << motion.name;
    if (motion.id == motion::kEmergencyStop) {
      EXPECT_EQ(Do(motion::kRecoveryStand, 0), 0);  // releases it
    }
  }
  EXPECT_EQ(log_.find("is refused: it may not"), std::string::npos) << log_.substr(0, 1000);
}

TEST_P(MotionBoard, WalksAsFarAsTheAppRequests) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  const Eigen::Vector2d before = TheBody().pose().position_m;
  ASSERT_EQ(Do(motion::kUserTrot, 4000, {0.5F, 0, 0}), 0);
  network_.RunFor(seconds(2));  // until it stands still
  const Eigen::Vector2d way = TheBody().pose().position_m - before;
  EXPECT_NEAR(way.x(), 2.0, 0.03);
  EXPECT_NEAR(way.y(), 0, 1e-6);
  EXPECT_NEAR(last_.pose.pose.position.x, TheBody().odometry().position_m.x(), 0.01);
}

TEST_P(MotionBoard, FollowsAStreamAndStopsWhenItEnds) {
  Stream(seconds(4), 0.4F);  // it stands up for it
  EXPECT_EQ(TheBody().gait(), 27);
  EXPECT_NEAR(last_.twist.twist.linear.x, 0.4, 0.05);
  network_.RunFor(seconds(1));
  EXPECT_EQ(TheBody().gait(), 1) << "WALK_STAND";
  EXPECT_NEAR(SpeedOfBody(), 0, 0.01);
}

TEST_P(MotionBoard, WalksASquareByItsOdometry) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  network_.RunFor(seconds(1));
  const Pose2 before = TheBody().pose();
  EXPECT_LT(WalkSquare(1.0, 0.3), 0.05);
  EXPECT_EQ(TheBody().gait(), 1) << "WALK_STAND";
  EXPECT_LT((TheBody().pose().position_m - before.position_m).norm(), 0.3) << "where it really is";
  EXPECT_NEAR(std::remainder(Odometry().yaw, 2 * M_PI), 0, 0.1);
}

// What `scripts/demo` requests of the body, state by state.
TEST_P(MotionBoard, GoesThroughTheDayOfTheDemo) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  EXPECT_LT(WalkSquare(2.0, 0.6), 0.3);
  Stream(seconds(2), 0.3F);
  EXPECT_EQ(LieDown(kLowPower, motion::kGetDown), 0) << log_;
  EXPECT_EQ(TheBody().mode(), 7);
  EXPECT_EQ(Do(motion::kRecoveryStand), 3003);
  EXPECT_EQ(Do(motion::kEmergencyStop), 0) << "in each state";
  motion_->Do(motion::motion_event::Opened{});
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.3F, 0, 0}), 3040);
  EXPECT_EQ(Do(motion::kRecoveryStand), 0);
  Stream(seconds(2), 0.3F);
  EXPECT_EQ(LieDown(kOta, motion::kGetDown), 0) << log_;
  motion_.reset();  // the next version
  StartMotion();
  EXPECT_EQ(TheBody().mode(), 7);
  EXPECT_EQ(Do(motion::kRecoveryStand), 0);
  Stream(seconds(2), 0.3F);
  EXPECT_EQ(LieDown(kTearDown, motion::kPassiveGetDown), 0) << log_;
  EXPECT_EQ(TheBody().mode(), 7);
  network_.RunFor(seconds(1));  // until it stands still
  EXPECT_NEAR(SpeedOfBody(), 0, 0.01);
}

TEST_P(MotionBoard, ReportsToTheAppWhyABodyThatIsLiftedDoesNotMove) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  network_.RunFor(seconds(1));
  SetFault("lifted");
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 3024);
  SetFault("none");
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 0);
}

TEST_P(MotionBoard, DoesNotWalkOnWhenItIsPutDown) {
  const auto set_fault = [&](const std::string& fault) {
    static_cast<void>(faults_->Publish({fault}));
  };
  const auto is_still = [&](const Eigen::Vector2d& since) {
    EXPECT_NEAR(SpeedOfBody(), 0, 0.01);
    EXPECT_LT((TheBody().pose().position_m - since).norm(), 0.1);
  };
  Stream(seconds(4), 0.4F);
  ASSERT_GT(SpeedOfBody(), 0.3);
  set_fault("lifted");
  Stream(seconds(1), 0.4F);
  const Eigen::Vector2d lifted = TheBody().pose().position_m;
  set_fault("none");
  Stream(seconds(3), 0.4F);
  is_still(lifted);  // the stream has not paused
  network_.RunFor(Milliseconds(500));
  Stream(seconds(3), 0.4F);
  ASSERT_GT(SpeedOfBody(), 0.3) << "a new stream: it walks";
  // A stream that ends while the board takes no stop.
  set_fault("lifted");
  network_.RunFor(Milliseconds(500));
  const Eigen::Vector2d again = TheBody().pose().position_m;
  set_fault("none");
  network_.RunFor(seconds(3));
  is_still(again);
}

// On LCM a motor's fault is beside the status of the motion, which the board decides on.
TEST_P(MotionBoard, NamesTheMotorThatIsTooHot) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  network_.RunFor(seconds(1));
  SetFault("motor_over_heat 5");
  EXPECT_NE(log_.find("motor 5 (front left knee)"), std::string::npos) << log_;
  const Result<> check = motion_->Check();
  ASSERT_FALSE(check);
  EXPECT_EQ(check.error().code, 3009);
  EXPECT_NE(check.error().message.find("motor 5 (front left knee) reports: too hot"),
            std::string::npos)
      << check.error().message;
  if (!OnLcm()) {
    EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 3053);
  }
}

TEST_P(MotionBoard, ReportsTheTemperaturesOfTwelveMotors) {
  network_.RunFor(seconds(2));
  const msg::MotorTemp::Response response = Call(*temperatures_, {});
  EXPECT_TRUE(response.result);
  ASSERT_EQ(response.motor_temp.size(), 12U);
  for (std::size_t i = 0; i < response.motor_temp.size(); ++i) {
    EXPECT_NEAR(response.motor_temp[i], TheBody().motor_temperature_c(i), 1) << i;
  }
}

TEST_P(MotionBoard, DefinesTheGaitOfAUserWhereItTakesGaits) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  msg::MotionCustomCmd::Request request;
  request.cmd_type = msg::MotionCustomCmd::kDefinition;
  request.motion_id = 400;
  EXPECT_EQ(Call(*gaits_, request).code, OnLcm() ? 0 : 3008) << log_;
  EXPECT_EQ(log_.find("steps of a gait") != std::string::npos, OnLcm());
  request.motion_id = motion::kUserTrot;
  EXPECT_EQ(Call(*gaits_, request).code, 3008) << "it is no gait of a user";
  request.cmd_type = msg::MotionCustomCmd::kExecution;
  request.motion_id = 400;
  EXPECT_EQ(Call(*gaits_, request).code, 0);
}

TEST_P(MotionBoard, PlaysASequenceByFootWhereItTakesGaits) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  msg::MotionSequenceShow::Request request;
  request.motion_id = 400;
  request.gait_list = {{true, false, false, true, 12}, {false, true, true, false, 12}};
  request.pace_list.emplace_back();
  request.pace_list[0].centroid.position.z = 0.01;
  request.pace_list[0].duration = 1000;
  const msg::MotionSequenceShow::Response response = Call(*sequences_, request);
  EXPECT_EQ(response.code, OnLcm() ? 0 : 3008) << response.describe;
  if (OnLcm()) {
    EXPECT_EQ(TheBody().mode(), 62);
    EXPECT_EQ(TheBody().gait(), 110);
  }
}

TEST_P(MotionBoard, StandsWhenAGaitIsRefused) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  msg::MotionSequenceShow::Request request;
  request.motion_id = 400;
  request.gait_toml = std::string(1'000'000, '#');
  request.pace_toml = "[[step]]\n";
  const msg::MotionSequenceShow::Response response = Call(*sequences_, request);
  EXPECT_EQ(response.code, OnLcm() ? 3010 : 3008);
  EXPECT_NE(response.describe, "");
  EXPECT_EQ(TheBody().mode(), 12);
  EXPECT_EQ(log_.find("of a gait"), log_.find("of a gait, ")) << "the board gets nothing";
  Stream(seconds(1), 0.2F);
  msg::MotionCustomCmd::Request definition;
  definition.motion_id = 400;
  EXPECT_EQ(Call(*gaits_, definition).code, OnLcm() ? 3011 : 3008) << "while the body walks";
}

TEST_P(MotionBoard, StatesHowFarItsOdometryMayBeWrong) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  network_.RunFor(seconds(1));
  EXPECT_NEAR(last_.pose.covariance[0], 0, 1e-4);
  EXPECT_GT(last_.twist.covariance[0], 0);
  EXPECT_GT(last_.twist.covariance[35], 0);
  ASSERT_EQ(Do(motion::kUserTrot, 4000, {0.5F, 0, 0}), 0);
  EXPECT_NEAR(std::sqrt(last_.pose.covariance[0]), 0.05 * 2.0, 0.02) << "it drifts on its way";
  EXPECT_GT(last_.pose.covariance[35], 0) << "its yaw, too";
}

TEST_P(MotionBoard, StopsInAnEmergencyAndKeepsTheStop) {
  Stream(seconds(4), 0.4F);
  EXPECT_EQ(Do(motion::kEmergencyStop), 0);
  EXPECT_EQ(TheBody().mode(), 0);
  network_.RunFor(seconds(1));  // until it stands still
  EXPECT_NEAR(SpeedOfBody(), 0, 0.01);
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 3040);
  EXPECT_EQ(Do(motion::kGetDown), 3040);
  network_.RunFor(seconds(10));
  EXPECT_EQ(TheBody().mode(), 0);
  EXPECT_EQ(Do(motion::kRecoveryStand), 0);
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 0);
}

TEST_P(MotionBoard, DoesNotWalkOnWithoutItsManager) {
  Stream(seconds(4), 0.4F);
  ASSERT_GT(SpeedOfBody(), 0.3);
  motion_.reset();
  network_.RunFor(seconds(3));
  EXPECT_NEAR(SpeedOfBody(), 0, 0.01);
}

TEST_P(MotionBoard, LetsABodyLieAtTheStartOfItsManager) {
  motion_.reset();
  StartMotion();
  network_.RunFor(seconds(3));
  EXPECT_EQ(TheBody().mode(), 7);
}

TEST_P(MotionBoard, LetsABodyStandAtANewStartOfItsManager) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  network_.RunFor(seconds(1));
  motion_.reset();
  network_.RunFor(Milliseconds(200));
  StartMotion();
  network_.RunFor(seconds(3));
  EXPECT_EQ(TheBody().mode(), 12);
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 0);
}

TEST_P(MotionBoard, RefusesMotionsOfASilentBoard) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  // Time is that of the world: without it, the manager's clock stands, too.
  motion_.reset();
  clock_ = transport::Clock::Steady(robot_->loop());
  StartMotion();
  world_.reset();
  network_.RunFor(seconds(1));
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 3035);
  const msg::MotorTemp::Response response = Call(*temperatures_, {});
  EXPECT_FALSE(response.result);
  EXPECT_EQ(response.code, 3035);
}

// --- what comes from the network ---

struct BadDatagrams {
  std::string name;
  std::string channel;
  std::string log;  // that names them, with its code
  std::function<std::vector<std::byte>()> bytes;
  int times = 1;
};

class MotionBoardBadInput : public MotionBoard {
 protected:
  // Of the same host as the board; the board goes on.
  void Inject(const BadDatagrams& bad, const std::string& url) {
    const auto sender =
        transport::LcmSocket::Open(robot_->loop(), {transport::ReadLcmUrl(url).value(), "lo", 0},
                                   [](const transport::LcmSample&) {})
            .value();
    for (int i = 0; i < bad.times; ++i) {
      ASSERT_TRUE(sender->Send(bad.channel, bad.bytes()));
      if (i % 10 == 9) network_.RunFor(Milliseconds(1));
    }
    network_.RunFor(seconds(1));
  }
  // Datagrams as they are.
  void InjectRaw(const std::vector<std::string>& datagrams, const std::string& url) {
    const transport::RawLcmSender sender(url);
    for (const std::string& datagram : datagrams) ASSERT_TRUE(sender.Send(datagram));
    network_.RunFor(seconds(1));
  }
};

INSTANTIATE_TEST_SUITE_P(Boards, MotionBoardBadInput, ::testing::Values(motion::BoardKind::kLcm),
                         [](const auto&) { return "Lcm"; });

// Motion 400 would execute the other one.
TEST_P(MotionBoardBadInput, OfAnotherProgramsGaitEndsTheOneThatWasDefined) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  msg::MotionCustomCmd::Request request;
  request.cmd_type = msg::MotionCustomCmd::kDefinition;
  request.motion_id = 400;
  ASSERT_EQ(Call(*gaits_, request).code, 0) << log_;
  Inject({"the gait of another program", "user_gait_file", "",
          [] { return motion::EncodeGaitFile("# Gait Def\n").value(); }},
         config_.lcm.command_url);
  EXPECT_NE(log_.find("another program has given the motion board a gait: 127.0.0.1:"),
            std::string::npos)
      << log_;
  request.cmd_type = msg::MotionCustomCmd::kExecution;
  EXPECT_EQ(Call(*gaits_, request).code, 3031);
  EXPECT_EQ(TheBody().mode(), 12);
  request.cmd_type = msg::MotionCustomCmd::kDefinition;
  EXPECT_EQ(Call(*gaits_, request).code, 0) << "the board has answered to both";
  request.cmd_type = msg::MotionCustomCmd::kExecution;
  EXPECT_EQ(Call(*gaits_, request).code, 0);
}

// The library of LCM sends a text of more than 64 KiB in several datagrams, and its board gets it.
TEST_P(MotionBoardBadInput, OfAnotherProgramsGaitOfAMegabyteEndsTheOneThatWasDefined) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  msg::MotionCustomCmd::Request request;
  request.cmd_type = msg::MotionCustomCmd::kDefinition;
  request.motion_id = 400;
  ASSERT_EQ(Call(*gaits_, request).code, 0) << log_;
  using std::string_view_literals::operator""sv;
  std::string first("LC03\0\0\0\1\0\x10\0\0\0\0\0\0\0\0\0\x11user_gait_file\0"sv);
  first.resize(60'000, '#');
  std::string later("LC03\0\0\0\1\0\x10\0\0\0\0\xFF\0\0\1\0\x11"sv);
  later.resize(60'000, '#');
  InjectRaw({first, later}, config_.lcm.command_url);
  EXPECT_NE(log_.find("another program has given the motion board a gait: 127.0.0.1:"),
            std::string::npos)
      << log_;
  request.cmd_type = msg::MotionCustomCmd::kExecution;
  EXPECT_EQ(Call(*gaits_, request).code, 3031);
  EXPECT_EQ(TheBody().mode(), 12);
}

// The length of a text that the code of lcm-gen would trust.
TEST_P(MotionBoardBadInput, OfATextOfAWrongLengthIsRefusedByTheBoard) {
  for (const std::int32_t length : {0, -5, std::numeric_limits<std::int32_t>::min(), 1000}) {
    SCOPED_TRACE(length);
    log_.clear();
    Inject({"a gait", "user_gait_file", "",
            [&] {
              auto bytes = transport::EncodeLcm(musher_lcm::file_send_lcmt{"# Gait Def\n"});
              for (int i = 0; i < 4; ++i) {
                bytes[8 + i] =
                    static_cast<std::byte>(static_cast<std::uint32_t>(length) >> (24 - 8 * i));
              }
              return bytes;
            }},
           config_.lcm.command_url);
    EXPECT_NE(log_.find("its text has another length"), std::string::npos) << log_;
  }
}

TEST_P(MotionBoardBadInput, OfAFloodOfAnotherHostIsNamedAndTheBodyStands) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  const transport::RawLcmSender other(config_.lcm.response_url, "127.0.0.2");
  musher_lcm::robot_control_response_lcmt response{};
  response.mode = 7;
  const auto data = transport::EncodeLcm(response);
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    const auto bytes = transport::WriteLcmPacket({i, "robot_control_response", data}).value();
    ASSERT_TRUE(other.Send({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
    if (i % 10 == 9) network_.RunFor(Milliseconds(1));
  }
  EXPECT_NE(log_.find("messages of a motion board from 127.0.0.2:"), std::string::npos) << log_;
  EXPECT_EQ(TheBody().mode(), 12);
  EXPECT_EQ(Do(132), 3011) << "it would jump as well";
  network_.RunFor(seconds(2));
  EXPECT_EQ(TheBody().mode(), 12);
  EXPECT_EQ(Do(132), 0);
}

TEST_P(MotionBoardBadInput, NamesWhatIsNoLcmMessageInEachOfItsGroups) {
  const auto& lcm = config_.lcm;
  const std::pair<std::string, std::string> groups[] = {
      {lcm.command_url, "robot_control_cmd"},
      {lcm.response_url, "robot_control_response"},
      {lcm.localization_url, "global_to_robot"}};
  for (const auto& [url, channel] : groups) {
    SCOPED_TRACE(channel);
    InjectRaw({"junk"}, url);
    const std::string line =
        "a datagram on LCM channel '" + channel + "' is dropped: 4 bytes are no LCM message (3010)";
    EXPECT_NE(log_.find(line), std::string::npos) << log_;
  }
}

TEST_P(MotionBoardBadInput, NamesAProgramThatMovesTheMotorsDirectly) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  Inject({"frames for the motors", "motor_ctrl", "", [] { return std::vector<std::byte>(248); }},
         config_.lcm.localization_url);
  EXPECT_NE(log_.find("moves the motors directly (motor_ctrl)"), std::string::npos) << log_;
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 3011);
  const Result<> check = motion_->Check();
  ASSERT_FALSE(check);
  EXPECT_NE(check.error().message.find("restart the board"), std::string::npos);
}

TEST_P(MotionBoardBadInput, GetsACodeAndASentenceAndTheBodyStands) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  network_.RunFor(seconds(1));
  using musher_lcm::localization_lcmt;
  using musher_lcm::robot_control_response_lcmt;
  const std::string dropped = "a datagram on LCM channel ";
  const auto cut = [](std::vector<std::byte> bytes) {
    bytes.resize(bytes.size() - 1);
    return bytes;
  };
  const BadDatagrams all[] = {
      {"of a wrong length", "robot_control_response", dropped + "'robot_control_response'",
       [&] { return cut(transport::EncodeLcm(robot_control_response_lcmt{})); }},
      {"of another fingerprint", "robot_control_response", dropped + "'robot_control_response'",
       [] { return transport::EncodeLcm(musher_lcm::danger_states_lcmt{}); }},
      {"with NaN", "global_to_robot", dropped + "'global_to_robot'",
       [] {
         localization_lcmt location{};
         location.xyz[0] = NAN;
         return transport::EncodeLcm(location);
       }},
      {"of 10 kHz", "robot_control_response", "the motion board sends ",
       [] {
         robot_control_response_lcmt response{};
         response.mode = 12;
         return transport::EncodeLcm(response);
       },
       10'000},
  };
  for (const BadDatagrams& bad : all) {
    SCOPED_TRACE(bad.name);
    const bool location = bad.channel == "global_to_robot";
    Inject(bad, location ? config_.lcm.localization_url : config_.lcm.response_url);
    EXPECT_NE(log_.find(bad.log), std::string::npos) << log_;
    EXPECT_EQ(TheBody().mode(), 12);
    EXPECT_NEAR(SpeedOfBody(), 0, 0.01);
    EXPECT_FALSE(std::isnan(last_.pose.pose.position.x));
  }
  EXPECT_NE(log_.find("(3010)"), std::string::npos);
  network_.RunFor(seconds(2));
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 0) << "it goes on";
}

}  // namespace musher::world::motion_board_test
