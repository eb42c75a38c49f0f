#pragma once
// The planner's, the controller's and the route server on a simulated network, each on a node of
// its own, in virtual time. A plan takes 20 ms, a step of the controller 5 ms.

#include <memory>
#include <string>

#include "musher/modules/navigation/controller_server/controller_server.hpp"
#include "musher/modules/navigation/planner_server/planner_server.hpp"
#include "musher/modules/navigation/route_server/route_server.hpp"
#include "musher/test/modules/navigation/loop_background.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::navigation::testing {

// Robots whose topics and actions begin with their name.
inline PlannerRobot PlannerTable(const std::string& name) {
  PlannerRobot robot;
  robot.name = name;
  robot.odometry = name + "/odom";
  robot.scanners = {{.topic = name + "/scan"}};
  robot.action = name + "/compute_path_to_pose";
  robot.path = name + "/planned_path";
  robot.refuge = name + "/compute_refuge";
  return robot;
}
inline ControllerRobot ControllerTable(const std::string& name) {
  ControllerRobot robot;
  robot.name = name;
  robot.odometry = name + "/odom";
  robot.scanners = {{.topic = name + "/scan"}};
  robot.action = name + "/follow_path";
  robot.trajectory = name + "/timed_trajectory";
  robot.command = name + "/cmd_vel";
  return robot;
}

inline RouteRobot RouteTable(const std::string& name) {
  return {name, name + "/odom", name + "/compute_route", name + "/compute_and_track_route"};
}

class ServersOnNetwork {
 public:
  explicit ServersOnNetwork(transport::sim::Network& network)
      : network_(network),
        planner_node_(network.MakeNode("robot")),
        controller_node_(network.MakeNode("robot")) {}

  // They accept goals from now on.
  void Start(const PlannerConfig& planner, const ControllerConfig& controller) {
    const auto log = [](LogLevel, const std::string&) {};
    planner_ = PlannerServer::Make({*planner_node_, *planner_clock_, "", log}, planner, [this] {
                 return std::make_unique<LoopBackground>(planner_node_->loop(), Milliseconds(20));
               }).value();
    controller_ = ControllerServer::Make(
                      {*controller_node_, *controller_clock_, "", log}, controller,
                      std::make_unique<LoopBackground>(controller_node_->loop(), Milliseconds(5)))
                      .value();
    planner_->Permit(true, "");
    controller_->Permit(true, "");
  }
  void StartRoutes(const RouteConfig& routes) {
    route_node_ = network_.MakeNode("robot");
    route_clock_ = transport::Clock::Steady(route_node_->loop());
    const auto log = [](LogLevel, const std::string&) {};
    routes_ =
        RouteServer::Make({*route_node_, *route_clock_, "", log}, routes,
                          std::make_unique<LoopBackground>(route_node_->loop(), Milliseconds(20)))
            .value();
    routes_->Permit(true, "");
  }

 private:
  transport::sim::Network& network_;
  const std::unique_ptr<transport::Node> planner_node_;
  const std::unique_ptr<transport::Node> controller_node_;
  const std::unique_ptr<transport::Clock> planner_clock_ =
      transport::Clock::Steady(planner_node_->loop());
  const std::unique_ptr<transport::Clock> controller_clock_ =
      transport::Clock::Steady(controller_node_->loop());
  std::unique_ptr<PlannerServer> planner_;
  std::unique_ptr<ControllerServer> controller_;
  std::unique_ptr<transport::Node> route_node_;
  std::unique_ptr<transport::Clock> route_clock_;
  std::unique_ptr<RouteServer> routes_;
};

}  // namespace musher::navigation::testing
