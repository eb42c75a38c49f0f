// The picture is really drawn: it is read back and looked at.

#include "musher/modules/world/picture/picture.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "musher/modules/world/paint/palette.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::world::picture_test {

class Picture : public ::testing::Test {
 protected:
  // Draws and reads back.
  cv::Mat Of(const World& world) {
    const std::string path = folder_ / "world.png";
    const Result<> drawn = Draw(world, path);
    EXPECT_TRUE(drawn) << drawn.error().message;
    return cv::imread(path);
  }
  static bool Is(const cv::Vec3b& pixel, const Color& color) {
    const auto near = [](int a, int b) { return std::abs(a - b) < 8; };
    return near(pixel[2], color.red) && near(pixel[1], color.green) && near(pixel[0], color.blue);
  }
  // How many pixels of that colour the place has, or the charts below it.
  static int CountAbove(const cv::Mat& image, const Color& color) {
    return Count(image.rowRange(60, 660).colRange(0, 680), color);
  }
  static int CountBelow(const cv::Mat& image, const Color& color) {
    return Count(image.rowRange(680, image.rows), color);
  }
  static int Count(const cv::Mat& image, const Color& color) {
    return static_cast<int>(
        std::count_if(image.begin<cv::Vec3b>(), image.end<cv::Vec3b>(),
                      [&](const cv::Vec3b& pixel) { return Is(pixel, color); }));
  }

  const TempFolder folder_;
};

