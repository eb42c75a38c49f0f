// What the detectors publish of a series of pictures.

#include "musher/modules/vision/course/course_detectors.hpp"

#include <gmock/gmock.h>

#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/objdetect.hpp>

#include "musher/test/modules/vision/course_pictures.hpp"

namespace musher::vision::course_detectors_test {

using ::testing::Eq;
using ::testing::Optional;

cv::Mat WithArrow(bool left) {
  cv::Mat bgr = GreyPicture();
  DrawArrow(bgr, {200, 200, 120, 80});
  return left ? Mirrored(bgr) : bgr;
}

cv::Mat WithCode(const std::string& content) {
  cv::Mat code, bgr(480, 640, CV_8UC3, kWhite);
  cv::QRCodeEncoder::create()->encode(content, code);
  cv::cvtColor(code, code, cv::COLOR_GRAY2BGR);
  const double scale = std::floor(400.0 / code.cols);
  cv::resize(code, code, {}, scale, scale, cv::INTER_NEAREST);
  code.copyTo(bgr(cv::Rect(40, 40, code.cols, code.rows)));
  return bgr;
}

cv::Mat WithDisc(int radius, int y = 150) {
  cv::Mat bgr = GreyPicture();
  cv::circle(bgr, {300, y}, radius, kYellow, cv::FILLED, cv::LINE_AA);
  return bgr;
}

class Series {
 public:
  explicit Series(std::unique_ptr<CourseDetector> detector) : detector_(std::move(detector)) {}

  CourseSight Look(const cv::Mat& bgr, const std::optional<Lens>& lens = std::nullopt) {
    CourseSight sight = detector_->Look(bgr, ++stamp_ns_, lens);
    cv::Mat drawing = bgr.clone();
    detector_->Draw(drawing);
    EXPECT_GT(cv::norm(drawing, bgr), 0) << "nothing is drawn";
    return sight;
  }

 private:
  std::unique_ptr<CourseDetector> detector_;
  std::int64_t stamp_ns_ = 0;
};

TEST(ArrowDetector, SaysTheDirectionAtFirstAndOnAChange) {
  Series arrows(MakeArrowDetector({}));
  EXPECT_EQ(arrows.Look(GreyPicture()).text, std::nullopt);
  EXPECT_THAT(arrows.Look(WithArrow(true)).text, Optional(Eq("left")));
  EXPECT_EQ(arrows.Look(WithArrow(true)).text, std::nullopt);
  EXPECT_EQ(arrows.Look(GreyPicture()).text, std::nullopt);
  const CourseSight again = arrows.Look(WithArrow(true));
  EXPECT_EQ(again.text, std::nullopt);
  EXPECT_TRUE(again.sighting->seen);
  EXPECT_EQ(again.sighting->text, "left");
  EXPECT_THAT(arrows.Look(WithArrow(false)).text, Optional(Eq("right")));
  EXPECT_FALSE(arrows.Look(GreyPicture()).sighting->seen);
}

TEST(BarrierDetector, SaysTheDistanceByTheLensOrByItsParameters) {
  Series barriers(MakeBarrierDetector({}));
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(100, 200, 400, 60)).setTo(kRed);
  const CourseSight sight = barriers.Look(bgr);
  EXPECT_THAT(sight.text, Optional(Eq("2.00")));
  EXPECT_EQ(sight.sighting->phase, "seen");
  EXPECT_NEAR(sight.sighting->x, 100 / 640.0, 1e-6);
  EXPECT_NEAR(sight.sighting->y, 200 / 480.0, 1e-6);
  EXPECT_NEAR(sight.sighting->width, 400 / 640.0, 1e-6);
  EXPECT_NEAR(sight.sighting->height, 60 / 480.0, 1e-6);
  const Lens lens{false, 300 / 640.0, 300 / 480.0, 0.5, 0.5};
  EXPECT_THAT(barriers.Look(bgr, lens).text, Optional(Eq("1.00")));

