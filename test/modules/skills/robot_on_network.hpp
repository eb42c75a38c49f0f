#pragma once
// A robot behind its topics, on a simulated network in virtual time, with fakes of its body, its
// planner, its controller and its hand.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "musher/messages/musher_msgs/manipulation.hpp"
#include "musher/messages/nav2_msgs/compute_path_to_pose.hpp"
#include "musher/messages/nav2_msgs/follow_path.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::skills {

template <class T>
T Must(Result<T> result) {
  if (!result) ADD_FAILURE() << result.error().message;
  return std::move(result).value();
}

inline SkillsConfig ConfigOfR() {
  auto reading = ReadSkillsText(
      "robot = \"r\"\nkind = \"jetbot\"\nhand = true\n[topics]\nline = \"line\"\nteleop = "
      "\"r/teleop\"\n[cameras]\n"
      "front = \"r/camera/image\"\n",
      "/tmp/r.toml");
  return *reading.config;
}

// The body of the robot and the servers for it, in a process of its own.
class Peers {
 public:
  using PlanGoal = transport::ServerGoal<msg::ComputePathToPose>;
  using DriveGoal = transport::ServerGoal<msg::FollowPath>;

  explicit Peers(transport::Node& node) : node(node), endpoints(node, "dog") {
    odometry = endpoints.Advertise<msg::Odometry>("r/odom");
    scan = endpoints.Advertise<msg::LaserScan>("r/scan", transport::kSensorDataQos);
    objects = endpoints.Advertise<msg::ObjectStates>("world/objects");
    line = endpoints.Advertise<msg::YellowLines>("line", transport::kSensorDataQos);
    camera = endpoints.Advertise<msg::Image>("r/camera/image", transport::kSensorDataQos);
    target = endpoints.Advertise<msg::Odometry>("/target_0/odom");
    teleop = endpoints.Advertise<msg::Twist>("r/teleop");
    battery = endpoints.Advertise<msg::BatteryState>("r/battery");
    endpoints.Subscribe<msg::Twist>("r/cmd_vel",
                                    [this](const msg::Twist& twist) { commands.push_back(twist); });
    transport::ActionHandlers<msg::ComputePathToPose> plan;
    plan.start = [this](PlanGoal goal) {
      goal.Execute();
      plans.push_back(goal);
    };
    plan.cancel = [](PlanGoal goal) { goal.Canceled({}); };
    endpoints.ServeAction<msg::ComputePathToPose>("r/compute_path_to_pose", std::move(plan));
    transport::ActionHandlers<msg::FollowPath> drive;
    drive.start = [this](DriveGoal goal) {
      goal.Execute();
      drives.push_back(goal);
    };
    drive.may_cancel = [this](const DriveGoal&) {
      const bool refused = refuses_cancels > 0;
      if (refused) --refuses_cancels;
      return !refused;
    };
    drive.cancel = [this](DriveGoal goal) {
      ++cancels;
      goal.Canceled({});
    };
    transport::ActionServerOptions options;
    options.stamp = [this] {
      return msg::ToStamp(msg::FromStamp(endpoints.clock().Stamp()) + clock_ahead);
    };
    endpoints.ServeAction<msg::FollowPath>("r/follow_path", std::move(drive), std::move(options));
    for (const char* memory : {"r/clear_planner_memory", "r/clear_controller_memory"}) {
      endpoints.Serve<msg::Trigger>(memory, [this, memory](const auto&, auto reply) {
        cleared.emplace_back(memory);
        msg::Trigger::Response response;
        response.success = clears;
        response.message = "it is busy";
        reply(response);
      });
    }
    endpoints.Serve<msg::ManipulationControl>("r/manipulation_control",
                                              [this](const auto& request, auto reply) {
                                                hand_object = request.object;
                                                msg::ManipulationControl::Response response;
                                                response.success = true;
                                                response.message = "Object attached";
                                                response.distance_m = 0.4;
                                                reply(response);
                                              });
  }

  transport::Node& node;
  std::vector<msg::Twist> commands;
  std::vector<PlanGoal> plans;
  std::vector<DriveGoal> drives;
  int cancels = 0;
  int refuses_cancels = 0;           // so many of the next ones
  Duration clock_ahead{};            // of the controller's time of day
  std::vector<std::string> cleared;  // memories
  bool clears = true;
  std::string hand_object;
  transport::Publisher<msg::Odometry>* odometry = nullptr;
  transport::Publisher<msg::LaserScan>* scan = nullptr;
  transport::Publisher<msg::ObjectStates>* objects = nullptr;
  transport::Publisher<msg::YellowLines>* line = nullptr;
  transport::Publisher<msg::Image>* camera = nullptr;
  transport::Publisher<msg::Odometry>* target = nullptr;
  transport::Publisher<msg::Twist>* teleop = nullptr;
  transport::Publisher<msg::BatteryState>* battery = nullptr;
  transport::Endpoints endpoints;
};

class ARosRobot : public ::testing::Test {
 protected:
  ARosRobot() : ARosRobot(ConfigOfR()) {}
  explicit ARosRobot(SkillsConfig config) : robot_(std::move(config)) {
    robot_.Open(*endpoints_, "dog",
                [this](LogLevel, const std::string& line) { lines_.push_back(line); });
    EXPECT_TRUE(endpoints_->opened());
    Run(500);
  }
  void Run(std::int64_t ms) {
    for (; ms > 0; ms -= 10) {
      if (sees_m_ && ++runs_ % 10 == 0) See(*sees_m_);
      network_.RunFor(Milliseconds(10));
      robot_.BeginStep(Now());
    }
  }
  // A scan around the robot, which hits something ahead.
  void See(double ahead_m) {
    msg::LaserScan scan;
    scan.range_min = 0.05F;
    scan.range_max = 10;
    scan.angle_increment = static_cast<float>(M_PI / 180);
    scan.ranges.assign(360, std::numeric_limits<float>::infinity());
    scan.ranges[0] = static_cast<float>(ahead_m);
    EXPECT_TRUE(peers_->scan->Publish(scan));
  }
  Time Now() { return body_->loop().Now(); }
  void Stand(double x_m, double yaw_rad, const std::string& frame = "") {
    msg::Odometry odometry;
    odometry.header.frame_id = frame;
    odometry.child_frame_id = "base_link";
    odometry.pose.pose = ToMessage(navigation::Pose{{x_m, 0, 0}, yaw_rad}, {}).pose;
    odometry.twist.twist.linear.x = 0.5;
    EXPECT_TRUE(peers_->odometry->Publish(odometry));
    Run(20);
  }
  // Until it is done; virtual time.
  template <class T>
  Result<T> ResultOf(const skill::Future<T>& future) {
    for (int i = 0; i < 3000 && !future.done(); ++i) Run(10);
    if (!future.done()) return Error{kCodeTimeout, "never done"};
    return future.result();
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> body_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> world_ = network_.MakeNode("world");
  std::optional<double> sees_m_;  // ahead, ten times a second
  int runs_ = 0;
  std::vector<std::string> lines_;  // that the robot has logged
  std::unique_ptr<Peers> peers_ = std::make_unique<Peers>(*world_);
  RosRobot robot_;
  std::unique_ptr<transport::Endpoints> endpoints_ =
      std::make_unique<transport::Endpoints>(*body_, "dog");
};

}  // namespace musher::skills
