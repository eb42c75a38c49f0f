#pragma once
// The controller's warnings and errors on ROS 2's /rosout, for rqt_console and `ros2 topic echo`: a
// line for each record of the journal with an error code.
//
// Threads: loop thread only; ToLog() is a pure function.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/messages/rcl_interfaces/log.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// nullopt for a record without an error code. The time stamp stays empty.
std::optional<msg::Log> ToLog(const MachineConfig& config, const action::Record& record);

class Rosout {
 public:
  // `wall_ns`: since 1970. All must outlive it.
  static Result<std::unique_ptr<Rosout>> Make(transport::Node& node, const MachineConfig& config,
                                              std::function<std::int64_t()> wall_ns);

  void OnRecord(const action::Record& record);

 private:
  Rosout(const MachineConfig& config, std::function<std::int64_t()> wall_ns)
      : config_(config), wall_ns_(std::move(wall_ns)) {}

  const MachineConfig& config_;
  const std::function<std::int64_t()> wall_ns_;
  std::unique_ptr<transport::Publisher<msg::Log>> publisher_;
};

}  // namespace musher
