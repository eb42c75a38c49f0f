// The real program over DDS: as an actuator of a machine, and alone.

#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

#include "musher/controller/machine_controller.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/rcl_interfaces/parameters.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/sensor_msgs/joint_state.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/exec/child.hpp"
#include "musher/modules/world/process/world_control.hpp"
#include "musher/modules/world/scene/humanoid_specs.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/service.hpp"

namespace musher::world::process_test {

namespace fs = std::filesystem;
using std::chrono::seconds;

constexpr const char* kRobot = R"(
[controller]
actuators = ["world"]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"]
default_time = 120000
default_state = "Uninitialized"
namespace = "dog1"
state_dir = "state"
[actuator.world]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"]
times = [120000, 120000, 120000, 120000, 120000]
command = ["musher-world", "scene.toml"]
cwd = "."
critical = true
)";

constexpr const char* kScene = R"(
speed = 5
battery.capacity_wh = 10
start.standing = true
picture.at_teardown = true
)";

class MusherWorld : public ::testing::Test {
 protected:
  MusherWorld() {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    setenv("PATH", (BinDir() + ":" + std::string(std::getenv("PATH"))).c_str(), 1);
    std::ofstream(folder_ / "robot.toml") << kRobot;
    std::ofstream(folder_ / "scene.toml") << kScene;
    node_ = transport::MakeDdsNode(loop_).value();
    clock_ = transport::Clock::FromTopic(*node_).value();
    states_ =
        transport::MakeSubscription<msg::BodyState>(
            *node_, "dog1/world/body_state",
            [this](const msg::BodyState& state, const transport::SampleInfo&) { state_ = state; })
            .value();
    commands_ =
        transport::MakePublisher<msg::MotionCustomCommand>(*node_, "dog1/world/body_command")
            .value();
  }

  bool Until(const std::function<bool()>& holds) {
    return loop_.RunUntil(holds, loop_.Now() + seconds(120));
  }
  // Without a machine.
  void StartAlone(const std::string& scene) {
    auto reaper = exec::Reaper::Start();
    ASSERT_TRUE(reaper);
    reaper_.emplace(std::move(reaper).value());
    exec::ChildSpec spec;
    spec.argv = {BinDir() + "/musher-world", scene, "--alone", "--namespace", "dog1"};
    spec.cwd = folder_.path();
    auto child = exec::Child::Start(spec, *reaper_);
    ASSERT_TRUE(child);
    child_.emplace(std::move(child).value());
  }
  // `ros2 param list` is answered by the node, which is one of ROS 2's list.
  void ExpectNoParameters(const std::string& node) {
    const auto list =
        transport::MakeClient<msg::ListParameters>(*node_, node + "/list_parameters").value();
    std::optional<Result<msg::ListParameters::Response>> answer;
    list->Call({}, seconds(120), [&](auto reply) { answer = std::move(reply); });
    ASSERT_TRUE(Until([&] { return answer.has_value(); }));
    ASSERT_TRUE(answer->ok()) << answer->error().message;
    EXPECT_TRUE(answer->value().result.names.empty());
  }
  // Time runs, and the body takes commands.
  void ExpectLife() {
    ASSERT_TRUE(Until([&] { return clock_->Now() > Time{} && commands_->MatchedReaders() > 0; }));
    const Time before = clock_->Now();
    msg::MotionCustomCommand walk;
    walk.mode = 11;
    walk.gait_id = 27;
    walk.life_count = 1;
    walk.vel_des = {0.5F, 0, 0};
    walk.duration = 1000;
    ASSERT_TRUE(commands_->Publish(walk));
    EXPECT_TRUE(Until([&] { return state_.mode == 11 && state_.order_process_bar == 100; }));
    EXPECT_GT(state_.pose.position.x, 0.3);
    // The clock is published each 20 ms: the last sample may be that old.
    EXPECT_GE(clock_->Now() - before, seconds(1) - std::chrono::milliseconds(20));
  }

  const TempFolder folder_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  msg::BodyState state_;
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<transport::Subscription> states_;
  std::unique_ptr<transport::Publisher<msg::MotionCustomCommand>> commands_;
  std::optional<exec::Reaper> reaper_;
  std::optional<exec::Child> child_;
};

