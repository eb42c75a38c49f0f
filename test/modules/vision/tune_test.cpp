// musher-vision tune on pictures of a hall whose lines have a colour of their own.

#include "musher/modules/vision/tool/tune.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "musher/base/files.hpp"
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
  // A bar of that colour across the picture.
  void SaveBar(const std::string& name, const cv::Rect& bar, const cv::Scalar& color) {
    cv::Mat bgr(480, 640, CV_8UC3, kGrey);
    bgr(bar).setTo(color);
    ASSERT_TRUE(cv::imwrite(folder_ / name, bgr));
  }
  Result<> Tune(const std::string& config = kConfig) {
    out_.str("");
    const auto reading = ReadVisionText(config, "/robot/course.toml");
    return tool::Tune(reading.config.value(), {"course.toml", folder_.path()}, out_);
  }
  // Of a file in a folder of its own, which is changed.
  Result<> TuneFile(const std::string& config) {
    std::ofstream(File()) << config;
    out_.str("");
    const auto reading = ReadVisionFile(File());
    return tool::Tune(reading.config.value(), {File(), folder_.path(), true}, out_);
  }
  std::string File() const { return files_ / "course.toml"; }
  // That is printed.
  std::string Table() const {
    const std::string out = out_.str();
    const std::size_t from = out.find("\n[hall]\n");
    return from == std::string::npos ? "" : out.substr(from, out.find("\n\n", from + 1) - from);
  }

  TempFolder files_;
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
              HasSubstr("5 pictures, with course.toml as it is:\n"
                        "  lane                         2 right    3 missed    0 wrong\n"
                        "    missed: lane-center-dark.png\n"));
  EXPECT_THAT(out_.str(),
              HasSubstr("with this table:\n"
                        "  lane                         5 right    0 missed    0 wrong\n"));
  // What it prints is a part of a file, and does what it says.
  const std::string table = Table();
  ASSERT_TRUE(Tune(std::string(kConfig) + table)) << table;
  EXPECT_THAT(out_.str(), HasSubstr("5 right    0 missed    0 wrong"));
  EXPECT_THAT(out_.str(), HasSubstr("no other colours, regions or white balance do better"));
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

TEST_F(TuneTest, SaysOfAMissedPictureThatTheFloorHasTheColorOfTheLines) {
  Save("lane-center-floor.png", {100, 540}, kYellow, kYellow);
  ASSERT_TRUE(Tune());
  EXPECT_THAT(out_.str(),
              HasSubstr("    missed: lane-center-floor.png: the floor has the colour of "
                        "the lines: 100 % of the region\n"));
}

TEST_F(TuneTest, LeavesColorsThatAreRight) {
  Save("lane-left-1.png", {203, 540}, kYellow);
  Save("lane-none-1.png", {}, kYellow);
  ASSERT_TRUE(Tune());
  EXPECT_THAT(out_.str(), HasSubstr("2 right    0 missed    0 wrong"));
  EXPECT_THAT(out_.str(), HasSubstr("no other colours, regions or white balance do better"));
  EXPECT_THAT(out_.str(), Not(HasSubstr("[hall]")));
}

// A red skirting below a white wall is a bar, as far as its colour and shape go.
TEST_F(TuneTest, FindsTheRegionThatLeavesOutWhatIsNoBar) {
  const cv::Scalar red(40, 30, 200);
  SaveBar("bar-yes-1.png", {100, 120, 400, 30}, red);
  SaveBar("bar-yes-2.png", {60, 180, 500, 40}, red);
  SaveBar("bar-none-skirting.png", {20, 420, 600, 30}, red);
  ASSERT_TRUE(Tune());
  EXPECT_THAT(out_.str(), HasSubstr("2 right    0 missed    1 wrong"));
  EXPECT_THAT(out_.str(), HasSubstr("3 right    0 missed    0 wrong"));
  EXPECT_THAT(Table(), HasSubstr("regions.barrier = { top = 0.00, bottom = 0."));
  const std::string table = Table();
  ASSERT_TRUE(Tune(kConfig + table)) << table;
  EXPECT_THAT(out_.str(), HasSubstr("3 right    0 missed    0 wrong"));
  // One of its own wins.
  std::string own = kConfig;
  own.insert(own.find("kind = \"barrier\"") + 16, "\nparameters.region = { top = 0.0 }");
  ASSERT_TRUE(Tune(own));
  EXPECT_THAT(out_.str(), HasSubstr("remove parameters.region of bar: it wins over [hall]\n"));
}

