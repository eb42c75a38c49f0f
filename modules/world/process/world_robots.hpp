#pragma once
// The robots, objects and movers of a world on the network. Of each robot R:
//
//   R/cmd_vel               geometry_msgs/Twist, subscribed: its velocity, in its own frame; with
//                           command_stamped of its scene a TwistStamped, whose stamp is not used
//   R/odom                  nav_msgs/Odometry, every step, in the frame "map"
//   R/scan                  sensor_msgs/LaserScan, best effort, at the rate of its lidar
//   R/range_down            sensor_msgs/Range, best effort, at its rate: of a robot with such a
//                           sensor, straight down
//   R/battery               sensor_msgs/BatteryState, once a second
//   R/objects_in_sight      musher_msgs/ObjectStates, 10 Hz: those that nothing hides from it
//   R/detections            musher_msgs/ObjectStates, best effort, in the frame R: what its
//                           detector finds in its view, with noise, at its rate
//   R/lines                 musher_msgs/YellowLines, 10 Hz: of a robot with a line_view
//   R/planned_path          nav_msgs/Path, subscribed, latched: drawn in the picture
//   R/manipulation_control  musher_msgs/ManipulationControl, served: of a robot with a hand
//   world/R/set_battery     std_msgs/Float32, subscribed: in %
//   world/R/place           geometry_msgs/PoseStamped, subscribed: puts it down on the ground there
//   world/R/odometry        std_msgs/String, subscribed: a fault of its odometry, "freeze" or
//                           "jump X Y" in m, until "right"
//   M/odom                  nav_msgs/Odometry, every step, of each mover M that is tracked
//   world/objects           musher_msgs/ObjectStates, 10 Hz
//   map, map_point_cloud    nav_msgs/OccupancyGrid, sensor_msgs/PointCloud2, latched
//
//   world/robots, robots_json  std_srvs/Trigger, served: what the robots do now
//   world/map                  std_srvs/SetBool, served: publishes the maps again, with the objects
//                              where they stand, or without them
//
// The maps are only in a scene with robots. Times and rates are of world time.
//
// Threads: the loop's.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/manipulation.hpp"
#include "musher/messages/nav_msgs/occupancy_grid.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/sensor_msgs/point_cloud2.hpp"
#include "musher/messages/sensor_msgs/range.hpp"
#include "musher/modules/world/process/robot_messages.hpp"
#include "musher/modules/world/simulation/world.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::world {

class WorldRobots {
 public:
  // `endpoints` is dropped before it and has the error if a topic could not be opened. `world`
  // outlives it.
  WorldRobots(transport::Endpoints& endpoints, World& world,
              std::function<void(const std::string&)> log);
  WorldRobots(const WorldRobots&) = delete;
  WorldRobots& operator=(const WorldRobots&) = delete;

  // After each step of the world.
  void OnStep();

  // Where a robot is by its odometry, with its fault.
  msg::Odometry OdometryOf(std::size_t robot);

 private:
  struct Outlet {
    transport::Publisher<msg::Odometry>* odometry = nullptr;
    transport::Publisher<msg::LaserScan>* scan = nullptr;    // null: it has no lidar
    transport::Publisher<msg::Range>* range_down = nullptr;  // null: it has no such sensor
    transport::Publisher<msg::BatteryState>* battery = nullptr;
    transport::Publisher<msg::ObjectStates>* in_sight = nullptr;
    transport::Publisher<msg::ObjectStates>* detections = nullptr;  // null: it has no detector
    transport::Publisher<msg::YellowLines>* lines = nullptr;        // null: it has no view of them
    std::string refused;  // the last refusal that was logged
    OdometryFault fault;
    std::optional<msg::Pose> frozen;
  };

  void Open(transport::Endpoints& endpoints, std::size_t robot);
  void OpenMaps(transport::Endpoints& endpoints);
  void PublishMaps(bool with_objects);
  void SetOdometry(std::size_t robot, const std::string& text);
  void Drive(std::size_t robot, const BodyVelocity& velocity);
  // Logs the line, if there is one.
  void Log(const std::optional<std::string>& line) const;

  World& world_;
  const std::function<void(const std::string&)> log_;
  std::vector<Outlet> outlets_;
  transport::Publisher<msg::OccupancyGrid>* grid_ = nullptr;
  transport::Publisher<msg::PointCloud2>* cloud_ = nullptr;
  std::vector<transport::Publisher<msg::Odometry>*> mover_odometry_;  // null: it is not tracked
  transport::Publisher<msg::ObjectStates>* objects_ = nullptr;
};

}  // namespace musher::world