// The tool published once any reader was there: with a recorder of the topic the world missed it.
TEST_F(MusherWorld, ACommandIsForTheWorldAndNotForAnotherReaderOfItsTopic) {
  int received = 0;
  const auto recorder = transport::MakeSubscription<msg::Float32>(
      *node_, "dog9/world/set_battery",
      [&received](const msg::Float32&, const transport::SampleInfo&) { ++received; });
  ASSERT_TRUE(recorder);
  const auto sent = SendWorldCommand(ChargeTo{4}, "dog9", seconds(1));
  EXPECT_FALSE(sent);
  loop_.RunUntil([] { return false; }, loop_.Now());
  EXPECT_EQ(received, 0);
}

// The same for what another module reads: it is an actuator.
TEST_F(MusherWorld, ASpokenTextAndThePowerKeyAreForAnActuatorAndNotForAnotherReader) {
  const auto other = transport::MakeDdsNode(loop_).value();
  std::vector<std::string> recorded;
  const auto speech = transport::MakeSubscription<msg::String>(
      *other, "dog9/world/speech_text", [&](const msg::String& text, const transport::SampleInfo&) {
        recorded.push_back(text.data);
      });
  const auto key = transport::MakeSubscription<msg::Bool>(
      *other, "dog9/world/power_key",
      [&](const msg::Bool&, const transport::SampleInfo&) { recorded.emplace_back("key"); });
  ASSERT_TRUE(speech && key);
  const auto sent = [](const WorldCommand& command, Duration limit = seconds(1)) {
    return SendWorldCommand(command, "dog9", limit);
  };
  const auto unreceived = sent(Speech{"sit"});
  ASSERT_FALSE(unreceived);
  EXPECT_THAT(unreceived.error().message,
              ::testing::HasSubstr("no actuator reads dog9/world/speech_text"));
  EXPECT_FALSE(sent(PowerKey{true}));
  loop_.RunUntil([] { return false; }, loop_.Now());
  EXPECT_THAT(recorded, ::testing::IsEmpty());

  const auto actuator = transport::MakePublisher<msg::ActuatorStatus>(
      *other, "dog9/musher/actuator_status", transport::kLatchedQos);
  ASSERT_TRUE(actuator);
  EXPECT_TRUE(sent(Speech{"sit"}, seconds(120)));
  EXPECT_TRUE(sent(PowerKey{true}, seconds(120)));
  EXPECT_TRUE(Until([&] { return recorded.size() == 2; }));
  EXPECT_THAT(recorded, ::testing::ElementsAre("sit", "key"));
}