  bgr = GreyPicture();
  bgr(cv::Rect(100, 0, 400, 60)).setTo(kRed);
  const CourseSight top = barriers.Look(bgr);
  EXPECT_EQ(top.sighting->phase, "top");
  EXPECT_TRUE(std::isnan(top.sighting->distance_m)) << "it is cut by the picture";
  EXPECT_EQ(top.text, std::nullopt);

  const CourseSight none = barriers.Look(GreyPicture());
  EXPECT_FALSE(none.sighting->seen);
  EXPECT_EQ(none.sighting->phase, "");
}

// One picture with something red at its edge ended the walk to the bar: the robot came to it
// upright.
TEST(BarrierDetector, SaysThatABarIsAtTheTopInTheSecondPictureWithIt) {
  Series barriers(MakeBarrierDetector({}));
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(100, 0, 400, 60)).setTo(kRed);
  EXPECT_EQ(barriers.Look(bgr).sighting->phase, "seen");
  EXPECT_EQ(barriers.Look(GreyPicture()).sighting->phase, "");
  EXPECT_EQ(barriers.Look(bgr).sighting->phase, "seen");
  EXPECT_EQ(barriers.Look(bgr).sighting->phase, "top");
}

TEST(MarkerDetector, SaysTheDistanceWhileItTracksAndThenThatItHasDisappeared) {
  Series markers(MakeMarkerDetector({}));
  EXPECT_EQ(markers.Look(GreyPicture()).sighting->phase, "searching");
  const CourseSight first = markers.Look(WithDisc(30));
  EXPECT_EQ(first.sighting->phase, "searching");
  EXPECT_EQ(first.text, std::nullopt);
  const CourseSight second = markers.Look(WithDisc(30));
  EXPECT_EQ(second.sighting->phase, "tracking");
  EXPECT_NEAR(second.sighting->distance_m, 0.2 * 600 / 61, 0.04);
  ASSERT_TRUE(second.text);
  EXPECT_NEAR(std::stod(*second.text), second.sighting->distance_m, 0.006);
  markers.Look(WithDisc(60, 70));  // 1 m
  for (int i = 0; i < 4; ++i) EXPECT_EQ(markers.Look(GreyPicture()).sighting->phase, "tracking");
  const CourseSight gone = markers.Look(GreyPicture());
  EXPECT_EQ(gone.sighting->phase, "disappeared");
  EXPECT_FALSE(gone.sighting->seen);
  EXPECT_TRUE(std::isnan(gone.sighting->distance_m));
}

TEST(MarkerDetector, SaysThatASignIsHiddenThatWasFarFromTheEdge) {
  Series markers(MakeMarkerDetector({}));
  for (int i = 0; i < 3; ++i) markers.Look(WithDisc(12));
  for (int i = 0; i < 4; ++i) markers.Look(GreyPicture());
  EXPECT_EQ(markers.Look(GreyPicture()).sighting->phase, "hidden");
}

// A robot that turned lost it at the edge, two metres before it, and counted it as passed.
TEST(MarkerDetector, SaysThatASignIsHiddenThatWasFarAwayAtTheEdge) {
  Series markers(MakeMarkerDetector({}));
  for (int i = 0; i < 3; ++i) markers.Look(WithDisc(30, 40));  // 2 m
  for (int i = 0; i < 4; ++i) markers.Look(GreyPicture());
  EXPECT_EQ(markers.Look(GreyPicture()).sighting->phase, "hidden");
}

