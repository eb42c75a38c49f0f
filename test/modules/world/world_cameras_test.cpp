// The cameras of a world on a network, in virtual time.

#include "musher/modules/world/process/world_cameras.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <map>

#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/world/scenes.hpp"
#include "musher/test/modules/world/shots.hpp"
#include "musher/test/modules/world/world_on_network.hpp"
#include "musher/transport/clock.hpp"

namespace musher::world::world_cameras_test {

using std::chrono::seconds;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

// A yard with something in it, and cameras of few pixels.
Scene SmallCameras() {
  Scene scene = FullYard();
  scene.ground.finest_per_m = 20;
  for (CameraSpec& camera : scene.cameras.cameras) {
    camera.width_px = 64;
    camera.height_px = 48;
  }
  return scene;
}

class CountingWorker : public PromptWorker {
 public:
  void Run(Work work, Done done) override {
    ++runs;
    PromptWorker::Run(std::move(work), std::move(done));
  }
  int runs = 0;
};

class WorldCamerasTest : public WorldOnNetwork {
 protected:
  WorldCamerasTest() : WorldOnNetwork("dog1") {}

  void Open(const Scene& scene, Worker& worker) { StartWorld(scene, &worker); }
  std::unique_ptr<transport::Subscription> Watch(const std::string& camera,
                                                 std::vector<msg::Image>& seen) {
    return Listen(Name("world/camera/" + camera), seen, transport::kSensorDataQos);
  }
};

TEST_F(WorldCamerasTest, DrawNothingWithoutASubscriber) {
  CountingWorker worker;
  Open(SmallCameras(), worker);
  network_.RunFor(seconds(5));
  EXPECT_EQ(worker.runs, 0);
  std::vector<msg::Image> seen;
  auto watch = Watch("front", seen);
  network_.RunFor(seconds(2));
  EXPECT_GE(worker.runs, 25) << "the front camera, and no other";
  EXPECT_LE(worker.runs, 31);
  watch.reset();
  network_.RunFor(Milliseconds(500));
  const int before = worker.runs;
  network_.RunFor(seconds(2));
  EXPECT_EQ(worker.runs, before);
}

TEST_F(WorldCamerasTest, PublishAtTheirRateWithTheWorldsTimeOfTheShot) {
  CountingWorker worker;
  Scene scene = SmallCameras();
  scene.cameras.cameras[1].rate_hz = 5;
  Open(scene, worker);
  std::vector<msg::Image> front, left;
  const auto watches = {Watch("front", front), Watch("left", left)};
  network_.RunFor(seconds(1));
  front.clear();
  left.clear();
  network_.RunFor(seconds(10));
  EXPECT_NEAR(static_cast<double>(front.size()), 150, 2);
  EXPECT_NEAR(static_cast<double>(left.size()), 50, 1);
  const msg::Image& image = front.back();
  EXPECT_EQ(image.header.frame_id, "camera_front");
  EXPECT_EQ(left.back().header.frame_id, "camera_left");
  EXPECT_EQ(image.encoding, "bgr8");
  EXPECT_EQ(image.width, 64U);
  EXPECT_EQ(image.height, 48U);
  EXPECT_EQ(image.step, 192U);
  EXPECT_THAT(image.data, SizeIs(192 * 48));
  for (std::size_t i = 1; i < left.size(); ++i) {
    EXPECT_EQ(msg::FromStamp(left[i].header.stamp) - msg::FromStamp(left[i - 1].header.stamp),
              Milliseconds(200));
  }
}

TEST_F(WorldCamerasTest, LatchTheExactIntrinsicsForLateSubscribers) {
  PromptWorker worker;
  const Scene scene = SmallCameras();
  Open(scene, worker);
  network_.RunFor(seconds(1));
  std::map<std::string, msg::CameraInfo> infos;
  std::vector<std::unique_ptr<transport::Subscription>> watches;
  for (const std::string name : {"front", "left", "right"}) {
    watches.push_back(
        transport::MakeSubscription<msg::CameraInfo>(
            *desk_, "dog1/world/camera/" + name + "/info",
            [&infos, name](const msg::CameraInfo& info, const auto&) { infos[name] = info; },
            transport::kLatchedQos)
            .value());
  }
  network_.RunFor(seconds(1));
  ASSERT_EQ(infos.size(), 3U);
  const Intrinsics front = IntrinsicsOf(scene.cameras.cameras[0]);
  EXPECT_EQ(infos["front"].distortion_model, "plumb_bob");
  EXPECT_EQ(infos["front"].d, std::vector<double>(5, 0));
  EXPECT_DOUBLE_EQ(infos["front"].k[0], front.focal_px);
  EXPECT_DOUBLE_EQ(infos["front"].k[5], 23.5);
  EXPECT_EQ(infos["left"].distortion_model, "equidistant");
  EXPECT_EQ(infos["left"].d, std::vector<double>(4, 0));
  EXPECT_DOUBLE_EQ(infos["left"].k[0], 32 / (M_PI / 2)) << "pixels in a radian";
  EXPECT_EQ(infos["right"].header.frame_id, "camera_right");
}

using Pictures = std::map<Duration, std::vector<std::uint8_t>>;  // by stamp

Pictures FrontPictures(const std::vector<std::string>& watched, Duration start) {
  transport::sim::Network network(3);
  const auto robot = network.MakeNode("robot");
  const auto desk = network.MakeNode("desk");
  PromptWorker worker;
  HostOptions options;
  options.log = [](const std::string&) {};
  options.shooter = &worker;
  Scene scene = SmallCameras();
  scene.events = {{seconds(1), Carry{{{1, 0}, 0.5}}}};
  const auto host = WorldHost::Start(*robot, scene, options).value();
  network.RunFor(start);
  Pictures pictures;
  std::vector<std::unique_ptr<transport::Subscription>> watches;
  for (const std::string& camera : watched) {
    watches.push_back(transport::MakeSubscription<msg::Image>(
                          *desk, "world/camera/" + camera,
                          [&pictures, camera](const msg::Image& image, const auto&) {
                            if (camera != "front") return;
                            pictures[msg::FromStamp(image.header.stamp)] = image.data;
                          },
                          transport::kSensorDataQos)
                          .value());
  }
  network.RunFor(seconds(3) - start);
  return pictures;
}

TEST(WorldCameras, ShowTheSameBitForBitToAnySubscriber) {
  const Pictures alone = FrontPictures({"front"}, Milliseconds(0));
  EXPECT_GE(alone.size(), 35U);
  EXPECT_EQ(FrontPictures({"front"}, Milliseconds(0)), alone);
  EXPECT_EQ(FrontPictures({"front", "left", "right"}, Milliseconds(0)), alone);
  const Pictures later = FrontPictures({"front"}, seconds(2));
  EXPECT_GE(later.size(), 10U);
  for (const auto& [stamp, picture] : later) {
    ASSERT_TRUE(alone.contains(stamp));
    EXPECT_EQ(alone.at(stamp), picture);
  }
  EXPECT_NE(alone.begin()->second, std::next(alone.begin())->second) << "noise is not frozen";
}

TEST_F(WorldCamerasTest, SkipAPictureThatIsDueWhileTheLastIsDrawnAndLogItOnce) {
  HeldWorker worker;
  Open(SmallCameras(), worker);
  std::vector<msg::Image> seen;
  const auto watch = Watch("front", seen);
  network_.RunFor(seconds(2));
  EXPECT_THAT(log_, IsEmpty()) << "the first one paints the surfaces, which takes longer";
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(worker.holds());
    worker.Release();
    network_.RunFor(seconds(1));
  }
  EXPECT_THAT(seen, SizeIs(3));
  EXPECT_GT(host_->world().now(), seconds(4)) << "time does not wait";
  EXPECT_THAT(log_, SizeIs(1));
  EXPECT_THAT(log_, Contains(HasSubstr("camera front: a shot was due")));
}

