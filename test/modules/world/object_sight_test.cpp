// Which objects a robot sees, and which are hidden from it.

#include "musher/modules/world/sensors/object_sight.hpp"

#include <gmock/gmock.h>

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
