// The module's config file, valid and invalid.

#include "musher/modules/camera/camera_config.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

#include <gmock/gmock.h>

namespace musher::camera::camera_config_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

CamerasConfig Good(const std::string& text) {
  const Parsed<CamerasConfig> reading = ReadCamerasText(text, "/etc/dog/cameras.toml");
  for (const Diagnostic& found : reading.diagnostics) ADD_FAILURE() << FormatDiagnostic(found);
  return reading.config.value_or(CamerasConfig{});
}

TEST(CamerasConfig, OfTheRepositoryIsGood) {
  const Parsed<CamerasConfig> reading =
      ReadCamerasFile(SourceDir() + "/config/camera/cameras.toml");
  ASSERT_TRUE(reading.config) << FormatDiagnostic(reading.diagnostics.at(0));
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_EQ(reading.config->cameras.size(), 3u);
  EXPECT_EQ(reading.config->cameras[0].topic, "image_rgb");
  EXPECT_EQ(reading.config->cameras[2].frame_id, "camera_right");
}

TEST(CamerasConfig, ReadsEveryKey) {
  const CamerasConfig config = Good(R"(
self_check_ms = 100
silence_ms = 200
retry_ms = 300
skip = ["ir"]
critical = ["front"]
on_in = ["Active"]
[service]
camera = "ir"
topic = "ai/image"
folder = "../saved"
[camera.front]
topic = "image_rgb"
frame_id = "lens"
source = "video"
from = "walk.avi"
at_end = "stop"
width_px = 320
height_px = 240
encoding = "mono8"
rate_hz = 7.5
hfov_deg = 69
on_demand = true
[camera.ir]
topic = "image_ir"
source = "device"
from = "2"
)");
  const CameraConfig front = {"front",
                              "image_rgb",
                              "lens",
                              SourceKind::kVideo,
                              "/etc/dog/walk.avi",
                              false,
                              {320, 240, "mono8"},
                              7.5,
                              true,
                              69};
  CameraConfig ir;
  ir.name = "ir";
  ir.topic = "image_ir";
  ir.frame_id = "camera_ir";
  ir.source = SourceKind::kDevice;
  ir.from = "2";
  EXPECT_THAT(config.cameras, ElementsAre(front, ir));
  EXPECT_EQ(config.service, (ServiceConfig{"ir", "ai/image", "/etc/saved"}));
  EXPECT_EQ(config.self_check_time, Milliseconds(100));
  EXPECT_EQ(config.silence, Milliseconds(200));
  EXPECT_EQ(config.retry, Milliseconds(300));
  EXPECT_THAT(config.skip, ElementsAre("ir"));
  EXPECT_THAT(config.on_in, ElementsAre("Active"));
}

TEST(CamerasConfig, ReportsWhatIsWrongAndWhere) {
  musher::testing::ExpectDiagnostics(
      [](const std::string& text) { return ReadCamerasText(text, "/etc/dog/cameras.toml"); },
      {{"all errors at once",
        R"(skip = ["fornt"]
[camera.front]
topic = "/image"
source = "vidio"
from = "x"
width_px = 640
colour = true
[camera.left]
topic = "image_left"
source = "world"
from = "world/camera/left"
)",
        {"cameras.toml:1:9: error: skip: expected one of front and left",
         "cameras.toml:3:9: error: camera.front.topic: expected the name of a topic relative to "
         "the "
         "namespace, as in \"image_rgb\", found \"/image\"",
         "cameras.toml:4:10: error: camera.front.source",
         "cameras.toml:6:12: error: camera.front.width_px: expected both",
         "cameras.toml:7:1: error: camera.front: unknown key \"colour\""}},
       {"no table of cameras", "", {"camera"}},
       {"no camera", "[camera]", {"camera"}},
       {"two cameras on a topic, and a critical one that is skipped",
        R"(
skip = ["a"]
critical = ["a"]
[camera.a]
topic = "t"
source = "world"
from = "w"
[camera.b]
topic = "t"
source = "world"
from = "w"
)",
        {"cannot be critical", "\"t\" is that of camera.a already"}},
       {"the topic of the service",
        "[camera.a]\ntopic = \"image\"\nsource = \"world\"\nfrom = \"w\"\n",
        {"error: camera.a.topic: \"image\" is that of camera_service"}}});
}

TEST(CamerasConfig, ReportsAMissingFile) {
  const Parsed<CamerasConfig> reading = ReadCamerasFile("/nowhere/cameras.toml");
  EXPECT_FALSE(reading.config);
  ASSERT_EQ(reading.diagnostics.size(), 1u);
}

}  // namespace musher::camera::camera_config_test
