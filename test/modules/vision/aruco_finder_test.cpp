// Markers whose bits are typed here, seen through equations of this test.

#include "musher/modules/vision/course/aruco_finder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/test/modules/vision/course_pictures.hpp"

namespace musher::vision::aruco_finder_test {

// Of the printed dictionary 4x4_50: marker 0 and marker 1, row by row, 1 is white.
using Bits = std::array<std::string_view, 4>;
constexpr Bits kMarker0 = {"1011", "0101", "0011", "0010"};
constexpr Bits kMarker1 = {"0000", "1111", "1001", "1010"};

constexpr double kSideM = 0.15;
constexpr int kCellPx = 40;

// Six cells wide, with its black border, on white paper of one more cell around.
cv::Mat Print(const Bits& bits) {
  cv::Mat paper(8 * kCellPx, 8 * kCellPx, CV_8UC3, kWhite);
  paper(cv::Rect(kCellPx, kCellPx, 6 * kCellPx, 6 * kCellPx)).setTo(cv::Scalar(20, 20, 20));
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      if (bits.at(std::size_t(row))[std::size_t(column)] != '1') continue;
      paper(cv::Rect((2 + column) * kCellPx, (2 + row) * kCellPx, kCellPx, kCellPx)).setTo(kWhite);
    }
  }
  return paper;
}

// A pinhole camera 80 degrees wide.
const Lens& Pinhole() {
  static const Lens lens = PinholeOf(80 * M_PI / 180, 640, 480);
  return lens;
}

// Puts the paper before the camera: its middle `far_m` ahead and `right_m` aside, turned about its
// upright axis.
void Hang(cv::Mat& bgr, const cv::Mat& paper, double far_m, double right_m, double turned_deg) {
  const double half_m = kSideM * 8 / 6 / 2, turn = turned_deg * M_PI / 180;
  const double focal_px = 320 / std::tan(40 * M_PI / 180);
  std::vector<cv::Point2f> from, to;
  for (const auto& [x, y] :
       {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
    from.emplace_back(float((x + 1) / 2.0 * paper.cols), float((y + 1) / 2.0 * paper.rows));
    const double ahead_m = far_m + x * half_m * std::sin(turn);
    const double aside_m = right_m + x * half_m * std::cos(turn);
    to.emplace_back(float(320 + focal_px * aside_m / ahead_m),
                    float(240 + focal_px * y * half_m / ahead_m));
  }
  cv::warpPerspective(paper, bgr, cv::getPerspectiveTransform(from, to), bgr.size(), cv::INTER_AREA,
                      cv::BORDER_TRANSPARENT);
}

TEST(Aruco, IsReadAsItsWordAtItsDistance) {
  for (const double far_m : {0.5, 1.0, 2.0, 2.8}) {
    for (const double turned_deg : {-45.0, 0.0, 45.0}) {
      cv::Mat bgr = GreyPicture();
      Hang(bgr, Print(kMarker1), far_m, 0.2, turned_deg);
      const auto found = FindAruco(bgr, {}, Pinhole());
      ASSERT_TRUE(found) << far_m << " m, " << turned_deg;
      EXPECT_EQ(found->word, "A-2");
      EXPECT_EQ(found->number, 1);
      EXPECT_NEAR(found->distance_m, std::hypot(far_m, 0.2), 0.06 * far_m) << turned_deg;
      EXPECT_NEAR(found->box.x + found->box.width / 2.0,
                  320 + 320 / std::tan(40 * M_PI / 180) * 0.2 / far_m, 9);
    }
  }
}

TEST(Aruco, WithoutAWordIsNone) {
  cv::Mat bgr = GreyPicture();
  Hang(bgr, Print(kMarker1), 1, 0, 0);
  ArucoParameters one;
  one.words = {"only"};
  const auto found = FindAruco(bgr, one, Pinhole());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->word, "");
}

TEST(Aruco, NextToOneOfAnotherWordIsNone) {
  cv::Mat bgr = GreyPicture();
  Hang(bgr, Print(kMarker0), 1, -0.3, 0);
  EXPECT_EQ(FindAruco(bgr, {}, Pinhole())->word, "A-1");
  Hang(bgr, Print(kMarker1), 1.1, 0.3, 0);
  EXPECT_EQ(FindAruco(bgr, {}, Pinhole())->word, "") << "they contradict each other";
}

TEST(Aruco, FarBehindTheBoardDoesNotCount) {
  cv::Mat bgr = GreyPicture();
  Hang(bgr, Print(kMarker0), 1, -0.3, 0);
  Hang(bgr, Print(kMarker1), 2.4, 0.3, 0);
  EXPECT_EQ(FindAruco(bgr, {}, Pinhole())->word, "A-1");
}

TEST(Aruco, IsNotFoundInNoiseSpotsOrAMirror) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    EXPECT_FALSE(FindAruco(NoisePicture(seed), {}, Pinhole())) << seed;
    EXPECT_FALSE(FindAruco(SpottedPicture(seed, 20), {}, Pinhole())) << seed;
  }
  cv::Mat bgr = GreyPicture();
  Hang(bgr, Print(kMarker1), 1, 0, 0);
  const auto mirrored = FindAruco(Mirrored(bgr), {}, Pinhole());
  EXPECT_TRUE(!mirrored || mirrored->word.empty());
}

TEST(Aruco, SaysItsWordAfterRepeats) {
  const auto detector = MakeArucoDetector({});
  cv::Mat bgr = GreyPicture();
  Hang(bgr, Print(kMarker0), 1, 0, 20);
  const CourseSight first = detector->Look(bgr, 1, Pinhole());
  EXPECT_TRUE(first.sighting->seen);
  EXPECT_EQ(first.text, std::nullopt);
  EXPECT_EQ(first.sighting->text, "");
  const CourseSight second = detector->Look(bgr, 2, Pinhole());
  EXPECT_EQ(second.text, "A-1");
  EXPECT_EQ(second.sighting->text, "A-1");
  EXPECT_EQ(detector->Look(GreyPicture(), 3, Pinhole()).text, std::nullopt);
  EXPECT_EQ(detector->Look(bgr, 4, Pinhole()).text, std::nullopt) << "two in a row";
}

}  // namespace musher::vision::aruco_finder_test
