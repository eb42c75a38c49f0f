// Codes and letters on boards of the simulated world.

#include "musher/modules/vision/course/qr_finder.hpp"

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/objdetect.hpp>

#include "musher/test/modules/vision/course_pictures.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::vision::qr_finder_test {

cv::Mat BoardShot(world::Sign::Kind kind, const std::string& content, double size_m, double far_m,
                  double yaw_deg = 0, double up_m = 0) {
  world::Scene scene = HallScene();
  world::Board board = BoardAt(far_m, size_m, yaw_deg, up_m);
  if (kind == world::Sign::Kind::kText) board.width_m *= 1.6;  // room beside the letters
  board.sign = {kind, content};
  scene.boards = {board};
  return SceneShot(scene, CourseCamera::kFront);
}

TEST(CodeOfABoard, IsReadFarAndTurnedByOneOfTheLooks) {
  int quick = 0, all = 0;
  for (const double far_m : testing::Ends({0.6, 1.0, 1.5, 2.0, 2.9})) {
    for (const double yaw_deg : {-15.0, -8.0, 0.0, 8.0, 15.0}) {
      const cv::Mat bgr = BoardShot(world::Sign::Kind::kQr, "A-1", 0.4, far_m, yaw_deg);
      auto code = FindCode(bgr);
      ++all;
      quick += code ? 1 : 0;
      if (!code) code = FindCodeThoroughly(bgr);
      ASSERT_TRUE(code) << far_m << " m " << yaw_deg;
      EXPECT_EQ(code->content, "A-1");
      EXPECT_NEAR(code->box.x + code->box.width / 2.0, 320, 20);
      EXPECT_NEAR(code->box.width * far_m / 600, 0.29, 0.06) << far_m << " m " << yaw_deg;
    }
  }
  EXPECT_GT(quick, all / 2);
}

TEST(CodeOfABoard, OfLightSquaresOnDarkIsReadByTheThoroughLook) {
  const cv::Mat bgr = BoardShot(world::Sign::Kind::kQr, "A-1", 0.4, 1);
  const cv::Mat inverted = cv::Scalar::all(255) - bgr;
  const auto code = FindCodeThoroughly(inverted);
  ASSERT_TRUE(code);
  EXPECT_EQ(code->content, "A-1");
  EXPECT_NEAR(code->box.x + code->box.width / 2.0, 320, 20);
}

// A code on a board with a white spot at a share of its sides.
cv::Mat WithGlare(double x, double y) {
  constexpr int kSquarePx = 6, kRadiusPx = 18;
  cv::Mat code, bgr = GreyPicture();
  cv::QRCodeEncoder::create()->encode("A-1", code);
  cv::cvtColor(code, code, cv::COLOR_GRAY2BGR);
  cv::resize(code, code, {}, kSquarePx, kSquarePx, cv::INTER_NEAREST);
  const cv::Rect board(240, 140, code.cols, code.rows);
  code.copyTo(bgr(board));
  const cv::Point glare(int(x * board.width), int(y * board.height));
  cv::circle(bgr, board.tl() + glare, kRadiusPx, {255, 255, 255}, cv::FILLED, cv::LINE_AA);
  cv::GaussianBlur(bgr, bgr, {}, 1.5);
  return bgr;
}

// Of 36 places of the spot ZXing reads the code at one.
TEST(CodeOfABoard, UnderAGlareIsReadByTheSecondReader) {
  constexpr int kPlaces = 6;
  int read = 0;
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    const cv::Mat bgr = WithGlare(0.15 + 0.14 * (i / kPlaces), 0.15 + 0.14 * (i % kPlaces));
    const auto code = FindCodeThoroughly(bgr);
    if (!code) continue;
    ++read;
    EXPECT_EQ(code->content, "A-1");
    EXPECT_TRUE(code->box.contains({240 + 80, 140 + 80})) << code->box;
  }
  EXPECT_GE(read, 3);
}

class Letters : public ::testing::Test {
 protected:
  std::string Read(const cv::Mat& bgr) {
    const auto found = reader_.value()->Read(bgr);
    return found ? found->word : "";
  }
  Result<std::unique_ptr<LetterReader>> reader_ = LetterReader::Make({});
};

TEST_F(Letters, OfABoardAreReadFarAndTurned) {
  ASSERT_TRUE(reader_);
  for (const std::string word : {"A-1", "A-2", "B-1", "B-2"}) {
    for (const double far_m : testing::Ends({0.6, 1.0, 2.0, 2.9})) {
      for (const double yaw_deg : testing::Ends({-15.0, 0.0, 15.0})) {
        EXPECT_EQ(Read(BoardShot(world::Sign::Kind::kText, word, 0.3, far_m, yaw_deg)), word)
            << far_m << " m " << yaw_deg;
      }
    }
  }
}

TEST_F(Letters, OfAHighBoardAreRead) {
  EXPECT_EQ(Read(BoardShot(world::Sign::Kind::kText, "B-2", 0.3, 2, 0, 0.5)), "B-2");
}

