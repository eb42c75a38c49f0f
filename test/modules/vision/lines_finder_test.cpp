// Yellow lines in drawn pictures, each rule at its limits, and on the ground of the simulated
// world.

#include "musher/modules/vision/course/lines_finder.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include "musher/test/modules/vision/course_pictures.hpp"

namespace musher::vision::lines_finder_test {

using ::testing::ElementsAre;

LinesParameters WholePicture() {
  LinesParameters parameters;
  parameters.region = {};
  return parameters;
}

// A line of 20 x 100 pixels whose centroid has that x; a second one for a second x.
cv::Mat Upright(const std::vector<int>& middles, int y = 300) {
  cv::Mat bgr = GreyPicture();
  for (const int x : middles) bgr(cv::Rect(x - 10, y, 20, 100)).setTo(kYellow);
  return bgr;
}

std::string Ycy(const std::vector<int>& middles) {
  return FindLines(Upright(middles), WholePicture()).lines.ycy;
}

TEST(Lines, BesideTheMiddleOfTwoIsLeftOrRightBeyondTheThreshold) {
  EXPECT_EQ(Ycy({100, 540}), "center");
  // 0.08 of 640 pixels are 51.
  EXPECT_EQ(Ycy({200, 540}), "center");
  EXPECT_EQ(Ycy({203, 540}), "left");  // the middle at 375 is right of the robot
  EXPECT_EQ(Ycy({100, 440}), "center");
  EXPECT_EQ(Ycy({100, 436}), "right");
}

TEST(Lines, OnOneSideCountByTheirMiddleToo) {
  EXPECT_EQ(Ycy({400, 600}), "left");
  EXPECT_EQ(Ycy({40, 240}), "right");
  EXPECT_EQ(Ycy({40, 240, 600}), "center");
}

// The lane's offset, with each pair; `center` is where its middle has to be.
struct Offsets {
  double outermost = 0, innermost = 0;
};

Offsets OffsetsOf(const std::vector<int>& middles, double center = 0.5) {
  LinesParameters parameters = WholePicture();
  parameters.ycy_center = center;
  Offsets offsets;
  for (const LanePair pair : {LanePair::kOutermost, LanePair::kInnermost}) {
    parameters.ycy_pair = pair;
    const float offset = FindLines(Upright(middles), parameters).lines.middle_offset;
    (pair == LanePair::kOutermost ? offsets.outermost : offsets.innermost) = double(offset);
  }
  return offsets;
}

constexpr double kHalfPx = 0.5 / 640;

TEST(InnermostLines, AreTheNearestToTheCentreOnEitherSide) {
  const Offsets offsets = OffsetsOf({20, 280, 440, 500});
  EXPECT_NEAR(offsets.outermost, (260.0 - 320) / 640, kHalfPx);
  EXPECT_NEAR(offsets.innermost, (360.0 - 320) / 640, kHalfPx);
  LinesParameters parameters = WholePicture();
  EXPECT_EQ(FindLines(Upright({20, 280, 440, 500}), parameters).lines.ycy, "right");
  parameters.ycy_pair = LanePair::kInnermost;
  parameters.ycy_threshold = 0.06;
  EXPECT_EQ(FindLines(Upright({20, 280, 440, 500}), parameters).lines.ycy, "left");
}

TEST(InnermostLines, AreTheOnlyTwoOfALane) {
  const Offsets offsets = OffsetsOf({200, 540});
  EXPECT_NEAR(offsets.innermost, (370.0 - 320) / 640, kHalfPx);
  EXPECT_EQ(offsets.innermost, offsets.outermost);
}

TEST(InnermostLines, AreTheOutermostWhereASideHasNone) {
  EXPECT_NEAR(OffsetsOf({400, 460, 600}).innermost, (500.0 - 320) / 640, kHalfPx);
  EXPECT_NEAR(OffsetsOf({40, 180, 240}).innermost, (140.0 - 320) / 640, kHalfPx);
}

TEST(InnermostLines, AreThoseBesideTheCentreOfTheKey) {
  EXPECT_NEAR(OffsetsOf({100, 300, 500}).innermost, (400.0 - 320) / 640, kHalfPx);
  EXPECT_NEAR(OffsetsOf({100, 300, 500}, 0.4).innermost, (200.0 - 256) / 640, kHalfPx);
  EXPECT_NEAR(OffsetsOf({100, 300, 500}, 0.4).outermost, (300.0 - 256) / 640, kHalfPx);
}

TEST(InnermostLine, OnTheCentreIsThatOfBothSides) {
  const Offsets offsets = OffsetsOf({320, 600});  // its centroid is the centre
  EXPECT_NEAR(offsets.innermost, 0, 1e-6);
  EXPECT_NEAR(offsets.outermost, (460.0 - 320) / 640, kHalfPx);
}

RC_GTEST_PROP(InnermostLines, DoNotDependOnLinesBeyondThem, ()) {
  const int left = *rc::gen::inRange(100, 305), right = *rc::gen::inRange(340, 540);
  std::vector<int> middles{left, right};
  const Offsets of_two = OffsetsOf(middles);
  if (*rc::gen::arbitrary<bool>()) middles.push_back(*rc::gen::inRange(15, left - 29));
  if (*rc::gen::arbitrary<bool>()) middles.push_back(*rc::gen::inRange(right + 30, 625));
  RC_ASSERT(OffsetsOf(middles).innermost == of_two.innermost);
}

TEST(Line, SeenAloneIsTheNearOne) {
  EXPECT_EQ(Ycy({100}), "left");
  EXPECT_EQ(Ycy({300}), "left");
  EXPECT_EQ(Ycy({340}), "right");
  EXPECT_EQ(Ycy({600}), "right");
}

// Upright at x, without its rows from `gap_from` to `gap_to`: a foot stands on it.
cv::Mat Cut(int x, int gap_from, int gap_to) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(x - 10, 100, 20, 350)).setTo(kYellow);
  bgr.rowRange(gap_from, gap_to).setTo(kGrey);
  return bgr;
}

