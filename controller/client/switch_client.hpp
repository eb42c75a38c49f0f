#pragma once
// Requests a switch and waits until its outcome is known, also if the controller that was called
// exits during the switch: its successor reports the outcome, by epoch and number.
//
//   finding ──a controller leads──▶ called ──its reply──▶ ended
//                                     │ it exits: on_news at once
//                                     ▼
//                                  orphaned ──another one leads──▶ querying ──its reply──▶ ended
//                                     └──no successor in time──▶ ended, unknown
//
// A TearDown of the machine is requested again from the successor, which continues it.
//
//   auto client = SwitchClient::Make(node, options, "Active", "", on_news, on_end);
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/controller/client/leader_watch.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/deadline.hpp"
#include "musher/transport/service.hpp"

namespace musher {

// The outcome of a requested switch.
struct SwitchEnd {
  enum class Kind {
    kAnswered,  // by the controller that was called
    kReported,  // by its successor; `result` has no actuators
    kUnknown,   // no controller reports it; result.reason gives the reason, and what to do
  };
  Kind kind = Kind::kUnknown;
  // With an outcome of set_state, or "interrupted": its controller exited before the switch ended.
  msg::SetState::Response result;

  friend bool operator==(const SwitchEnd&, const SwitchEnd&) = default;
};

class SwitchClient {
 public:
  static constexpr Duration kServiceWithin = std::chrono::seconds(5);

  struct Options {
    LeaderWatch::Options leader;
    std::string by = {};                          // the person or program, for the history
    Duration timeout = std::chrono::seconds(60);  // in total
    // For a controller that leads. Its service may take kServiceWithin more; a switch but a
    // TearDown is not requested later, also where this computer was suspended meanwhile.
    Duration find = std::chrono::seconds(60);
    Duration successor = std::chrono::seconds(5);  // for another controller to lead
    // The last status of a controller that was called in another way and has exited before its
    // reply. The client begins as orphaned, unless this status, or a first one from the same
    // participant, reports that the machine is stopped.
    std::optional<msg::MachineStatus> exited = std::nullopt;
  };
  // A sentence to print at once: the controller has exited, the client waits for another one.
  using OnNews = std::function<void(const std::string&)>;
  // Runs exactly once, within the timeout, never inside Make(). It must not drop the client.
  using OnEnd = std::function<void(const SwitchEnd&)>;

  // `actuator` empty: the whole machine. The node must outlive the client; dropping the client only
  // ends the waiting, not the switch.
  static Result<std::unique_ptr<SwitchClient>> Make(transport::Node& node, Options options,
                                                    std::string target, std::string actuator,
                                                    OnNews on_news, OnEnd on_end);

  // A controller has been found.
  bool found() const { return watch_->leader().has_value() || step_ != Step::kFinding; }
  const std::optional<msg::MachineStatus>& leader() const { return watch_->leader(); }

 private:
  enum class Step { kFinding, kCalled, kOrphaned, kQuerying, kEnded };

  SwitchClient(transport::Node& node, Options options, std::string target, std::string actuator,
               OnNews on_news, OnEnd on_end);
  Result<> Open();
  void OnStatus(const msg::MachineStatus& status);
  void TakeStopped(const msg::MachineStatus& status);
  void OnLeaderEnd(const msg::MachineStatus& leader, const std::string& how);
  void Call(const msg::MachineStatus& leader);
  void Orphan();
  void Continue(const msg::MachineStatus& successor);
  void Query();
  void Send();
  void OnReply(const msg::GetSwitch::Response& reply);
  void EndUnknown(const std::string& why);
  void End(const SwitchEnd& end);
  std::string Lost() const;
  bool EndedWithItsMachine() const;
  SwitchEnd EndByStatus() const;

  transport::Node& node_;
  const Options options_;
  const std::string target_;
  const std::string actuator_;
  const OnNews on_news_;
  const OnEnd on_end_;
  const transport::Deadline send_by_;
  Step step_ = Step::kFinding;
  Epoch epoch_ = 0;                            // of the controller that was called
  CommandNumber before_ = 0;                   // number of its last switch before the request
  CommandNumber number_ = 0;                   // of the requested switch; 0: not known
  std::int32_t pid_ = 0;                       // of the controller that was called
  transport::ParticipantId called_ = 0;        // its participant; a repeated status has another
  std::string how_;                            // how that controller ended
  std::optional<msg::MachineStatus> stopped_;  // the last status, if the machine is stopped
  bool sent_ = false;                          // the request of this step
  transport::LoopHandlePtr timeout_;
  transport::LoopHandlePtr wait_;  // the end of the current step, or the next query
  std::unique_ptr<transport::Client<msg::SetState>> set_state_;
  std::unique_ptr<transport::Client<msg::GetSwitch>> get_switch_;
  std::unique_ptr<LeaderWatch> watch_;  // last: its callbacks use all of the above
};

}  // namespace musher
