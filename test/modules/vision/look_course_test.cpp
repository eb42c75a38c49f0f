// What musher-vision look --detector prints and writes.

#include "musher/modules/vision/tool/look_course.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>

#include "musher/test/support/temp_folder.hpp"

namespace musher::vision::look_course_test {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;

// Sees a sign in every picture but the first, and draws it white.
class SecondSight : public CourseDetector {
 public:
  CourseSight Look(const cv::Mat&, std::int64_t stamp_ns,
                   const std::optional<Lens>& lens) override {
    EXPECT_GT(stamp_ns, std::exchange(last_ns_, stamp_ns));
    CourseSight sight;
    sight.sighting.emplace();
    sight.sighting->seen = ++looks_ > 1;
    sight.sighting->phase = "searching";
    sight.sighting->distance_m = lens ? 1.5F : NAN;
    sight.sighting->width = 0.5F;
    return sight;
  }
  void Draw(cv::Mat& bgr) const override { bgr.setTo(cv::Scalar(255, 255, 255)); }

 private:
  int looks_ = 0;
  std::int64_t last_ns_ = -1;
};

class LookAtCourse : public ::testing::Test {
 protected:
  LookAtCourse() {
    entry_.name = "sign";
    entry_.factory = {[] { return std::unique_ptr<CourseDetector>(new SecondSight); },
                      [] { return Ok(); }};
    config_.detectors = {entry_};
  }
  std::string SavePicture(const std::string& name) {
    std::string file = folder_ / name;
    EXPECT_TRUE(cv::imwrite(file, picture_));
    return file;
  }
  std::string Printed() {
    std::ostringstream out;
    const Result<> looked = tool::LookAtCourse(entry_, options_, out);
    EXPECT_TRUE(looked) << looked.error().message;
    return out.str();
  }
  std::string Failure() {
    std::ostringstream out;
    const Result<> looked = tool::LookAtCourse(entry_, options_, out);
    return looked ? "" : looked.error().message;
  }

  const TempFolder folder_;
  const cv::Mat picture_ = cv::Mat(48, 64, CV_8UC3, cv::Scalar(1, 2, 3));
  CourseEntry entry_;
  VisionConfig config_;
  tool::LookOptions options_;
};

TEST_F(LookAtCourse, PrintsEachPictureByADetectorOfItsOwnAndWritesTheLast) {
  options_.pictures = {SavePicture("a.png"), SavePicture("b.png")};
  options_.out = folder_ / "out.png";
  EXPECT_THAT(Printed(), MatchesRegex(".*a.png: 64 x 48, [0-9]+ ms\n  not seen, searching\n"
                                      ".*b.png: 64 x 48, [0-9]+ ms\n  not seen, searching\n"));
  EXPECT_EQ(cv::imread(options_.out).at<cv::Vec3b>(0, 0), cv::Vec3b(255, 255, 255));
}

TEST_F(LookAtCourse, PrintsEachPictureOfAFilmByOneDetector) {
  const std::string file = folder_ / "walk.avi";
  cv::VideoWriter film(file, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10, picture_.size());
  ASSERT_TRUE(film.isOpened());
  for (int i = 0; i < 3; ++i) film.write(picture_);
  film.release();
  options_.pictures = {file};
  options_.hfov_deg = 60;
  const std::string printed = Printed();
  EXPECT_THAT(printed, HasSubstr("walk.avi at 0."));
  EXPECT_THAT(printed, HasSubstr("  not seen, searching\n"));
  EXPECT_THAT(printed, HasSubstr("  seen, searching, 1.50 m, at 0.250 0.000, 0.500 x 0.000\n"));
}

TEST_F(LookAtCourse, PrintsTheNumbersAndWordsOfLines) {
  CourseSight sight;
  sight.lines.emplace();
  sight.lines->contours = 1;
  sight.lines->ycy = "left";
  sight.lines->dy = "front";
  sight.lines->walk = "center";
  sight.lines->middle_offset = -0.25F;
  sight.lines->line_offset = 0.1F;
  sight.lines->bottom_gap_px = NAN;
  sight.lines->area_px2 = 700;
  EXPECT_EQ(tool::SightText(sight),
            "  1 line: ycy left, dy front, walk center; middle_offset -0.250, line_offset 0.100, "
            "bottom_gap_px unknown, area_px2 700\n");
  EXPECT_EQ(tool::SightText({std::nullopt, std::nullopt, "A-1"}), "  publishes \"A-1\"\n");
}

TEST_F(LookAtCourse, FailsWithAFileThatCannotBeReadOrWritten) {
  options_.pictures = {folder_ / "none.png"};
  EXPECT_THAT(Failure(), HasSubstr("none.png is no picture that can be read"));
  std::ofstream(folder_ / "broken.mp4") << "no film";
  options_.pictures = {folder_ / "broken.mp4"};
  EXPECT_THAT(Failure(), HasSubstr("broken.mp4 is no film that can be read"));
  options_.pictures = {SavePicture("a.png")};
  options_.out = "/no/such/folder/out.png";
  EXPECT_EQ(Failure(), "/no/such/folder/out.png cannot be written");
  entry_.factory.check = [] { return Result<>(Error{5912, "tesseract-ocr-eng is missing"}); };
  EXPECT_EQ(Failure(), "tesseract-ocr-eng is missing");
}

TEST_F(LookAtCourse, NamesTheKnownDetectorsForAnUnknownOne) {
  EXPECT_TRUE(tool::DetectorOf(config_, "sign"));
  EXPECT_EQ(tool::DetectorOf(config_, "sing").error().message,
            "there is no detector 'sing'; did you mean 'sign'? There is only sign");
  config_.detectors.clear();
  EXPECT_EQ(tool::DetectorOf(config_, "sign").error().message,
            "the config has no table [[detectors]]");
}

}  // namespace musher::vision::look_course_test
