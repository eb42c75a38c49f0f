#pragma once
// Tells everybody that this controller lives and with which epoch, hears other controllers of the
// same machine, and passes emergency stops on.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <optional>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/coordinator.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/transport/node.hpp"

namespace musher {

class ControllerPresence {
 public:
  using Emit = std::function<void(Event)>;
  struct Identity {
    std::uint64_t incarnation = 0;
    std::int32_t pid = 0;
    std::string host;
  };

  // `node` and `config` must outlive it.
  static Result<std::unique_ptr<ControllerPresence>> Make(transport::Node& node,
                                                          const MachineConfig& config,
                                                          Identity identity, Emit emit);

  // Says so at once, and again and again from now on.
  void Announce(std::uint64_t epoch);
  // Says so once more, for somebody who may not have heard it.
  void Repeat();
  // Another controller that was heard, if any.
  struct Rival {
    std::string who;  // "process 4711 of this host"
    std::uint64_t epoch = 0;
    std::string machine;  // its name
  };
  const std::optional<Rival>& rival() const { return rival_; }
  // Not any more: somebody else leads, or the machine is stopped.
  void FallSilent();

  void Tell(const EmergencyStop& stop, bool engaged);
  // None is engaged any more: an actuator that comes from now on receives releases only.
  void ForgetEngaged() { engaged_stops_ = nullptr; }

 private:
  ControllerPresence(transport::Node& node, const MachineConfig& config, Identity identity,
                     Emit emit);
  Result<> Open();
  void OnHeartbeat(const msg::ControllerBeat& heartbeat);

  transport::Node& node_;
  const MachineConfig& config_;
  const Identity identity_;
  const Emit emit_;
  std::uint64_t epoch_ = 0;
  std::optional<Rival> rival_;
  std::unique_ptr<transport::Publisher<msg::ControllerBeat>> heartbeats_;
  // Each keeps its last ones for those that come later. That of the engaged is there while there
  // are any: an actuator must not meet one that is over.
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> engaged_stops_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> released_stops_;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Subscription> rivals_;
  std::unique_ptr<transport::Subscription> stops_heard_;
};

}  // namespace musher
