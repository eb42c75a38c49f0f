// The simulated board under the real motion manager: every motion of the robot's table, requested
// as its app does, on the simulated network and in virtual time.

#include <gmock/gmock.h>

#include <optional>
#include <ostream>

#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/motion/motion_shell.hpp"
#include "musher/modules/motion/motion_table.hpp"
#include "musher/modules/motion/topic_backend.hpp"
#include "musher/modules/world/process/world_host.hpp"
#include "musher/test/modules/world/scenes.hpp"
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

class MotionBoard : public ::testing::Test {
 protected:
  MotionBoard() {
    HostOptions options;
    options.log = [this](const std::string& line) { log_ += "world: " + line + "\n"; };
    options.in_background = [](const std::function<void()>& work) { work(); };
    options.shooter = &shooter_;
    Scene scene = EmptyYard();
    scene.start_standing = false;
    world_ = WorldHost::Start(*world_node_, scene, options).value();
    clock_ = transport::Clock::FromTopic(*robot_).value();
    motion_ =
        motion::MotionShell::Make(
            {*robot_, *clock_, Table(), config_, "",
             [](const std::string&) -> Result<> { return Ok(); },
             [this](const std::string& line) { log_ += "motion: " + line + "\n"; }},
            [this](motion::MotionBackend::OnBody on_body) { return Backend(std::move(on_body)); })
            .value();
    client_ = transport::MakeClient<msg::MotionResultCmd>(*desk_, "motion_result_cmd").value();
    motion_->Do(motion::motion_event::Opened{});
    network_.RunFor(seconds(1));
  }

  Result<std::unique_ptr<motion::MotionBackend>> Backend(motion::MotionBackend::OnBody on_body) {
    auto backend = motion::TopicBackend::Make(*robot_, "", std::move(on_body));
    if (!backend) return backend.error();
    return std::unique_ptr<motion::MotionBackend>(std::move(backend).value());
  }

  // CyberDog's code.
  std::int32_t Do(std::int32_t id, std::int32_t duration_ms, std::vector<float> speed = {}) {
    msg::MotionResultCmd::Request request;
    request.motion_id = id;
    request.duration = duration_ms;
    request.vel_des = std::move(speed);
    std::optional<std::int32_t> code;
    client_->Call(request, seconds(300), [&](const Result<msg::MotionResultCmd::Response>& reply) {
      code = reply ? reply.value().code : reply.error().code;
    });
    network_.RunUntil([&] { return code.has_value(); }, network_.now() + seconds(400));
    return code.value_or(-1);
  }

  transport::sim::Network network_{5};
  std::string log_;
  motion::MotionConfig config_;
  PromptWorker shooter_;
  std::unique_ptr<transport::Node> world_node_ = network_.MakeNode("world");
  std::unique_ptr<transport::Node> robot_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::unique_ptr<WorldHost> world_;
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<motion::MotionShell> motion_;
  std::unique_ptr<transport::Client<msg::MotionResultCmd>> client_;
};

TEST_F(MotionBoard, HasEveryMotionOfTheRobotsTable) {
  for (const motion::Motion& motion : Table().motions()) {
    EXPECT_NE(FindMotion(motion.mode, motion.gait), nullptr) << motion.id;
  }
}

TEST_F(MotionBoard, AllowsEveryModeToFollowThatTheRobotsTableAllows) {
  constexpr std::int8_t kUnknownToTheTable = 15;
  for (const motion::Motion& motion : Table().motions()) {
    for (const std::int8_t next : motion.next) {
      if (next == kUnknownToTheTable) continue;
      EXPECT_TRUE(MayFollow(motion.mode, motion.gait, next))
          << motion.id << " may go to mode " << static_cast<int>(next);
    }
  }
}

TEST_F(MotionBoard, DoesEveryMotionWithinTheTimeThatTheRobotGivesIt) {
  for (const motion::Motion& motion : Table().motions()) {
    const bool takes_duration = motion.min_exec_time_ms <= 0;
    EXPECT_EQ(Do(motion.id, takes_duration ? 1000 : 0), 0) << motion.id << " " << motion.name;
    if (motion.id == motion::kEmergencyStop) {
      EXPECT_EQ(Do(motion::kRecoveryStand, 0), 0);  // releases it
    }
  }
  EXPECT_EQ(log_.find("refused"), std::string::npos) << log_.substr(0, 1000);
}

TEST_F(MotionBoard, WalksAsFarAsTheAppRequests) {
  ASSERT_EQ(Do(motion::kRecoveryStand, 0), 0);
  const Eigen::Vector2d before = world_->world().body().pose().position_m;
  ASSERT_EQ(Do(motion::kUserTrot, 4000, {0.5F, 0, 0}), 0);
  network_.RunFor(seconds(2));  // until it stands still
  const Eigen::Vector2d way = world_->world().body().pose().position_m - before;
  EXPECT_NEAR(way.x(), 2.0, 0.02);
  EXPECT_NEAR(way.y(), 0, 1e-6);
}

TEST_F(MotionBoard, ReportsToTheAppWhyAFaultyBodyDoesNotMove) {
  ASSERT_EQ(Do(motion::kRecoveryStand, 0), 0);
  const auto faults = transport::MakePublisher<msg::String>(*desk_, "world/fault").value();
  network_.RunFor(seconds(1));
  ASSERT_TRUE(faults->Publish({"lifted"}));
  network_.RunFor(seconds(1));
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 3024);
  ASSERT_TRUE(faults->Publish({"motor_over_heat 5"}));
  network_.RunFor(seconds(1));
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 3053);
  ASSERT_TRUE(faults->Publish({"none"}));
  network_.RunFor(seconds(1));
  EXPECT_EQ(Do(motion::kUserTrot, 1000, {0.5F, 0, 0}), 0);
}

}  // namespace musher::world::motion_board_test
