// Arrows drawn with any proportions, on boards of the simulated world, and things that are none.

#include "musher/modules/vision/course/arrow_finder.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "musher/test/modules/vision/course_pictures.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::vision::arrow_finder_test {

cv::Mat WithArrow(const cv::Rect& box, double head = 0.4, double shaft = 0.4) {
  cv::Mat bgr = GreyPicture();
  DrawArrow(bgr, box, head, shaft);
  return bgr;
}

std::string Direction(const cv::Mat& bgr) {
  return FindArrows(bgr, {}).direction;
}

TEST(Arrow, PointsToItsHead) {
  EXPECT_EQ(Direction(WithArrow({200, 200, 120, 80})), "right");
  EXPECT_EQ(Direction(Mirrored(WithArrow({200, 200, 120, 80}))), "left");
}

TEST(Arrow, OfEveryUsualProportionIsRead) {
  for (const double head : {0.3, 0.4, 0.5, 0.6}) {
    for (const double shaft : {0.25, 0.4, 0.55}) {
      for (const int height : {50, 80, 110}) {
        const cv::Rect box(100, 100, 120, height);
        EXPECT_EQ(Direction(WithArrow(box, head, shaft)), "right") << head << shaft << height;
      }
    }
  }
}

TEST(Arrow, MayBeTilted) {
  for (const double degrees : {-20.0, -10.0, 10.0, 20.0}) {
    cv::Mat bgr = WithArrow({200, 200, 160, 100});
    const cv::Mat turn = cv::getRotationMatrix2D({280, 250}, degrees, 1);
    cv::warpAffine(bgr, bgr, turn, bgr.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    EXPECT_EQ(Direction(bgr), "right") << degrees;
  }
}

TEST(Arrows, ThatDisagreeAreNoAnswer) {
  cv::Mat bgr = WithArrow({100, 200, 120, 80});
  DrawArrow(bgr, {400, 200, 120, 80});
  EXPECT_EQ(Direction(bgr), "right");
  EXPECT_EQ(FindArrows(bgr, {}).arrows.size(), 2U);
  const cv::Rect right_part(350, 180, 250, 120);
  Mirrored(WithArrow({100, 200, 120, 80}))(right_part).copyTo(bgr(right_part));
  const ArrowsFound found = FindArrows(bgr, {});
  EXPECT_EQ(found.arrows.size(), 2U);
  EXPECT_EQ(found.direction, "");
}

using Shape = std::vector<cv::Point>;

// Three of usual shapes, to the right.
const Shape kChevron{{200, 150}, {250, 150}, {320, 220}, {250, 290}, {200, 290}, {270, 220}};
const Shape kElbow{{200, 330}, {200, 190}, {280, 190}, {280, 150}, {360, 215},
                   {280, 280}, {280, 240}, {245, 240}, {245, 330}};
const Shape kTapered{{180, 210}, {300, 190}, {300, 150}, {390, 220},
                     {300, 290}, {300, 250}, {180, 230}};

cv::Mat WithShape(const Shape& shape, const cv::Scalar& board, const cv::Scalar& paint) {
  cv::Mat bgr = GreyPicture();
  bgr(cv::Rect(130, 110, 320, 250)).setTo(board);
  cv::fillPoly(bgr, std::vector{shape}, paint, cv::LINE_AA);
  return bgr;
}

TEST(Arrow, MayBeAChevronAnElbowOrTapered) {
  for (const Shape& shape : {kChevron, kElbow, kTapered}) {
    const cv::Mat bgr = WithShape(shape, kWhite, kGreen);
    EXPECT_EQ(Direction(bgr), "right") << shape[0] << shape[2];
    EXPECT_EQ(Direction(Mirrored(bgr)), "left") << shape[0] << shape[2];
  }
  ArrowParameters straight_only;
  straight_only.other_shapes = false;
  EXPECT_EQ(FindArrows(WithShape(kElbow, kWhite, kGreen), straight_only).direction, "");
}

TEST(Arrow, MayBeWhiteOnGreen) {
  for (const Shape& shape : {ArrowCorners({180, 160, 200, 120}, 0.4, 0.4), kElbow}) {
    const cv::Mat bgr = WithShape(shape, kGreen, kWhite);
    EXPECT_EQ(Direction(bgr), "right") << shape[0];
    EXPECT_EQ(Direction(Mirrored(bgr)), "left") << shape[0];
    EXPECT_EQ(Direction(WithShape(shape, kGreen, {10, 10, 10})), "") << "black on green is none";
  }
}

TEST(Green, ThatPointsBothWaysOrToNoSideHasNoDirection) {
  const Shape both{{150, 220}, {200, 160}, {200, 200}, {340, 200}, {340, 160},
                   {390, 220}, {340, 280}, {340, 240}, {200, 240}, {200, 280}};
  const Shape cross{{250, 150}, {290, 150}, {290, 200}, {340, 200}, {340, 240}, {290, 240},
                    {290, 290}, {250, 290}, {250, 240}, {200, 240}, {200, 200}, {250, 200}};
  const Shape corner{{200, 150}, {340, 150}, {340, 190}, {240, 190}, {240, 290}, {200, 290}};
  for (const Shape& shape : {both, cross, corner}) {
    EXPECT_EQ(Direction(WithShape(shape, kWhite, kGreen)), "") << shape[0];
    EXPECT_EQ(Direction(WithShape(shape, kGreen, kWhite)), "") << shape[0];
  }
}

TEST(Green, ThatIsNoArrowHasNoDirection) {
  cv::Mat box = GreyPicture();
  box(cv::Rect(200, 200, 150, 80)).setTo(kGreen);
  cv::Mat ball = GreyPicture();
  cv::circle(ball, {300, 200}, 60, kGreen, cv::FILLED);
  cv::Mat upwards;
  cv::rotate(WithArrow({200, 200, 120, 80}), upwards, cv::ROTATE_90_CLOCKWISE);
  for (const cv::Mat& bgr : {box, ball, upwards}) EXPECT_EQ(Direction(bgr), "");
}

TEST(Arrow, ThatThePictureCutsOrGreenSurroundsIsNone) {
  EXPECT_EQ(Direction(WithArrow({560, 200, 120, 80})), "");
  cv::Mat meadow = GreyPicture();
  meadow.setTo(cv::Scalar(60, 150, 50));
  EXPECT_EQ(Direction(meadow), "");
  EXPECT_EQ(Direction(WithArrow({300, 200, 40, 25})), "") << "smaller than the least area";
}

RC_GTEST_PROP(ArrowProperty, OfAMirroredPicturePointsToTheOtherSide, ()) {
  const int width = *rc::gen::inRange(80, 300), height = *rc::gen::inRange(40, 160);
  const double head = *rc::gen::inRange(30, 60) / 100.0, shaft = *rc::gen::inRange(25, 55) / 100.0;
  const cv::Rect box(*rc::gen::inRange(5, 300), *rc::gen::inRange(5, 300), width, height);
  const cv::Mat bgr = WithArrow(box, head, shaft);
  const std::string direction = Direction(bgr), mirrored = Direction(Mirrored(bgr));
  RC_ASSERT(direction != "left");
  RC_ASSERT(mirrored == (direction.empty() ? "" : "left"));
}

// A board 0.5 m large with an arrow across it.
class ArrowBoard : public ::testing::Test {
 protected:
  cv::Mat Shot(bool left, double far_m, double yaw_deg,
               world::Ground::Texture texture = world::Ground::Texture::kPlain) {
    cv::Mat picture(512, 512, CV_8UC3, kWhite);
    DrawArrow(picture, {50, 130, 412, 250});
    const std::string path = folder_ / (left ? "left.png" : "right.png");
    cv::imwrite(path, left ? Mirrored(picture) : picture);
    world::Scene scene = HallScene();
    scene.ground.texture = texture;
    world::Board board = BoardAt(far_m, 0.5, yaw_deg);
    board.sign = {world::Sign::Kind::kPicture, path};
    scene.boards = {board};
    return SceneShot(scene, CourseCamera::kFront);
  }
  const TempFolder folder_;
};

TEST_F(ArrowBoard, IsReadFromHalfAMetreToThreeAndTurnedBy15Degrees) {
  for (const double far_m : testing::Ends({0.6, 1.0, 2.0, 3.0})) {
    for (const double yaw_deg : testing::Ends({-15.0, 0.0, 15.0})) {
      EXPECT_EQ(Direction(Shot(true, far_m, yaw_deg)), "left") << far_m << " m " << yaw_deg;
      EXPECT_EQ(Direction(Shot(false, far_m, yaw_deg)), "right") << far_m << " m " << yaw_deg;
    }
  }
}

TEST_F(ArrowBoard, IsReadOverGrass) {
  EXPECT_EQ(Direction(Shot(true, 2, 10, world::Ground::Texture::kGrass)), "left");
}

TEST(Arrow, IsNotFoundInNoise) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_TRUE(FindArrows(NoisePicture(seed), {}).arrows.empty()) << seed;
    EXPECT_TRUE(FindArrows(SpottedPicture(seed, 40), {}).arrows.empty()) << seed;
  }
}

}  // namespace musher::vision::arrow_finder_test
