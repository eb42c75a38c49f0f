// Yellow signs and lights: drawn, and in the simulated world; and their track from picture to
// picture.

#include "musher/modules/vision/course/marker_finder.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "musher/modules/vision/course/marker_tracker.hpp"
#include "musher/test/modules/vision/course_pictures.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::vision::marker_finder_test {

using Phase = MarkerTracker::Phase;

cv::Mat WithDisc(const cv::Point& center, int radius) {
  cv::Mat bgr = GreyPicture();
  cv::circle(bgr, center, radius, kYellow, cv::FILLED, cv::LINE_AA);
  return bgr;
}

TEST(Marker, IsRoundOrSquare) {
  const auto disc = FindMarker(WithDisc({300, 100}, 30), {});
  ASSERT_TRUE(disc);
  EXPECT_TRUE(disc->round);
  EXPECT_NEAR(disc->size_px, 61, 1.5);
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(200, 100, 60, 60)).setTo(kYellow);
  const auto square = FindMarker(bgr, {});
  ASSERT_TRUE(square);
  EXPECT_FALSE(square->round);
  EXPECT_NEAR(square->size_px, 60, 1);
}

TEST(Marker, IsSearchedWhereItHangs) {
  EXPECT_TRUE(FindMarker(WithDisc({300, 214}, 30), {}));
  EXPECT_FALSE(FindMarker(WithDisc({300, 218}, 30), {}));
  EXPECT_FALSE(FindMarker(WithDisc({300, 20}, 30), {})) << "cut by the picture";
}

TEST(Marker, IsNeitherTooSmallNorTooLarge) {
  EXPECT_FALSE(FindMarker(WithDisc({300, 100}, 6), {}));
  EXPECT_TRUE(FindMarker(WithDisc({300, 100}, 10), {}));
  EXPECT_TRUE(FindMarker(WithDisc({300, 100}, 65), {}));
  EXPECT_FALSE(FindMarker(WithDisc({300, 100}, 72), {}));
}

// The wall's mask and the sign's were one outline.
TEST(Marker, IsFoundBeforeAWallOfItsColor) {
  cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(110, 165, 205));
  cv::circle(bgr, {300, 100}, 30, kYellow, cv::FILLED, cv::LINE_AA);
  const auto disc = FindMarker(bgr, {});
  ASSERT_TRUE(disc);
  EXPECT_NEAR(disc->size_px, 61, 5);
  bgr.setTo(cv::Scalar(110, 165, 205));
  EXPECT_FALSE(FindMarker(bgr, {}));
}

// It is as yellow as the wall, which is darker; where the camera clips it, its hue is that of
// signs.
TEST(Marker, IsNotWhitePaperInWarmLight) {
  cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(100, 140, 186));
  cv::circle(bgr, {300, 100}, 30, cv::Scalar(140, 200, 255), cv::FILLED, cv::LINE_AA);
  EXPECT_FALSE(FindMarker(bgr, {}));
}

// A leaf, fruit or fur of the hue of signs, as round as one: found as a sign in photographs.
TEST(Marker, IsOfOnePaint) {
  cv::RNG random(3);
  cv::Mat blotches(12, 16, CV_8UC3), bgr(480, 640, CV_8UC3);
  for (int i = 0; i < int(blotches.total()); ++i) {
    blotches.at<cv::Vec3b>(i) =
        cv::Vec3b(std::uint8_t(random.uniform(19, 31)), std::uint8_t(random.uniform(90, 250)), 220);
  }
  cv::resize(blotches, bgr, bgr.size(), 0, 0, cv::INTER_CUBIC);
  cv::cvtColor(bgr, bgr, cv::COLOR_HSV2BGR);
  cv::Mat disc = cv::Mat::zeros(bgr.size(), CV_8U);
  cv::circle(disc, {300, 100}, 40, 255, cv::FILLED);
  cv::Mat leaf = GreyPicture();
  bgr.copyTo(leaf, disc);
  EXPECT_FALSE(FindMarker(leaf, {}));
  EXPECT_TRUE(FindMarker(WithDisc({300, 100}, 40), {}));
}

