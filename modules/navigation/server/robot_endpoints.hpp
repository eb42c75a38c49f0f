#pragma once
// The topics and the action that each robot of a navigation server has: odometry, a scan if the
// robot has a scanner, a service that clears what is remembered of scans, and the action, whose
// stamps are of the machine's clock.
//
// Threads: handlers run on the loop.

#include <functional>
#include <string>
#include <utility>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/messages/tf2_msgs/tf_message.hpp"
#include "musher/modules/navigation/server/robot_table.hpp"
#include "musher/navigation/frames/frame_tree.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::navigation {

// As tf2 has it.
inline constexpr transport::Qos kTfQos{transport::Qos::Reliability::kReliable,
                                       transport::Qos::Durability::kVolatile, 100};

template <class Action>
struct RobotHandlers {
  std::function<void(const msg::Odometry&)> on_odometry;
  std::function<void(std::size_t scanner, const msg::LaserScan&)> on_scan;
  std::function<void()> clear_memory;
  std::function<bool()> accept;  // a goal
  std::function<void(const transport::ServerGoal<Action>&)> start;
  std::function<void(transport::ServerGoal<Action>)> cancel;
};

// Both must outlive the endpoints.
inline void SubscribeFrames(transport::Endpoints& endpoints, const TfSource& tf,
                            const transport::Clock& clock, FrameTree& frames) {
  if (tf.topic.empty()) return;
  const auto take = [&clock, &frames](bool fixed) {
    return [&clock, &frames, fixed](const msg::TfMessage& message) {
      frames.Take(message, fixed, clock.Now());
    };
  };
  endpoints.Subscribe<msg::TfMessage>(tf.topic, take(false), kTfQos);
  endpoints.Subscribe<msg::TfMessage>(tf.topic + "_static", take(true),
                                      transport::kLatchedFromManyQos);
}

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
  endpoints.Serve<msg::Trigger>(
      robot.clear_memory, [clear = std::move(handlers.clear_memory)](const auto&, auto reply) {
        clear();
        msg::Trigger::Response response;
        response.success = true;
        reply(response);
      });
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
