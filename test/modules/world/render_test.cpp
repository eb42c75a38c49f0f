// The pictures of the world's cameras: where things are in the picture, and their looks.

#include "musher/modules/world/render/render.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <functional>

#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/shots.hpp"

namespace musher::world::render_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr Color kMagenta{255, 0, 255};

bool IsMagenta(const std::uint8_t* bgr) {
  return bgr[0] > 180 && bgr[1] < 60 && bgr[2] > 180;
}
bool IsRed(const std::uint8_t* bgr) {
  return bgr[2] > 60 && bgr[2] > 2 * bgr[1] && bgr[2] > 2 * bgr[0];
}
bool IsBlue(const std::uint8_t* bgr) {
  return bgr[0] > 60 && bgr[0] > 2 * bgr[1] && bgr[0] > 2 * bgr[2];
}
bool IsYellow(const std::uint8_t* bgr) {
  return bgr[2] > 100 && bgr[1] > 80 && bgr[0] < bgr[1] / 2;
}

// Its ground is quickly painted.
Scene RoughYard() {
  Scene scene = EmptyYard();
  scene.ground.finest_per_m = 20;
  return scene;
}

Box BoxAt(double x_m, const Color& color, double half_y_m = 0.2, double height_m = 0.5) {
  Box box{"", {x_m, 0}, {0.1, half_y_m}};
  box.height_m = height_m;
  box.color = color;
  return box;
}

