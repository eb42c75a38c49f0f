// musher-camera-manager and musher-camera from outside: the real programs over DDS.

#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/protocol/camera.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/module_process.hpp"

namespace musher::camera::camera_process_test {

using msg::ActuatorCommand;
using msg::CameraService;
using ::testing::HasSubstr;

constexpr const char* kFile = R"(
self_check_ms = 5000
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
class CameraManagerProcess : public test::ModuleProcess {
 protected:
  CameraManagerProcess() : ModuleProcess("RealSenseActuator", "musher-camera-manager") {}

  void MakeWorld() {
    shots_ = Publisher<msg::Image>("world/camera/front", transport::kSensorDataQos);
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
  void Watch() { Listen("image_rgb", seen_, transport::kSensorDataQos); }
  CameraService::Response TakePicture(const std::string& name) {
    return Call<CameraService>("camera_service", {CameraService::kTakePicture, name, 320, 240, 0});
  }
  exec::Child Tool(std::vector<std::string> words) {
    words.insert(words.begin(), "musher-camera");
    return Launch(std::move(words));
  }
  void ExpectRun(std::vector<std::string> words, int code, const std::string& said) {
    exec::Child tool = Tool(std::move(words));
    EXPECT_EQ(Await(tool), code) << Said();
    EXPECT_THAT(Said(), HasSubstr(said));
  }

  msg::Image picture_;
  int shown_ = 0;
  std::optional<msg::Image> seen_;
  std::unique_ptr<transport::Publisher<msg::Image>> shots_;
  transport::LoopHandlePtr ticker_;
};

TEST_F(CameraManagerProcess, RunsThroughAllStatesAndPublishesInActiveAndProtectedOnly) {
  MakeWorld();
  Start(kFile);
  Watch();
  for (const BuiltInState state :
       {kSelfCheck, kActive, kLowPower, kProtected, kOta, kDeActive, kError, kActive}) {
    ExpectDone(state);
    const bool on = state == "Active" || state == "Protected";
    EXPECT_TRUE(peer_.Until([&] { return (shots_->MatchedReaders() > 0) == on; })) << state;
    seen_.reset();
    EXPECT_TRUE(!on || peer_.Until([&] { return seen_.has_value(); })) << state;
  }
  EXPECT_EQ(seen_->data, picture_.data);
  EXPECT_EQ(seen_->header.frame_id, "camera_front");
  ExpectTornDown();
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
  Start(kFile);
  const auto checked = peer_.Switch("SelfCheck");
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked.value().verdict, ActuatorCommand::kVerdictDone);
  EXPECT_EQ(checked.value().status.degraded_code, 4409);
  EXPECT_THAT(checked.value().status.degraded_reason, HasSubstr("broken: there is no device"));
  EXPECT_TRUE(AwaitOutput("broken: there is no device /dev/video99, 4412")) << peer_.Output();
}

TEST_F(CameraManagerProcess, FailsItsSelfCheckWithoutACriticalCamera) {
  Start(kFile);
  EXPECT_THAT(Failure(kSelfCheck),
              ::testing::AllOf(::testing::StartsWith("4409 "), HasSubstr("front (critical): ")));
}

TEST_F(CameraManagerProcess, SavesAPictureAtTheReportedPath) {
  MakeWorld();
  Start(kFile);
  EXPECT_EQ(TakePicture("").code, 4403) << "in SetUp";
  ASSERT_TRUE(peer_.Switch("Active"));
  const auto taken = TakePicture("me.jpg");
  EXPECT_EQ(taken.result, 0) << taken.msg;
  EXPECT_EQ(taken.msg, peer_.folder() / "saved/me.jpg");
  EXPECT_GT(std::filesystem::file_size(taken.msg), 500u);
}

TEST_F(CameraManagerProcess, IsWatchedByTheTool) {
  MakeWorld();
  Start(kFile);
  ASSERT_TRUE(peer_.Switch("Active"));
  ExpectRun({"shot", "image_rgb", "now.png"}, 0, "now.png: 640x480 of image_rgb");
  EXPECT_TRUE(std::filesystem::exists(peer_.folder() / "now.png"));
  ExpectRun({"list", "--seconds", "3"}, 0, "640x480 bgr8");
  ExpectRun({"watch", "image_rgb", "--seconds", "3", "--json"}, 0, "\"age_p99_ms\"");
}

TEST_F(CameraManagerProcess, IsSeenAsAStripThatIsWrittenWhenItIsInterrupted) {
  MakeWorld();
  Start(kFile);
  ASSERT_TRUE(peer_.Switch("Active"));
  ExpectRun({"strip", "image_rgb", "whole.png", "--every", "0.1", "--count", "3"}, 0,
            "whole.png: 3 of 3 pictures");
  // Interrupted once it has received a picture, known by its subscription.
  const auto others = [&] { return shots_->MatchedReaders(); };
  const int before = others();
  exec::Child cut =
      Tool({"strip", "world/camera/front", "cut.jpg", "--every", "3600", "--count", "3"});
  ASSERT_TRUE(peer_.Until([&] { return others() > before; }));
  const int first = shown_;
  // A picture of almost a megabyte, sent once, may be lost on a busy computer.
  ASSERT_TRUE(peer_.Until([&] { return shown_ >= first + 60; })) << "many have been shown to it";
  kill(cut.pid(), SIGTERM);
  EXPECT_EQ(Await(cut), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("cut.jpg: 1 of 3 pictures"));
  EXPECT_TRUE(std::filesystem::exists(peer_.folder() / "cut.jpg"));
}

TEST_F(CameraManagerProcess, IsSeenAsAStripWithAPictureForEachChangeOfAText) {
  MakeWorld();
  Start(kFile);
  ASSERT_TRUE(peer_.Switch("Active"));
  const auto state = Publisher<msg::String>("state");
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
  Start(kFile);
  ASSERT_TRUE(peer_.Switch("Active"));
  const auto state = Publisher<msg::String>("state");
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
  ExpectRun({"strip", "image_rgb", "a.png", "--on-demand"}, 2, "--changes");
}

TEST_F(CameraManagerProcess, IsReportedMissingByTheTool) {
  ExpectRun({"shot", "image_rgb", "now.png", "--timeout", "0.5"}, 1, "no publisher of image_rgb");
  ExpectRun({"shot", "image_rgb", "now.txt"}, 2, "ends with .png, .jpg or .bmp");
}

}  // namespace musher::camera::camera_process_test