TEST(LightDetector, HasNoSightingInADoubtAndKeepsItsTrack) {
  Series lights(MakeMarkerDetector(LightParameters()));
  lights.Look(WithDisc(30, 200));
  EXPECT_EQ(lights.Look(WithDisc(30, 200)).sighting->phase, "tracking");
  cv::Mat warm = GreyPicture();  // a wall under warm lamps, as bright as a light
  warm(cv::Rect(0, 0, 640, 260)).setTo(cv::Scalar(110, 248, 255));
  for (int i = 0; i < 10; ++i) {
    const CourseSight sight = lights.Look(warm);
    EXPECT_FALSE(sight.sighting || sight.text) << "it would say that there is no light";
    EXPECT_NE(sight.doubt, "");
  }
  const CourseSight gone = lights.Look(GreyPicture());
  EXPECT_EQ(gone.sighting->phase, "tracking");
  EXPECT_EQ(gone.doubt, "");
}

TEST(QrDetector, SaysAWordOfItsListAndOnlyShowsAnotherCode) {
  Series codes(MakeQrDetector({}));
  const CourseSight word = codes.Look(WithCode("A-2"));
  EXPECT_THAT(word.text, Optional(Eq("A-2")));
  EXPECT_EQ(word.sighting->text, "A-2");
  const CourseSight other = codes.Look(WithCode("A-3"));
  EXPECT_TRUE(other.sighting->seen);
  EXPECT_EQ(other.sighting->text, "A-3");
  EXPECT_EQ(other.text, std::nullopt);
  const CourseSight long_one = codes.Look(WithCode(std::string(100, 'x')));
  EXPECT_EQ(long_one.sighting->text, std::string(64, 'x'));
  EXPECT_EQ(long_one.text, std::nullopt);
}

// The second code in the right half, `scale` times as large as the first.
cv::Mat WithTwoCodes(const std::string& left, const std::string& right, double scale) {
  cv::Mat bgr(480, 960, CV_8UC3, kWhite), small;
  const cv::Mat one = WithCode(left), other = WithCode(right);
  one(cv::Rect(20, 20, 440, 440)).copyTo(bgr(cv::Rect(0, 0, 440, 440)));
  cv::resize(other(cv::Rect(20, 20, 440, 440)), small, {}, scale, scale, cv::INTER_AREA);
  small.copyTo(bgr(cv::Rect(500, 0, small.cols, small.rows)));
  return bgr;
}

// It took the one that was decoded first.
TEST(QrDetector, TakesTheLargerOfTwoBoardsAndNoneOfTwoThatAreAsLarge) {
  Series codes(MakeQrDetector({}));
  EXPECT_THAT(codes.Look(WithTwoCodes("A-1", "A-2", 0.5)).text, Optional(Eq("A-1")));
  EXPECT_THAT(codes.Look(WithTwoCodes("A-2", "A-1", 0.5)).text, Optional(Eq("A-2")));
  const CourseSight both = codes.Look(WithTwoCodes("A-1", "A-2", 1));
  EXPECT_TRUE(both.sighting->seen);
  EXPECT_EQ(both.sighting->text, "A-1, A-2");
  EXPECT_EQ(both.text, std::nullopt);
  EXPECT_THAT(codes.Look(WithTwoCodes("A-1", "A-1", 1)).text, Optional(Eq("A-1")));
  EXPECT_THAT(codes.Look(WithTwoCodes("https://a.label", "A-2", 0.5)).text, Optional(Eq("A-2")));
}

TEST(QrDetector, WaitsForRepeats) {
  QrParameters parameters;
  parameters.min_repeats = 2;
  parameters.letters = false;
  Series codes(MakeQrDetector(parameters));
  const CourseSight first = codes.Look(WithCode("A-2"));
  EXPECT_EQ(first.text, std::nullopt);
  EXPECT_TRUE(first.sighting->seen);
  EXPECT_EQ(first.sighting->text, "") << "who reads the sighting waits, too";
  EXPECT_EQ(codes.Look(WithCode("A-1")).text, std::nullopt);
  EXPECT_THAT(codes.Look(WithCode("A-1")).text, Optional(Eq("A-1")));
  EXPECT_EQ(codes.Look(GreyPicture()).text, std::nullopt);
}

