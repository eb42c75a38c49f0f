#pragma once
// A robot on a simulated network: a body that executes cmd_vel, with odometry at 50 Hz and a scan
// at 10 Hz of the walls of a map and of discs. A differential one ignores velocities aside. Beside
// them the peers of the navigation chain: a map, and clients of its two actions.

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/nav2_msgs/compute_path_to_pose.hpp"
#include "musher/messages/nav2_msgs/follow_path.hpp"
#include "musher/messages/nav_msgs/occupancy_grid.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/modules/navigation/messages/conversions.hpp"
#include "musher/navigation/planner/clearance.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher::navigation::testing {

// Where the peers' samples go in the frame "map".
msg::PoseStamped At(double x_m, double y_m, double yaw_rad = 0, double z_m = 0);
msg::OccupancyGrid GridOf(const CellMap& map);

struct Disc {
  Point at;
  double radius_m = 0.2;
};

class SimulatedRobot {
 public:
  struct Options {
    std::string name = "jetbot_0";
    Pose start;
    bool differential = true;
    double lag_s = 0;  // of the velocity behind the command
  };

  // `walls` must outlive it.
  SimulatedRobot(transport::Node& node, const Clearance& walls, const Options& options);

  const Pose& pose() const { return pose_; }
  double speed_m_s() const { return Speed(velocity_); }
  int commands() const { return commands_; }
  int zeros() const { return zeros_; }  // of the commands
  const msg::Twist& last_command() const { return command_; }
  double hardest_m_s2() const { return hardest_m_s2_; }  // change of the command's speed
  void ForgetHardest() { hardest_m_s2_ = 0; }

  bool odometry_silent = false;
  bool scan_silent = false;
  Duration scan_late{};          // each scan comes so long after its stamp
  bool stuck = false;            // the wheels turn, the body does not move
  double slips = 1;              // it moves by this share of its velocity
  bool odometry_frozen = false;  // the pose stands, its stamps do not
  bool stamps_stand = false;
  std::string odometry_frame = "map";
  Point odometry_off;  // what a wrong localisation adds to the pose
  // From the body's edge to the nearest wall, so far.
  double least_room_m() const { return least_room_m_; }
  std::vector<Disc> discs;

 private:
  void OnCommand(const msg::Twist& twist);
  void Move();
  void SendOdometry();
  void SendScan();
  double RangeAt(double angle_rad) const;
  msg::Header HeaderNow() const;

  transport::Node& node_;
  const Clearance& walls_;
  const Options options_;
  Pose pose_;
  Velocity velocity_;  // in the frame of the map
  msg::Twist command_;
  int commands_ = 0;
  int zeros_ = 0;
  Time command_at_;
  double hardest_m_s2_ = 0;
  double least_room_m_ = 10;
  msg::Odometry last_odometry_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  std::unique_ptr<transport::Publisher<msg::LaserScan>> scan_;
  std::deque<std::pair<Time, msg::LaserScan>> taken_;  // and not sent yet
  std::unique_ptr<transport::Subscription> commands_in_;
  std::vector<transport::LoopHandlePtr> timers_;
};

}  // namespace musher::navigation::testing
