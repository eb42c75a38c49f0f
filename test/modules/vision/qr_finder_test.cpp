// Codes and letters on boards of the simulated world.

#include "musher/modules/vision/course/qr_finder.hpp"

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "musher/test/modules/vision/course_pictures.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::vision::qr_finder_test {

cv::Mat BoardShot(world::Sign::Kind kind, const std::string& content, double size_m, double far_m,
                  double yaw_deg = 0, double up_m = 0) {
  world::Scene scene = Hall();
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

TEST_F(Letters, AreNoneInNoiseAndInAnEmptyHall) {
  for (unsigned seed = 1; seed <= (musher::testing::Nightly() ? 6U : 2U); ++seed) {
    EXPECT_EQ(Read(NoisePicture(seed)), "") << seed;
    EXPECT_EQ(Read(SpottedPicture(seed, 20)), "") << seed;
    EXPECT_FALSE(FindCode(NoisePicture(seed)) || FindCodeThoroughly(NoisePicture(seed)));
  }
  EXPECT_EQ(Read(SceneShot(Hall(), CourseCamera::kFront)), "");
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
