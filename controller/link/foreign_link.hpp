#pragma once
// What the links to programs without Musher's contract have in common. Such a program has no
// epochs, command numbers and queries; the link keeps, in its place, the report that an actuator of
// Musher's own would publish, and passes one command at a time to it.
//
//            its server is matched         command            ended
//   (lost) ────────────────────────▶ free ─────────▶ busy ────────────▶ free
//      ▲                               │               │  a newer command waits: one place,
//      └────── no server any more ─────┴───────────────┘  the newest keeps it
//
// Each process with the name is an incarnation of its own, identified by its DDS participant: a
// restarted process is matched before the lease of the previous one expires. If the previous one
// still runs, there are two with one name: the first one stays the actuator, and is degraded.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/controller/link/actuator_link.hpp"
#include "musher/transport/endpoint.hpp"

namespace musher {

class ForeignLink : public ActuatorLink {
 public:
  void Switch(const SwitchCommand& command) final;
  void Query(const QueryCommand& command) final;
  void OnProcess(std::int32_t pid) final;
  void OnProcessFound(std::int32_t pid) final;
  void OnProcessEnded(std::int32_t pid) final;
  transport::ParticipantId ProgramsParticipant() const final { return ours() ? 0 : server_; }
  void OnParticipantWatched(transport::ParticipantId participant) final;
  void OnParticipantEnded(transport::ParticipantId participant, std::int32_t pid) final;

 protected:
  // The command that is under way.
  struct PendingCommand {
    CommandNumber number = 0;  // 0: SetUp, which is not commanded
    State target;
    Time deadline{};
    bool queried = false;  // its deadline has passed and the coordinator has queried it
    bool stopped = false;  // is to end as soon as possible
  };

  // `node` and `config` must outlive the link.
  ForeignLink(transport::Node& node, const MachineConfig& config, ActuatorIndex actuator,
              Emit emit);

  // Implemented by each protocol. A new process is matched, its report is empty; earlier commands
  // are void.
  virtual void OnAppeared() = 0;
  // The process is lost, and with it the command under way.
  virtual void OnLost() = 0;
  // Executes pending(); to end with End().
  virtual void Drive() = 0;
  // Queries the state of the process; to end with AnswerQuery(), or without an answer.
  virtual void Inquire(const QueryCommand& query) = 0;
  // A second process with the name is matched: has the first one exited, or does it run? To end
  // with EndComparison(). By default a second one is the successor of the first.
  virtual void Compare() { EndComparison(false); }

  // Called by each protocol: the participants that offer the service now, whenever that may have
  // changed.
  void OnServers(std::vector<transport::ParticipantId> servers);
  // Whether the first process with the name still runs.
  void EndComparison(bool first_runs);
  void BeginSetUp(Duration budget);
  // The command has ended. Begins the waiting command.
  void End(Verdict verdict, std::int32_t code = kCodeOk, const std::string& message = "");
  // The command had not begun, and the coordinator does not wait for it any more.
  void DropPending();
  void AnswerQuery(CommandNumber number) { Reply(number, true, Verdict::kDone, kCodeOk, ""); }
  void ReportStatus();
  void ReportVanished(const std::string& how, bool for_good = false);

  bool available() const { return server_ != 0; }
  bool ours() const { return process_ != 0 && !found_; }  // this controller has started its process
  transport::ParticipantId server() const { return server_; }
  std::optional<PendingCommand>& pending() { return pending_; }
  const std::optional<PendingCommand>& pending() const { return pending_; }
  bool has_waiting() const { return waiting_.has_value(); }
  ActuatorReport& report() { return report_; }
  const ActuatorReport& report() const { return report_; }
  const MachineConfig& machine() const { return config_; }
  const ActuatorConfig& actuator() const { return config_.actuators[actuator_]; }
  transport::Node& node() { return node_; }
  Time Now() const { return node_.loop().Now(); }

 private:
  struct WaitingCommand {
    SwitchCommand command;
    Time since{};
  };

  void Post(std::function<void()> work);
  void Take(const SwitchCommand& command);
  void Take(const QueryCommand& command);
  void Begin(const SwitchCommand& command);
  void BeginWaiting();
  void Appear(transport::ParticipantId server);
  void Forget();
  bool TakeOther();
  void NoteDoubles();
  std::string ProcessText(transport::ParticipantId server) const;
  void Arrive(const State& target);
  void Reply(CommandNumber number, bool query, Verdict verdict, std::int32_t code,
             const std::string& message);
  void Refuse(CommandNumber number, const Error& why) {
    Reply(number, false, Verdict::kRefused, why.code, why.message);
  }
  ActuatorReport Stamped();

  transport::Node& node_;
  const MachineConfig& config_;
  const ActuatorIndex actuator_;
  const Emit emit_;
  ActuatorReport report_;
  std::int32_t process_ = 0;
  bool found_ = false;                             // it ran when this controller started
  transport::ParticipantId server_ = 0;            // the current process; 0: none
  std::vector<transport::ParticipantId> servers_;  // all that offer the service
  std::set<transport::ParticipantId> ended_;       // the servers whose process has exited
  std::set<transport::ParticipantId> watched_;     // the servers whose exit will be reported
  transport::ParticipantId newcomer_ = 0;          // compared with the current process; 0: none
  std::optional<PendingCommand> pending_;
  std::optional<WaitingCommand> waiting_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for work that is posted
};

}  // namespace musher