TEST_F(Picture, HasItsSizeAndIsNoEmptySheet) {
  const cv::Mat image = Of(World(FullYard()));
  ASSERT_EQ(image.cols, kPictureWidth);
  ASSERT_EQ(image.rows, kPictureHeight);
  EXPECT_TRUE(Is(image.at<cv::Vec3b>(5, 5), kPaper));
  EXPECT_GT(CountAbove(image, kObstacle), 2000);
  EXPECT_GT(CountAbove(image, kGround), 100'000);
}

TEST_F(Picture, ShowsZonesWithTheirNames) {
  Scene scene = EmptyYard();
  EXPECT_LT(CountAbove(Of(World(scene)), kZone), 50);  // edges of letters
  scene.zones = {{"GOAL", {5, 5}, {1, 1}}};
  const cv::Mat image = Of(World(scene));
  EXPECT_GT(CountAbove(image, kZone), 1000);
  EXPECT_GT(CountAbove(image, kZoneEdge), 150);
}

TEST_F(Picture, ShowsTheTimeInTheColourOfTheWayIfTheSceneSaysSo) {
  Scene scene = EmptyYard();
  scene.picture.way = ::musher::world::Picture::Way::kTime;
  World world(scene);
  Commander commander(world);
  commander.Walk({0.8, 0, 0}, Seconds(8));
  const cv::Mat image = Of(world);
  EXPECT_GT(CountAbove(image, ColorOfTime(0.5)), 10);
  EXPECT_GT(CountAbove(image, ColorOfTime(0.25)), 10);
  EXPECT_GT(CountAbove(image, ColorOfTime(0.75)), 10);
}

TEST_F(Picture, ShowsGuestsWhereTheyAreAndWhatAHumanoidSees) {
  const Color red{220, 20, 60};
  Scene scene = EmptyYard();
  scene.least_m = {-2, -2};
  scene.most_m = {2, 2};
  GuestSpec guest;
  guest.from_m = {1, 1};
  guest.color = red;
  scene.guests = {guest};
  const cv::Mat with_guest = Of(World(scene));
  EXPECT_GT(CountAbove(with_guest, red), 50);
  EXPECT_EQ(CountAbove(with_guest, kSight), 0);
  scene.humanoid.emplace();
  EXPECT_GT(CountAbove(Of(World(scene)), kSight), 1000);
}

TEST_F(Picture, ShowsTheLidarScanIfTheSceneRequestsIt) {
  Scene scene = FullYard();
  EXPECT_EQ(CountAbove(Of(World(scene)), kScanRed), 0);
  scene.picture.scan = true;
  EXPECT_GT(CountAbove(Of(World(scene)), kScanRed), 500);
  scene.sensors.lidar.enabled = false;
  EXPECT_EQ(CountAbove(Of(World(scene)), kScanRed), 0);
}

TEST_F(Picture, IsLowerForAWidePlaceAndNoWiderForAHighOne) {
  Scene scene = EmptyYard();
  scene.least_m.y() = -1;
  scene.most_m.y() = 1;
  const cv::Mat wide = Of(World(scene));
  EXPECT_EQ(wide.cols, kPictureWidth);
  EXPECT_LT(wide.rows, kPictureHeight - 100);
  scene = EmptyYard();
  scene.least_m.x() = -1;
  scene.most_m.x() = 1;
  const cv::Mat high = Of(World(scene));
  EXPECT_EQ(high.cols, kPictureWidth);
  EXPECT_EQ(high.rows, kPictureHeight);
}

TEST_F(Picture, ShowsThePadOnlyWhereThereIsOne) {
  Scene scene = EmptyYard();
  EXPECT_EQ(CountAbove(Of(World(scene)), kPad), 0);
  scene.pads = {{{5, 5}, 2}};
  EXPECT_GT(CountAbove(Of(World(scene)), kPad), 1000);
}

TEST_F(Picture, ColoursThePathAndTheBandByTheMachinesState) {
  World world(EmptyYard());
  Commander commander(world);
  world.SetMachineState("Active");
  commander.Walk({0.6, 0, 0}, Seconds(10));
  EXPECT_EQ(CountAbove(Of(world), ColorOfState("Protected")), 0);
  const int active = CountAbove(Of(world), ColorOfState("Active"));
  EXPECT_GT(active, 400);
  world.SetMachineState("Protected");
  commander.Walk({0, 0.3, 0}, Seconds(10));
  const cv::Mat image = Of(world);
  EXPECT_GT(CountAbove(image, ColorOfState("Protected")), 200);
  EXPECT_NEAR(CountAbove(image, ColorOfState("Active")), active, 0.2 * active);
  EXPECT_GT(CountBelow(image, ColorOfState("Protected")), 5000);
  EXPECT_GT(CountBelow(image, ColorOfState("Active")), 5000);
}

TEST_F(Picture, ColoursThePathByBatteryWithoutAMachine) {
  World world(EmptyYard());
  ASSERT_EQ(world.SetBattery(100), std::nullopt);
  Commander(world).Walk({0.6, 0, 0}, Seconds(10));
  EXPECT_GT(CountAbove(Of(world), ColorOfBattery(100)), 300);
}

TEST_F(Picture, DrawsNoLineWhereTheBodyWasCarried) {
  World world(EmptyYard());
  world.SetMachineState("Error");
  Pass(world, Seconds(1));
  ASSERT_EQ(world.PutDown({{-8, -8}, 0}), std::nullopt);
  Pass(world, Seconds(1));
  ASSERT_EQ(world.PutDown({{8, 8}, 0}), std::nullopt);
  Pass(world, Seconds(1));
  EXPECT_LT(CountAbove(Of(world), ColorOfState("Error")), 200);  // dots at most
}

TEST_F(Picture, MarksBumpsAndCharging) {
  World world(EmptyYard());
  EXPECT_EQ(CountAbove(Of(world), kBumpRed), 0);
  ASSERT_EQ(world.PutDown({{9, 0}, 0}), std::nullopt);
  Commander(world).Walk({0.6, 0, 0}, Seconds(3));
  ASSERT_EQ(world.PutDown({{0, 0}, 0}), std::nullopt);
  world.Plug(true);
  Pass(world, Seconds(3));
  const cv::Mat image = Of(world);
  EXPECT_GT(CountAbove(image, kBumpRed), 10);
  EXPECT_GT(CountBelow(image, kPad), 5000);
}

TEST_F(Picture, MarksMomentsInTheCharts) {
  World world(EmptyYard());
  Commander commander(world);
  commander.Walk({0.5, 0, 0}, Seconds(4));
  EXPECT_LT(CountBelow(Of(world), kMarkInk), 20);
  world.AddMark("kill -KILL sensor_manager");
  commander.Walk({0.5, 0, 0}, Seconds(4));
  for (int i = 0; i < 1000; ++i) world.AddMark(std::string(1000, 'x'));
  EXPECT_GT(CountBelow(Of(world), kMarkInk), 100) << "a line through all rows";
  EXPECT_LE(world.track().marks().size(), 50U) << "anyone may publish";
}

TEST_F(Picture, HandlesAnyNameFromTheNetwork) {
  Scene scene = EmptyYard();
  scene.name = std::string(500, 'x') + "\xff\xfe\n";
  World world(scene);
  world.SetMachineState(std::string(300, 'y'));
  Pass(world, Seconds(5));
  EXPECT_EQ(Of(world).cols, kPictureWidth);
}

TEST_F(Picture, ReportsWhereItCouldNotBeWritten) {
  const Result<> drawn = Draw(World(EmptyYard()), "/nowhere/world.png");
  ASSERT_FALSE(drawn);
  EXPECT_THAT(drawn.error().message, ::testing::HasSubstr("/nowhere/world.png"));
}

TEST_F(Picture, LeavesNoPartialFileBehind) {
  static_cast<void>(Of(World(EmptyYard())));
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "")) {
    EXPECT_EQ(entry.path().filename(), "world.png");
    ++files;
  }
  EXPECT_EQ(files, 1);
}

}  // namespace musher::world::picture_test
