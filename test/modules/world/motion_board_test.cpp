// The contract between the motion manager and a motion board, the same for each kind of board: on
// topics, and on LCM with its datagrams on the loopback of this computer. Every motion of the
// robot's table is requested as its app does, on the simulated network and in virtual time.

#include <gmock/gmock.h>

#include <optional>
#include <ostream>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/motion/lcm_backend.hpp"
#include "musher/modules/motion/motion_shell.hpp"
#include "musher/modules/motion/motion_table.hpp"
#include "musher/modules/motion/topic_backend.hpp"
#include "musher/modules/world/process/world_host.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/socket_node.hpp"
#include "musher/test/support/lcm_group.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/sim/network.hpp"

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
      return Made(
          motion::LcmBackend::Make(robot_->loop(), *clock_, config_, std::move(events)).value());
    }
    return Made(motion::TopicBackend::Make(*robot_, "", std::move(on_body)).value());
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
  void Stream(Duration duration, float speed) {
    for (const Time end = network_.now() + duration; network_.now() < end;) {
      motion::ServoCommand command;
      command.requested.id = motion::kUserTrot;
      command.requested.arguments.vel_des = {speed, 0, 0};
      motion_->Do(motion::motion_event::ServoArrived{command});
      network_.RunFor(Milliseconds(50));
    }
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
    EXPECT_EQ(Do(motion.id, takes_duration ? 1000 : 0), 0) << motion.id << " " << motion.name;
    if (motion.id == motion::kEmergencyStop) {
      EXPECT_EQ(Do(motion::kRecoveryStand, 0), 0);  // releases it
    }
  }
  EXPECT_EQ(log_.find("refused"), std::string::npos) << log_.substr(0, 1000);
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

TEST_P(MotionBoard, ReportsToTheAppWhyABodyThatIsLiftedDoesNotMove) {
  ASSERT_EQ(Do(motion::kRecoveryStand), 0);
  network_.RunFor(seconds(1));
  SetFault("lifted");
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 3024);
  SetFault("none");
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 0);
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

}  // namespace musher::world::motion_board_test
