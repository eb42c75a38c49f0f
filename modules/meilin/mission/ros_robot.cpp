#include "musher/modules/meilin/mission/ros_robot.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "musher/messages/action_of_motion_interfaces/move_to_pose.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/r2_interfaces/arm_action.hpp"
#include "musher/messages/r2_interfaces/spear_action.hpp"
#include "musher/messages/r2_interfaces/suspension_control.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/modules/meilin/field/grid.hpp"
#include "musher/modules/meilin/mission/goal_channel.hpp"
#include "musher/modules/meilin/nodes/goal_watch.hpp"

namespace musher::meilin {
namespace {

constexpr double kDegPerRad = 180 / kPi;

void Count(Signal& signal, bool value, Time now) {
  signal.at = now;
  if (value) ++signal.trues;
  if (value && signal.value != true) ++signal.rises;
  signal.value = value;
}

std::optional<PoseFix> FixOf(const msg::PoseStamped& message, Time now) {
  if (!message.header.frame_id.empty() && message.header.frame_id != "map") return std::nullopt;
  const auto& [position, turn] = message.pose;
  const double yaw_rad = std::atan2(2 * (turn.w * turn.z + turn.x * turn.y),
                                    1 - 2 * (turn.y * turn.y + turn.z * turn.z));
  if (!std::isfinite(position.x + position.y + turn.w + turn.x + turn.y + turn.z)) {
    return std::nullopt;
  }
  // A localisation on a plane has no height: it says 0.
  const double z_m = position.z == 0 ? std::numeric_limits<double>::quiet_NaN() : position.z;
  return PoseFix{position.x, position.y, yaw_rad, now, z_m};
}

constexpr std::size_t kHeightsAt = 4;  // in a message of the chassis

// Nothing: it is too short, or a height is not a number.
std::optional<Wheels> WheelsOf(const msg::Float32MultiArray& chassis,
                               const std::array<std::size_t, Wheels::kCount>& order, Time now) {
  Wheels wheels{{}, now};
  if (chassis.data.size() < kHeightsAt + Wheels::kCount) return std::nullopt;
  for (std::size_t i = 0; i < Wheels::kCount; ++i) {
    wheels.mm.at(i) = chassis.data[kHeightsAt + order.at(i)];
    if (!std::isfinite(wheels.mm.at(i))) return std::nullopt;
  }
  return wheels;
}

std::string TextOf(const msg::MoveToPose::Feedback& feedback) {
  return fmt::format("{}, {:.2f} m to go", feedback.phase, feedback.distance_error);
}
template <class Feedback>
std::string TextOf(const Feedback& feedback) {
  return fmt::format("state {}", feedback.current_state);
}

}  // namespace

struct RosRobot::Wire {
  transport::Endpoints& endpoints;
  std::map<std::string, std::shared_ptr<GoalChannel<msg::MoveToPose>>> moves;
  std::map<std::string, std::shared_ptr<GoalChannel<msg::SuspensionControl>>> suspensions;
  std::map<std::string, std::shared_ptr<GoalChannel<msg::ArmAction>>> arms;
  std::map<std::string, std::shared_ptr<GoalChannel<msg::SpearAction>>> spears;

  template <msg::Action A>
  GoalChannel<A>& Channel(std::map<std::string, std::shared_ptr<GoalChannel<A>>>& channels,
                          const std::string& server) {
    std::shared_ptr<GoalChannel<A>>& channel = channels[server];
    if (channel == nullptr) {
      channel = std::make_shared<GoalChannel<A>>(
          endpoints.OpenActionClient<A>(server), endpoints.node().loop(), kServerTime,
          [](const typename A::Feedback& feedback) { return TextOf(feedback); });
    }
    return *channel;
  }