TEST_F(WorldCamerasTest, HoldTheWorldTimeIfTheSceneRequiresIt) {
  HeldWorker worker;
  Scene scene = SmallCameras();
  scene.speed = 100;
  scene.cameras.late = CameraSet::Late::kWait;
  Open(scene, worker);
  std::vector<msg::Image> seen;
  const auto watch = Watch("front", seen);
  network_.RunFor(seconds(1));
  for (int i = 0; i < 20; ++i) {
    const Duration before = host_->world().now();
    network_.RunFor(seconds(1));
    ASSERT_EQ(host_->world().now(), before) << "time stands still while a shot is due and drawn";
    ASSERT_TRUE(worker.holds());
    worker.Release();
    network_.RunFor(Milliseconds(500));
  }
  ASSERT_THAT(seen, SizeIs(20));
  for (std::size_t i = 1; i < seen.size(); ++i) {
    const Duration gap =
        msg::FromStamp(seen[i].header.stamp) - msg::FromStamp(seen[i - 1].header.stamp);
    EXPECT_GE(gap, Milliseconds(60)) << "each one that is due, and";
    EXPECT_LE(gap, Milliseconds(80)) << "none missed";
  }
  EXPECT_THAT(log_, Not(Contains(HasSubstr("skipped"))));
}

