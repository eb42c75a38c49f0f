// musher-vision-manager as a controller and the robot's other modules use it: the real programs
// over DDS.

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/vision/vision_process.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::vision::vision_process_test {

using ::testing::HasSubstr;

// A face 1 m before the front camera, as high as it.
constexpr const char* kScene = R"(
speed = 2
start.standing = true
body.noise = 0
[camera.front]
x_m = 0.2
z_m = 0.1
hfov_deg = 56.0
[[board]]
x_m = 1.2
y_m = 0.0
yaw_deg = 180.0
width_m = 0.35
height_m = 0.35
bottom_m = 0.215
face = 3
)";

constexpr const char* kFile = R"(
picture = "world/camera/front"
hfov_deg = 56.0
self_check_ms = 15000
[faces]
face_m = 0.208
)";

using VisionInWorld = VisionProcess;

TEST_F(VisionInWorld, SeesTheFaceInTheWorldAndHowFarAwayItIs) {
  std::optional<msg::PointStamped> target;
  std::optional<msg::Bool> too_close;
  std::optional<msg::String> faces;
  Watch("wedding/perception/target", target);
  Watch("wedding/perception/too_close", too_close);
  Watch("wedding/perception/faces_json", faces);
  StartWorld(kScene);
  Start(kFile);
  ExpectDone("SelfCheck");
  EXPECT_FALSE(target) << "a check is no looking";
  ExpectDone("Active");
  ASSERT_TRUE(peer_.Until([&] { return target && too_close && faces; })) << peer_.Output();
  EXPECT_NEAR(target->point.x, 0.5, 0.03);
  EXPECT_NEAR(target->point.y, 0.5, 0.08);
  EXPECT_NEAR(target->point.z, 1, 0.15);
  EXPECT_EQ(target->header.frame_id, "camera");
  EXPECT_FALSE(too_close->data);
  ASSERT_TRUE(
      peer_.Until([&] { return nlohmann::json::parse(faces->data).at("count").get<int>() == 1; }));
  ExpectTornDown();
}

TEST_F(VisionInWorld, LooksInActiveOnlySoThatTheWorldNeedNotDraw) {
  const auto camera = Publisher<msg::Image>("world/camera/front", transport::kSensorDataQos);
  StartWorld(kScene);
  Start(kFile);
  for (const BuiltInState state : {kDeActive, kProtected, kLowPower, kOta, kError}) {
    ExpectDone("Active");
    EXPECT_TRUE(peer_.Until([&] { return camera->MatchedReaders() == 1; })) << state;
    ExpectDone(state);
    EXPECT_TRUE(peer_.Until([&] { return camera->MatchedReaders() == 0; })) << state;
  }
  ExpectDone("SelfCheck");
  EXPECT_TRUE(peer_.Until([&] { return camera->MatchedReaders() == 0; }));
}

TEST_F(VisionProcess, FailsItsSelfCheckWithoutPictures) {
  Start("self_check_ms = 100\n");
  EXPECT_THAT(Failure("SelfCheck"), HasSubstr("5909 no publisher of image_rgb"));
}

TEST_F(VisionProcess, FailsItsSelfCheckAndDoesNotLookWithoutAModel) {
  Start("[detector]\nmodel = \"/no/such/model.xml\"\n");
  EXPECT_THAT(Failure("SelfCheck"), HasSubstr("5909 /no/such/model.xml: there is no such model"));
  EXPECT_THAT(Failure("Active"), HasSubstr("5912 /no/such/model.xml: there is no such model"));
}

TEST_F(VisionProcess, IsNotStartedWithAnInvalidFile) {
  ExpectRefused("rate = 3\n", "vision.toml:1:1: error: unknown key \"rate\"");
}

constexpr const char* kFaultyFile =
    "rate_hz = 0\nhfov_deg = 60\n[detector]\nhang_ms = 1000\nfailures = 5\n";

TEST_F(FaultyVision, ExitsWithOneWhenTheDetectorFailsRepeatedly) {
  StartWithCamera(kFaultyFile);
  SetDetector("throw");
  ASSERT_TRUE(AwaitOutput("detector is lost"));
  EXPECT_EQ(peer_.AwaitExit(), 1);
  EXPECT_THAT(
      peer_.Output(),
      HasSubstr("vision: warning: the detector is lost: 5 pictures in a row: the detector failed: "
                "by the test (5912"));
}

TEST_F(FaultyVision, HangsWhenTheDetectorDoesNotReturnAndRecoversWhenItDoes) {
  std::optional<msg::ActuatorHeartbeat> heartbeat;
  Listen(transport::ActuatorHeartbeatTopic(""), heartbeat, transport::kHeartbeatQos);
  StartWithCamera(kFaultyFile);
  SetDetector("hang");
  ASSERT_TRUE(peer_.Until([&] {
    return heartbeat && heartbeat->work == msg::ActuatorHeartbeat::kWorkHung;
  })) << HeartbeatText(heartbeat)
      << peer_.Output();
  SetDetector("work");
  std::ofstream(peer_.folder() / "gate") << "go on";
  EXPECT_TRUE(peer_.Until([&] { return heartbeat->work == msg::ActuatorHeartbeat::kWorkWell; }));
  ExpectTornDown();
}

}  // namespace musher::vision::vision_process_test
