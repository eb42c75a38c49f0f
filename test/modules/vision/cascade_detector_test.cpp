// The real detector on the world's drawn faces, at distances that are known.

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "musher/modules/vision/faces/detector.hpp"
#include "musher/modules/vision/picture/lens.hpp"
#include "musher/modules/vision/tool/look.hpp"
#include "musher/modules/world/render/render.hpp"
#include "musher/test/modules/vision/faces.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::vision::cascade_detector_test {

using ::testing::HasSubstr;

constexpr double kBoardM = 0.35;  // side of a board with a face
// What the detector's box encloses of a face on it, measured: nine sixteenths and a little more.
constexpr double kFaceM = 0.595 * kBoardM;

// The front camera's picture of a board with that face, as high as the camera.
msg::Image PictureOfFace(std::optional<int> face, double far_m, double aside_m = 0) {
  using namespace world;
  Scene scene = EmptyYard();
  scene.ground.finest_per_m = 30;
  const CameraSpec camera = CameraSet().cameras[0];
  const double eye_m = 0.29 + camera.position_m.z();
  Board board{
      "", {camera.position_m.x() + far_m, aside_m}, M_PI, kBoardM, kBoardM, eye_m - kBoardM / 2};
  if (face) board.sign = {Sign::Kind::kFace, "", *face};
  scene.boards = {board};
  const auto scenery = Scenery::Make(scene);
  Image image =
      Camera(camera).Shoot(*scenery.value(), {{}, {0.29, 0, 0}, std::uint64_t(far_m * 10)});
  msg::Image picture;
  picture.width = std::uint32_t(image.width);
  picture.height = std::uint32_t(image.height);
  picture.encoding = "bgr8";
  picture.step = picture.width * 3;
  picture.data = std::move(image.bgr);
  return picture;
}

std::unique_ptr<Detector> TheDetector(int width_px = 320) {
  CascadeConfig config;
  config.model = DefaultModel();
  config.width_px = width_px;
  auto made = MakeCascadeDetector(config);
  EXPECT_TRUE(made) << made.error().message;
  return std::move(made).value();
}

TEST(CascadeDetector, FindsTheWorldsFacesAndHowFarAwayTheyAre) {
  const auto detector = TheDetector();
  for (const double far_m : testing::Ends({0.4, 0.6, 1.0, 1.5, 2.0})) {
    for (const int face : {0, 3, 4, 7}) {
      const auto found = detector->Detect(PictureOfFace(face, far_m));
      ASSERT_EQ(found.size(), 1U) << face << " at " << far_m;
      EXPECT_NEAR(found[0].center_x(), 0.5, 0.02);
      EXPECT_NEAR(found[0].center_y(), 0.5, 0.05);
      EXPECT_TRUE(found[0].frontal);
      EXPECT_GE(found[0].confidence, 0.5);
      EXPECT_NEAR(DistanceM(FrontLens(), found[0], found[0].height, kFaceM), far_m, 0.15 * far_m)
          << face;
    }
  }
}

TEST(CascadeDetector, SeesFartherInALargerPicture) {
  EXPECT_TRUE(TheDetector(320)->Detect(PictureOfFace(3, 4)).empty());
  EXPECT_EQ(TheDetector(640)->Detect(PictureOfFace(3, 4)).size(), 1U);
}

TEST(CascadeDetector, FindsNoFaceInAnEmptyScene) {
  EXPECT_TRUE(TheDetector()->Detect(PictureOfFace(std::nullopt, 1)).empty());
}

