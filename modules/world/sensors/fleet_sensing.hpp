#pragma once
// The measurements of a fleet's range sensors, and the maps of the place they are in, as messages.
// A function of the world alone: random numbers depend on its seed, the robot and the time.

#include "musher/messages/nav_msgs/occupancy_grid.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/sensor_msgs/point_cloud2.hpp"
#include "musher/messages/sensor_msgs/range.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// What stands around a robot: the fixed things, and what moves, without the robot and what it
// holds.
Scene SceneAround(const World& world, std::size_t robot);

// In the frame of the robot, `<robot>/scan`, whose angles are from its own direction.
msg::LaserScan MeasureRobotScan(const World& world, std::size_t robot);

// In the frame `<robot>/range_down`, whose x is down. Of a robot with such a sensor.
msg::Range MeasureRobotRange(const World& world, std::size_t robot);

// The frame of maps and of all poses of a fleet.
inline constexpr const char* kMapFrame = "map";

// The ground in cells of 5 cm, from the fence inwards. A cell is occupied if a fixed thing whose
// underside is lower than `height_m` is within half a cell of its middle, and along the fence;
// objects, movers and robots are not in it.
msg::OccupancyGrid MapOfGround(const Scene& scene, double height_m);
// The height that matters to the robots on the ground: of the tallest one.
double TallestOnGround(const Scene& scene);

// The surfaces of the fixed things, of the fence, the ground and the ceiling, as points 8 cm apart.
msg::PointCloud2 CloudOfSurfaces(const Scene& scene);

}  // namespace musher::world