TEST_F(WorldCamerasTest, FallSilentWithAFaultUntilItIsFixed) {
  PromptWorker worker;
  Open(SmallCameras(), worker);
  std::vector<msg::Image> front, left;
  const auto watches = {Watch("front", front), Watch("left", left)};
  network_.RunFor(seconds(1));
  EXPECT_FALSE(front.empty());
  InjectFault("camera front");
  front.clear();
  left.clear();
  network_.RunFor(seconds(2));
  EXPECT_THAT(front, IsEmpty());
  EXPECT_FALSE(left.empty());
  InjectFault("none");
  network_.RunFor(seconds(1));
  EXPECT_FALSE(front.empty());
}

TEST_F(WorldCamerasTest, AreMissingWithoutCamerasInTheScene) {
  PromptWorker worker;
  Scene scene = SmallCameras();
  scene.cameras.cameras[2].enabled = false;
  Open(scene, worker);
  std::vector<msg::Image> seen;
  const auto watch = Watch("right", seen);
  network_.RunFor(seconds(2));
  EXPECT_EQ(watch->MatchedWriters(), 0);
}

TEST_F(WorldCamerasTest, AreOffWithALogLineWhenAPictureIsMissingAndTimeContinues) {
  PromptWorker worker;
  Scene scene = SmallCameras();
  Board board;
  board.center_m = {5, 5};
  board.sign = {Sign::Kind::kPicture, "/nowhere/poster.png"};
  scene.boards = {board};
  Open(scene, worker);
  std::vector<msg::Image> seen;
  const auto watch = Watch("front", seen);
  network_.RunFor(seconds(3));
  EXPECT_THAT(seen, IsEmpty());
  EXPECT_THAT(log_, SizeIs(1));
  EXPECT_THAT(log_, Contains(HasSubstr("/nowhere/poster.png does not exist any more")));
  EXPECT_GT(host_->world().now(), seconds(2));
}

TEST_F(WorldCamerasTest, MayEndWhileAShotIsDrawn) {
  HeldWorker worker;
  Open(SmallCameras(), worker);
  std::vector<msg::Image> seen;
  const auto watch = Watch("front", seen);
  network_.RunFor(seconds(1));
  host_.reset();
  worker.Release();
  network_.RunFor(seconds(1));
  EXPECT_THAT(seen, IsEmpty());
}

}  // namespace musher::world::world_cameras_test
