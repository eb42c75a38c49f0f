// The scene config/scenes/rooms.toml: its ways, and the picture of a run in it. With
// MUSHER_UPDATE_GOLDEN=1 in the environment that picture is also written to docs/images.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "musher/modules/world/picture/picture.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/modules/world/sensors/fleet_sensing.hpp"
#include "musher/test/modules/world/rooms.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::world::rooms_test {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

Scene Rooms() {
  return ReadSceneFile(SourceDir() + "/config/scenes/rooms.toml").scene.value();
}

// The cells that the middle of a body can reach from a point.
class Reached {
 public:
  Reached(const msg::OccupancyGrid& map, double radius_m, const Vector2d& from)
      : map_(map), reached_(map.data.size(), false) {
    const int cells = static_cast<int>(std::ceil(radius_m / map.info.resolution));
    std::deque<Vector2d> open = {from};
    while (!open.empty()) {
      const Vector2d at = open.front();
      open.pop_front();
      if (!Fits(at, cells) || reached_[Index(at)]) continue;
      reached_[Index(at)] = true;
      const double step = map.info.resolution;
      for (const auto& [x, y] : {std::pair(step, 0.0), std::pair(-step, 0.0), std::pair(0.0, step),
                                 std::pair(0.0, -step)}) {
        open.emplace_back(at.x() + x, at.y() + y);
      }
    }
  }
  bool Has(const Vector2d& at) const { return reached_[Index(at)]; }

 private:
  std::size_t Index(const Vector2d& at) const {
    const auto column = static_cast<std::size_t>(at.x() / map_.info.resolution);
    return static_cast<std::size_t>(at.y() / map_.info.resolution) * map_.info.width + column;
  }
  bool Fits(const Vector2d& at, int cells) const {
    const int x = static_cast<int>(at.x() / map_.info.resolution);
    const int y = static_cast<int>(at.y() / map_.info.resolution);
    for (int i = -cells; i <= cells; ++i) {
      for (int j = -cells; j <= cells; ++j) {
        const bool inside = x + i >= 0 && y + j >= 0 && x + i < int(map_.info.width) &&
                            y + j < int(map_.info.height);
        if (!inside) return false;
        const auto index =
            static_cast<std::size_t>(y + j) * map_.info.width + static_cast<std::size_t>(x + i);
        if (map_.data[index] != 0 && std::hypot(i, j) <= cells) return false;
      }
    }
    return true;
  }

  const msg::OccupancyGrid& map_;
  std::vector<bool> reached_;
};

TEST(Rooms, AreJoinedByDoorsForARobotOnTheGroundAndTheVaultIsClosed) {
  const Scene scene = Rooms();
  const msg::OccupancyGrid map = MapOfGround(scene, TallestOnGround(scene));
  const Reached reached(map, 0.3, scene.robots[0].start_m.head<2>());
  EXPECT_TRUE(reached.Has(scene.robots[1].start_m.head<2>()));
  EXPECT_TRUE(reached.Has({10.4, 1.0})) << "store, beside box_red";
  EXPECT_TRUE(reached.Has({7.0, 7.2})) << "lab, before the table";
  EXPECT_FALSE(reached.Has({11.0, 8.0})) << "vault";
}

// Drives straight to each point, at the robot's own height.
void DriveAlong(World& world, std::size_t robot, const std::vector<Vector2d>& points) {
  for (const Vector2d& point : points) {
    for (int step = 0; step < 1500; ++step) {
      const RobotBody& body = world.fleet().robots()[robot].body;
      const Vector2d way = point - body.position_m().head<2>();
      if (way.norm() < 0.05) break;
      const double turn = std::remainder(std::atan2(way.y(), way.x()) - body.yaw_rad(), 2 * M_PI);
      const Vector2d ahead =
          Rotation2Dd(-body.yaw_rad()) * Vector2d(way * std::min(1.5, 0.8 / way.norm()));
      world.Drive(robot, {{ahead.x(), ahead.y(), 0}, 2 * turn});
      world.Step();
    }
  }
}