double Uniform(double least, double most) {
  return least + (most - least) * *rc::gen::inRange(0, 10'001) / 10'000;
}

RC_GTEST_PROP(RenderProperty, ShowsAPointWhereCameraInfoProjectsIt, ()) {
  for (CameraSpec spec : CameraSet().cameras) {
    spec.noise = 0;
    const View view{{{Uniform(-5, 5), Uniform(-5, 5)}, Uniform(-3, 3)},
                    {Uniform(0.2, 0.35), Uniform(-0.2, 0.2), Uniform(-0.2, 0.2)}};
    const Eigen::Isometry3d camera = CameraInPlace(spec, view.body, view.attitude);
    const Intrinsics intrinsics = IntrinsicsOf(spec);
    const Vector2d wanted(Uniform(60, 580), Uniform(60, 420));
    const bool near_the_rim = (wanted - intrinsics.center_px).norm() > 305;
    if (near_the_rim && spec.model == CameraModel::kFisheye) continue;
    const Vector3d point = camera * (RayOf(intrinsics, wanted) * Uniform(0.8, 2));
    if (point.z() < 0.05) continue;  // under the ground
    Scene scene = RoughYard();
    scene.fence_height_m = 0;
    scene.balls = {{point, 0.02, kMagenta, true}};
    const auto pixel = Project(intrinsics, camera.inverse() * point);
    RC_ASSERT(pixel.has_value());
    const auto seen = MiddleOf(ShotOf(scene, spec, view), IsMagenta);
    RC_ASSERT(seen.has_value());
    RC_ASSERT((*seen - *pixel).norm() < 0.6);
  }
}

TEST(Render, ShowsWhatIsNearerBeforeWhatIsFarther) {
  Scene scene = RoughYard();
  scene.boxes = {BoxAt(1.5, {220, 0, 0}), BoxAt(3, {0, 0, 220}, 1, 1.2)};
  const Image image = FrontShot(scene);
  EXPECT_TRUE(IsRed(image.At(320, 240)));
  EXPECT_TRUE(IsBlue(image.At(320, 100))) << "over the near one";
  EXPECT_TRUE(IsBlue(image.At(200, 200))) << "beside it";
  // The same, whatever the order in the scene.
  std::swap(scene.boxes[0], scene.boxes[1]);
  EXPECT_EQ(FrontShot(scene).bgr, image.bgr);
}

TEST(Render, ShowsEveryShapeAndWhatHangsOverTheGround) {
  Scene scene = RoughYard();
  scene.circles = {{"", {2, 0.5}, 0.15, 0.4, 0, {220, 0, 0}}};
  scene.balls = {{{2, -0.5, 0.2}, 0.2, {0, 0, 220}}};
  Box barrier = BoxAt(2, {230, 210, 0}, 0.9, 0.08);
  barrier.bottom_m = 0.6;
  scene.boxes = {barrier};
  const Image image = FrontShot(scene);
  const auto at = [&](const Vector3d& point) {
    return image.At(PixelOf(point).x(), PixelOf(point).y());
  };
  EXPECT_TRUE(IsRed(at({1.85, 0.5, 0.3})));
  EXPECT_TRUE(IsBlue(at({1.8, -0.5, 0.2})));
  EXPECT_TRUE(IsYellow(at({1.9, 0, 0.64})));
  EXPECT_FALSE(IsYellow(at({1.9, 0, 0.5}))) << "one sees through below it";
}

TEST(Render, HidesWhatStandsBehindTheFence) {
  Scene scene = RoughYard();
  scene.most_m.x() = 3;
  scene.boxes = {BoxAt(4, {220, 0, 0}, 1, 0.5)};
  EXPECT_FALSE(MiddleOf(FrontShot(scene), IsRed));
  scene.fence_height_m = 0.1;
  EXPECT_TRUE(MiddleOf(FrontShot(scene), IsRed));
}

TEST(Render, PaintsALineOnTheGroundWithItsWidthAndColour) {
  Scene scene = RoughYard();
  scene.least_m = {-1, -2};
  scene.most_m = {3, 2};
  scene.ground.finest_per_m = 320;
  scene.ground.texture = Ground::Texture::kGrass;
  scene.ground.color = {98, 134, 60};
  scene.ground.other_color = {64, 98, 40};
  scene.lines = {{{{1.5, -2}, {1.5, 2}}, 0.05, {246, 206, 20}}};
  const Image image = FrontShot(scene);
  const double near = PixelOf({1.475, 0, 0}).y();
  const double far = PixelOf({1.525, 0, 0}).y();
  int rows = 0;
  for (int y = 0; y < image.height; ++y) rows += IsYellow(image.At(320, y)) ? 1 : 0;
  EXPECT_NEAR(rows, near - far, 2.5) << "smooth at both edges";
  EXPECT_TRUE(IsYellow(image.At(320, static_cast<int>(std::lround((near + far) / 2)))));
}

// A line that is straight on the ground is straight for a pinhole and bent by a fisheye, as far as
// the model says.
TEST(Render, BendsStraightLinesAsAFisheyeDoes) {
  Scene scene = RoughYard();
  scene.least_m = {-3, -1};
  scene.most_m = {3, 3};
  scene.ground.finest_per_m = 200;
  scene.lines = {{{{-3, 0.5}, {3, 0.5}}, 0.05, {246, 206, 20}}};
  CameraSpec left = CameraSet().cameras[1];
  left.noise = 0;
  const Image image = ShotOf(scene, left, Standing());
  const Eigen::Isometry3d camera = CameraInPlace(left, {}, Standing().attitude);
  double highest = 1e9, lowest = 0;
  for (const double x : {-0.4, 0.0, 0.22, 0.4, 0.8}) {
    const auto pixel = Project(IntrinsicsOf(left), camera.inverse() * Vector3d(x, 0.5, 0));
    ASSERT_TRUE(pixel);
    EXPECT_TRUE(IsYellow(image.At(static_cast<int>(std::lround(pixel->x())),
                                  static_cast<int>(std::lround(pixel->y())))))
        << x;
    highest = std::min(highest, pixel->y());
    lowest = std::max(lowest, pixel->y());
  }
  EXPECT_GT(lowest - highest, 15) << "a pinhole would show it level";
}

TEST(Render, LaysOutAPictureOnTheGroundTheRightWayRound) {
  const TempFolder folder;
  Scene scene = RoughYard();
  scene.ground.texture = Ground::Texture::kPicture;
  // Red upper left, blue upper right, yellow below: the upper edge lies along the larger y.
  scene.ground.file = WriteQuarters(folder / "ground.png");
  scene.ground.once = true;
  scene.ground.finest_per_m = 50;
  scene.ground.least_m = {1, -0.5};
  scene.ground.most_m = {2, 0.5};
  const Image image = FrontShot(scene);
  const auto at = [&](double x, double y) {
    return image.At(PixelOf({x, y, 0}).x(), PixelOf({x, y, 0}).y());
  };
  EXPECT_TRUE(IsRed(at(1.25, 0.25)));
  EXPECT_TRUE(IsBlue(at(1.75, 0.25)));
  EXPECT_TRUE(IsYellow(at(1.25, -0.25)));
  EXPECT_FALSE(IsYellow(at(2.5, -0.25)));
}

TEST(Render, ShowsTheFrontOfABoardTheRightWayRoundAndNothingOnItsBack) {
  const TempFolder folder;
  Scene scene = RoughYard();
  Board board{"", {1.5, 0}, M_PI, 0.4, 0.4, 0.1};
  board.sign = {Sign::Kind::kPicture, WriteQuarters(folder / "board.png")};
  scene.boards = {board};
  const Image image = FrontShot(scene);
  const auto at = [&](double y, double z) {
    return image.At(PixelOf({1.5, y, z}).x(), PixelOf({1.5, y, z}).y());
  };
  EXPECT_TRUE(IsRed(at(0.1, 0.4))) << "upper left";
  EXPECT_TRUE(IsBlue(at(-0.1, 0.4))) << "upper right";
  EXPECT_TRUE(IsYellow(at(0.1, 0.2)));
  scene.boards[0].yaw_rad = 0;
  const Image back = FrontShot(scene);
  EXPECT_FALSE(MiddleOf(back, IsRed));
  EXPECT_FALSE(MiddleOf(back, IsBlue));
}

TEST(Render, ShowsOnlyTheDiscOfARoundBoard) {
  Scene scene = RoughYard();
  Board board{"", {1.5, 0}, M_PI, 0.4, 0.4, 0.1, kMagenta};
  board.round = true;
  scene.boards = {board};
  const Image image = FrontShot(scene);
  const auto is_board = [&](double y, double z) {
    const std::uint8_t* bgr = image.At(PixelOf({1.5, y, z}).x(), PixelOf({1.5, y, z}).y());
    return bgr[0] > 100 && bgr[1] < 50 && bgr[2] > 100;
  };
  EXPECT_TRUE(is_board(0, 0.3));
  EXPECT_TRUE(is_board(0.12, 0.42));
  EXPECT_TRUE(is_board(0.19, 0.3));
  EXPECT_FALSE(is_board(0.16, 0.46));
  EXPECT_FALSE(is_board(-0.16, 0.14));
}

TEST(Render, ShowsNoBallThatIsHidden) {
  Scene scene = RoughYard();
  scene.balls = {{{2, 0.3, 0.3}, 0.1, kMagenta, true}, {{2, -0.3, 0.3}, 0.1, kMagenta, true}};
  View view = Standing();
  view.hidden_balls = {0};
  const auto middle = MiddleOf(ShotOf(scene, FrontCamera(), view), IsMagenta);
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->x(), PixelOf({2, -0.3, 0.3}).x(), 2);
  view.hidden_balls = {0, 1};
  EXPECT_FALSE(MiddleOf(ShotOf(scene, FrontCamera(), view), IsMagenta));
}