// White paper in the light of warm lamps before what is dark was found as a sign.
TEST(Marker, IsMoreSaturatedThanPaperInTheWarmestLight) {
  cv::Mat bgr = GreyPicture();
  cv::circle(bgr, {300, 100}, 30, cv::Scalar(164, 229, 254), cv::FILLED, cv::LINE_AA);
  EXPECT_FALSE(FindMarker(bgr, {}));
}

TEST(Yellow, ThatIsALineOrATriangleOrAnArrowIsNoMarker) {
  cv::Mat line = GreyPicture();
  line(cv::Rect(100, 100, 200, 30)).setTo(kYellow);
  cv::Mat triangle = GreyPicture();
  cv::fillPoly(triangle, std::vector<Contour>{{{200, 100}, {280, 100}, {240, 170}}}, kYellow);
  cv::Mat arrow = GreyPicture();
  cv::fillPoly(arrow, std::vector{ArrowCorners({200, 80, 120, 90}, 0.4, 0.4)}, kYellow);
  cv::Mat ring = WithDisc({300, 100}, 40);
  cv::ellipse(ring, {300, 100}, {45, 45}, 0, 30, 150, kGrey, cv::FILLED);
  for (const cv::Mat& bgr : {line, triangle, arrow, ring}) EXPECT_FALSE(FindMarker(bgr, {}));
}

TEST(Light, IsABallBeforeALineOfItsColour) {
  cv::Mat bgr = WithDisc({300, 240}, 40);
  bgr(cv::Rect(0, 236, 640, 12)).setTo(kYellow);
  const auto light = FindMarker(bgr, LightParameters());
  ASSERT_TRUE(light);
  EXPECT_NEAR(light->size_px, 81, 6);
  cv::Mat square = GreyPicture();
  square(cv::Rect(300, 200, 80, 80)).setTo(kYellow);
  EXPECT_FALSE(FindMarker(square, LightParameters()));
}

// A ball of light in that place: its colour from its middle to its rim.
cv::Mat WithLamp(const std::vector<std::pair<int, cv::Scalar>>& rings) {
  cv::Mat bgr = GreyPicture();
  for (const auto& [radius, color] : rings) {
    cv::circle(bgr, {300, 200}, radius, color, cv::FILLED, cv::LINE_AA);
  }
  return bgr;
}
const cv::Scalar kAmber(0, 150, 255);

TEST(Light, IsAmberToo) {
  const auto light = FindMarker(WithLamp({{40, kAmber}}), LightParameters());
  ASSERT_TRUE(light);
  EXPECT_NEAR(light->size_px, 81, 3);
}

TEST(Light, MayHaveAWhiteCore) {
  const cv::Scalar core(235, 252, 255);
  const cv::Scalar ring(60, 200, 255);
  for (const int core_px : {30, 36}) {
    const auto light = FindMarker(WithLamp({{40, ring}, {core_px, core}}), LightParameters());
    ASSERT_TRUE(light) << core_px;
    EXPECT_NEAR(light->size_px, 81, 6) << core_px;
  }
  EXPECT_FALSE(FindMarker(WithLamp({{40, core}}), LightParameters())) << "a white lamp";
  EXPECT_FALSE(FindMarker(WithLamp({{40, kRed}, {30, core}}), LightParameters())) << "a red one";
}

TEST(Light, IsNoYellowDiscThatDoesNotShine) {
  cv::Mat bgr = GreyPicture();
  bgr.setTo(cv::Scalar(225, 235, 235));  // a poster
  cv::circle(bgr, {300, 200}, 40, kYellow, cv::FILLED, cv::LINE_AA);
  EXPECT_FALSE(FindMarker(bgr, LightParameters()));
}

// A flower is as round and as bright, and brighter towards its rim: it was seen as a light.
TEST(Light, IsNotDarkerInItsMiddle) {
  constexpr int kRadius = 34;
  const auto with = [](bool is_flower) {
    cv::Mat bgr = GreyPicture();
    for (int radius = kRadius; radius > 0; --radius) {
      const double bright = is_flower ? 0.5 + 0.5 * radius / kRadius : 1;
      cv::circle(bgr, {320, 200}, radius, kYellow * bright, cv::FILLED);
    }
    return bgr;
  };
  EXPECT_TRUE(LookForMarker(with(false), LightParameters()).marker);
  EXPECT_FALSE(LookForMarker(with(true), LightParameters()).marker);
}

