#pragma once
// Requests a switch and stays with it until it is known what became of it, also when the controller
// that was asked ends during it: its successor tells, by epoch and number.
//
//   finding ──a controller leads──▶ asked ──its answer──▶ ended
//                                     │ it ends: on_news at once
//                                     ▼
//                                  orphaned ──another one leads──▶ querying ──its answer──▶ ended
//                                     └──none does in time──▶ ended, unknown
//
// A TearDown of the machine is requested again from the successor: what was begun is joined there.
//
//   auto client = SwitchClient::Make(node, options, "Active", "", on_news, on_end);
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/controller/leader_watch.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/service.hpp"

namespace musher {

// What became of a requested switch.
struct SwitchEnd {
  enum class Kind {
    kAnswered,  // by the controller that was asked
    kTold,      // by its successor; `result` has no actuators
    kUnknown,   // no controller tells; result.reason says why, and how to go on
  };
  Kind kind = Kind::kUnknown;
  // With an outcome of set_state, or "interrupted": its controller ended before the switch did.
  msg::SetState::Response result;

  friend bool operator==(const SwitchEnd&, const SwitchEnd&) = default;
};

class SwitchClient {
 public:
  struct Options {
    LeaderWatch::Options leader;
    Duration timeout = std::chrono::seconds(60);   // for all of it
    Duration successor = std::chrono::seconds(5);  // how long another controller is waited for
  };
  // A sentence to show at once: the controller has ended, another one is asked.
  using OnNews = std::function<void(const std::string&)>;
  // Runs exactly once, within the timeout, never inside Make(). It must not drop the client.
  using OnEnd = std::function<void(const SwitchEnd&)>;

  // `actuator` empty: the whole machine. The node must outlive the client; dropping the client ends
  // the waiting, not the switch.
  static Result<std::unique_ptr<SwitchClient>> Make(transport::Node& node, Options options,
                                                    std::string target, std::string actuator,
                                                    OnNews on_news, OnEnd on_end);

  // A controller has been found.
  bool found() const { return watch_->leader().has_value() || step_ != Step::kFinding; }
  const std::optional<msg::MachineStatus>& leader() const { return watch_->leader(); }

 private:
  enum class Step { kFinding, kAsked, kOrphaned, kQuerying, kEnded };

  SwitchClient(transport::Node& node, Options options, std::string target, std::string actuator,
               OnNews on_news, OnEnd on_end);
  Result<> Open();
  void OnStatus(const msg::MachineStatus& status);
  void OnLeaderEnd(const msg::MachineStatus& leader, const std::string& how);
  void Ask(const msg::MachineStatus& leader);
  void Orphan();
  void GoOn(const msg::MachineStatus& successor);
  void Query();
  void Send();
  void OnTold(const msg::GetSwitch::Response& told);
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
  Step step_ = Step::kFinding;
  std::uint64_t epoch_ = 0;                    // of the controller that was asked
  std::uint64_t before_ = 0;                   // number of its last switch before the request
  std::uint64_t number_ = 0;                   // of ours; 0: not known
  std::int32_t pid_ = 0;                       // of the controller that was asked
  std::string how_;                            // it ended
  std::optional<msg::MachineStatus> stopped_;  // the last status, where the machine is stopped
  bool sent_ = false;                          // the request of this step
  transport::LoopHandlePtr timeout_;
  transport::LoopHandlePtr wait_;  // the end of the present step, or the next query
  std::unique_ptr<transport::Client<msg::SetState>> set_state_;
  std::unique_ptr<transport::Client<msg::GetSwitch>> get_switch_;
  std::unique_ptr<LeaderWatch> watch_;  // last: its callbacks use all of the above
};

}  // namespace musher