TEST(QrDetector, ReadsLettersInEachSoManyPicturesWithoutACode) {
  cv::Mat bgr(480, 640, CV_8UC3, kWhite);
  cv::putText(bgr, "B-1", {220, 260}, cv::FONT_HERSHEY_SIMPLEX, 3, {20, 20, 20}, 8, cv::LINE_AA);
  QrParameters parameters;
  parameters.thorough_every = 3;
  parameters.letter_repeats = 1;
  Series codes(MakeQrDetector(parameters));
  for (int i = 0; i < 7; ++i) {
    const CourseSight sight = codes.Look(bgr);
    EXPECT_EQ(sight.text.has_value(), i % 3 == 0) << i;
    EXPECT_EQ(sight.text.value_or("B-1"), "B-1");
  }
}

TEST(QrDetector, SaysAWordOfLettersThatTwoLooksInARowAgreeOn) {
  cv::Mat bgr(480, 640, CV_8UC3, kWhite);
  cv::putText(bgr, "B-1", {220, 260}, cv::FONT_HERSHEY_SIMPLEX, 3, {20, 20, 20}, 8, cv::LINE_AA);
  Series codes(MakeQrDetector({}));
  const CourseSight first = codes.Look(bgr);
  EXPECT_TRUE(first.sighting->seen);
  EXPECT_EQ(first.sighting->text, "");
  EXPECT_EQ(first.text, std::nullopt);
  const CourseSight second = codes.Look(bgr);
  EXPECT_EQ(second.text, "B-1");
  EXPECT_EQ(second.sighting->text, "B-1");
}

TEST(QrDetector, ReadsNoLettersWhileACodeIsSeenThatCannotBeRead) {
  cv::Mat bgr = WithCode("A-2");
  bgr(cv::Rect(180, 180, 260, 260)).setTo(kWhite);
  cv::putText(bgr, "B-1", {200, 330}, cv::FONT_HERSHEY_SIMPLEX, 3, {20, 20, 20}, 8, cv::LINE_AA);
  ASSERT_FALSE(FindCode(bgr) || FindCodeThoroughly(bgr));
  Series codes(MakeQrDetector({}));
  for (int i = 0; i < 12; ++i) EXPECT_EQ(codes.Look(bgr).text, std::nullopt);
  bgr(cv::Rect(30, 30, 150, 430)).setTo(kWhite);  // without its finder patterns
  bgr(cv::Rect(30, 30, 430, 150)).setTo(kWhite);
  int read = 0;
  for (int i = 0; i < 7; ++i) read += codes.Look(bgr).text == "B-1" ? 1 : 0;
  EXPECT_GT(read, 0);
}

TEST(QrDetector, ThrowsWithThePackageWhenItCannotReadLetters) {
  QrParameters parameters;
  parameters.language = "chi_none";
  Series codes(MakeQrDetector(parameters));
  EXPECT_THAT(codes.Look(WithCode("A-1")).text, Optional(Eq("A-1"))) << "codes need no letters";
  EXPECT_THROW(codes.Look(GreyPicture()), std::runtime_error);
  EXPECT_FALSE(CheckLetters(parameters));
  parameters.letters = false;
  EXPECT_TRUE(CheckLetters(parameters));
  EXPECT_TRUE(CheckLetters({}));
}

// Stones are dark signs in rows, on the light area of their joints.
TEST(TextLines, AreNoneOnAStoneWall) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    cv::RNG random(seed);
    cv::Mat wall(480, 640, CV_8UC1, cv::Scalar(200));
    for (int y = 5; y + 30 < wall.rows; y += 32) {
      for (int x = 5; x + 30 < wall.cols; x += 30) {
        const cv::Size stone(random.uniform(16, 27), random.uniform(18, 28));
        wall(cv::Rect({x, y}, stone)).setTo(random.uniform(40, 90));
      }
    }
    EXPECT_TRUE(FindTextLines(wall).empty()) << seed;
  }
}

