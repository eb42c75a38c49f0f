#pragma once
// The link to a module of CyberDog's machine library: service `<name>machine_service` and, where
// the module has them, its beats on `manager_heartbeats`.
//
// What that protocol can and cannot tell:
//   - The service is created after SetUp, so a module that is seen is set up.
//   - Its answer says how the command ended. `current_state` beside it is 0 whatever the state is,
//     and not looked at.
//   - It cannot be asked. While an answer is owed the report is busy with that command, and nothing
//     more is sent: a module that is overdue is unknown until it answers or starts again.
//   - A module that beats and then does not for 5 periods is lost, until it beats or answers again.
//     While a command runs within its time it need not beat: callbacks may block its only thread.
//
// Threads: loop thread only.

#include <memory>

#include "musher/controller/link/foreign_link.hpp"
#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/messages/protocol/heartbeats.hpp"
#include "musher/transport/service.hpp"

namespace musher {

class CyberdogLink : public ForeignLink {
 public:
  static Result<std::unique_ptr<ActuatorLink>> Make(transport::Node& node,
                                                    const MachineConfig& config,
                                                    std::size_t actuator, Emit emit);

 private:
  using ForeignLink::ForeignLink;

  void OnAppeared() override;
  void OnGone() override;
  void Drive() override;
  void Inquire(const QueryCommand& query) override;

  void OnReply(const Result<msg::FsMachine::Response>& reply);
  void OnHeartbeat();
  void SignOfLife();
  void Watch(Time until);
  void OnSilence();

  std::uint64_t call_ = 0;  // the one whose answer counts
  Time last_sign_{};
  bool silent_ = false;             // lost, because its beats have ceased
  transport::LoopHandlePtr watch_;  // none: it has not beaten yet, or is lost
  std::unique_ptr<transport::Client<msg::FsMachine>> client_;
  std::unique_ptr<transport::Subscription> heartbeats_;  // last: its callback uses all of the above
};

}  // namespace musher