TEST(LineInTwoPieces, IsOneLine) {
  for (const int x : {100, 250}) {
    const msg::YellowLines lines = FindLines(Cut(x, 200, 260), WholePicture()).lines;
    EXPECT_EQ(lines.contours, 1U) << x;
    EXPECT_EQ(lines.ycy, "left") << x;
  }
  EXPECT_EQ(FindLines(Cut(400, 200, 260), WholePicture()).lines.ycy, "right");
}

RC_GTEST_PROP(LineInPieces, SaysWhatTheWholeLineSays, ()) {
  const int x = *rc::gen::inRange(20, 300);
  const int from = *rc::gen::inRange(150, 300), to = from + *rc::gen::inRange(5, 100);
  cv::Mat bgr = Cut(x, from, to);
  // A second, whole line on the other side.
  bgr(cv::Rect(*rc::gen::inRange(340, 600), 100, 20, 350)).setTo(kYellow);
  const msg::YellowLines cut = FindLines(bgr, WholePicture()).lines;
  bgr(cv::Rect(x - 10, 100, 20, 350)).setTo(kYellow);
  const msg::YellowLines whole = FindLines(bgr, WholePicture()).lines;
  RC_ASSERT(cut.ycy == whole.ycy);
  RC_ASSERT(cut.contours == 2U && whole.contours == 2U);
}

TEST(FloorOfTheColorOfTheLines, IsADoubtAndNoLine) {
  const cv::Mat floor(480, 640, CV_8UC3, kYellow);
  const msg::YellowLines lines = FindLines(floor, {}).lines;
  EXPECT_EQ(lines.doubt, "the floor has the colour of the lines: 100 % of the region");
  EXPECT_EQ(lines.contours, 0U);
  EXPECT_EQ(lines.ycy, "center");
  EXPECT_TRUE(lines.edge_x.empty());
}

TEST(LinesOnAFloorOfTheirColor, AreWhatIsClearlyMoreSaturated) {
  cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(90, 150, 190));  // wood
  EXPECT_NE(FindLines(bgr, WholePicture()).lines.doubt, "");
  for (const int x : {190, 530}) bgr(cv::Rect(x, 300, 20, 100)).setTo(kYellow);
  const msg::YellowLines lines = FindLines(bgr, WholePicture()).lines;
  EXPECT_EQ(lines.doubt, "");
  EXPECT_EQ(lines.contours, 2U);
  EXPECT_EQ(lines.ycy, "center");
}

