#pragma once
// Which participants of this namespace and domain belong to another machine: the processes of its
// actuators, by their statuses, and of its controller, by its heartbeat. For what names no machine,
// as CyberDog's commands do not, and reaches each robot of the namespace in reach.
//
// A participant counts from its first status or heartbeat on, also after its connection was lost:
// two robots at the edge of a wifi discover each other again and again. Nothing is known of
// programs that send neither, such as a tool or a ROS 2 node. Of the participants that are lost
// only some hundred are remembered; one that comes back is awaited again. A process of this host is
// of no other machine: two of one namespace and domain cannot run on one host, so there a different
// identity is a config or a state folder that has changed.
//
// Threads: loop thread only.

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

class OtherMachines {
 public:
  // `node`, which outlives it, has the participant of an actuator: its own status says which
  // machine this is. Not for a machine with keys, whose actuators may not read statuses.
  static Result<std::unique_ptr<OtherMachines>> Make(Node& node, std::string_view name_space);

  // The other machine that the participant belongs to; null: it belongs to none, as far as known.
  const MachineIdentity* Of(ParticipantId participant) const;
  // Whether the participant is an actuator or a controller whose first sample has not arrived yet.
  bool IsAwaited(ParticipantId participant) const;
  // Runs `then` once the participant is not awaited, perhaps at once; with false when it still is
  // after `timeout`, or when too many others wait.
  void OnceKnown(ParticipantId participant, Duration timeout, std::function<void(bool known)> then);

 private:
  struct Process {
    ParticipantId participant = 0;
    MachineIdentity machine;
    std::string host;
  };

  struct PendingRequest {
    ParticipantId participant = 0;
    std::function<void(bool known)> then;
    LoopHandlePtr timer;
  };

  explicit OtherMachines(Node& node) : loop_(node.loop()), own_participant_(node.participant()) {}
  template <class M>
  void Take(const M& sample, const SampleInfo& info, bool is_own);
  const Process* Find(ParticipantId participant) const;
  bool IsMatched(ParticipantId participant) const;
  void ForgetOneThatIsLost();
  void EndWait(std::uint64_t number, bool known);

  EventLoop& loop_;
  const ParticipantId own_participant_;
  Process own_;
  std::deque<Process> others_;                       // the last one that sent is last
  std::map<std::uint64_t, PendingRequest> waiting_;  // in their order
  std::uint64_t last_number_ = 0;                    // of waiting_
  // Last: their callbacks use the rest.
  std::unique_ptr<Subscription> statuses_;
  std::unique_ptr<Subscription> heartbeats_;
};

}  // namespace musher::transport