// Pale lines on a floor that has their hue and is more saturated: no range of colours has one
// without the other.
TEST_F(TuneTest, FindsAWhiteBalanceWhereNoColorWillDo) {
  const cv::Scalar pale(70, 140, 210), floor(20, 110, 200);
  Save("lane-left-1.png", {203, 540}, pale, floor);
  Save("lane-right-1.png", {100, 436}, pale, floor);
  Save("lane-none-1.png", {}, pale, floor);
  ASSERT_TRUE(Tune());
  EXPECT_THAT(out_.str(), HasSubstr("1 right    2 missed    0 wrong"));
  EXPECT_THAT(Table(), HasSubstr("white_balance = [0.5"));
  const std::string table = Table();
  ASSERT_TRUE(Tune(kConfig + table)) << table;
  EXPECT_THAT(out_.str(), HasSubstr("3 right    0 missed    0 wrong"));
}

constexpr const char* kOwnHall = R"(# Of our hall.
detect_faces = false
[hall]                # measured in May
lane_m = 0.9          # with a tape
yellow = { from = [20, 50, 50], to = [35, 255, 255] }   # of the old tape

[[detectors]]         # the lane
name = "lane"
kind = "lines"
)";

TEST_F(TuneTest, WritesTheTableAndLeavesAllElseOfTheFile) {
  Save("lane-center-1.png", {100, 540}, cv::Scalar(10, 110, 235));
  ASSERT_TRUE(TuneFile(kOwnHall));
  const std::string written = ReadFile(File());
  EXPECT_THAT(out_.str(), HasSubstr("written to [hall] of " + File() +
                                    ":\n  - yellow = { from = "
                                    "[20, 50, 50], to = [35, 255, 255] }   # of the old tape\n"
                                    "  + yellow = { from = ["));
  EXPECT_THAT(written,
              HasSubstr("# Of our hall.\ndetect_faces = false\n[hall]                # "
                        "measured in May\nlane_m = 0.9          # with a tape\nyellow = "));
  EXPECT_THAT(written, HasSubstr("  # of the old tape\n\n[[detectors]]         # the lane\n"));
  EXPECT_THAT(out_.str(), Not(HasSubstr("nothing is written")));
  ASSERT_TRUE(TuneFile(written));
  EXPECT_THAT(out_.str(), HasSubstr("1 right    0 missed    0 wrong"));
  EXPECT_EQ(ReadFile(File()), written) << "nothing is better";
}

TEST_F(TuneTest, AddsATableToAFileWithoutOne) {
  Save("lane-center-1.png", {100, 540}, cv::Scalar(10, 110, 235));
  ASSERT_TRUE(TuneFile(kConfig));
  EXPECT_THAT(ReadFile(File()), HasSubstr(std::string(kConfig) + "\n[hall]\nyellow = {"));
}

TEST_F(TuneTest, ChangesNoFileWhoseTableHasAnotherForm) {
  Save("lane-center-1.png", {100, 540}, cv::Scalar(10, 110, 235));
  const std::string other =
      std::string(kConfig) + "[hall]\n[hall.yellow]\nfrom = [20, 50, 50]\nto = [35, 255, 255]\n";
  const Result<> tuned = TuneFile(other);
  ASSERT_FALSE(tuned);
  EXPECT_THAT(tuned.error().message, HasSubstr("copy the table by hand"));
  EXPECT_EQ(ReadFile(File()), other);
}

TEST_F(TuneTest, WritesNothingWithoutTheOption) {
  Save("lane-center-1.png", {100, 540}, cv::Scalar(10, 110, 235));
  ASSERT_TRUE(Tune());
  EXPECT_THAT(out_.str(),
              HasSubstr("nothing is written; --write changes [hall] of course.toml so\n"));
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
