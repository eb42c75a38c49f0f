// The tables [[detectors]] of the config.

#include "musher/modules/vision/course/course_config.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "musher/modules/vision/course/course_parameters.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::vision::course_config_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::SizeIs;

std::vector<std::string> Said(const std::string& text) {
  std::vector<std::string> lines;
  for (const Diagnostic& diagnostic : ReadVisionText(text, "/robot/course.toml").diagnostics) {
    lines.push_back(FormatDiagnostic(diagnostic));
  }
  return lines;
}

VisionConfig Read(const std::string& text) {
  const Parsed<VisionConfig> reading = ReadVisionText(text, "/robot/course.toml");
  EXPECT_TRUE(reading.config) << FormatDiagnostic(reading.diagnostics.front());
  return reading.config.value();
}

TEST(CourseConfig, OfTheRepositoryIsGood) {
  const Parsed<VisionConfig> reading = ReadVisionFile(SourceDir() + "/config/vision/course.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  EXPECT_FALSE(reading.config->detect_faces);
  EXPECT_EQ(reading.config->still, Milliseconds(300));
  EXPECT_EQ(reading.config->detectors.front().still, Milliseconds(300));
  std::vector<std::string> names;
  for (const CourseEntry& entry : reading.config->detectors) names.push_back(entry.name);
  EXPECT_THAT(names, IsSupersetOf({"qr_detector", "green_arrow_detector", "red_barrier_detector",
                                   "yellow_marker_detector", "yellow_light_detector", "left",
                                   "right", "front", "right_lane", "front_lane"}));
}

// Otherwise what `musher-vision tune` prints for [hall] would change nothing.
TEST(CourseConfig, OfTheRepositoryHasTheColorsOfItsHall) {
  std::ifstream file(SourceDir() + "/config/vision/course.toml");
  std::string text(std::istreambuf_iterator<char>(file), {});
  const std::string colors =
      "\nyellow = { from = [1, 2, 3], to = [4, 5, 6] }\ngreen = { from = [1, 2, 3], to = [4, 5, 6] "
      "}"
      "\nred = { from = [1, 2, 3], to = [4, 5, 6] }";
  text.insert(text.find("\n[hall]\n") + 7, colors);
  const Parsed<VisionConfig> reading = ReadVisionText(text, "/robot/course.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  const HsvRange of_hall{{1, 2, 3}, {4, 5, 6}};
  for (const CourseEntry& entry : reading.config->detectors) {
    if (const auto* lines = std::get_if<LinesParameters>(&entry.parameters)) {
      EXPECT_EQ(lines->yellow, of_hall) << entry.name;
    } else if (const auto* marker = std::get_if<MarkerParameters>(&entry.parameters)) {
      EXPECT_EQ(marker->yellow, of_hall) << entry.name;
    } else if (const auto* arrow = std::get_if<ArrowParameters>(&entry.parameters)) {
      EXPECT_EQ(arrow->green, of_hall) << entry.name;
    } else if (const auto* barrier = std::get_if<BarrierParameters>(&entry.parameters)) {
      EXPECT_EQ(barrier->red, of_hall) << entry.name;
    }
  }
}

TEST(CourseConfig, WarnsOfAColorThatWinsOverThatOfTheHall) {
  const auto reading = ReadVisionText(R"([hall]
yellow = { from = [18, 90, 40], to = [32, 255, 255] }
[[detectors]]
name = "left"
kind = "lines"
parameters.yellow = { from = [20, 50, 50], to = [35, 255, 255] }
[[detectors]]
name = "lamp"
kind = "light"
parameters.yellow = { from = [9, 100, 100], to = [34, 255, 255] }
)",
                                      "/robot/course.toml");
  ASSERT_TRUE(reading.config) << "a warning is no error";
  ASSERT_THAT(reading.diagnostics, SizeIs(1)) << "an amber light needs one of its own";
  EXPECT_THAT(FormatDiagnostic(reading.diagnostics[0]),
              HasSubstr("course.toml:6:21: warning: detectors.left.parameters.yellow: wins over "
                        "that of [hall]; remove it"));
}

TEST(CourseConfig, HasTheDefaultsOfTheKind) {
  const VisionConfig config = Read(R"(
[[detectors]]
name = "board"
kind = "qr"
[[detectors]]
name = "left"
kind = "lines"
picture = "image_left"
)");
  EXPECT_TRUE(config.detect_faces);
  ASSERT_THAT(config.detectors, SizeIs(2));
  const CourseEntry& board = config.detectors[0];
  EXPECT_EQ(board.picture, "image_rgb");
  EXPECT_EQ(board.CameraInfoTopic(), "image_rgb/camera_info");
  EXPECT_EQ(board.limits, DetectorLimits());
  EXPECT_EQ(board.Outputs().text, "qr_detector/qr_info");
  EXPECT_EQ(board.Outputs().sighting, "qr_detector/sighting");
  EXPECT_EQ(board.Outputs().debug_image, "qr_detector/debug_image");
  const CourseEntry& left = config.detectors[1];
  EXPECT_EQ(left.CameraInfoTopic(), "image_left/camera_info");
  EXPECT_EQ(left.Outputs().lines, "yellow_line_detector/left");
  EXPECT_EQ(left.Outputs().debug_image, "yellow_line_detector/left/debug_image");
  EXPECT_FALSE(left.Outputs().text);
}

TEST(CourseConfig, HasTheValuesOfTheFile) {
  const VisionConfig config = Read(R"(
detect_faces = false
[[detectors]]
name = "sign"
kind = "marker"
picture = "front/image"
camera_info = "front/info"
hfov_deg = 90
rate_hz = 5
publish = "/my/sign/distance"
hang_ms = 300
failures = 2
[detectors.parameters]
yellow = { from = [20, 100, 100], to = [30, 255, 255] }
region = { bottom = 0.5 }
least_area_px2 = 100
)");
  ASSERT_THAT(config.detectors, SizeIs(1));
  const CourseEntry& sign = config.detectors[0];
  EXPECT_EQ(sign.kind, CourseKind::kMarker);
  EXPECT_EQ(sign.picture, "front/image");
  EXPECT_EQ(sign.CameraInfoTopic(), "front/info");
  EXPECT_NEAR(*sign.hfov_rad, M_PI / 2, 1e-9);
  EXPECT_EQ(sign.rate_hz, 5);
  EXPECT_EQ(sign.Outputs().sighting, "/my/sign/sighting");
  EXPECT_EQ(sign.limits, (DetectorLimits{Milliseconds(300), 2}));
  MarkerParameters expected;
  expected.yellow = {{20, 100, 100}, {30, 255, 255}};
  expected.region.bottom = 0.5;
  expected.least_area_px2 = 100;
  EXPECT_EQ(std::get<MarkerParameters>(sign.parameters), expected);
}

TEST(Hall, GivesItsColorsToTheDetectorsThatHaveNone) {
  const VisionConfig config = Read(R"(
detect_faces = false
[hall]
yellow = { from = [18, 90, 40], to = [32, 255, 255] }
lane_m = 1.0
line_width_m = [0.03, 0.07]
trunk_height_m = 0.3
[[mounts]]
picture = "image_left"
model = "fisheye"
yaw_deg = 90
hfov_deg = 180
[[detectors]]
name = "left"
kind = "lines"
picture = "image_left"
[[detectors]]
name = "front"
kind = "lines"
parameters.yellow.from = [10, 10, 10]
[[detectors]]
name = "sign"
kind = "marker"
)");
  const HsvRange of_hall{{18, 90, 40}, {32, 255, 255}};
  const auto left = std::get<LinesParameters>(config.detectors[0].parameters);
  EXPECT_EQ(left.yellow, of_hall);
  EXPECT_EQ(left.lane_m, 1.0);
  EXPECT_EQ(left.least_width_m, 0.03);
  EXPECT_EQ(left.most_width_m, 0.07);
  ASSERT_TRUE(left.mount);
  EXPECT_TRUE(left.mount->camera.fisheye);
  EXPECT_EQ(left.mount->trunk_height_m, 0.3);
  const auto front = std::get<LinesParameters>(config.detectors[1].parameters);
  EXPECT_EQ(front.yellow, (HsvRange{{10, 10, 10}, {32, 255, 255}}));
  EXPECT_FALSE(front.mount) << "there is none of its camera";
  EXPECT_EQ(std::get<MarkerParameters>(config.detectors[2].parameters).yellow, of_hall);
}

TEST(Hall, GivesItsRegionsAndItsWhiteBalanceToItsDetectors) {
  const VisionConfig config = Read(R"(
detect_faces = false
[hall]
white_balance = [0.6, 1, 1.9]
regions.barrier = { bottom = 0.8 }
regions.light = { top = 0.2 }
[[detectors]]
name = "bar"
kind = "barrier"
[[detectors]]
name = "own"
kind = "barrier"
publish = "own/distance"
parameters.region = { bottom = 0.7 }
[[detectors]]
name = "lamp"
kind = "light"
[[detectors]]
name = "lane"
kind = "lines"
)");
  const auto region = [&](std::size_t i) {
    return std::get<BarrierParameters>(config.detectors[i].parameters).region;
  };
  EXPECT_EQ(region(0), (Region{0, 0.8, 0, 1}));
  EXPECT_FALSE(config.detectors[0].own_region);
  EXPECT_EQ(region(1), (Region{0, 0.7, 0, 1}));
  EXPECT_TRUE(config.detectors[1].own_region);
  Region of_light = LightParameters().region;
  of_light.top = 0.2;
  EXPECT_EQ(std::get<MarkerParameters>(config.detectors[2].parameters).region, of_light);
  for (const CourseEntry& entry : config.detectors) {
    EXPECT_EQ(entry.balance, (WhiteBalance{0.6, 1, 1.9})) << entry.name;
  }
  // Yellow lines under warm lamps, whose light has too little blue and too much red.
  cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(40, 120, 200));
  for (const int x : {90, 530}) bgr(cv::Rect(x, 300, 20, 180)).setTo(cv::Scalar(3, 110, 250));
  const auto lines = [&](const CourseFactory& factory) {
    return factory.make().value()->Look(bgr, 1, std::nullopt).lines.value();
  };
  EXPECT_EQ(lines(config.detectors[3].factory).contours, 2U);
  EXPECT_NE(lines(FactoryOf(config.detectors[3].parameters)).contours, 2U);
}

