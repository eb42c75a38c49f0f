// The planner and the controller under injected faults: the robot drives in Active only and stands
// during an emergency stop, whatever path it is to follow; goals are accepted in Active only.

#include "musher/modules/navigation/server/server_actuator.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/test/modules/navigation/navigation_rig.hpp"

namespace musher::navigation::navigation_fault_test {

using musher::testing::ModuleFaultTest;
using musher::testing::RobotWithoutSelfCheck;
using transport::GoalEnd;

// A client that requests paths.
class Planning {
 public:
  explicit Planning(transport::Node& desk) : goals(desk, "jetbot_0/compute_path_to_pose") {}
  testing::Goals<msg::ComputePathToPose> goals;
};

TEST(ThePlannerServer, AcceptsGoalsInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  ModuleFaultTest<ServerActuator<PlannerServer>, Planning> test;
  test.config_text = RobotWithoutSelfCheck("planner");
  test.make = [] {
    PlannerRobot robot;
    robot.name = "jetbot_0";
    robot.odometry = "jetbot_0/odom";
    robot.action = "jetbot_0/compute_path_to_pose";
    robot.path = "jetbot_0/planned_path";
    robot.refuge = "jetbot_0/compute_refuge";
    robot.clear_memory = "jetbot_0/clear_planner_memory";
    PlannerConfig config;
    config.robots = {robot};
    return std::make_unique<ServerActuator<PlannerServer>>("planner", config);
  };
  // Without a map an accepted goal is aborted.
  const auto accepts = [&test] {
    test.Pass(Milliseconds(300));  // discovery
    auto& goals = test.peers->goals;
    const std::size_t goal = goals.Send({.goal = testing::At(3, 3)});
    test.Await([&] { return goals.ends[goal].has_value(); });
    return goals.ends[goal] && goals.ends[goal]->end == GoalEnd::kAborted;
  };
  int accepted = 0;
  test.always = [&](const auto&, const ActuatorReport& report) {
    const bool accepts_now = accepts();
    if (accepts_now) ++accepted;
    EXPECT_TRUE(!accepts_now || (report.state == kActive && report.emergency_stop == 0))
        << "a goal is accepted in " << report.state;
  };
  test.after_emergency_stop = [&](const auto&, const ActuatorReport&) {
    EXPECT_FALSE(accepts()) << "during a stop";
  };
  test.Run();
  EXPECT_GT(accepted, 50) << "or nothing has been tried";
}

// A robot in two rooms, and a client that lets it drive at all times.
class Driving {
 public:
  explicit Driving(transport::Node& desk)
      : robot(desk, walls_, {"jetbot_0", {{1, 2, 0}, 0}}),
        goals_(desk, "jetbot_0/follow_path"),
        map_(transport::MakePublisher<msg::OccupancyGrid>(desk, "map", transport::kLatchedQos)
                 .value()),
        ticker_(desk.loop().Every(Milliseconds(200), [this] { Drive(); })) {
    static_cast<void>(map_->Publish(testing::GridOf(walls_.map())));
  }

  Clearance walls_{testing::TwoRooms()};
  testing::SimulatedRobot robot;

 private:
  // To the end of the room that is farther away.
  void Drive() {
    const Pose& from = robot.pose();
    const double to_m = from.at.x_m < 2 ? 3 : 1;
    msg::Path path;
    path.header.frame_id = "map";
    for (int i = 0; i <= 10; ++i) {
      const double share = i / 10.0;
      path.poses.push_back(testing::At(from.at.x_m + share * (to_m - from.at.x_m),
                                       from.at.y_m + share * (2 - from.at.y_m)));
    }
    goals_.Send({.path = path});
  }

  testing::Goals<msg::FollowPath> goals_;
  std::unique_ptr<transport::Publisher<msg::OccupancyGrid>> map_;
  transport::LoopHandlePtr ticker_;
};

TEST(TheControllerServer, DrivesInActiveOnlyAndNeverInAnEmergencyUnderInjectedFaults) {
  ModuleFaultTest<ServerActuator<ControllerServer>, Driving> test;
  test.scenarios = 30;
  test.config_text = RobotWithoutSelfCheck("driver");
  test.make = [] {
    ControllerRobot robot;
    robot.name = "jetbot_0";
    robot.odometry = "jetbot_0/odom";
    robot.action = "jetbot_0/follow_path";
    robot.trajectory = "jetbot_0/timed_trajectory";
    robot.command = "jetbot_0/cmd_vel";
    ControllerConfig config;
    config.robots = {robot};
    return std::make_unique<ServerActuator<ControllerServer>>(
        "driver", config, [](const Dependencies& dependencies, const ControllerConfig& read) {
          return ControllerServer::Make(
              dependencies, read,
              std::make_unique<testing::LoopBackground>(dependencies.node.loop(), Milliseconds(5)));
        });
  };
  const auto drives = [&test] {
    test.Pass(Milliseconds(100));  // what is under way
    const int before = test.peers->robot.commands() - test.peers->robot.zeros();
    test.Pass(Milliseconds(600));
    return test.peers->robot.commands() - test.peers->robot.zeros() > before;
  };
  int drove = 0;
  test.always = [&](const auto&, const ActuatorReport& report) {
    const bool drives_now = drives();
    if (drives_now) ++drove;
    EXPECT_TRUE(!drives_now || (report.state == kActive && report.emergency_stop == 0))
        << "it drives in " << report.state;
  };
  test.after_emergency_stop = [&](const auto&, const ActuatorReport&) {
    EXPECT_FALSE(drives()) << "during a stop";
  };
  test.Run();
  EXPECT_GT(drove, 5) << "or nothing has been tried";
}

}  // namespace musher::navigation::navigation_fault_test
