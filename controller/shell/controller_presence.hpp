#pragma once
// Publishes this controller's heartbeat with its epoch, receives the heartbeats of other
// controllers of the same machine, and publishes emergency stops.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <optional>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// Long enough to receive the heartbeat of a controller of another host.
Duration ListenTime(const MachineConfig& config);

class ControllerPresence {
 public:
  using Emit = std::function<void(Event)>;
  struct Identity {
    Incarnation incarnation = 0;
    std::int32_t pid = 0;
    std::string host;
    std::string host_name{};  // for people; may be empty
  };

  // `node` and `config` must outlive it.
  static Result<std::unique_ptr<ControllerPresence>> Make(transport::Node& node,
                                                          const MachineConfig& config,
                                                          Identity identity, Emit emit);

  // Publishes the heartbeat at once and periodically from now on.
  void Announce(Epoch epoch);
  // Publishes the heartbeat once more, for an actuator that may not have received it.
  void Repeat();
  // Time from which this controller may start processes. One that was silent for some time, because
  // its process was stopped, must listen first: a controller of another host may have taken over
  // and started them.
  Time MayStartProcessesAt();
  // Another controller whose heartbeat was received, if any.
  struct Rival {
    std::string process;  // "process 4711 of this host"
    Epoch epoch = 0;
    std::string machine;  // its name
  };
  const std::optional<Rival>& rival() const { return rival_; }
  // Stops publishing: another controller leads, or the machine is stopped.
  void FallSilent();

  void Publish(const EmergencyStop& stop, bool engaged);
  // No stop is engaged any more: an actuator that joins from now on receives releases only.
  void ForgetEngaged() { engaged_stops_ = nullptr; }

 private:
  ControllerPresence(transport::Node& node, const MachineConfig& config, Identity identity,
                     Emit emit);
  Result<> Open();
  void OnHeartbeat(const msg::ControllerBeat& heartbeat);
  void NoteSilence();
  std::string HostOf(const msg::ControllerBeat& heartbeat) const;

  transport::Node& node_;
  const MachineConfig& config_;
  const Identity identity_;
  const Emit emit_;
  Epoch epoch_ = 0;
  std::optional<Rival> rival_;
  Time last_heartbeat_{};
  Time listens_until_{};
  std::unique_ptr<transport::Publisher<msg::ControllerBeat>> heartbeats_;
  // Both latch their last stops for actuators that join later. engaged_stops_ exists only while a
  // stop is engaged: an actuator must not receive a stop that is over.
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> engaged_stops_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> released_stops_;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Subscription> rivals_;
  std::unique_ptr<transport::Subscription> received_stops_;
};

}  // namespace musher