TEST(Hall, WithErrorsSaysWhereAndWhatWasExpected) {
  EXPECT_THAT(Said(R"(
detect_faces = false
[hall]
yellow = { from = [18, 300, 40] }
lane_m = 0
line_width_m = [0.1, 0.02]
colour = 1
white_balance = [1, 9, 1]
regions.arrow = { top = 0.9, bottom = 0.1 }
regions.lines = { top = 0.5 }
[[mounts]]
hfov_deg = 180
[[mounts]]
picture = "image_rgb"
[[mounts]]
picture = "image_rgb"
[[detectors]]
name = "front"
kind = "lines"
)"),
              ::testing::UnorderedElementsAre(
                  HasSubstr("course.toml:4:19: error: hall.yellow.from: expected [hue 0 to 179"),
                  HasSubstr("course.toml:5:10: error: hall.lane_m: "),
                  HasSubstr("course.toml:6:16: error: hall.line_width_m: expected the least"),
                  HasSubstr("course.toml:7:1: error: hall: unknown key \"colour\""),
                  HasSubstr("expected the factors [red, green, blue], each 0.2 to 5"),
                  HasSubstr("must be more than top"), HasSubstr("unknown key \"lines\""),
                  HasSubstr("course.toml:11:1: error: mounts: the key \"picture\" is missing"),
                  HasSubstr("mounts.hfov_deg: a pinhole has less"),
                  HasSubstr("there is a mount of the camera of \"image_rgb\" already")));
}