TEST(Confidence, IsHalfAtTheLimitsAndOneForTheIdealThing) {
  EXPECT_FLOAT_EQ(ConfidenceBy({1, 1}), 1);
  EXPECT_FLOAT_EQ(ConfidenceBy({1, 0.4}), 0.7F);
  EXPECT_FLOAT_EQ(ConfidenceBy({3, -1}), 0.5F);
  EXPECT_FLOAT_EQ(ConfidenceBy({std::nan("")}), 0.5F);
}

TEST(Confidence, OfASightingIsThatOfItsWeakestRule) {
  const auto confidence = [](std::unique_ptr<CourseDetector> detector, const cv::Mat& bgr) {
    return detector->Look(bgr, 1, std::nullopt).sighting->confidence;
  };
  const float arrow = confidence(MakeArrowDetector({}), WithArrow(true));
  EXPECT_GT(arrow, 0.7F);
  EXPECT_LE(arrow, 1);
  EXPECT_EQ(confidence(MakeArrowDetector({}), GreyPicture()), 0) << "nothing is seen";
  const float disc = confidence(MakeMarkerDetector({}), WithDisc(30));
  EXPECT_GT(disc, 0.8F);
  // A sign from the side.
  cv::Mat bgr = GreyPicture();
  cv::ellipse(bgr, {300, 150}, {40, 26}, 0, 0, 360, kYellow, cv::FILLED, cv::LINE_AA);
  const float oval = confidence(MakeMarkerDetector({}), bgr);
  EXPECT_LT(oval, 0.7F);
  EXPECT_GE(oval, 0.5F);
  QrParameters once;
  once.letters = false;
  EXPECT_EQ(confidence(MakeQrDetector(once), WithCode("A-2")), 1) << "by its check sum";
  EXPECT_EQ(confidence(MakeQrDetector(once), WithCode("hello")), 0.5F) << "no word";
  once.min_repeats = 2;
  EXPECT_EQ(confidence(MakeQrDetector(once), WithCode("A-2")), 0.5F) << "no word yet";
}

TEST(Confidence, OfABarGrowsWithItsLength) {
  const auto confidence = [](int length_px) {
    cv::Mat bgr = GreyPicture();
    bgr(cv::Rect(40, 200, length_px, 30)).setTo(cv::Scalar(40, 30, 200));
    const auto sighting = MakeBarrierDetector({})->Look(bgr, 1, std::nullopt).sighting;
    EXPECT_TRUE(sighting->seen) << length_px;
    return sighting->confidence;
  };
  EXPECT_LT(confidence(130), 0.6F);
  EXPECT_GT(confidence(500), 0.9F);
}

TEST(LinesDetector, SaysOnlyLines) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(100, 380, 30, 80)).setTo(kYellow);
  Series lines(MakeLinesDetector({}));
  const CourseSight sight = lines.Look(bgr);
  ASSERT_TRUE(sight.lines);
  EXPECT_EQ(sight.lines->ycy, "left");
  EXPECT_FALSE(sight.sighting || sight.text);
}

TEST(Finder, RefusesAPictureThatIsNotBgr8) {
  EXPECT_DEATH(FindLines(cv::Mat(), {}), "picture");
  EXPECT_DEATH(FindArrows(cv::Mat(10, 10, CV_8UC1), {}), "picture");
}

TEST(Finders, AcceptEverySizeOfPicture) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 600), cv::Size(1920, 7)}) {
    const cv::Mat bgr(size, CV_8UC3, kYellow);
    EXPECT_LE(FindLines(bgr, {}).lines.contours, 1U);
    EXPECT_TRUE(FindArrows(bgr, {}).arrows.empty());
    EXPECT_FALSE(FindBarrier(bgr, {}));
    EXPECT_FALSE(FindMarker(bgr, {}));
    EXPECT_FALSE(FindCode(bgr));
  }
}

}  // namespace musher::vision::course_detectors_test