// The eye of an animal, and a leaf in the sun: brighter on one side.
TEST(Light, IsAlikeInEveryDirection) {
  const auto with = [](double brighter_aside, int radius) {
    cv::Mat bgr = GreyPicture();
    for (int y = -radius; y <= radius; ++y) {
      for (int x = -radius; x <= radius; ++x) {
        if (std::hypot(x, y) > radius) continue;
        const double bright = 1 - brighter_aside * (0.5 + 0.5 * x / double(radius));
        const cv::Scalar color = kYellow * bright;
        bgr.at<cv::Vec3b>(200 + y, 320 + x) =
            cv::Vec3b(std::uint8_t(color[0]), std::uint8_t(color[1]), std::uint8_t(color[2]));
      }
    }
    return bgr;
  };
  EXPECT_TRUE(LookForMarker(with(0, 20), LightParameters()).marker);
  EXPECT_FALSE(LookForMarker(with(0.45, 20), LightParameters()).marker);
  // Near to the robot it is a doubt, and no way that is clear.
  const MarkerLook near = LookForMarker(with(0.45, 60), LightParameters());
  EXPECT_FALSE(near.marker);
  EXPECT_THAT(near.doubt, ::testing::HasSubstr("not alike all around"));
}

TEST(Light, IsTheNearOneWithAWhiteCoreBesideAFarOne) {
  cv::Mat bgr = WithLamp({{40, {60, 200, 255}}, {37, {235, 252, 255}}});
  cv::circle(bgr, {500, 150}, 10, kYellow, cv::FILLED, cv::LINE_AA);
  const auto light = FindMarker(bgr, LightParameters());
  ASSERT_TRUE(light);
  EXPECT_NEAR(light->size_px, 81, 6);
}

// Of two colours, as warm lamps show it to a camera without a white balance.
cv::Mat WarmWall() {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(0, 0, 320, 260)).setTo(cv::Scalar(100, 150, 190));
  bgr(cv::Rect(320, 0, 320, 260)).setTo(cv::Scalar(50, 130, 190));
  return bgr;
}

MarkerLook LookBeforeWarmWall(int radius_px, const cv::Scalar& color) {
  cv::Mat bgr = WarmWall();
  cv::circle(bgr, {200, 150}, radius_px, color, cv::FILLED, cv::LINE_AA);
  return LookForMarker(bgr, LightParameters());
}

const cv::Scalar kOverexposed(235, 252, 255);  // the core of a lamp

// Each picture of a hall in warm light was a doubt.
TEST(Light, BeforeAWallOfItsColourIsSeenAndThatThereIsNone) {
  const MarkerLook wall = LookForMarker(WarmWall(), LightParameters());
  EXPECT_FALSE(wall.marker);
  EXPECT_EQ(wall.doubt, "");
  for (const int radius_px : {12, 40, 70}) {
    const MarkerLook lamp = LookBeforeWarmWall(radius_px, {60, 253, 254});
    ASSERT_TRUE(lamp.marker) << radius_px;
    EXPECT_NEAR(lamp.marker->size_px, 2 * radius_px + 1, 5);
    EXPECT_EQ(lamp.doubt, "");
  }
  EXPECT_EQ(LookForMarker(WarmWall(), {}).doubt, "") << "of a sign that does not shine";
}

TEST(Light, BeforeAWallOfItsColourMayHaveAWhiteCore) {
  cv::Mat bgr = WarmWall();
  cv::circle(bgr, {200, 150}, 40, {60, 200, 255}, cv::FILLED, cv::LINE_AA);
  cv::circle(bgr, {200, 150}, 30, {235, 252, 255}, cv::FILLED, cv::LINE_AA);
  const MarkerLook lamp = LookForMarker(bgr, LightParameters());
  EXPECT_TRUE(lamp.marker);
  EXPECT_EQ(lamp.doubt, "");
}

