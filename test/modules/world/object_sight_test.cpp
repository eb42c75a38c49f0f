// Which objects a robot sees, and which are hidden from it.

#include "musher/modules/world/sensors/object_sight.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "musher/modules/world/process/robot_messages.hpp"
#include "musher/test/modules/world/rooms.hpp"

namespace musher::world::object_sight_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::size_t kGround = 0;

Box WallAt(double x_m, double from_y_m, double to_y_m, double height_m) {
  Box wall;
  wall.center_m = {x_m, (from_y_m + to_y_m) / 2};
  wall.half_m = {0.05, (to_y_m - from_y_m) / 2};
  wall.height_m = height_m;
  return wall;
}

// The robot is at (0, 0), a box on the ground three metres ahead.
Scene YardWithABox() {
  Scene scene = RobotYard();
  scene.objects = {BoxOf("box_red", {3, 0, 0.075})};
  return scene;
}

TEST(ObjectSight, SeesWhatStandsInTheOpenAlsoBehindTheRobot) {
  Scene scene = YardWithABox();
  scene.objects.push_back(BoxOf("box_blue", {-2, 1, 0.075}));
  EXPECT_THAT(ObjectsInSight(World(scene), kGround), ElementsAre(0, 1));
}

TEST(ObjectSight, DoesNotLookThroughAWall) {
  Scene scene = YardWithABox();
  scene.boxes.push_back(WallAt(1.5, -2, 2, 2.4));
  EXPECT_THAT(ObjectsInSight(World(scene), kGround), IsEmpty());
}

TEST(ObjectSight, SeesWhatAWallHidesOnlyInPart) {
  Scene scene = YardWithABox();
  scene.boxes.push_back(WallAt(2.9, -2, 0.02, 2.4));
  EXPECT_THAT(ObjectsInSight(World(scene), kGround), SizeIs(1));
}

TEST(ObjectSight, IsHiddenByAnotherObjectAndByARobot) {
  Scene scene = YardWithABox();
  scene.objects.push_back(BoxOf("box_big", {1, 0, 0.5}));
  scene.objects[1].size_m = {0.4, 1, 1};
  EXPECT_THAT(ObjectsInSight(World(scene), kGround), ElementsAre(1));
  scene = YardWithABox();
  scene.robots[1].start_m = {1.5, 0, 0};
  scene.robots[1].radius_m = 0.4;
  scene.robots[1].height_m = 1;
  EXPECT_THAT(ObjectsInSight(World(scene), kGround), IsEmpty());
}

Scene YardWithADetector() {
  Scene scene = YardWithABox();
  scene.robots[kGround].detector = DetectorSpec{.most_m = 4, .noise_m = 0};
  return scene;
}

TEST(Detector, FindsAnObjectInTheFrameOfTheRobot) {
  Scene scene = YardWithADetector();
  scene.robots[kGround].start_yaw_rad = 0.3;
  const auto found = DetectObjects(World(scene), kGround);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_NEAR(found[0].middle_m.x(), 3 * std::cos(0.3), 1e-9);
  EXPECT_NEAR(found[0].middle_m.y(), -3 * std::sin(0.3), 1e-9);
  EXPECT_NEAR(found[0].middle_m.z(), 0.075, 1e-9);
}

TEST(Detector, FindsNothingBesideItsViewTooFarAwayOrBehindAWall) {
  Scene aside = YardWithADetector();
  aside.robots[kGround].start_yaw_rad = 0.7;
  EXPECT_THAT(DetectObjects(World(aside), kGround), IsEmpty());
  Scene far = YardWithADetector();
  far.objects[0].middle_m.x() = 4.5;
  EXPECT_THAT(DetectObjects(World(far), kGround), IsEmpty());
  Scene hidden = YardWithADetector();
  hidden.boxes.push_back(WallAt(1.5, -2, 2, 2.4));
  EXPECT_THAT(DetectObjects(World(hidden), kGround), IsEmpty());
}

TEST(Detector, IsOffByItsNoiseAndMissesItsShare) {
  Scene scene = YardWithADetector();
  scene.robots[kGround].detector->noise_m = 0.02;
  scene.robots[kGround].detector->miss_share = 0.25;
  World world(scene);
  constexpr int kPictures = 2000;
  int found = 0;
  double squares = 0;
  for (int i = 0; i < kPictures; ++i) {
    world.Step();
    for (const DetectedObject& seen : DetectObjects(world, kGround)) {
      ++found;
      squares += std::pow(seen.middle_m.x() - 3, 2);
    }
  }
  EXPECT_NEAR(double(found) / kPictures, 0.75, 0.04);
  EXPECT_NEAR(std::sqrt(squares / found), 0.02, 0.002);
}

TEST(ObjectSight, IsPublishedWithNamesAndPoses) {
  Scene scene = YardWithABox();
  scene.objects.insert(scene.objects.begin(), BoxOf("box_blue", {3, 2, 0.075}));
  scene.boxes.push_back(WallAt(1.5, 0.5, 3, 2.4));
  const msg::ObjectStates states = ObjectsInSightOf(World(scene), kGround);
  ASSERT_THAT(states.objects, SizeIs(1));
  EXPECT_EQ(states.objects[0].name, "box_red");
  EXPECT_EQ(states.objects[0].pose.position.x, 3);
}

}  // namespace musher::world::object_sight_test