TEST(Render, SmoothsTheEdgesOfThings) {
  Scene scene = RoughYard();
  scene.fence_height_m = 0;
  scene.light.sky = {255, 255, 255};
  Box tower = BoxAt(2, {0, 0, 0}, 0.2, 3);
  tower.yaw_rad = 0.3;
  scene.boxes = {tower};
  CameraSpec rolled = CameraSet().cameras[0];
  rolled.noise = 0;
  rolled.roll_rad = 0.15;
  const Image image = ShotOf(scene, rolled, Standing());
  int between = 0;
  for (int y = 20; y < 120; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const int level = image.At(x, y)[1];
      if (level > 40 && level < 180) ++between;
    }
  }
  EXPECT_GT(between, 100) << "about one on either side in each row";
  EXPECT_LT(between, 600);
}

TEST(Render, IsTheSameFromTheSameSeedAndDiffersInNoiseOnlyFromAnother) {
  Scene scene = FullYard();
  scene.ground.finest_per_m = 20;
  CameraSpec spec = CameraSet().cameras[0];
  spec.noise = 4;
  View view = Standing();
  view.seed = 7;
  const Image image = ShotOf(scene, spec, view);
  EXPECT_EQ(ShotOf(scene, spec, view).bgr, image.bgr);
  view.seed = 8;
  const Image other = ShotOf(scene, spec, view);
  double squares = 0;
  for (std::size_t i = 0; i < image.bgr.size(); ++i) {
    const double by = image.bgr[i] - other.bgr[i];
    squares += by * by;
  }
  const double deviation = std::sqrt(squares / static_cast<double>(image.bgr.size()) / 2);
  EXPECT_NEAR(deviation, 4, 0.4);
}

