#pragma once
// The status of the machine on ROS 2's /diagnostics, for rqt_robot_monitor, diagnostic_aggregator
// and similar tools: the machine, each actuator, the battery if the policy has one, and the samples
// lost by DDS. Published once a second and shortly after each change while the topic has a
// subscriber; without one it costs nothing.
//
// Threads: loop thread only; ToDiagnostics() is a pure function.

#include <cstdint>
#include <functional>
#include <memory>

#include "musher/controller/shell/controller_shell.hpp"
#include "musher/messages/diagnostic_msgs/diagnostic_array.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// `lost_samples` so far, and whether some were lost recently.
struct DdsLosses {
  std::uint64_t lost_samples = 0;
  bool recently = false;
};

// The time stamp stays empty.
msg::DiagnosticArray ToDiagnostics(const msg::MachineStatus& status, const DdsLosses& losses);

class Diagnostics {
 public:
  // `wall_ns`: since 1970. All must outlive it.
  static Result<std::unique_ptr<Diagnostics>> Make(transport::Node& node, ControllerShell& shell,
                                                   std::function<std::int64_t()> wall_ns);

  // The machine has changed.
  void OnRecord() { PublishSoon(); }

 private:
  Diagnostics(transport::Node& node, ControllerShell& shell, std::function<std::int64_t()> wall_ns)
      : node_(node), shell_(shell), wall_ns_(std::move(wall_ns)) {}

  bool HasSubscriber() const { return publisher_ && publisher_->MatchedReaders() > 0; }
  void OnSubscribers();
  void PublishSoon();
  void Publish();

  transport::Node& node_;
  ControllerShell& shell_;
  const std::function<std::int64_t()> wall_ns_;
  Time published_at_{};
  std::uint64_t lost_ = 0;       // in the last published array
  std::optional<Time> lost_at_;  // when `lost_` last increased
  transport::LoopHandlePtr every_second_;
  transport::LoopHandlePtr soon_;
  std::unique_ptr<transport::Publisher<msg::DiagnosticArray>> publisher_;
};

}  // namespace musher