// It was neither a light nor a doubt: the robot walked on.
TEST(Light, BeforeAWallOfItsColourIsNoneNowhereWhereItIsOverexposed) {
  for (const int x : {180, 450}) {
    for (const bool is_all_white : {false, true}) {
      cv::Mat bgr = WarmWall();
      cv::circle(bgr, {x, 150}, 54, {60, 200, 255}, cv::FILLED, cv::LINE_AA);
      cv::circle(bgr, {x, 150}, is_all_white ? 55 : 40, kOverexposed, cv::FILLED, cv::LINE_AA);
      const MarkerLook look = LookForMarker(bgr, LightParameters());
      EXPECT_TRUE(look.marker || !look.doubt.empty()) << x << is_all_white;
    }
  }
}

// A farther thing that shines took the doubt of a near one away.
TEST(Light, ThatIsFarLeavesTheDoubtOfANearOne) {
  cv::Mat bgr = WarmWall();
  cv::circle(bgr, {200, 150}, 60, {15, 130, 190}, cv::FILLED, cv::LINE_AA);
  cv::circle(bgr, {450, 150}, 20, {60, 253, 254}, cv::FILLED, cv::LINE_AA);
  EXPECT_THAT(LookForMarker(bgr, LightParameters()).doubt, ::testing::HasSubstr("may shine"));
  cv::circle(bgr, {450, 150}, 70, {60, 253, 254}, cv::FILLED, cv::LINE_AA);
  const MarkerLook nearer = LookForMarker(bgr, LightParameters());
  ASSERT_TRUE(nearer.marker);
  EXPECT_NEAR(nearer.marker->size_px, 141, 5);
  EXPECT_EQ(nearer.doubt, "");
}

TEST(Light, BeforeASmallWallOfItsColourIsSeen) {
  cv::Mat bgr = GreyPicture();
  WarmWall().rowRange(100, 210).copyTo(bgr.rowRange(100, 210));
  EXPECT_FALSE(FindMarker(bgr, LightParameters()));
  cv::circle(bgr, {200, 150}, 40, {60, 253, 254}, cv::FILLED, cv::LINE_AA);
  const MarkerLook lamp = LookForMarker(bgr, LightParameters());
  ASSERT_TRUE(lamp.marker);
  EXPECT_NEAR(lamp.marker->size_px, 81, 5);
}

TEST(Light, BeforeASmallWallOfItsColourIsNoneNowhereWhereItIsOverexposed) {
  cv::Mat bgr = GreyPicture();
  WarmWall().rowRange(80, 230).copyTo(bgr.rowRange(80, 230));
  cv::circle(bgr, {200, 155}, 55, kOverexposed, cv::FILLED, cv::LINE_AA);
  const MarkerLook look = LookForMarker(bgr, LightParameters());
  EXPECT_TRUE(look.marker || !look.doubt.empty());
}

TEST(Light, BeforeAWallOfItsColourIsAmberToo) {
  const MarkerLook lamp = LookBeforeWarmWall(40, kAmber);
  ASSERT_TRUE(lamp.marker);
  EXPECT_NEAR(lamp.marker->size_px, 81, 5);
}

TEST(Light, BeforeAWallOfItsColourIsNoPaperAndNoPoolOfLight) {
  EXPECT_FALSE(LookBeforeWarmWall(40, {134, 201, 255}).marker) << "white paper";
  cv::Mat bgr = WarmWall();
  for (int radius_px = 90; radius_px > 0; radius_px -= 2) {
    const double more = (90 - radius_px) * 0.7;
    cv::circle(bgr, {200, 170}, radius_px, {100 - more / 4, 150 + more, 190 + more}, cv::FILLED);
  }
  EXPECT_FALSE(LookForMarker(bgr, LightParameters()).marker) << "a pool of a lamp's light";
}

// An amber lamp and amber paint are alike there; as far as a robot that stops.
TEST(Light, BeforeAWallOfItsColourIsInDoubtWhereSomethingNearAndRoundHasItToo) {
  EXPECT_THAT(LookBeforeWarmWall(60, {15, 130, 190}).doubt, ::testing::HasSubstr("may shine"));
  EXPECT_EQ(LookBeforeWarmWall(25, {15, 130, 190}).doubt, "") << "farther away";
}