// The same picture in every encoding of cameras.
TEST(CascadeDetector, FindsTheSameInEveryEncoding) {
  const msg::Image bgr = PictureOfFace(3, 1, 0.2);
  const auto detector = TheDetector();
  const auto expected = detector->Detect(bgr);
  ASSERT_EQ(expected.size(), 1U);
  for (const std::string encoding : {"rgb8", "rgba8", "bgra8", "mono8"}) {
    msg::Image picture = bgr;
    const std::uint32_t channels = encoding == "mono8" ? 1 : encoding.size() == 5 ? 4 : 3;
    picture.encoding = encoding;
    picture.step = picture.width * channels + 12;  // rows with something behind them
    picture.data.assign(std::size_t{picture.step} * picture.height, 255);
    for (std::size_t y = 0; y < picture.height; ++y) {
      for (std::size_t x = 0; x < picture.width; ++x) {
        const std::uint8_t* from = bgr.data.data() + y * bgr.step + 3 * x;
        std::uint8_t* to = picture.data.data() + y * picture.step + channels * x;
        if (channels == 1) {
          *to = std::uint8_t(std::lround(0.114 * from[0] + 0.587 * from[1] + 0.299 * from[2]));
        } else {
          for (std::size_t c = 0; c < 3; ++c) to[c] = from[encoding[0] == 'r' ? 2 - c : c];
        }
      }
    }
    const auto found = detector->Detect(picture);
    ASSERT_EQ(found.size(), 1U) << encoding;
    EXPECT_NEAR(Distance(found[0], expected[0]), 0, 0.01) << encoding;
    EXPECT_NEAR(found[0].height, expected[0].height, 0.01) << encoding;
  }
}

TEST(CascadeDetector, HandlesPicturesOfAnySize) {
  const auto detector = TheDetector();
  for (const auto& [width, height] : {std::pair(1U, 1U), std::pair(1U, 2000U), std::pair(2000U, 1U),
                                      std::pair(19U, 21U), std::pair(3840U, 2160U)}) {
    EXPECT_TRUE(detector->Detect(Picture(width, height)).empty()) << width << " x " << height;
  }
}

TEST(CascadeDetector, IsNotMadeFromAnInvalidModel) {
  const TempFolder folder;
  CascadeConfig config;
  config.model = folder / "missing.xml";
  EXPECT_EQ(MakeCascadeDetector(config).error().message,
            config.model + ": there is no such model; Debian's opencv-data has some");
  for (const std::string text :
       {"", "no xml", "<?xml version=\"1.0\"?><opencv_storage></opencv_storage>"}) {
    config.model = folder / "broken.xml";
    std::ofstream(config.model) << text;
    const auto made = MakeCascadeDetector(config);
    ASSERT_FALSE(made) << text;
    EXPECT_EQ(made.error().code, 5912);
    EXPECT_THAT(made.error().message, HasSubstr("broken.xml: this is no cascade"));
  }
}

std::string WritePicture(const std::string& file, msg::Image picture) {
  const cv::Mat mat(int(picture.height), int(picture.width), CV_8UC3, picture.data.data());
  EXPECT_TRUE(cv::imwrite(file, mat));
  return file;
}

TEST(LookTool, PrintsWhatIsFoundAndDrawsIt) {
  const TempFolder folder;
  tool::LookOptions options;
  options.pictures = {WritePicture(folder / "face.png", PictureOfFace(3, 1))};
  options.out = folder / "boxes.png";
  options.hfov_deg = 2 * std::atan(320.0 / 600) * 180 / M_PI;
  options.at_m = 1;
  std::ostringstream out;
  ASSERT_TRUE(tool::Look({}, options, out));
  EXPECT_THAT(out.str(), ::testing::ContainsRegex("face.png: 640 x 480, 1 face in [0-9]+ ms"));
  EXPECT_THAT(out.str(), ::testing::ContainsRegex("  at 0.[45][0-9]+ 0.[45][0-9]+, .* m away"));
  EXPECT_THAT(out.str(), ::testing::ContainsRegex("it is 1.00 m away when face_m = 0.(19|2[0-3])"));
  const cv::Mat before = cv::imread(options.pictures[0]);
  const cv::Mat after = cv::imread(options.out);
  ASSERT_EQ(after.size(), before.size());
  EXPECT_GT(cv::norm(before, after), 0);
}

TEST(LookTool, ReportsWhatItCannotReadOrWrite) {
  const TempFolder folder;
  tool::LookOptions options;
  options.pictures = {folder / "missing.png"};
  std::ostringstream out;
  EXPECT_THAT(tool::Look({}, options, out).error().message,
              HasSubstr("missing.png is no picture that can be read"));
  options.pictures = {WritePicture(folder / "face.png", Picture())};
  options.out = "/no/such/folder/boxes.png";
  EXPECT_THAT(tool::Look({}, options, out).error().message,
              HasSubstr("/no/such/folder/boxes.png cannot be written"));
}

}  // namespace musher::vision::cascade_detector_test