TEST(Render, TakesBrightnessColourAndGradientFromTheLight) {
  const auto ground_at = [](const Scene& scene, double y) {
    const Image image = FrontShot(scene);
    const auto pixel = PixelOf({1.5, y, 0});
    const std::uint8_t* bgr = image.At(pixel.x(), pixel.y());
    return Vector3d(bgr[2], bgr[1], bgr[0]);
  };
  Scene scene = RoughYard();
  scene.least_m = {-1, -1};
  scene.most_m = {3, 1};
  const Vector3d plain = ground_at(scene, 0);
  scene.light.brightness = 0.5;
  EXPECT_NEAR(ground_at(scene, 0).y(), plain.y() / 2, 2);
  scene.light.brightness = 1;
  scene.light.temperature_k = 3000;
  const Vector3d warm = ground_at(scene, 0);
  EXPECT_GT(warm.x() / warm.z(), 1.5 * plain.x() / plain.z());
  scene.light.temperature_k = 6500;
  scene.light.gradient = 0.6;
  scene.light.gradient_yaw_rad = M_PI / 2;  // darker to the left
  EXPECT_LT(ground_at(scene, 0.3).y(), 0.85 * ground_at(scene, -0.3).y());
}

TEST(Render, ShowsShadowsUnlessTheSceneHasNone) {
  Scene scene = RoughYard();
  scene.light.yaw_rad = M_PI / 2;  // from the left
  scene.boxes = {BoxAt(2, {200, 200, 200})};
  const auto beside = PixelOf({2, -0.3, 0});
  const int shaded = FrontShot(scene).At(beside.x(), beside.y())[1];
  scene.light.shadows = false;
  const int lit = FrontShot(scene).At(beside.x(), beside.y())[1];
  EXPECT_LT(shaded, 0.8 * lit);
}

TEST(Render, IsDarkerInTheCornersAndLighterWithMoreExposure) {
  Scene scene = RoughYard();
  scene.light.sky = {128, 128, 128};
  CameraSpec spec = CameraSet().cameras[0];
  spec.noise = 0;
  spec.pitch_rad = -M_PI / 2;  // up
  spec.vignette = 0.5;
  const auto level = [&](int x, int y) { return ShotOf(scene, spec, Standing()).At(x, y)[1]; };
  EXPECT_LT(level(0, 0), 0.65 * level(320, 240));
  const double before = level(320, 240);
  spec.exposure = 1.5;
  EXPECT_NEAR(level(320, 240), 1.5 * before, 2);
}

TEST(Render, HandlesABodyOnItsBackAndACameraInsideAThing) {
  Scene scene = FullYard();
  scene.ground.finest_per_m = 20;
  scene.balls = {{{0.27, 0, 0.3}, 0.2, kMagenta}};
  for (const CameraSpec& spec : CameraSet().cameras) {
    for (const double roll : {0.0, 1.5, 3.14}) {
      const View view{{{0, 0}, 0.3}, {0.02, roll, 0.7}};
      EXPECT_EQ(ShotOf(scene, spec, view).bgr.size(), 640U * 480 * 3);
    }
  }
}

TEST(Scenery, ReportsWhichPictureIsMissing) {
  Scene scene = RoughYard();
  Board board;
  board.sign = {Sign::Kind::kPicture, "/nowhere/poster.png"};
  scene.boards = {board};
  const auto scenery = Scenery::Make(scene);
  ASSERT_FALSE(scenery);
  EXPECT_THAT(scenery.error().message, ::testing::HasSubstr("/nowhere/poster.png"));
}

}  // namespace musher::world::render_test