TEST(Lines, ThatAreMissingAreNoneAndCenter) {
  const msg::YellowLines none = FindLines(GreyPicture(), {}).lines;
  EXPECT_EQ(none.contours, 0U);
  EXPECT_EQ(none.ycy + none.dy + none.walk, "centercentercenter");
  EXPECT_TRUE(std::isnan(none.middle_offset) && std::isnan(none.line_offset));
  EXPECT_TRUE(std::isnan(none.bottom_gap_px));
  EXPECT_EQ(none.area_px2, 0);
  EXPECT_TRUE(none.edge_x.empty() && none.edge_y.empty());
}

TEST(Lines, SmallerThanTheLeastAreaDoNotCount) {
  LinesParameters parameters = WholePicture();
  parameters.least_area_px2 = 19 * 99;  // that an outline of 20 x 100 pixels encloses
  EXPECT_EQ(FindLines(Upright({100, 500}), parameters).lines.contours, 2U);
  EXPECT_FLOAT_EQ(FindLines(Upright({100, 500}), parameters).lines.area_px2, 2 * 19 * 99);
  parameters.least_area_px2 += 1;
  EXPECT_EQ(FindLines(Upright({100, 500}), parameters).lines.contours, 0U);
}

TEST(Lines, CountUpToTheMostOfThemAndTheLargestFirst) {
  cv::Mat bgr = Upright({50, 150, 250, 350, 450});
  bgr(cv::Rect(560, 300, 30, 100)).setTo(kYellow);
  EXPECT_EQ(FindLines(bgr, WholePicture()).lines.contours, 5U);
  LinesParameters one = WholePicture();
  one.most_lines = 1;
  EXPECT_EQ(FindLines(bgr, one).lines.ycy, "right");
}

// A line of 200 x 20 pixels whose middle row is y.
msg::YellowLines Across(int y, const LinesParameters& parameters, int x = 220) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(x, y - 10, 200, 20)).setTo(kYellow);
  return FindLines(bgr, parameters).lines;
}

TEST(Line, AcrossIsFrontOrBackOfItsTarget) {
  // 0.15 of 480 rows are 72: from 168 to 312.
  EXPECT_EQ(Across(240, WholePicture()).dy, "center");
  EXPECT_EQ(Across(165, WholePicture()).dy, "front");
  EXPECT_EQ(Across(171, WholePicture()).dy, "center");
  EXPECT_EQ(Across(309, WholePicture()).dy, "center");
  EXPECT_EQ(Across(315, WholePicture()).dy, "back");
  LinesParameters nearer = WholePicture();
  nearer.dy_target = 0.75;
  EXPECT_EQ(Across(240, nearer).dy, "front");
  EXPECT_NEAR(Across(240, nearer).line_offset, -0.25, 1e-3);
  EXPECT_EQ(Across(360, nearer).dy, "center");
}

TEST(Line, AcrossIsDistinguishedFromOneBesideItByItsLength) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(180, 140, 200, 20)).setTo(kYellow);
  bgr(cv::Rect(310, 300, 30, 100)).setTo(kYellow);  // ahead, and nearer to the centre line
  EXPECT_EQ(FindLines(bgr, WholePicture()).lines.dy, "back");
  LinesParameters across = WholePicture();
  across.least_length = 3;
  const msg::YellowLines lines = FindLines(bgr, across).lines;
  EXPECT_EQ(lines.contours, 1U);
  EXPECT_EQ(lines.dy, "front");
  across.least_length = 11;
  EXPECT_EQ(FindLines(bgr, across).lines.contours, 0U) << "it is 10 times as wide as high";
}