TEST_F(Letters, OfOtherWordsAreNone) {
  for (const std::string text : {"A-3", "STOP", "C-1", "8-1", "A-1 A-2", "A\n1\nB\n2"}) {
    EXPECT_EQ(Read(BoardShot(world::Sign::Kind::kText, text, 0.4, 1)), "") << text;
  }
}

// A board in the picture, with that text in its middle.
cv::Mat DrawnBoard(const std::string& text, const std::vector<cv::Point>& corners) {
  cv::Mat bgr = GreyPicture();
  cv::fillConvexPoly(bgr, corners, kWhite, cv::LINE_AA);
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_DUPLEX, 2, 8, nullptr);
  const cv::Rect box = cv::boundingRect(corners);
  cv::putText(bgr, text, (box.tl() + box.br()) / 2 + cv::Point(-size.width / 2, size.height / 2),
              cv::FONT_HERSHEY_DUPLEX, 2, {20, 20, 20}, 8, cv::LINE_AA);
  return bgr;
}
const std::vector<cv::Point> kQuad{{120, 150}, {520, 140}, {520, 340}, {120, 330}};

TEST_F(Letters, AreReadOnALightAreaWithFourCornersOnly) {
  EXPECT_EQ(Read(DrawnBoard("B-1", kQuad)), "B-1");
  const std::vector<cv::Point> triangle{{0, 340}, {320, 20}, {639, 340}};
  EXPECT_EQ(Read(DrawnBoard("B-1", triangle)), "");
}

TEST_F(Letters, OfTwoWordsOnABoardAreNoneAlsoWhereOneIsNotRead) {
  const cv::Mat bgr = DrawnBoard("A-1 A-2", {{60, 150}, {600, 140}, {600, 340}, {60, 330}});
  EXPECT_EQ(Read(bgr), "");
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  const std::vector<TextLine> lines = FindTextLines(grey);
  EXPECT_GE(lines.size(), 2U);
  for (const TextLine& line : lines) EXPECT_FALSE(line.alone);
}

// Half of a board with two words: as lines they are in doubt, in the region only one is seen.
TEST_F(Letters, OfARegionAreNoneWhereTheirLineIsInDoubt) {
  const auto width = [](const char* text) {
    return cv::getTextSize(text, cv::FONT_HERSHEY_DUPLEX, 2, 8, nullptr).width;
  };
  const double left_px = 330 - width("A-1 A-2") / 2.0;
  QrParameters parameters;
  parameters.regions = {{0.35, 0.65, (left_px - 16) / 640, (left_px + width("A-1") + 8) / 640}};
  auto reader = LetterReader::Make(parameters);
  ASSERT_TRUE(reader);
  cv::Mat bgr = DrawnBoard("A-1 A-2", {{60, 150}, {600, 140}, {600, 340}, {60, 330}});
  EXPECT_FALSE(reader.value()->Read(bgr));
  // Dents: it is no board any more, and has no line.
  bgr(cv::Rect(330, 275, 310, 80)).setTo(kGrey);
  bgr(cv::Rect(330, 120, 310, 80)).setTo(kGrey);
  const auto found = reader.value()->Read(bgr);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->word, "A-1");
}

TEST_F(Letters, AreNoneInNoiseAndInAnEmptyHall) {
  for (unsigned seed = 1; seed <= (musher::testing::Nightly() ? 6U : 2U); ++seed) {
    EXPECT_EQ(Read(NoisePicture(seed)), "") << seed;
    EXPECT_EQ(Read(SpottedPicture(seed, 20)), "") << seed;
    EXPECT_FALSE(FindCode(NoisePicture(seed)) || FindCodeThoroughly(NoisePicture(seed)));
  }
  EXPECT_EQ(Read(SceneShot(HallScene(), CourseCamera::kFront)), "");
  EXPECT_EQ(Read(GreyPicture()), "");
}

TEST(LetterReader, OfALanguageThatIsNotInstalledSaysWhatToInstall) {
  QrParameters parameters;
  parameters.language = "eng+xyz_abc";
  const auto reader = LetterReader::Make(parameters);
  if (reader) GTEST_SKIP() << "Tesseract has accepted the languages that it has";
  EXPECT_THAT(reader.error().message, ::testing::HasSubstr("tesseract-ocr-xyz-abc"));
}

TEST(LetterReader, OfOneLanguageThatIsNotInstalledSaysWhatToInstall) {
  QrParameters parameters;
  parameters.language = "chi_none";
  const auto reader = LetterReader::Make(parameters);
  ASSERT_FALSE(reader);
  EXPECT_THAT(reader.error().message,
              ::testing::AllOf(::testing::HasSubstr("'chi_none'"),
                               ::testing::HasSubstr("tesseract-ocr-chi-none")));
}

TEST(LetterReader, ReadsChineseWhereItIsAskedTo) {
  QrParameters parameters;
  parameters.language = "chi_sim";
  parameters.words = {"库位1", "库位2"};
  auto reader = LetterReader::Make(parameters);
  ASSERT_TRUE(reader) << reader.error().message;
  const auto found = reader.value()->Read(BoardShot(world::Sign::Kind::kText, "库位2", 0.4, 1));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->word, "库位2");
}

}  // namespace musher::vision::qr_finder_test