// A robot fetches a box and puts it on the table, a humanoid moves the cup on it, a flyer crosses
// the lab, another one collides.
World RunInRooms() {
  World world(Rooms());
  DriveAlong(world, 0, {{4.0, 2.0}, {5.6, 2.0}, {9.0, 1.3}, {10.2, 1.0}});
  EXPECT_EQ(world.UseHand(0, {HandAction::kAttach, "box_red", 2, {}}).message, "Object attached");
  DriveAlong(world, 0, {{9.4, 1.6}, {8.4, 2.6}, {8.0, 4.0}, {8.0, 5.0}, {7.9, 7.2}});
  const HandReply placed = world.UseHand(0, {HandAction::kPlace, "box_red", 0, {7.8, 7.9, 0.4}});
  EXPECT_EQ(placed.message, "Object placed");
  DriveAlong(world, 3, {{9.9, 5.6}, {7.2, 6.4}, {7.2, 7.0}});
  EXPECT_EQ(world.UseHand(3, {HandAction::kAttach, "cup", 2, {}}).message, "Object attached");
  EXPECT_EQ(world.UseHand(3, {HandAction::kPlace, "", 0, {7.3, 8.0, 0.4}}).message,
            "Object placed");
  DriveAlong(world, 3, {{7.2, 6.2}, {9.8, 5.6}});
  DriveFor(world, 2, {{0, 0, 0.5}, 0}, Seconds(2.2));
  DriveAlong(world, 2, {{1.4, 5.6}, {4.3, 6.8}, {5.8, 6.8}, {8.6, 7.0}});
  world.SetPlanned(1, {{3.8, 7.8}, {3.9, 6.9}, {4.4, 6.8}, {5.5, 6.8}, {6.2, 5.8}});
  DriveAlong(world, 1, {{3.9, 6.9}, {4.4, 6.8}, {5.0, 6.8}});
  DriveAlong(world, 1, {{4.2, 5.9}});
  DriveFor(world, 1, {{0.6, 0, 0}, 0}, Seconds(2));
  return world;
}

TEST(Rooms, CanBeDrivenAndFlownThroughAndObjectsCanBeFetched) {
  const World world = RunInRooms();
  const Fleet& fleet = world.fleet();
  EXPECT_EQ(fleet.robots()[0].collisions, 0);
  EXPECT_EQ(fleet.robots()[1].collisions, 1) << "with the car";
  EXPECT_EQ(fleet.robots()[2].collisions, 0);
  EXPECT_TRUE(fleet.robots()[2].body.airborne());
  EXPECT_TRUE(fleet.objects()[0].middle_m.isApprox(Vector3d(7.8, 7.9, 0.49), 1e-6));
  EXPECT_TRUE(fleet.objects()[2].middle_m.isApprox(Vector3d(7.3, 8.0, 0.45), 1e-6));
}

// How many pixels of the left part of a picture, the map, have about that colour.
int Painted(const cv::Mat& picture, const Color& color) {
  int count = 0;
  for (int y = 0; y < 640; ++y) {
    for (int x = 120; x < 857; ++x) {
      const auto& pixel = picture.at<cv::Vec3b>(y, x);
      const int off = std::abs(pixel[0] - color.blue) + std::abs(pixel[1] - color.green) +
                      std::abs(pixel[2] - color.red);
      count += off < 12 ? 1 : 0;
    }
  }
  return count;
}

TEST(Rooms, ShowEachRobotsWayInItsColour) {
  const TempFolder folder;
  const World before(Rooms());
  const World after = RunInRooms();
  ASSERT_TRUE(Draw(before, folder / "before.png"));
  ASSERT_TRUE(Draw(after, folder / "after.png"));
  const cv::Mat still = cv::imread(folder / "before.png");
  const cv::Mat driven = cv::imread(folder / "after.png");
  for (const RobotSpec& robot : after.scene().robots) {
    const Color way = Mix(robot.color, {255, 255, 255}, 0.25);
    EXPECT_GT(Painted(driven, way), Painted(still, way) + 100) << robot.name;
  }
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) {
    ASSERT_TRUE(Draw(after, SourceDir() + "/docs/images/rooms.png"));
  }
}

}  // namespace musher::world::rooms_test