TEST(Line, ThatIsNearestToTheCentreLineIsTheOneOfDyAndWalk) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(20, 20, 200, 20)).setTo(kYellow);
  bgr(cv::Rect(300, 400, 100, 20)).setTo(kYellow);
  const msg::YellowLines lines = FindLines(bgr, WholePicture()).lines;
  EXPECT_EQ(lines.dy, "back");
  EXPECT_EQ(lines.bottom_gap_px, 60);
}

TEST(Line, OfAWalkIsBackNearTheBottomAndElseFrontWhenItIsAside) {
  const auto walk = [](int y, int x) { return Across(y, WholePicture(), x).walk; };
  EXPECT_EQ(walk(419, 220), "center");  // 51 rows below it
  EXPECT_EQ(walk(421, 220), "back");
  EXPECT_EQ(walk(300, 220 + 29), "center");
  EXPECT_EQ(walk(300, 220 + 32), "front");
  EXPECT_EQ(walk(300, 220 - 32), "front");
  EXPECT_EQ(walk(421, 220 + 32), "back");
}

TEST(Lines, AreSearchedInTheRegionOnly) {
  LinesParameters lower;
  lower.region = {0.5, 1, 0, 1};
  EXPECT_EQ(Across(200, lower).contours, 0U);
  const msg::YellowLines lines = Across(360, lower);
  EXPECT_EQ(lines.contours, 1U);
  EXPECT_NEAR(lines.line_offset, 0, 1e-3);
  EXPECT_EQ(lines.bottom_gap_px, 110);
  EXPECT_NEAR(lines.edge_y.at(0), 369.5 / 480, 1e-4);
}

TEST(Edge, IsTheLowestPixelInEachColumnThatHasOne) {
  LinesParameters four = WholePicture();
  four.edge_columns = 4;  // at 80, 240, 400 and 560
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(200, 100, 100, 50)).setTo(kYellow);
  bgr(cv::Rect(200, 200, 300, 50)).setTo(kYellow);
  const msg::YellowLines lines = FindLines(bgr, four).lines;
  EXPECT_THAT(lines.edge_x, ElementsAre(240.5F / 640, 400.5F / 640));
  EXPECT_THAT(lines.edge_y, ElementsAre(249.5F / 480, 249.5F / 480));
}

TEST(Lines, NeedBrightEnoughYellow) {
  LinesParameters whole = WholePicture();
  for (const auto& [color, is_yellow] :
       {std::pair(cv::Scalar(20, 206, 246), true), std::pair(cv::Scalar(40, 120, 140), true),
        std::pair(cv::Scalar(225, 245, 255), false), std::pair(cv::Scalar(40, 200, 60), false),
        std::pair(cv::Scalar(30, 60, 220), false)}) {
    cv::Mat bgr = GreyPicture();
    bgr(cv::Rect(100, 100, 100, 100)).setTo(color);
    EXPECT_EQ(FindLines(bgr, whole).lines.contours, is_yellow ? 1U : 0U) << color;
  }
}

RC_GTEST_PROP(LinesProperty, OfAMirroredPictureAreOnTheOtherSide, ()) {
  cv::Mat bgr = GreyPicture();
  const int count = *rc::gen::inRange(0, 4);
  for (int i = 0; i < count; ++i) {
    bgr(cv::Rect(*rc::gen::inRange(0, 600), *rc::gen::inRange(0, 380), 40, 100)).setTo(kYellow);
  }
  const msg::YellowLines lines = FindLines(bgr, {}).lines;
  const msg::YellowLines mirrored = FindLines(Mirrored(bgr), {}).lines;
  const std::string other = lines.ycy == "left"    ? "right"
                            : lines.ycy == "right" ? "left"
                                                   : "center";
  RC_ASSERT(mirrored.ycy == other);
  RC_ASSERT(mirrored.contours == lines.contours);
}

// A lane along x, 0.83 m wide.
world::Scene Lane() {
  world::Scene scene = HallScene();
  for (const double y : {-0.44, 0.44}) {
    world::Line line;
    line.points_m = {{-3, y}, {3, y}};
    scene.lines.push_back(line);
  }
  return scene;
}

// The same, across the robot's heading.
world::Pose2 At(double x_m, double y_m, double yaw_deg) {
  return {{x_m, y_m}, yaw_deg * M_PI / 180};
}