// Without one all lines counted, also those across.
TEST(LinesAlong, NeedAMountOfTheirCamera) {
  const std::string detector = R"(
[[detectors]]
name = "front"
kind = "lines"
picture = "image_left"
parameters.along = true
)";
  EXPECT_THAT(Said("detect_faces = false\n" + detector),
              ::testing::ElementsAre(
                  HasSubstr("parameters.along: needs a mount of the camera of \"image_left\"")));
  const VisionConfig config =
      Read("detect_faces = false\n[[mounts]]\npicture = \"image_left\"\n" + detector);
  EXPECT_TRUE(std::get<LinesParameters>(config.detectors[0].parameters).along);
}

TEST(CourseConfig, HasTheValuesOfEveryParameter) {
  const VisionConfig config = Read(R"(
detect_faces = false
[[detectors]]
name = "a"
kind = "lines"
parameters.yellow.from = [15, 50, 30]
parameters.region = { top = 0.5, bottom = 1, left = 0.1, right = 0.9 }
parameters.least_area_px2 = 300
parameters.most_lines = 4
parameters.least_length = 2.5
parameters.ycy_threshold = 0.1
parameters.dy_threshold = 0.1
parameters.ycy_pair = "innermost"
parameters.ycy_center = 0.6
parameters.dy_target = 0.4
parameters.walk_bottom_px = 10
parameters.walk_x_px = 80
parameters.edge_columns = 12
parameters.most_coverage = 0.3
[[detectors]]
name = "b"
kind = "arrow"
parameters.green.to = [80, 255, 255]
parameters.region.top = 0.1
parameters.least_area_px2 = 1
parameters.kernel_px = 1
parameters.most_misfit = 0.2
parameters.clearly = 2
parameters.other_shapes = false
parameters.most_shape_misfit = 0.2
[[detectors]]
name = "c"
kind = "barrier"
parameters.red = { from = [160, 40, 40], to = [5, 255, 255] }
parameters.region.top = 0.1
parameters.least_area_px2 = 1
parameters.least_length = 2
parameters.least_fill = 0.5
parameters.most_tilt_deg = 10
parameters.top = 0.2
parameters.height_m = 0.1
parameters.focal_px = 500
parameters.striped = false
parameters.yellow.from = [14, 110, 50]
[[detectors]]
name = "d"
kind = "light"
parameters.most_area_px2 = 9000
parameters.kernel_px = 3
parameters.least_aspect = 0.7
parameters.round_only = false
parameters.shines = false
parameters.size_m = 0.1
parameters.focal_px = 500
parameters.sightings = 3
parameters.misses = 4
parameters.passed_within_m = 2
[[detectors]]
name = "e"
kind = "qr"
parameters.words = ["left", "right"]
parameters.min_repeats = 2
parameters.letters = false
parameters.thorough_every = 3
parameters.language = "eng+chi_sim"
parameters.least_confidence = 50
parameters.page_modes = [6, 7]
parameters.regions = [{ top = 0.1, bottom = 0.2 }, { left = 0.5 }]
)");
  const LinesParameters lines = {{{15, 50, 30}, {35, 255, 255}},
                                 {0.5, 1, 0.1, 0.9},
                                 300,
                                 2.5,
                                 4,
                                 false,
                                 0.1,
                                 LanePair::kInnermost,
                                 0.6,
                                 0.1,
                                 0.4,
                                 10,
                                 80,
                                 12,
                                 0.3};
  const ArrowParameters arrow = {
      {{35, 50, 50}, {80, 255, 255}}, {0.1, 1, 0, 1}, 1, 1, 0.2, 2, false, 0.2};
  const BarrierParameters barrier = {
      {{160, 40, 40}, {5, 255, 255}}, {0.1, 1, 0, 1}, 1, 2, 0.5, 10, 0.2, 0.1, 500, false,
      {{14, 110, 50}, {35, 255, 255}}};
  MarkerParameters light = LightParameters();
  light.most_area_px2 = 9000;
  light.kernel_px = 3;
  light.least_aspect = 0.7;
  light.round_only = false;
  light.shines = false;
  light.size_m = 0.1;
  light.focal_px = 500;
  light.sightings = 3;
  light.misses = 4;
  light.passed_within_m = 2;
  QrParameters qr;
  qr.words = {"left", "right"};
  qr.min_repeats = 2;
  qr.thorough_every = 3;
  qr.letters = false;
  qr.language = "eng+chi_sim";
  qr.least_confidence = 50;
  qr.page_modes = {6, 7};
  qr.regions = {{0.1, 0.2, 0, 1}, {0, 1, 0.5, 1}};
  const std::vector<CourseParameters> expected = {lines, arrow, barrier, light, qr};
  ASSERT_EQ(config.detectors.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_TRUE(config.detectors[i].parameters == expected[i]) << config.detectors[i].name;
  }
}