TEST_F(MusherWorld, RunsThroughTheStatesOfAMachineAndDrawsAtTheEnd) {
  MachineController controller;
  ASSERT_TRUE(controller.Init(folder_ / "robot.toml"));
  const Result<> set_up = controller.AwaitSetUp();
  ASSERT_TRUE(set_up) << set_up.error().message;
  for (const BuiltInState state : {kSelfCheck, kActive, kLowPower}) {
    ASSERT_TRUE(controller.Switch(state).done()) << state;
  }
  ExpectLife();  // in LowPower, too
  const std::string picture = folder_ / "state/world.png";
  const auto draw = transport::MakeClient<msg::Trigger>(*node_, "dog1/world/draw").value();
  ASSERT_TRUE(Until([&] { return draw->Ready(); }));
  std::string answer;
  draw->Call({}, seconds(120), [&](const Result<msg::Trigger::Response>& reply) {
    answer = reply ? reply.value().message : reply.error().message;
  });
  ASSERT_TRUE(Until([&] { return !answer.empty(); }));
  EXPECT_EQ(answer, fs::canonical(picture));
  fs::remove(picture);
  EXPECT_TRUE(controller.Switch("TearDown").done());
  EXPECT_GT(fs::file_size(picture), 10'000u);
}

TEST_F(MusherWorld, RunsAloneUntilASignalAndDrawsThen) {
  ASSERT_NO_FATAL_FAILURE(StartAlone(folder_ / "scene.toml"));
  ExpectLife();
  ExpectNoParameters("dog1/world");
  child_->Signal(SIGINT);
  ASSERT_TRUE(child_->EndedBy(std::chrono::steady_clock::now() + seconds(120)));
  EXPECT_EQ(child_->Reap().number, 0);
  EXPECT_GT(fs::file_size(folder_ / "world.png"), 10'000u);
}

TEST_F(MusherWorld, IsControlledFromTheCommandLine) {
  ASSERT_NO_FATAL_FAILURE(StartAlone(folder_ / "scene.toml"));
  double percent = 0;
  const auto batteries = transport::MakeSubscription<msg::BatteryState>(
                             *node_, "dog1/world/battery",
                             [&](const msg::BatteryState& state, const transport::SampleInfo&) {
                               percent = state.percentage * 100;
                             })
                             .value();
  const auto sent = [](const std::vector<std::string>& words) -> Result<std::string> {
    const auto command = ParseWorldCommand(words);
    if (!command) return command.error();
    return SendWorldCommand(command.value(), "dog1", seconds(120));
  };
  EXPECT_TRUE(sent({"battery", "17.5"}));
  EXPECT_TRUE(Until([&] { return percent > 1 && percent < 18; }));
  EXPECT_TRUE(sent({"fault", "motor", "3"}));
  EXPECT_TRUE(Until([&] { return state_.motor_error[3] != 0; }));
  std::string spoken;
  const auto subscription = transport::MakeSubscription<msg::String>(
                                *node_, "dog1/world/speech_text",
                                [&](const msg::String& text, const auto&) { spoken = text.data; })
                                .value();
  const auto actuator = transport::MakePublisher<msg::ActuatorStatus>(
      *node_, "dog1/musher/actuator_status", transport::kLatchedQos);
  ASSERT_TRUE(actuator);
  EXPECT_TRUE(sent({"say", "good", "dog"}));
  EXPECT_TRUE(Until([&] { return spoken == "good dog"; }));
  EXPECT_TRUE(sent({"cable", "in"}));
  EXPECT_TRUE(Until([&] { return percent > 18; }));
  const auto drawn = sent({"draw"});
  ASSERT_TRUE(drawn) << drawn.error().message;
  EXPECT_EQ(drawn.value(), fs::canonical(folder_ / "world.png"));
  const auto report = sent({"referee"});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_THAT(report.value(), ::testing::HasSubstr("collisions: "));
  const auto json = sent({"referee", "--json"});
  ASSERT_TRUE(json) << json.error().message;
  EXPECT_THAT(json.value(), ::testing::StartsWith("{\"name\":"));
  EXPECT_TRUE(sent({"mark", "the", "lamp", "is", "on"}));
  EXPECT_TRUE(sent({"show", "lamp"}));
  EXPECT_TRUE(sent({"hide", "lamp"}));
  for (const std::vector<std::string>& wrong :
       std::vector<std::vector<std::string>>{{"battery", "nan"},
                                             {"battery"},
                                             {"cable", "sideways"},
                                             {"place", "1"},
                                             {"odometry", "jump", "1", "jetbot_0"},
                                             {"odometry", "melt", "jetbot_0"},
                                             {"map", "half"},
                                             {"dance"},
                                             {"say"},
                                             {"mark"},
                                             {"show"},
                                             {"referee", "json"},
                                             {"power-key", "left"}}) {
    EXPECT_FALSE(ParseWorldCommand(wrong)) << wrong[0];
  }
}

TEST_F(MusherWorld, PublishesWhatItsCamerasSeeToSubscribers) {
  ASSERT_NO_FATAL_FAILURE(StartAlone(folder_ / "scene.toml"));
  std::vector<msg::Image> seen;
  std::optional<msg::CameraInfo> info;
  const auto images = transport::MakeSubscription<msg::Image>(
                          *node_, "dog1/world/camera/right",
                          [&](const msg::Image& image, const auto&) { seen.push_back(image); },
                          transport::kSensorDataQos)
                          .value();
  const auto infos = transport::MakeSubscription<msg::CameraInfo>(
                         *node_, "dog1/world/camera/right/info",
                         [&](const msg::CameraInfo& received, const auto&) { info = received; },
                         transport::kLatchedQos)
                         .value();
  EXPECT_TRUE(Until([&] { return seen.size() >= 3 && info; }));
  ASSERT_GE(seen.size(), 3U);
  EXPECT_EQ(seen[0].data.size(), 640U * 480 * 3);
  EXPECT_EQ(seen[0].header.frame_id, "camera_right");
  EXPECT_LT(msg::FromStamp(seen[0].header.stamp), msg::FromStamp(seen[1].header.stamp));
  EXPECT_EQ(info->distortion_model, "equidistant");
  child_->Signal(SIGTERM);
  EXPECT_EQ(child_->Reap().number, 0);
}

TEST_F(MusherWorld, PlaysTheWeddingForAnySubscriber) {
  ASSERT_NO_FATAL_FAILURE(StartAlone(SourceDir() + "/config/scenes/wedding.toml"));
  msg::JointState joints;
  std::vector<std::string> gestures;
  const auto listening =
      transport::MakeSubscription<msg::JointState>(
          *node_, "dog1/wedding/motion/joint_states",
          [&](const msg::JointState& received, const auto&) { joints = received; })
          .value();
  const auto subscription =
      transport::MakeSubscription<msg::String>(
          *node_, "dog1/wedding/perception/gesture",
          [&](const msg::String& received, const auto&) { gestures.push_back(received.data); })
          .value();
  const auto poses =
      transport::MakePublisher<msg::String>(*node_, "dog1/wedding/motion/pose").value();
  ASSERT_TRUE(Until([&] { return poses->MatchedReaders() > 0; }));
  ASSERT_TRUE(poses->Publish({"heart"}));
  ASSERT_TRUE(SendWorldCommand(Speed{10}, "dog1", seconds(120)));
  const auto elbow = [&] { return joints.position.size() == kJoints ? joints.position[16] : 0; };
  EXPECT_TRUE(Until([&] { return elbow() < -1.5; })) << "the left one is bent, at " << elbow();
  const auto received = [&](const char* gesture) {
    return std::find(gestures.begin(), gestures.end(), gesture) != gestures.end();
  };
  EXPECT_TRUE(Until([&] { return received("heart") && received("v"); })) << "bride and groom";
  child_->Signal(SIGTERM);
  EXPECT_EQ(child_->Reap().number, 0);
}

TEST_F(MusherWorld, DrawsWhatACameraSeesIntoAFile) {
  const auto reaper = exec::Reaper::Start();
  ASSERT_TRUE(reaper);
  const auto shoot = [&](const std::string& camera) {
    exec::ChildSpec spec;
    spec.argv = {BinDir() + "/musher-world",
                 folder_ / "scene.toml",
                 "--shot",
                 camera,
                 folder_ / "shot.png",
                 "--for",
                 "0.5"};
    auto child = exec::Child::Start(spec, reaper.value());
    return child ? child.value().Reap().number : -1;
  };
  EXPECT_EQ(shoot("left"), 0);
  EXPECT_GT(fs::file_size(folder_ / "shot.png"), 10'000U);
  EXPECT_EQ(shoot("rear"), 2);
}

TEST_F(MusherWorld, TakesTheSeedAndTheChoicesOfARunFromItsCommandLine) {
  const auto reaper = exec::Reaper::Start();
  ASSERT_TRUE(reaper);
  std::ofstream(folder_ / "scene.toml") << "[choices]\ncode = [\"A-1\", \"A-2\"]\n";
  const auto draw = [&](std::vector<std::string> more) {
    exec::ChildSpec spec;
    spec.argv = {BinDir() + "/musher-world", folder_ / "scene.toml", "--draw",
                 folder_ / "world.png"};
    spec.argv.insert(spec.argv.end(), more.begin(), more.end());
    auto child = exec::Child::Start(spec, reaper.value());
    return child ? child.value().Reap().number : -1;
  };
  EXPECT_EQ(draw({"--seed", "7", "--choose", "code=A-2"}), 0);
  EXPECT_EQ(draw({"--choose", "code=A-3"}), 2);
  EXPECT_EQ(draw({"--choose", "code"}), 2);
  EXPECT_EQ(draw({"--seed", "-1"}), 2);
}

TEST_F(MusherWorld, EndsWithUsageErrorsForAWrongScene) {
  const auto reaper = exec::Reaper::Start();
  ASSERT_TRUE(reaper);
  std::ofstream(folder_ / "scene.toml") << "speed = -1\n";
  exec::ChildSpec spec;
  spec.argv = {BinDir() + "/musher-world", folder_ / "scene.toml", "--alone"};
  auto child = exec::Child::Start(spec, reaper.value());
  ASSERT_TRUE(child);
  EXPECT_EQ(child.value().Reap().number, 2);
}

}  // namespace musher::world::process_test
