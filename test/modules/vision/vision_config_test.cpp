#include "musher/modules/vision/vision_config.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "musher/actuator/program/states.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::vision::vision_config_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> Said(const std::string& text) {
  std::vector<std::string> lines;
  for (const Diagnostic& diagnostic : ReadVisionText(text, "/robot/faces.toml").diagnostics) {
    lines.push_back(FormatDiagnostic(diagnostic));
  }
  return lines;
}

TEST(VisionConfig, OfOldFilesCountsEqualPicturesNoLonger) {
  EXPECT_THAT(
      Said("still_pictures = 15\n"),
      ElementsAre("/robot/faces.toml:1:18: error: still_pictures: is replaced by still_ms, the "
                  "milliseconds in which a camera shows only old pictures: 300, or 0 to "
                  "check nothing"));
  EXPECT_EQ(ReadVisionText("", "/robot/faces.toml").config->still, Milliseconds(300));
}

TEST(VisionConfig, OfTheRepositoryIsGood) {
  const Parsed<VisionConfig> reading = ReadVisionFile(SourceDir() + "/config/vision/faces.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  EXPECT_TRUE(reading.config->LooksIn("Active"));
  for (const char* state : {"DeActive", "Protected", "LowPower", "OTA", "Error", "TearDown"}) {
    EXPECT_FALSE(reading.config->LooksIn(state)) << state;
  }
}

TEST(VisionConfig, IsWholeWithoutAKey) {
  const Parsed<VisionConfig> reading = ReadVisionText("", "/robot/faces.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(reading.config->picture, "image_rgb");
  EXPECT_EQ(reading.config->CameraInfoTopic(), "image_rgb/camera_info");
  EXPECT_THAT(reading.config->cascade.model, HasSubstr("haarcascade_frontalface_alt2.xml"));
}

TEST(VisionConfig, HasTheValuesOfTheFile) {
  const Parsed<VisionConfig> reading = ReadVisionText(R"(
picture = "/camera/head/image_raw"
hfov_deg = 90
publish_under = "faces"
look_in = ["Active", "Show"]
rate_hz = 0
self_check_ms = 700
silence_ms = 900
[detector]
model = "mine.xml"
width_px = 640
step = 1.2
neighbours = 5
hang_ms = 100
failures = 2
[faces]
face_m = 0.21
smallest = 0.1
iou = 0.3
distance = 0.2
confirm_pictures = 3
confirm_within_ms = 400
forget_ms = 2000
smoothing_ms = 0
[target]
lost_ms = 300
nearer = 0.1
[too_close]
near_m = 0.5
clear_m = 0.5
hold_ms = 0
)",
                                                      "/robot/faces.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  const VisionConfig& config = *reading.config;
  EXPECT_EQ(config.CameraInfoTopic(), "/camera/head/image_raw/camera_info");
  EXPECT_NEAR(*config.hfov_rad, M_PI / 2, 1e-9);
  EXPECT_EQ(config.publish_under, "faces");
  EXPECT_THAT(config.look_in, ElementsAre("Active", "Show"));
  EXPECT_EQ(config.rate_hz, 0);
  EXPECT_EQ(config.self_check_time, Milliseconds(700));
  EXPECT_EQ(config.cascade, (CascadeConfig{"mine.xml", 640, 1.2, 5, 0.1}));
  EXPECT_EQ(config.limits.hang, Milliseconds(100));
  EXPECT_EQ(config.limits.failures, 2);
  FaceRules expected;
  expected.face_m = 0.21;
  expected.tracker = {0.1, 0.3, 0.2, 3, Milliseconds(400), Milliseconds(2000), Duration::zero()};
  expected.target = {Milliseconds(300), 0.1};
  expected.closeness = {0.5, 0.5, Duration::zero(), Milliseconds(900)};
  EXPECT_EQ(config.faces, expected);
}

TEST(VisionConfig, ReportsEveryErrorWithItsPlace) {
  EXPECT_THAT(
      Said(R"(picture = "image rgb"
rate_hz = -1
lookin = ["Active"]
[detector]
step = 1.0
width_px = "320"
[too_close]
near_m = 0.6
clear_m = 0.5
)"),
      ElementsAre(HasSubstr("faces.toml:1:11: error: picture: expected the name of a topic"),
                  HasSubstr("faces.toml:2:11: error: rate_hz"),
                  HasSubstr("faces.toml:3:1: error: unknown key \"lookin\""),
                  HasSubstr("faces.toml:5:8: error: detector.step"),
                  HasSubstr("faces.toml:6:12: error: detector.width_px"),
                  HasSubstr("faces.toml:9:11: error: too_close.clear_m: must not be less")));
  EXPECT_THAT(Said("picture ="), ElementsAre(HasSubstr("faces.toml:1:")));
}

TEST(VisionConfig, RefusesARateAtWhichAFaceIsLostFromOnePictureToTheNext) {
  EXPECT_THAT(Said("rate_hz = 0.19\n"),
              ElementsAre(HasSubstr("faces.toml:1:11: error: rate_hz: a face would be forgotten")));
  EXPECT_THAT(Said("rate_hz = 0.2\n"), IsEmpty());
  EXPECT_THAT(Said("rate_hz = 0.19\n[faces]\nforget_ms = 6000\n"), IsEmpty());
}

// Checked once the machine is known, since the file alone does not name it.
TEST(StatesOfAModule, RefuseAMisspeltOneWithTheNearest) {
  MachineConfig machine;
  machine.states = {"Active", "DeActive", "Show"};
  const auto check = [&](const std::vector<State>& states) {
    const Result<> checked = program::CheckStates(machine, "look_in", states, 5910);
    return checked ? "" : checked.error().message;
  };
  EXPECT_EQ(check({"Active", "Actve"}),
            "look_in: the machine has no state \"Actve\"; did you mean \"Active\"?");
  EXPECT_EQ(check({"Wedding"}), "look_in: the machine has no state \"Wedding\"");
  EXPECT_EQ(check({"Active", "Show"}), "");
  EXPECT_EQ(check({"Protected"}), "") << "of another machine with the same file";
}

TEST(VisionConfig, ThatCannotBeReadIsReported) {
  const Parsed<VisionConfig> reading = ReadVisionFile("/no/faces.toml");
  EXPECT_FALSE(reading.config);
  EXPECT_FALSE(reading.diagnostics.empty());
}

}  // namespace musher::vision::vision_config_test