TEST(Light, BeforeAWallAsBrightAsItWouldBeIsInDoubt) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(0, 0, 640, 260)).setTo(cv::Scalar(110, 248, 255));
  const MarkerLook look = LookForMarker(bgr, LightParameters());
  EXPECT_FALSE(look.marker);
  EXPECT_THAT(look.doubt, ::testing::HasSubstr("as bright as it would be"));
  EXPECT_EQ(LookForMarker(GreyPicture(), LightParameters()).doubt, "");
}

// The sky of an open place is as bright as a picture can be.
TEST(Light, BeforeABrightSkyHasAllTheRedAndGreen) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(0, 0, 640, 260)).setTo(cv::Scalar(252, 244, 232));
  cv::Mat paint = bgr.clone();
  cv::circle(bgr, {300, 150}, 40, {30, 254, 254}, cv::FILLED, cv::LINE_AA);
  EXPECT_TRUE(FindMarker(bgr, LightParameters()));
  cv::circle(paint, {300, 150}, 40, {20, 200, 250}, cv::FILLED, cv::LINE_AA);
  EXPECT_FALSE(FindMarker(paint, LightParameters()));
  cv::circle(paint, {300, 150}, 40, {60, 232, 250}, cv::FILLED, cv::LINE_AA);
  EXPECT_FALSE(FindMarker(paint, LightParameters())) << "of the brightest paint";
}

TEST(Light, IsNoYellowSignWithAWhiteDisc) {
  for (const int disc_px : {35, 50, 60}) {
    cv::Mat bgr = GreyPicture();
    bgr(cv::Rect(230, 130, 140, 140)).setTo(cv::Scalar(20, 206, 255));
    cv::circle(bgr, {300, 200}, disc_px, {245, 250, 252}, cv::FILLED, cv::LINE_AA);
    EXPECT_FALSE(FindMarker(bgr, LightParameters())) << disc_px;
    bgr = GreyPicture();
    cv::circle(bgr, {300, 200}, 75, {20, 200, 235}, cv::FILLED, cv::LINE_AA);
    cv::circle(bgr, {300, 200}, disc_px, {240, 244, 245}, cv::FILLED, cv::LINE_AA);
    EXPECT_FALSE(FindMarker(bgr, LightParameters())) << disc_px << " on a round one";
  }
}

RC_GTEST_PROP(MarkerProperty, OfAMirroredPictureIsInTheMirroredPlace, ()) {
  const cv::Mat bgr =
      WithDisc({*rc::gen::inRange(0, 640), *rc::gen::inRange(0, 300)}, *rc::gen::inRange(3, 90));
  const auto marker = FindMarker(bgr, {}), mirrored = FindMarker(Mirrored(bgr), {});
  RC_ASSERT(marker.has_value() == mirrored.has_value());
  if (marker) RC_ASSERT(std::abs(640 - marker->box.br().x - mirrored->box.x) <= 2);
}

double DistanceM(const cv::Mat& bgr, const Marker& marker) {
  const Lens lens = PinholeOf(world::CameraSet().cameras[0].hfov_rad, 640, 480);
  return DistanceBySizeM(lens, bgr.size(), marker.size_px, 0.2, 600);
}

// A sign of 0.2 m whose middle hangs 1 m over the ground, on a grey board behind it.
TEST(HighSign, HasItsDistanceFromNearToFarAndTurned) {
  const TempFolder folder;
  cv::Mat round(300, 300, CV_8UC3, kGrey), square = round.clone();
  cv::circle(round, {150, 150}, 100, kYellow, cv::FILLED, cv::LINE_AA);
  square(cv::Rect(50, 50, 200, 200)).setTo(kYellow);
  for (const auto& [name, picture] : {std::pair("round.png", round), {"square.png", square}}) {
    cv::imwrite(folder / name, picture);
    for (const double far_m : testing::Ends({2.5, 3.0, 4.0, 5.0})) {
      for (const double yaw_deg : testing::Ends({-20.0, 0.0, 20.0})) {
        world::Scene scene = HallScene();
        world::Board board = BoardAt(far_m, 0.3, yaw_deg, 0.65);
        board.sign = {world::Sign::Kind::kPicture, folder / name};
        scene.boards = {board};
        const cv::Mat bgr = SceneShot(scene, CourseCamera::kFront);
        const auto marker = FindMarker(bgr, {});
        ASSERT_TRUE(marker) << name << far_m << " m " << yaw_deg;
        EXPECT_NEAR(DistanceM(bgr, *marker), far_m, 0.1 * far_m) << name << yaw_deg;
      }
    }
  }
}

