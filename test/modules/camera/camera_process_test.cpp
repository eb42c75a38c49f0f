// musher-camera-manager and musher-camera from outside: the real programs over DDS.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/protocol/camera.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/actuator_peer.hpp"
#include "musher/test/modules/exec/processes.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::camera::camera_process_test {

using msg::ActuatorCommand;
using msg::CameraService;
using ::testing::HasSubstr;

const std::vector<std::string> kAllStates = {"SetUp",    "TearDown", "SelfCheck",
                                             "Active",   "DeActive", "Protected",
                                             "LowPower", "OTA",      "Error"};

constexpr const char* kFile = R"(
self_check_ms = 2000
critical = ["front"]
[service]
folder = "saved"
[camera.front]
topic = "image_rgb"
source = "world"
from = "world/camera/front"
[camera.broken]
topic = "image_broken"
source = "device"
from = "/dev/video99"
)";

// The world that has the front camera, and the program.
class CameraManagerProcess : public ::testing::Test {
 protected:
  void Start(const std::string& file = kFile) {
    peer_.Start(file);
    ASSERT_TRUE(peer_.AwaitVisible()) << peer_.Output();
  }
  void MakeWorld() {
    shots_ = transport::MakePublisher<msg::Image>(peer_.node(), "world/camera/front",
                                                  transport::kSensorDataQos)
                 .value();
    picture_.width = 640;
    picture_.height = 480;
    picture_.encoding = "bgr8";
    picture_.step = 640 * 3;
    picture_.data.assign(std::size_t{picture_.step} * 480, 90);
    ticker_ = peer_.node().loop().Every(Milliseconds(50), [this] {
      picture_.header.stamp = msg::ToStamp(std::chrono::duration_cast<Duration>(
          std::chrono::system_clock::now().time_since_epoch()));
      if (shots_->MatchedReaders() > 0 && shots_->Publish(picture_)) ++shown_;
    });
  }
  void Watch() {
    eye_ = transport::MakeSubscription<msg::Image>(
               peer_.node(), "image_rgb",
               [this](msg::Image&& picture, const auto&) { seen_ = std::move(picture); },
               transport::kSensorDataQos)
               .value();
  }
  CameraService::Response Call(const CameraService::Request& request) {
    const auto client =
        transport::MakeClient<CameraService>(peer_.node(), "camera_service").value();
    std::optional<Result<CameraService::Response>> answer;
    client->Call(request, Milliseconds(20'000), [&](auto reply) { answer = reply; });
    EXPECT_TRUE(peer_.Until([&] { return answer.has_value(); }));
    return answer && *answer ? answer->value() : CameraService::Response{255, "no answer", -1};
  }
  // Runs musher-camera with these arguments; returns its exit code. The output goes to the file
  // `said`.
  exec::Child Tool(const std::vector<std::string>& arguments) {
    std::vector<std::string> argv = {BinDir() + "/musher-camera"};
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    const UniqueFd output(
        open((peer_.folder() / "said").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    return exec::Child::Start({argv, peer_.folder().path(), {}}, reaper_, output.get()).value();
  }
  // While the world's time advances.
  int Await(exec::Child& tool) {
    bool ended = false;
    const auto watch = peer_.node().loop().WhenReadable(tool.pidfd(), [&ended] { ended = true; });
    EXPECT_TRUE(peer_.Until([&ended] { return ended; }));
    const ExitStatus status = tool.Reap();
    return status.killed ? -status.number : status.number;
  }
  std::string Said() const {
    std::ifstream stream(peer_.folder() / "said");
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  test::ActuatorPeer peer_{"RealSenseActuator", kAllStates, "musher-camera-manager"};
  const exec::Reaper reaper_ = exec::Reaper::Start().value();
  msg::Image picture_;
  int shown_ = 0;
  std::optional<msg::Image> seen_;
  std::unique_ptr<transport::Publisher<msg::Image>> shots_;
  std::unique_ptr<transport::Subscription> eye_;
  transport::LoopHandlePtr ticker_;
};

TEST_F(CameraManagerProcess, RunsThroughAllStatesAndPublishesInActiveAndProtectedOnly) {
  MakeWorld();
  Start();
  Watch();
  for (const BuiltInState state :
       {kSelfCheck, kActive, kLowPower, kProtected, kOta, kDeActive, kError, kActive}) {
    const auto done = peer_.Switch(state);
    ASSERT_TRUE(done);
    EXPECT_EQ(done.value().verdict, ActuatorCommand::kVerdictDone) << state << peer_.Output();
    const bool on = state == "Active" || state == "Protected";
    EXPECT_TRUE(peer_.Until([&] { return (shots_->MatchedReaders() > 0) == on; })) << state;
    seen_.reset();
    EXPECT_TRUE(!on || peer_.Until([&] { return seen_.has_value(); })) << state;
  }
  EXPECT_EQ(seen_->data, picture_.data);
  EXPECT_EQ(seen_->header.frame_id, "camera_front");
  EXPECT_EQ(peer_.Switch("TearDown").value().verdict, ActuatorCommand::kVerdictDone);
  EXPECT_EQ(peer_.AwaitExit(), 0) << peer_.Output();
}

TEST_F(CameraManagerProcess, IsOnInSelfCheckIfConfigured) {
  MakeWorld();
  Start("on_in = [\"SelfCheck\", \"Active\"]\n" + std::string(kFile));
  ASSERT_TRUE(peer_.Switch("SelfCheck"));
  Watch();
  EXPECT_TRUE(peer_.Until([&] { return seen_.has_value(); })) << peer_.Output();
  ASSERT_TRUE(peer_.Switch("LowPower"));
  EXPECT_TRUE(peer_.Until([&] { return shots_->MatchedReaders() == 0; }));
}

TEST_F(CameraManagerProcess, PassesItsSelfCheckWithoutANonCriticalCameraAndLogsIt) {
  MakeWorld();
  Start();
  const auto checked = peer_.Switch("SelfCheck");
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked.value().verdict, ActuatorCommand::kVerdictDone);
  EXPECT_EQ(checked.value().status.degraded_code, 4409);
  EXPECT_THAT(checked.value().status.degraded_reason, HasSubstr("broken: there is no device"));
  EXPECT_TRUE(peer_.Until([&] {
    return peer_.Output().find("broken: there is no device /dev/video99, 4412") !=
           std::string::npos;
  })) << peer_.Output();
}

TEST_F(CameraManagerProcess, FailsItsSelfCheckWithoutACriticalCamera) {
  Start();
  const auto checked = peer_.Switch("SelfCheck");
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked.value().verdict, ActuatorCommand::kVerdictFailed);
  EXPECT_EQ(checked.value().code, 4409);
  EXPECT_THAT(checked.value().message, HasSubstr("front (critical): "));
}

TEST_F(CameraManagerProcess, SavesAPictureAtTheReportedPath) {
  MakeWorld();
  Start();
  EXPECT_EQ(Call({CameraService::kTakePicture, "", 0, 0, 0}).code, 4403) << "in SetUp";
  ASSERT_TRUE(peer_.Switch("Active"));
  const auto taken = Call({CameraService::kTakePicture, "me.jpg", 320, 240, 0});
  EXPECT_EQ(taken.result, 0) << taken.msg;
  EXPECT_EQ(taken.msg, peer_.folder() / "saved/me.jpg");
  EXPECT_GT(std::filesystem::file_size(taken.msg), 500u);
}

TEST_F(CameraManagerProcess, IsNotStartedWithAnInvalidFile) {
  peer_.Start("[camera.front]\ntopic = 3\n");
  EXPECT_EQ(peer_.AwaitExit(), 2);
  EXPECT_THAT(peer_.Output(), HasSubstr(".toml:2:9: error: camera.front.topic"));
}

TEST_F(CameraManagerProcess, IsWatchedByTheTool) {
  MakeWorld();
  Start();
  ASSERT_TRUE(peer_.Switch("Active"));
  exec::Child shot = Tool({"shot", "image_rgb", "now.png"});
  EXPECT_EQ(Await(shot), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("now.png: 640x480 of image_rgb"));
  EXPECT_TRUE(std::filesystem::exists(peer_.folder() / "now.png"));
  exec::Child list = Tool({"list", "--seconds", "0.5"});
  EXPECT_EQ(Await(list), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("640x480 bgr8"));
  exec::Child watch = Tool({"watch", "image_rgb", "--seconds", "0.5", "--json"});
  EXPECT_EQ(Await(watch), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("\"age_p99_ms\""));
}

TEST_F(CameraManagerProcess, IsSeenAsAStripThatIsWrittenWhenItIsInterrupted) {
  MakeWorld();
  Start();
  ASSERT_TRUE(peer_.Switch("Active"));
  exec::Child whole = Tool({"strip", "image_rgb", "whole.png", "--every", "0.1", "--count", "3"});
  EXPECT_EQ(Await(whole), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("whole.png: 3 of 3 pictures"));
  // Interrupted once it has received a picture, known by its subscription.
  const auto others = [&] { return shots_->MatchedReaders(); };
  const int before = others();
  exec::Child cut =
      Tool({"strip", "world/camera/front", "cut.jpg", "--every", "3600", "--count", "3"});
  ASSERT_TRUE(peer_.Until([&] { return others() > before; }));
  const int first = shown_;
  ASSERT_TRUE(peer_.Until([&] { return shown_ >= first + 10; })) << "ten have been shown to it";
  kill(cut.pid(), SIGTERM);
  EXPECT_EQ(Await(cut), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("cut.jpg: 1 of 3 pictures"));
  EXPECT_TRUE(std::filesystem::exists(peer_.folder() / "cut.jpg"));
}

TEST_F(CameraManagerProcess, IsSeenAsAStripWithAPictureForEachChangeOfAText) {
  MakeWorld();
  Start();
  ASSERT_TRUE(peer_.Switch("Active"));
  const auto state = transport::MakePublisher<msg::String>(peer_.node(), "state").value();
  exec::Child tool = Tool({"strip", "image_rgb", "states.png", "--changes", "state", "--every",
                           "0.1", "--count", "2", "--json"});
  // Published repeatedly, as states are; it alternates with the pictures, so that a text that
  // comes too early for the tool comes again.
  const auto speaker = peer_.node().loop().Every(Milliseconds(20), [&] {
    EXPECT_TRUE(state->Publish({shown_ / 40 % 2 == 0 ? "IDLE" : "TRACKING"}));
  });
  EXPECT_EQ(Await(tool), 0) << Said();
  EXPECT_THAT(Said(), AllOf(HasSubstr("s  IDLE"), HasSubstr("s  TRACKING")));
}

TEST_F(CameraManagerProcess, HasItsPicturesOnDemandInAStripOfTwoCameras) {
  MakeWorld();
  Start();
  ASSERT_TRUE(peer_.Switch("Active"));
  const auto state = transport::MakePublisher<msg::String>(peer_.node(), "state").value();
  ASSERT_TRUE(peer_.Until([&] { return shots_->MatchedReaders() == 1; })) << "of the program";
  exec::Child tool = Tool({"strip", "world/camera/front", "both.png", "--beside", "image_rgb",
                           "--changes", "state", "--on-demand", "--every", "0.1", "--count", "2"});
  ASSERT_TRUE(peer_.Until([&] { return state->MatchedReaders() > 0; }));
  EXPECT_EQ(shots_->MatchedReaders(), 1) << "no state, no subscription";
  EXPECT_TRUE(state->Publish({"IDLE"}));
  ASSERT_TRUE(peer_.Until([&] { return shots_->MatchedReaders() == 2; }));
  ASSERT_TRUE(peer_.Until([&] { return shots_->MatchedReaders() == 1; }));
  EXPECT_TRUE(state->Publish({"TRACKING"}));
  EXPECT_EQ(Await(tool), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("both.png: 2 of 2 pictures"));
  exec::Child aimless = Tool({"strip", "image_rgb", "a.png", "--on-demand"});
  EXPECT_EQ(Await(aimless), 2) << "without --changes";
}

TEST_F(CameraManagerProcess, IsReportedMissingByTheTool) {
  exec::Child without_publisher = Tool({"shot", "image_rgb", "now.png", "--timeout", "0.5"});
  EXPECT_EQ(Await(without_publisher), 1);
  EXPECT_THAT(Said(), HasSubstr("no publisher of image_rgb"));
  exec::Child no_picture = Tool({"shot", "image_rgb", "now.txt"});
  EXPECT_EQ(Await(no_picture), 2);
  EXPECT_THAT(Said(), HasSubstr("ends with .png, .jpg or .bmp"));
}

}  // namespace musher::camera::camera_process_test