TEST(LaneAhead, IsInTheMiddleLeftOrRightAsTheRobotStands) {
  const auto lane = world::SceneryOf(Lane());
  const auto lines = [&](double y_m, double threshold) {
    LinesParameters parameters;
    parameters.ycy_threshold = threshold;
    return FindLines(SceneShot(*lane, CourseCamera::kFront, At(-2, y_m, 0)), parameters).lines;
  };
  EXPECT_EQ(lines(0, 0.04).ycy, "center");
  EXPECT_EQ(lines(0.1, 0.04).ycy, "left");
  EXPECT_EQ(lines(-0.1, 0.04).ycy, "right");
  EXPECT_EQ(lines(0.15, 0.08).ycy, "center");
  EXPECT_EQ(lines(0.21, 0.08).ycy, "left");
  EXPECT_NEAR(lines(0.1, 0.08).middle_offset, 0.05, 0.01);
}

// What the detector knows of the camera.
LinesParameters Mounted() {
  LinesParameters parameters;
  parameters.ycy_threshold = 0.05;
  parameters.mount.emplace();
  const world::CameraSpec spec = world::CameraSet().cameras[std::size_t(CourseCamera::kFront)];
  navigation::MountedCamera& camera = parameters.mount->camera;
  camera.x_m = spec.position_m.x();
  camera.z_m = spec.position_m.z();
  camera.pitch_rad = spec.pitch_rad;
  camera.hfov_rad = spec.hfov_rad;
  return parameters;
}

TEST(OnlyLineOfALane, IsEnoughForItsMiddle) {
  world::Scene lane = Lane();
  lane.lines.pop_back();  // the one on the left
  const auto scenery = world::SceneryOf(lane);
  const auto ycy = [&](double y_m, const LinesParameters& parameters) {
    return FindLines(SceneShot(*scenery, CourseCamera::kFront, At(-2, y_m, 0)), parameters)
        .lines.ycy;
  };
  EXPECT_EQ(ycy(0, Mounted()), "center");
  EXPECT_EQ(ycy(0.2, Mounted()), "left");
  EXPECT_EQ(ycy(-0.2, Mounted()), "right");
  LinesParameters without = Mounted();
  without.mount.reset();
  EXPECT_EQ(ycy(0, without), "right") << "of the line on the right only its side is known";
}

TEST(LaneModel, SaysItsUncertaintyInMetres) {
  const auto lane = world::SceneryOf(Lane());
  world::Scene single = Lane();
  single.lines.pop_back();  // the one on the left
  const auto one = world::SceneryOf(single);
  for (const double y_m : {-0.2, 0.0, 0.1, 0.2}) {
    const auto lines = [&](const auto& scenery, const LinesParameters& parameters) {
      return FindLines(SceneShot(*scenery, CourseCamera::kFront, At(-2, y_m, 0)), parameters).lines;
    };
    const msg::YellowLines both = lines(lane, Mounted()), only = lines(one, Mounted());
    EXPECT_GT(both.uncertainty_m, 0);
    EXPECT_LT(both.uncertainty_m, 0.05);
    EXPECT_NEAR(both.middle_m, y_m, both.uncertainty_m);
    EXPECT_GT(only.uncertainty_m, both.uncertainty_m) << "the width of the lane counts, too";
    EXPECT_NEAR(only.middle_m, y_m, only.uncertainty_m);
  }
  LinesParameters without = Mounted();
  without.mount.reset();
  const cv::Mat bgr = SceneShot(*lane, CourseCamera::kFront, At(-2, 0.2, 0));
  EXPECT_EQ(FindLines(bgr, without).lines.uncertainty_m, 0) << "without a mount it is not known";
}

