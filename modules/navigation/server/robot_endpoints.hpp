#pragma once
// The topics and the action that each robot of a navigation server has: odometry, a scan if the
// robot has a scanner, and the action, whose stamps are of the machine's clock.
//
// Threads: handlers run on the loop.

#include <functional>
#include <string>
#include <utility>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/modules/navigation/server/robot_table.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::navigation {

template <class Action>
struct RobotHandlers {
  std::function<void(const msg::Odometry&)> on_odometry;
  std::function<void(std::size_t scanner, const msg::LaserScan&)> on_scan;
  std::function<bool()> accept;  // a goal
  std::function<void(const transport::ServerGoal<Action>&)> start;
  std::function<void(transport::ServerGoal<Action>)> cancel;
};

// `clock` must outlive the endpoints.
template <class Action>
void OpenRobotEndpoints(transport::Endpoints& endpoints, const RobotTable& robot,
                        const std::string& action, const transport::Clock& clock,
                        RobotHandlers<Action> handlers) {
  endpoints.Subscribe<msg::Odometry>(robot.odometry, std::move(handlers.on_odometry),
                                     transport::kSensorDataQos);
  for (std::size_t i = 0; i < robot.scanners.size(); ++i) {
    endpoints.Subscribe<msg::LaserScan>(
        robot.scanners[i].topic,
        [i, on_scan = handlers.on_scan](const msg::LaserScan& scan) { on_scan(i, scan); },
        transport::kSensorDataQos);
  }
  transport::ActionHandlers<Action> of_goals;
  of_goals.accept = [accept = std::move(handlers.accept)](const typename Action::Goal&,
                                                          transport::ParticipantId) {
    return accept();
  };
  of_goals.start = std::move(handlers.start);
  of_goals.cancel = std::move(handlers.cancel);
  transport::ActionServerOptions options;
  options.stamp = [&clock] { return clock.Stamp(); };
  endpoints.ServeAction<Action>(action, std::move(of_goals), std::move(options));
}

}  // namespace musher::navigation
