// musher-vision tune on pictures of a hall whose lines have a colour of their own.

#include "musher/modules/vision/tool/tune.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "musher/test/modules/vision/course_pictures.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::vision::tune_test {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kConfig = R"(
detect_faces = false
[[detectors]]
name = "lane"
kind = "lines"
[[detectors]]
name = "bar"
kind = "barrier"
[[detectors]]
name = "board"
kind = "qr"
)";

class TuneTest : public ::testing::Test {
 protected:
  // On a floor of that colour, with upright lines at those places.
  void Save(const std::string& name, const std::vector<int>& lines, const cv::Scalar& color,
            const cv::Scalar& floor = kGrey) {
    cv::Mat bgr(480, 640, CV_8UC3, floor);
    for (const int x : lines) bgr(cv::Rect(x - 10, 300, 20, 180)).setTo(color);
    ASSERT_TRUE(cv::imwrite(folder_ / name, bgr));
  }
  Result<> Tune(const std::string& config = kConfig) {
    out_.str("");
    const auto reading = ReadVisionText(config, "/robot/course.toml");
    return tool::Tune(reading.config.value(), {"course.toml", folder_.path()}, out_);
  }

  TempFolder folder_;
  std::ostringstream out_;
};

TEST_F(TuneTest, FindsTheColorOfLinesThatTheFileDoesNotHave) {
  const cv::Scalar orange(10, 110, 235), brown(60, 80, 105);
  Save("lane-left-1.png", {203, 540}, orange, brown);
  Save("lane-right-1.png", {100, 436}, orange, brown);
  Save("lane-center-dark.png", {100, 540}, orange * 0.4, brown * 0.4);
  Save("lane-none-1.png", {}, orange, brown);
  const cv::Scalar red(40, 30, 200);
  Save("lane-none-red.png", {100, 400}, red, brown);
  ASSERT_TRUE(Tune());
  EXPECT_THAT(out_.str(),
              HasSubstr("5 pictures, with the colours of course.toml:\n"
                        "  lane                         2 right    3 missed    0 wrong\n"
                        "    missed: lane-center-dark.png\n"));
  EXPECT_THAT(out_.str(),
              HasSubstr("with these colours:\n"
                        "  lane                         5 right    0 missed    0 wrong\n"));
  // What it prints is a part of a file, and does what it says.
  const std::string table = out_.str().substr(out_.str().find("[hall]"));
  ASSERT_TRUE(Tune(std::string(kConfig) + table)) << table;
  EXPECT_THAT(out_.str(), HasSubstr("5 right    0 missed    0 wrong"));
  EXPECT_THAT(out_.str(), HasSubstr("no other colours do better"));
}

TEST_F(TuneTest, NamesTheDetectorsWhoseOwnColorWinsOverTheTable) {
  const cv::Scalar orange(10, 110, 235);
  Save("lane-center-1.png", {100, 540}, orange);
  std::string own = kConfig;
  own.insert(own.find("kind = \"lines\"") + 14,
             "\nparameters.yellow = { from = [20, 50, 50], to = [35, 255, 255] }");
  ASSERT_TRUE(Tune(own));
  EXPECT_THAT(out_.str(), HasSubstr("remove parameters.yellow of lane: it wins over [hall]\n"));
  ASSERT_TRUE(Tune());
  EXPECT_THAT(out_.str(), Not(HasSubstr("remove")));
}

TEST_F(TuneTest, LeavesColorsThatAreRight) {
  Save("lane-left-1.png", {203, 540}, kYellow);
  Save("lane-none-1.png", {}, kYellow);
  ASSERT_TRUE(Tune());
  EXPECT_THAT(out_.str(), HasSubstr("2 right    0 missed    0 wrong"));
  EXPECT_THAT(out_.str(), HasSubstr("no other colours do better"));
  EXPECT_THAT(out_.str(), Not(HasSubstr("[hall]")));
}

TEST_F(TuneTest, SaysWhichNameIsWrong) {
  const auto error = [&] {
    const Result<> tuned = Tune();
    return tuned ? std::string() : tuned.error().message;
  };
  EXPECT_THAT(error(), HasSubstr("has no picture"));
  Save("lane.png", {}, kYellow);
  EXPECT_THAT(error(), HasSubstr("lane.png has no label in its name, as in front_lane-left-1.png"));
  std::filesystem::remove(folder_ / "lane.png");
  Save("lame-left-1.png", {}, kYellow);
  EXPECT_THAT(error(), HasSubstr("did you mean 'lane'"));
  std::filesystem::remove(folder_ / "lame-left-1.png");
  Save("board-yes-1.png", {}, kYellow);
  EXPECT_THAT(error(), HasSubstr("board")) << "it has no colour";
  std::filesystem::remove(folder_ / "board-yes-1.png");
  Save("bar-left-1.png", {}, kYellow);
  EXPECT_THAT(error(), HasSubstr("left"));
  std::filesystem::remove(folder_ / "bar-left-1.png");
  std::ofstream(folder_ / "bar-yes-1.png") << "no picture";
  EXPECT_THAT(error(), HasSubstr("bar-yes-1.png is no picture that can be read"));
}

}  // namespace musher::vision::tune_test