  std::vector<std::pair<std::string, AnyChannel*>> All() const {
    std::vector<std::pair<std::string, AnyChannel*>> all;
    const auto add = [&all](const auto& channels) {
      for (const auto& entry : channels) all.emplace_back(entry.first, entry.second.get());
    };
    add(moves);
    add(suspensions);
    add(arms);
    add(spears);
    return all;
  }
};

void RosRobot::Open(transport::Endpoints& endpoints, std::function<void(const std::string&)> warn) {
  warn_ = std::move(warn);
  pose_.reset();
  wheels_.reset();
  suspension_state_ = 0;
  partner_ready_ = arm_idle_ = {};
  const auto wire = std::make_shared<Wire>(Wire{endpoints, {}, {}, {}, {}});
  endpoints.Keep(wire);
  wire_ = wire;
  wire->Channel(wire->moves, kMoveServer);
  wire->Channel(wire->suspensions, kSuspensionServer);
  wire->Channel(wire->arms, kArmServer);
  wire->Channel(wire->spears, kSpearServer);
  Subscribe(endpoints);
}

void RosRobot::Subscribe(transport::Endpoints& endpoints) {
  transport::Clock& clock = endpoints.clock();
  endpoints.Subscribe<msg::Float32MultiArray>(
      topics_.chassis, [this, &clock](const msg::Float32MultiArray& chassis) {
        if (const auto wheels = WheelsOf(chassis, topics_.wheel_order, clock.Now())) {
          wheels_ = wheels;
        }
      });
  endpoints.Subscribe<msg::Int32>(
      "current_state", [this](const msg::Int32& state) { suspension_state_ = state.data; },
      transport::kLatchedQos);
  endpoints.Subscribe<msg::PoseStamped>(topics_.pose, [this, &clock](const msg::PoseStamped& pose) {
    const Duration stamp = msg::FromStamp(pose.header.stamp);
    const Duration last = std::exchange(pose_stamp_, stamp);
    if (stamp == last && stamp != Duration{}) return;  // published again: not where it is now
    if (const auto fix = FixOf(pose, clock.Now())) pose_ = fix;
  });
  endpoints.Subscribe<msg::Bool>("r1_ready", [this, &clock](const msg::Bool& ready) {
    Count(partner_ready_, ready.data, clock.Now());
  });
  endpoints.Subscribe<msg::Bool>("arm_runtime_state", [this, &clock](const msg::Bool& idle) {
    Count(arm_idle_, idle.data, clock.Now());
  });
}

void RosRobot::Update() {
  const auto wire = wire_.lock();
  if (!wire) return;
  for (const auto& [server, channel] : wire->All()) channel->Update();
}

void RosRobot::CancelAll() {
  const auto wire = wire_.lock();
  if (!wire) return;
  for (const auto& [server, channel] : wire->All()) channel->CancelAll();
}

std::size_t RosRobot::open_goals() const {
  const auto wire = wire_.lock();
  std::size_t count = 0;
  if (!wire) return count;
  for (const auto& [server, channel] : wire->All()) count += channel->open_goals();
  return count;
}

std::string RosRobot::Missing() const {
  const auto wire = wire_.lock();
  if (!wire) return "the robot's topics are not open";
  std::string missing;
  for (const auto& [server, channel] : wire->All()) {
    if (!channel->Ready()) missing += (missing.empty() ? "no server of " : ", ") + server;
  }
  return missing;
}

namespace {

// Of a robot without topics.
GoalPtr Unavailable() {
  auto record = std::make_shared<GoalRecord>();
  record->state = GoalState::kUnavailable;
  return std::make_unique<GoalHandle>(std::move(record), std::weak_ptr<AnyChannel>());
}

}  // namespace

GoalPtr RosRobot::MoveToPose(const std::string& server, const MoveGoal& goal) {
  const auto wire = wire_.lock();
  if (!wire) return Unavailable();
  return wire->Channel(wire->moves, server).Begin({goal.x_m, goal.y_m, goal.yaw_rad * kDegPerRad});
}

GoalPtr RosRobot::ControlSuspension(const std::string& server, const SuspensionGoal& goal) {
  const auto wire = wire_.lock();
  if (!wire) return Unavailable();
  return wire->Channel(wire->suspensions, server)
      .Begin({goal.mode, goal.direction, static_cast<float>(goal.height_mm),
              static_cast<float>(goal.timeout_s)});
}

GoalPtr RosRobot::MoveArm(const std::string& server, const ArmGoal& goal) {
  const auto wire = wire_.lock();
  if (!wire) return Unavailable();
  return wire->Channel(wire->arms, server)
      .Begin({goal.command, goal.wait_result, static_cast<float>(goal.timeout_s)});
}

GoalPtr RosRobot::MoveSpear(const std::string& server, const SpearGoal& goal) {
  const auto wire = wire_.lock();
  if (!wire) return Unavailable();
  return wire->Channel(wire->spears, server)
      .Begin({goal.command, static_cast<float>(goal.timeout_s)});
}

void RosRobot::Warn(const std::string& text) {
  if (warn_) warn_(text);
}

}  // namespace musher::meilin
