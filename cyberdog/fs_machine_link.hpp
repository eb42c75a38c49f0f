#pragma once
// The link to a module of CyberDog's machine library: service `<name>machine_service` and, where
// the module has them, its heartbeats on `manager_heartbeats`.
//
// What that protocol reports:
//   - The module creates the service after SetUp: once the service is matched, the module is set
//     up.
//   - The reply has the outcome of the command. Its `current_state` is 0 in every state, and
//     ignored.
//   - There is no query. While a reply is outstanding the report is busy with that command, and the
//     link sends nothing more: the state of an overdue module is unknown until it replies or is
//     restarted.
//   - A module whose heartbeats stop for 5 periods is lost, until a heartbeat or a reply arrives.
//     While a command runs within its time limit, heartbeats may stop: a callback may block the
//     module's only thread.
//
// Threads: loop thread only.

#include <memory>

#include "musher/controller/link/foreign_link.hpp"
#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/messages/protocol/heartbeats.hpp"
#include "musher/transport/service.hpp"

namespace musher {

class FsMachineLink : public ForeignLink {
 public:
  static Result<std::unique_ptr<ActuatorLink>> Make(transport::Node& node,
                                                    const MachineConfig& config,
                                                    ActuatorIndex actuator, Emit emit);

 private:
  using ForeignLink::ForeignLink;

  void OnAppeared() override;
  void OnLost() override;
  void Drive() override;
  void Inquire(const QueryCommand& query) override;

  void OnReply(const Result<msg::FsMachine::Response>& reply);
  void OnHeartbeat();
  void NoteContact();
  void Watch(Time until);
  void OnSilence();

  std::uint64_t call_ = 0;  // the one whose reply counts
  Time last_contact_{};
  bool silent_ = false;             // lost, because its heartbeats have stopped
  transport::LoopHandlePtr watch_;  // none: no heartbeat yet, or lost
  std::unique_ptr<transport::Client<msg::FsMachine>> client_;
  std::unique_ptr<transport::Subscription> heartbeats_;  // last: its callback uses all of the above
};

}  // namespace musher