// Two lines that are not as far apart as those of a lane: one of them is none, or of another lane.
// A doubt would hide all else that the picture says, and a robot that keeps to the lane would
// stand.
TEST(LaneModel, SaysLeftOrRightAlsoWithinItsUncertainty) {
  LinesParameters parameters = Mounted();
  parameters.lane_m = 1.2;
  parameters.ycy_threshold = 0.03;
  const auto lane = world::SceneryOf(Lane());
  const auto lines = [&](double y_m) {
    return FindLines(SceneShot(*lane, CourseCamera::kFront, At(-2, y_m, 0)), parameters).lines;
  };
  const msg::YellowLines near = lines(0.1), far = lines(0.25);
  EXPECT_NEAR(near.uncertainty_m, (1.2 - 0.88) / 2, 0.02);
  EXPECT_LT(std::abs(near.middle_m), near.uncertainty_m);
  EXPECT_EQ(near.doubt, "");
  EXPECT_EQ(near.ycy, "left");
  EXPECT_EQ(far.doubt, "");
  EXPECT_EQ(far.ycy, "left");
}

TEST(OnlyLine, FartherAwayThanALaneIsWideIsADoubt) {
  world::Scene lane = Lane();
  lane.lines.pop_back();
  const auto scenery = world::SceneryOf(lane);
  const auto found = [&](double y_m) {
    return FindLines(SceneShot(*scenery, CourseCamera::kFront, At(-2, y_m, 0)), Mounted()).lines;
  };
  EXPECT_EQ(found(0.2).doubt, "");
  const msg::YellowLines far = found(0.6);
  EXPECT_EQ(far.contours, 1U);
  EXPECT_NE(far.doubt, "");
  EXPECT_EQ(far.ycy, "center");
}

// Of another lane, which crosses beside it: its line passed for one of this lane, and the robot was
// in the middle of both by chance.
TEST(LineAcross, IsNoneOfALaneAlongWhichTheCameraLooks) {
  world::Scene lane = Lane();
  world::Line across;
  across.points_m = {{-0.9, -0.6}, {-0.9, -1.6}};
  lane.lines.push_back(across);
  const auto scenery = world::SceneryOf(lane);
  LinesParameters parameters = Mounted();
  parameters.region = {0.5, 1, 0, 1};
  parameters.along = true;
  const auto lines = [&](double y_m) {
    return FindLines(SceneShot(*scenery, CourseCamera::kFront, At(-2, y_m, 0)), parameters).lines;
  };
  EXPECT_EQ(lines(0).contours, 2U);
  EXPECT_EQ(lines(0).ycy, "center") << lines(0).doubt;
  EXPECT_EQ(lines(-0.25).ycy, "right");
  EXPECT_EQ(lines(0.25).ycy, "left");
}

// At the end of a bay: its end was inside the region, and beside the centre, as soon as the robot
// came nearer. The middle between it and a line of the bay was in the middle, 0.25 m beside it.
TEST(LineAcross, AheadIsNoneOfTheTwoBesideTheCentre) {
  world::Scene lane = Lane();
  world::Line across;
  across.points_m = {{-0.5, -0.34}, {-0.5, 0.34}};
  lane.lines.push_back(across);
  const auto scenery = world::SceneryOf(lane);
  LinesParameters parameters = Mounted();
  parameters.region = {0.6, 0.8, 0, 1};
  parameters.ycy_pair = LanePair::kInnermost;
  int with_it = 0;
  for (double x_m = -2.4; x_m < -1.2; x_m += 0.05) {
    for (const double y_m : {-0.25, 0.25}) {
      const auto lines =
          FindLines(SceneShot(*scenery, CourseCamera::kFront, At(x_m, y_m, 0)), parameters).lines;
      if (lines.contours == 3) ++with_it;
      EXPECT_EQ(lines.ycy, y_m < 0 ? "right" : "left") << x_m << ", " << y_m << lines.doubt;
      EXPECT_NEAR(lines.middle_m, y_m, 0.05) << x_m << ", " << y_m;
    }
  }
  EXPECT_GT(with_it, 5);
}

TEST(LinesAlong, ThatAreNoLaneApartAreADoubt) {
  world::Scene lane = Lane();
  lane.lines.pop_back();
  LinesParameters parameters = Mounted();
  parameters.along = true;
  const auto lines =
      FindLines(SceneShot(lane, CourseCamera::kFront, At(-2, -0.1, 0)), parameters).lines;
  EXPECT_EQ(lines.doubt, "no two of the lines are as far apart as those of a lane");
  EXPECT_EQ(lines.ycy, "center");
}

