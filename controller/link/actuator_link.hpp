#pragma once
// How the controller communicates with one actuator. There is one kind of link for each `protocol`
// of the config; to the decision code all of them look the same: commands go in, events come out.
// Where a protocol does not report something (a state, a clock, the outcome of a command), the link
// makes an ActuatorReport from its data.
//
// Threads: loop thread only. `emit` may be called at any time except inside Switch() and Query().

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "musher/lifecycle/actuator/actuator_core.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// Timeout of a call to an actuator. Far longer than every deadline of the decision code, which
// applies its own timeouts: ends a forgotten call.
inline constexpr Duration kCallTimeout = std::chrono::hours(2);

class ActuatorLink {
 public:
  using Emit = std::function<void(Event)>;

  virtual ~ActuatorLink() = default;

  // Sends the command. Its reply becomes event::Replied; there may be none, the decision code has
  // its own deadline.
  virtual void Switch(const SwitchCommand& command) = 0;
  // Queries the outcome of a command, and fences it where the protocol can.
  virtual void Query(const QueryCommand& command) = 0;
  // The machine that commands belong to, and the host of its controller.
  virtual void OnMachine(const MachineIdentity& /*machine*/, const std::string& /*host*/) {}
  // The participant that the actuator's status comes from now.
  virtual void OnPeer(transport::ParticipantId /*participant*/) {}
  // The controller has started this process for the actuator.
  virtual void OnProcess(std::int32_t /*pid*/) {}
  // The controller has found this process running: an earlier controller may have controlled it.
  virtual void OnProcessFound(std::int32_t /*pid*/) {}
  // The started or found process has exited.
  virtual void OnProcessEnded(std::int32_t /*pid*/) {}
  // The participant that a program of another protocol has; 0: none, or the protocol reports its
  // process itself.
  virtual transport::ParticipantId ProgramsParticipant() const { return 0; }
  // The process of that participant runs on this host and is watched from now on.
  virtual void OnParticipantWatched(transport::ParticipantId /*participant*/) {}
  // That process has exited.
  virtual void OnParticipantEnded(transport::ParticipantId /*participant*/, std::int32_t /*pid*/) {}
};

using LinkMaker = std::function<Result<std::unique_ptr<ActuatorLink>>(
    transport::Node& node, const MachineConfig& config, ActuatorIndex actuator,
    ActuatorLink::Emit emit)>;
// Links for protocols that the controller does not have itself.
using LinkMakers = std::map<Protocol, LinkMaker>;

// The link for `config.actuators[actuator].protocol`. `node` and `config` must outlive it. Fails if
// the controller has no such link and `extensions` neither.
Result<std::unique_ptr<ActuatorLink>> MakeLink(transport::Node& node, const MachineConfig& config,
                                               ActuatorIndex actuator, ActuatorLink::Emit emit,
                                               const LinkMakers& extensions);

}  // namespace musher