TEST(CourseConfig, ReportsEveryErrorOfATableWithItsPlace) {
  EXPECT_THAT(
      Said(R"([[detectors]]
name = "2nd"
kind = "arow"
picture = "image rgb"
rate_hz = -1
failurs = 3
[[detectors]]
rate_hz = 3
)"),
      ElementsAre(
          HasSubstr("course.toml:2:8: error: detectors.name: expected a name of letters"),
          HasSubstr(
              "course.toml:3:8: error: detectors.kind: expected one of qr, aruco, arrow, barrier, "
              "marker, light, lines and net, found \"arow\"; did you mean \"arrow\"?"),
          HasSubstr("course.toml:4:11: error: detectors.picture: expected the name of a topic"),
          HasSubstr("course.toml:5:11: error: detectors.rate_hz: expected a number from 0"),
          HasSubstr("course.toml:6:1: error: detectors: unknown key \"failurs\"; did you mean "
                    "\"failures\"?"),
          HasSubstr("course.toml:7:1: error: detectors: the key \"name\" is missing"),
          HasSubstr("course.toml:7:1: error: detectors: the key \"kind\" is missing")));
}

TEST(CourseConfig, ReportsEveryErrorOfTheParametersWithItsPlace) {
  EXPECT_THAT(
      Said(R"([[detectors]]
name = "sign"
kind = "marker"
[detectors.parameters]
yelow = 3
yellow = { from = [180, 0, 0], to = [20, 300, 0] }
region = { top = 0.5, bottom = 0.4, middle = 1 }
least_area_px2 = 300
most_area_px2 = 200
sightings = 0
)"),
      ElementsAre(
          HasSubstr("course.toml:5:1: error: detectors.sign.parameters: unknown key \"yelow\"; "
                    "did you mean \"yellow\"?"),
          HasSubstr("course.toml:6:19: error: detectors.sign.parameters.yellow.from: expected "
                    "[hue 0 to 179"),
          HasSubstr("course.toml:6:37: error: detectors.sign.parameters.yellow.to: expected "
                    "[hue 0 to 179"),
          HasSubstr("course.toml:7:32: error: detectors.sign.parameters.region.bottom: must be "
                    "more than top"),
          HasSubstr("course.toml:7:37: error: detectors.sign.parameters.region: unknown key "
                    "\"middle\""),
          HasSubstr("course.toml:9:17: error: detectors.sign.parameters.most_area_px2: must not"),
          HasSubstr("course.toml:10:13: error: detectors.sign.parameters.sightings: expected an "
                    "integer from 1")));
  EXPECT_THAT(Said(R"([[detectors]]
name = "lane"
kind = "lines"
parameters.dy_threshold = 0.81
parameters.yellow = { from = [15, 50, 30], to = [35, 40, 255] }
)"),
              ElementsAre(HasSubstr("course.toml:4:27: error: detectors.lane.parameters."
                                    "dy_threshold: expected a number from 0 to 0.5, found 0.81"),
                          HasSubstr("course.toml:5:49: error: detectors.lane.parameters.yellow.to: "
                                    "the saturation must not be less")));
}

TEST(CourseConfig, RefusesTwoDetectorsOfOneNameOrTopic) {
  EXPECT_THAT(Said(R"([[detectors]]
name = "board"
kind = "qr"
[[detectors]]
name = "board"
kind = "arrow"
[[detectors]]
name = "other"
kind = "qr"
publish = "/qr_detector/text"
[[detectors]]
name = "near"
kind = "marker"
publish = "/wedding/perception/target"
)"),
              ElementsAre(HasSubstr("course.toml:5:8: error: detectors.board.name: \"board\" is "
                                    "the name of the detector in line 2 already"),
                          HasSubstr("course.toml:10:11: error: detectors.other.publish: the topic "
                                    "\"/qr_detector/sighting\" is published by \"board\" already"),
                          HasSubstr("course.toml:14:11: error: detectors.near.publish: the topic "
                                    "\"/wedding/perception/target\" is published by the face "
                                    "detection already")));
}

TEST(CourseConfig, RefusesAFileThatDetectsNothing) {
  EXPECT_THAT(Said("\ndetect_faces = false\n"),
              ElementsAre(HasSubstr("course.toml:2:16: error: detect_faces: nothing is detected")));
}

}  // namespace musher::vision::course_config_test
