#pragma once
// Whether a goal, or a request to an actuator, reaches the machine that the page shows and no other
// one: every actuator of its name in the namespace receives it. By the latched statuses of the
// actuators, so it needs no controller.
//
// Threads: loop thread only, callbacks too.

#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/transport/node.hpp"

namespace musher::view {

class MeantServers {
 public:
  static constexpr Duration kServersWithin = std::chrono::seconds(5);  // a server is discovered
  static constexpr Duration kOthersWithin = Milliseconds(300);         // others, after the first
  static constexpr Duration kStatusWithin = std::chrono::seconds(1);   // its status is received

  // The node must outlive it.
  MeantServers(transport::Node& node, const std::string& name_space, bool with_keys);

  using Servers = std::function<std::vector<transport::ParticipantId>()>;
  // Calls `then` once, never after this is dropped: with why nothing may be sent to these servers
  // (kCodeTimeout: there is none), or with nullopt: they are of the machine `meant`, or their
  // machine is not known. `name`: of the actuator, for the sentence. `servers` must stay valid.
  void Check(const std::string& name, Servers servers, const MachineIdentity& meant,
             std::function<void(std::optional<Error>)> then);
  // Whether a reply of `server` is that of the machine `meant`. All of `servers` have received the
  // request. Where its machine or `meant` is not known, `servers` must be of one machine.
  bool IsMeant(transport::ParticipantId server,
               const std::vector<transport::ParticipantId>& servers,
               const MachineIdentity& meant) const;
  // The first known machine of these participants that is not `meant`; nullopt: there is none.
  std::optional<MachineIdentity> OtherThan(
      const MachineIdentity& meant,
      const std::vector<transport::ParticipantId>& participants) const;

 private:
  struct WaitingCall {
    std::string name;
    Servers servers;
    MachineIdentity meant;
    std::function<void(std::optional<Error>)> then;
    Time begun;
    std::optional<Time> found_at{};
  };
  struct Known {
    MachineIdentity machine;
    transport::ParticipantId participant;
  };

  void LookAtAll();
  // Whether it has to wait longer.
  bool Waits(WaitingCall& waiting) const;
  std::optional<Error> WhyNot(const WaitingCall& waiting) const;
  const MachineIdentity* MachineOf(transport::ParticipantId participant) const;

  transport::Node& node_;
  const std::string name_space_;
  std::map<transport::EndpointId, Known> known_;  // by their writer
  std::list<WaitingCall> waiting_;
  std::unique_ptr<transport::Subscription> statuses_;  // null: not permitted, nothing is known
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::view