// A lamp in the way, at the height of the camera, and the lines of a lane behind it.
TEST(LightInTheWay, HasItsDistanceFromNearToFar) {
  for (const double far_m : {0.5, 0.7, 1.0, 2.0, 3.0}) {
    world::Scene scene = HallScene();
    scene.balls = {{{kEyeM + far_m, 0.05, 0.35}, 0.1, {246, 206, 20}, true}};
    for (const double y : {-0.44, 0.44}) {
      world::Line line;
      line.points_m = {{-3, y}, {6, y}};
      scene.lines.push_back(line);
    }
    const cv::Mat bgr = SceneShot(scene, CourseCamera::kFront);
    const auto light = FindMarker(bgr, LightParameters());
    ASSERT_TRUE(light) << far_m;
    EXPECT_NEAR(DistanceM(bgr, *light), far_m, 0.08 * far_m);
  }
}

TEST(Marker, IsNotFoundInNoise) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_FALSE(FindMarker(NoisePicture(seed), {})) << seed;
    EXPECT_FALSE(FindMarker(NoisePicture(seed), LightParameters())) << seed;
  }
}

TEST(MarkersTrack, BeginsAfterSightingsInARow) {
  MarkerTracker tracker(2, 5);
  EXPECT_EQ(tracker.OnPicture(true), Phase::kSearching);
  EXPECT_EQ(tracker.OnPicture(false), Phase::kSearching);
  EXPECT_EQ(tracker.OnPicture(true), Phase::kSearching);
  EXPECT_EQ(tracker.OnPicture(true), Phase::kTracking);
}

TEST(MarkersTrack, EndsAfterFiveMissesInARow) {
  MarkerTracker tracker(1, 5);
  EXPECT_EQ(tracker.OnPicture(true, true), Phase::kTracking);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(tracker.OnPicture(false), Phase::kTracking);
  EXPECT_EQ(tracker.OnPicture(true, true), Phase::kTracking);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(tracker.OnPicture(false), Phase::kTracking);
  EXPECT_EQ(tracker.OnPicture(false), Phase::kDisappeared);
  EXPECT_EQ(tracker.OnPicture(false), Phase::kDisappeared);
}

TEST(MarkersTrack, BeginsAgainAfterADisappearance) {
  MarkerTracker tracker(2, 1);
  for (const bool seen : {true, true, false}) tracker.OnPicture(seen, true);
  EXPECT_EQ(tracker.OnPicture(true, true), Phase::kDisappeared);
  EXPECT_EQ(tracker.OnPicture(true, true), Phase::kTracking);
}

TEST(MarkersTrack, BehindAPersonIsHiddenAndGoesOn) {
  MarkerTracker tracker(2, 2);
  for (const bool seen : {true, true, false}) tracker.OnPicture(seen);
  EXPECT_EQ(tracker.OnPicture(false), Phase::kHidden) << "it was seen in the middle of the picture";
  EXPECT_EQ(tracker.OnPicture(true), Phase::kHidden);
  EXPECT_EQ(tracker.OnPicture(true), Phase::kTracking);
  EXPECT_EQ(tracker.OnPicture(true, true), Phase::kTracking);
  tracker.OnPicture(false);
  EXPECT_EQ(tracker.OnPicture(false), Phase::kDisappeared) << "now it was at the edge";
}

TEST(MarkersTrack, IsSearchingUntilTheFirstSighting) {
  MarkerTracker tracker(1, 2);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(tracker.OnPicture(false), Phase::kSearching);
}

}  // namespace musher::vision::marker_finder_test
