#include "musher/controller/ros2/rosout.hpp"

#include <algorithm>
#include <chrono>

#include "musher/base/code.hpp"
#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/messages/stamp.hpp"

namespace musher {
namespace {

// The QoS of rcl: a console that starts later still receives the last 10 s.
transport::Qos RosoutQos() {
  transport::Qos qos = transport::kLatchedQos;
  qos.depth = 1000;
  qos.lifespan = std::chrono::seconds(10);
  return qos;
}

// The name of the logger, as rclcpp builds it from namespace and node: "dog1.musher".
std::string LoggerOf(const MachineConfig& config) {
  std::string name = config.name_space.empty() ? "musher" : config.name_space + "/musher";
  std::replace(name.begin(), name.end(), '/', '.');
  return name;
}

}  // namespace

std::optional<msg::Log> ToLog(const MachineConfig& config, const action::Record& record) {
  if (record.code == kCodeOk) return std::nullopt;
  msg::Log log;
  const bool critical = record.actuator && config.actuators[*record.actuator].critical;
  const bool machine_failed = record.kind == "machine" && record.code == kCodeFailed;
  log.level = critical || machine_failed ? msg::Log::kError : msg::Log::kWarn;
  log.name = LoggerOf(config);
  if (record.actuator) log.name += "." + config.actuators[*record.actuator].name;
  log.msg = WithCode(record.message, record.code);
  return log;
}

Result<std::unique_ptr<Rosout>> Rosout::Make(transport::Node& node, const MachineConfig& config,
                                             std::function<std::int64_t()> wall_ns) {
  std::unique_ptr<Rosout> rosout(new Rosout(config, std::move(wall_ns)));
  // One topic for all nodes of the domain, outside the machine's namespace.
  auto publisher = transport::MakePublisher<msg::Log>(node, "rosout", RosoutQos());
  if (!publisher) return publisher.error();
  rosout->publisher_ = std::move(publisher).value();
  return rosout;
}

void Rosout::OnRecord(const action::Record& record) {
  auto log = ToLog(config_, record);
  if (!log) return;
  log->stamp = msg::ToStamp(std::chrono::nanoseconds(wall_ns_()));
  static_cast<void>(publisher_->Publish(*log));  // the journal has it as well
}

}  // namespace musher
