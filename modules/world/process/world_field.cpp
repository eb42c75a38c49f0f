#include "musher/modules/world/process/world_field.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/world/simulation/field_report.hpp"

namespace musher::world {
namespace {

constexpr double kReadyHz = 5;
constexpr std::size_t kStatusNumbers = 12;  // of r0x0201
constexpr std::size_t kToolNumbers = 9;     // of r0x0203 and r0x0204

msg::Float32MultiArray ToolMessage(const Tool& tool) {
  msg::Float32MultiArray message;
  message.data.assign(kToolNumbers, 0);
  message.data[0] = tool.done ? 1 : 0;
  return message;
}

}  // namespace

WorldField::WorldField(transport::Endpoints& endpoints, World& world,
                       std::function<void(const std::string&)> log)
    : world_(world), log_(std::move(log)) {
  if (!world_.field()) return;
  Listen(endpoints, "t0x0101_pid", 3, [this](const std::vector<float>& numbers) {
    return world_.DriveLift({numbers[0], numbers[1], numbers[2]});
  });
  Listen(endpoints, "t0x0102_action", kLiftWheels, [this](const std::vector<float>& numbers) {
    return world_.Lift({numbers[0], numbers[1], numbers[2], numbers[3]});
  });
  Listen(endpoints, "t0x0103_", 1,
         [this](const std::vector<float>& numbers) { return world_.CommandArm(numbers[0]); });
  Listen(endpoints, "t0x0104_", 1,
         [this](const std::vector<float>& numbers) { return world_.CommandSpear(numbers[0]); });
  suspension_ = endpoints.Advertise<Floats>("r0x0201");
  distances_ = endpoints.Advertise<Floats>("sensor_distances");
  arm_ = endpoints.Advertise<Floats>("r0x0203");
  spear_ = endpoints.Advertise<Floats>("r0x0204");
  pose_ = endpoints.Advertise<msg::PoseStamped>("transformed/pose");
  ready_ = endpoints.Advertise<msg::Bool>("r1_ready");
  endpoints.Serve<msg::Trigger>("world/field", [this](const auto&, auto reply) {
    reply({true, FieldJson(world_)});
  });
}

void WorldField::Listen(
    transport::Endpoints& endpoints, const std::string& topic, std::size_t numbers,
    std::function<std::optional<std::string>(const std::vector<float>&)> handle) {
  endpoints.Subscribe<Floats>(
      topic, [this, topic, numbers, handle = std::move(handle)](const Floats& message) {
        std::optional<std::string> refused;
        if (message.data.size() < numbers) {
          refused = "expected " + std::to_string(numbers) + " numbers, found " +
                    std::to_string(message.data.size());
        } else {
          refused = handle(message.data);
        }
        std::string& last = refused_[topic];
        if (refused && last != *refused) log_(topic + ": " + *refused);
        last = refused.value_or("");
      });
}

void WorldField::OnStep() {
  if (!world_.field()) return;
  const Field& field = *world_.field();
  const Duration now = world_.now();
  // The next ones follow soon.
  PublishReadings(field);
  if (!world_.IsSilent("pose silent")) {
    const LiftBody& robot = field.robot();
    msg::PoseStamped pose;
    pose.header = {msg::ToStamp(now), "map"};
    pose.pose.position = {robot.position_m().x(), robot.position_m().y(), robot.height_mm() / 1000};
    pose.pose.orientation = {0, 0, std::sin(robot.yaw_rad() / 2), std::cos(robot.yaw_rad() / 2)};
    static_cast<void>(pose_->Publish(pose));
  }
  const bool changed = field.partner_ready() != was_ready_;
  if ((IsDue(now, kReadyHz) || changed) && !world_.IsSilent("r1 silent")) {
    was_ready_ = field.partner_ready();
    static_cast<void>(ready_->Publish({was_ready_}));
  }
}

void WorldField::PublishReadings(const Field& field) {
  constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
  const bool lost = world_.IsSilent("distances lost");
  for (const FieldReading& reading : field.readings()) {
    Floats status;
    for (const bool on : reading.switches) status.data.push_back(on ? 1 : 0);
    for (const double height : reading.wheels_mm) {
      status.data.push_back(static_cast<float>(height));
    }
    status.data.resize(kStatusNumbers);
    if (!world_.IsSilent("suspension silent")) static_cast<void>(suspension_->Publish(status));
    Floats distances;
    for (const double distance : reading.distances_mm) {
      distances.data.push_back(lost ? kNothing : static_cast<float>(distance));
    }
    static_cast<void>(distances_->Publish(distances));
    if (!world_.IsSilent("arm silent")) static_cast<void>(arm_->Publish(ToolMessage(field.arm())));
    if (!world_.IsSilent("spear silent")) {
      static_cast<void>(spear_->Publish(ToolMessage(field.spear())));
    }
  }
}

}  // namespace musher::world