// Of lanes side by side, the line between them worn away.
TEST(LinesOfTwoLanes, AreNotThoseOfOne) {
  world::Scene lanes = HallScene();
  LinesParameters far = Mounted();
  far.region = {0.5, 1, 0, 1};
  for (const double side : {1.0, -1.0}) {
    lanes.lines.clear();
    for (const double y : {-0.44 * side, 1.32 * side}) {
      world::Line line;
      line.points_m = {{-3, y}, {3, y}};
      lanes.lines.push_back(line);
    }
    const msg::YellowLines lines =
        FindLines(SceneShot(lanes, CourseCamera::kFront, At(-2, 0, 0)), far).lines;
    EXPECT_EQ(lines.contours, 2U);
    EXPECT_EQ(lines.doubt, "");
    EXPECT_EQ(lines.ycy, "center") << side << ": " << lines.middle_offset;
  }
}

TEST(WhatIsWiderThanALine, IsNone) {
  world::Scene hall = HallScene();
  world::Line carpet;
  carpet.points_m = {{-1.2, 0.3}, {0, 0.3}};
  carpet.width_m = 0.4;
  hall.lines.push_back(carpet);
  const cv::Mat bgr = SceneShot(hall, CourseCamera::kFront, At(-2, 0, 0));
  const msg::YellowLines lines = FindLines(bgr, Mounted()).lines;
  EXPECT_EQ(lines.contours, 0U);
  EXPECT_NE(lines.doubt.find("m wide, which no line is"), std::string::npos) << lines.doubt;
}

TEST(LaneAcross, IsSeenByAFisheye) {
  // The robot looks across the lane, so that the lane's lines run from left to right.
  const auto lane = world::SceneryOf(Lane());
  for (const auto& [camera, yaw_deg] :
       {std::pair(CourseCamera::kRight, 0.0), std::pair(CourseCamera::kLeft, 0.0)}) {
    const msg::YellowLines lines = FindLines(SceneShot(*lane, camera, At(0, 0, yaw_deg)), {}).lines;
    EXPECT_EQ(lines.contours, 1U);
    EXPECT_GE(lines.edge_x.size(), 12U);
    EXPECT_NEAR(lines.middle_offset, 0, 0.08);
  }
}

TEST(LineBeside, IsNearerToTheBottomTheNearerTheRobotIs) {
  const auto lane = world::SceneryOf(Lane());
  const auto middle = [&](double y_m) {
    const msg::YellowLines lines =
        FindLines(SceneShot(*lane, CourseCamera::kRight, At(0, y_m, 0)), {}).lines;
    EXPECT_FALSE(lines.edge_y.empty());
    return lines.edge_y.empty() ? 0 : lines.edge_y[lines.edge_y.size() / 2];
  };
  EXPECT_LT(middle(0.1), middle(0));
  EXPECT_LT(middle(0), middle(-0.1));
}

TEST(LaneOfASide, IsLeftOrRightInTheFisheyesPicture) {
  // The robot stands across the lane: in the right picture, left is ahead.
  const auto lane = world::SceneryOf(Lane());
  LinesParameters parameters;
  parameters.ycy_threshold = 0.03;
  const auto ycy = [&](CourseCamera camera, double ahead_m) {
    return FindLines(SceneShot(*lane, camera, At(0, ahead_m - 0.22, 90)), parameters).lines.ycy;
  };
  EXPECT_EQ(ycy(CourseCamera::kRight, 0), "center");
  EXPECT_EQ(ycy(CourseCamera::kRight, 0.1), "left");
  EXPECT_EQ(ycy(CourseCamera::kRight, -0.1), "right");
  EXPECT_EQ(ycy(CourseCamera::kLeft, 0.1), "right");
  EXPECT_EQ(ycy(CourseCamera::kLeft, -0.1), "left");
}

TEST(Lines, AreNotFoundInNoise) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_EQ(FindLines(NoisePicture(seed), {}).lines.contours, 0U) << seed;
  }
}

}  // namespace musher::vision::lines_finder_test
