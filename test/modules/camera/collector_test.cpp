// Which pictures musher-camera puts into a strip.

#include "musher/modules/camera/tool/collector.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "musher/messages/stamp.hpp"

namespace musher::camera::tool::collector_test {

// A grey picture that was taken at that time.
msg::Image Shot(double seconds, std::uint8_t grey = 100) {
  msg::Image picture;
  picture.header.stamp = msg::ToStamp(Duration(std::llround(seconds * 1e9)));
  picture.width = 4;
  picture.height = 2;
  picture.encoding = "bgr8";
  picture.step = 12;
  picture.data.assign(24, grey);
  return picture;
}

StripOptions OfThreeCameras() {
  StripOptions options;
  options.topic = "left";
  options.beside = {"front", "right"};
  options.changes = "state";
  options.on_demand = true;
  options.every_s = 0.5;
  options.count = 2;
  options.width_px = 4;
  return options;
}

std::uint8_t GreyAt(const msg::Image& picture, std::uint32_t column) {
  return picture.data[std::size_t{column} * 3];
}

TEST(Collector, SetsThePicturesOfAMomentSideBySide) {
  Collector collector(OfThreeCameras());
  collector.OnText("START");
  collector.Take(0, Shot(1.0));
  collector.Take(1, Shot(1.1, 7));
  collector.Take(0, Shot(1.5, 10));
  collector.Take(2, Shot(1.5, 30));
  EXPECT_THAT(collector.Tiles(), ::testing::SizeIs(1));
  collector.Take(1, Shot(1.6, 20));
  collector.Take(1, Shot(1.7, 99));
  const std::vector<StripTile> tiles = collector.Tiles();
  ASSERT_EQ(tiles.size(), 1u);
  EXPECT_EQ(tiles[0].label, "1.5 s  START");
  EXPECT_EQ(GreyAt(tiles[0].picture, 0), 10);
  EXPECT_EQ(GreyAt(tiles[0].picture, 8), 20) << "the first of the second camera since then";
  EXPECT_EQ(GreyAt(tiles[0].picture, 16), 30);
}

TEST(Collector, NeedsPicturesOnDemandOnlyUntilAChangeHasItsOwn) {
  Collector collector(OfThreeCameras());
  EXPECT_FALSE(collector.NeedsPictures()) << "no text yet";
  collector.OnText("START");
  EXPECT_TRUE(collector.NeedsPictures());
  collector.Take(0, Shot(1.0));
  collector.Take(0, Shot(1.5));
  EXPECT_TRUE(collector.NeedsPictures()) << "those of the other cameras";
  collector.Take(1, Shot(1.5));
  collector.Take(2, Shot(1.5));
  EXPECT_FALSE(collector.NeedsPictures());
  collector.OnText("START");
  EXPECT_FALSE(collector.NeedsPictures()) << "no change";
  collector.OnText("END");
  EXPECT_TRUE(collector.NeedsPictures());
  collector.Take(0, Shot(2.0));
  collector.Take(0, Shot(2.5));
  collector.Take(1, Shot(2.5));
  collector.Take(2, Shot(2.5));
  EXPECT_TRUE(collector.done());
  EXPECT_FALSE(collector.NeedsPictures());
}

TEST(Collector, TakesATileWithoutACameraThatIsSilent) {
  Collector collector(OfThreeCameras());
  for (const double second : {1.0, 2.0}) {
    collector.OnText(std::to_string(second));
    collector.Take(0, Shot(second));
    collector.Take(0, Shot(second + 0.5, 10));
    collector.Take(1, Shot(second + 0.5, 20));
  }
  const std::vector<StripTile> tiles = collector.Tiles();
  ASSERT_EQ(tiles.size(), 2u) << "one by the next change, one that has begun";
  for (const StripTile& tile : tiles) {
    EXPECT_EQ(GreyAt(tile.picture, 8), 20);
    EXPECT_EQ(GreyAt(tile.picture, 16), 255) << "white";
  }
}

TEST(Collector, TakesOneCameraPeriodicallyWithoutATopicOfTexts) {
  StripOptions options;
  options.every_s = 1;
  options.count = 2;
  options.width_px = 4;
  Collector collector(options);
  EXPECT_TRUE(collector.NeedsPictures());
  for (const double second : {5.0, 5.5, 6.0, 7.0}) collector.Take(0, Shot(second));
  const std::vector<StripTile> tiles = collector.Tiles();
  ASSERT_EQ(tiles.size(), 2u);
  EXPECT_EQ(tiles[1].label, "6.0 s");
  EXPECT_TRUE(collector.done());
}

TEST(Collector, KeepsTheReasonOfAPictureThatItCannotRead) {
  Collector collector(StripOptions{});
  msg::Image broken = Shot(1.0);
  broken.data.clear();
  collector.Take(0, broken);
  EXPECT_TRUE(collector.Tiles().empty());
  EXPECT_TRUE(collector.unreadable());
}

}  // namespace musher::camera::tool::collector_test
