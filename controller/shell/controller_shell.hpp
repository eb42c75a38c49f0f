#pragma once
// The I/O around the controller's decision code (lifecycle/coordinator/coordinator.hpp): samples,
// process exits and requests become events; actions become commands, processes, replies and journal
// entries.
//
// Threads: loop thread only. Runs on any transport; the simulation runs this class, too.

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/controller/journal/journal.hpp"
#include "musher/controller/journal/recorder.hpp"
#include "musher/controller/link/actuator_link.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/controller/process/process_probe.hpp"
#include "musher/controller/process/process_runner.hpp"
#include "musher/controller/shell/capability_board.hpp"
#include "musher/controller/shell/controller_presence.hpp"
#include "musher/controller/shell/health_watch.hpp"
#include "musher/controller/shell/policy_inputs.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/node.hpp"

namespace musher {

class ControllerShell {
 public:
  // The dependencies of the shell; all must outlive it.
  struct Dependencies {
    transport::Node* node = nullptr;
    LinkMakers links = {};  // of the extensions
    ProcessRunner* processes = nullptr;
    ProcessProbe* process_probe = nullptr;
    JournalSink* journal = nullptr;
    // These save what must survive this controller. Each hands its value to the disk and does not
    // wait: `done` runs on the loop, at once or later, when the value is on disk or has failed, and
    // once more when a failed save succeeds later. Each may be called again before that; then the
    // last value counts.
    using OnSaved = std::function<void(const Result<>&)>;
    std::function<void(Epoch, OnSaved done)> save_epoch;
    std::function<void(const StoredStops&, OnSaved done)> save_emergency_stops;
    std::function<void(const StoredPolicy&, OnSaved done)> save_policy;
    std::function<void(bool, OnSaved done)> save_stop_intent;
    std::function<void(const std::vector<RemoteActuator>&, OnSaved done)> save_remote_actuators;
    // Saves the processes that the next controller has to find; may be empty.
    std::function<void(const std::vector<ChildProcess>&, OnSaved done)> save_children;
    // The mark by which the process of an actuator is found again (child_processes.hpp); may be
    // empty.
    std::function<std::string(const std::string& actuator)> child_mark;
    // The file for stdout and stderr of the process of this name; may be null.
    std::function<std::shared_ptr<const UniqueFd>(const std::string&)> output;
    std::function<std::int64_t()> wall_ns;  // since 1970
    std::string config_text;                // text of the config, for the journal; may be empty
    std::string host;                       // HostId()
    std::string host_name;                  // HostName(); may be empty
    std::int32_t pid = 0;
    Incarnation incarnation = 0;  // of this controller
    std::string machine_id;       // of its machine; empty: not known yet
  };
  // Callbacks; each may be empty.
  struct Hooks {
    // Opens the services for clients. Begin() calls it before the first decision: only the leading
    // controller offers services. If it fails, this controller does not begin.
    std::function<Result<>()> open_services;
    // Closes the services: at once when another controller has taken over, after the last reply
    // when the machine is stopped.
    std::function<void()> close_services;
    // Whether a reply of these services is not sent yet; may be empty.
    std::function<bool()> holds_answers;
    std::function<void(const action::Record&)> on_record;
    std::function<void(const action::SendSwitch&)> on_send;  // before it is sent
    std::function<void(const action::StartUpEnded&)> on_start_up_ended;
    std::function<void(bool reboot)> on_power;  // before the power command runs
    std::function<void()> on_stopped;
    std::function<void(const std::string&)> on_fenced;  // another controller has taken over
  };

  static Result<std::unique_ptr<ControllerShell>> Make(Dependencies dependencies,
                                                       const MachineConfig& config, Hooks hooks);
  ~ControllerShell();

  // Starts the machine; the shell fills in the host of `begin`. From now on the shell answers
  // clients and latches the machine's status, until another controller takes over or the machine is
  // stopped. `children`: the processes in `begin` that an earlier controller has started.
  void Begin(event::Begin begin, const std::vector<ChildProcess>& children = {});
  // Before Begin(): the id of this machine.
  void SetMachineId(const std::string& id);
  // An emergency stop of a process of this host, which has not sent it by the transport.
  void OnStop(const msg::EmergencyStop& stop) { presence_->OnStop(stop); }
  // What this machine is known by on the network.
  MachineIdentity machine_identity() const { return presence_->machine(); }
  // Whether that is another machine, whose controller is present in this namespace and domain.
  bool IsOtherMachine(const MachineIdentity& machine) const;
  // The last status of each actuator that was received before Begin().
  const std::map<ActuatorIndex, msg::ActuatorStatus>& statuses_before_begin() const {
    return statuses_before_begin_;
  }
  // Another controller of this machine whose heartbeat was received, if any.
  const std::optional<ControllerPresence::Rival>& rival() const { return presence_->rival(); }
  // When the first actuator status was received, before Begin().
  std::optional<Time> first_status_at() const { return first_status_at_; }
  // The number of actuators whose status was received before Begin().
  std::size_t ActuatorsBeforeBegin() const { return before_begin_.size(); }
  // "legs (pid 7), eyes (pid 8) run": the actuators received by then that run on this host and use
  // a different config than this controller and than the config with the given hash; empty if
  // there are none.
  std::string RunningWithAnotherConfig(const std::string& hash) const;
  // Call instead of Begin(): refuses every caller in this process with `why` and calls
  // on_fenced.
  void Refuse(const Error& why);
  // Releases control, as if a heartbeat of the leader `rival` ("process 4711 of this host") had
  // been received: this controller is fenced, and on_fenced is called.
  void ReleaseControl(const std::string& rival);

  using OnResult = std::function<void(const SwitchResult&)>;
  using OnAnswer = std::function<void(const Result<>&)>;
  // Switches the machine, or one actuator. `done` runs exactly once, also for a refusal, maybe at
  // once.
  void SetState(const State& target, const std::optional<std::string>& actuator, OnResult done,
                const Requester& by = {});
  // TearDown of the machine, once it has begun; calls hooks.on_stopped at its end.
  void TearDown(AfterTearDown after);
  void AwaitSetUp(OnAnswer done);
  // Restarts an actuator's process; calls `done` when it is back, or with why it is not.
  void Restart(const std::string& actuator, OnAnswer done);
  void ReleaseEmergencyStop(const std::string& by, OnAnswer done);
  // Sends a request to the policy; this function chooses `requested.request`. `done` runs exactly
  // once, maybe at once. A request that leads to a switch is answered at the switch's end, with its
  // code and reason unless the outcome is done.
  void SendPolicyRequest(event::PolicyRequested requested, OnAnswer done);

  // Writing the journal has begun to fail, or works again.
  void OnJournalWritten(const Result<>& written);

  // The participants of another DDS, for the status.
  void SetOtherVendors(std::vector<std::string> others);

  // Records an event that needs no decision.
  void Remark(std::int32_t code, const std::string& message);

  // Whether clients are answered; after the machine is stopped, until the last reply is sent.
  bool OpenForClients() const { return status_ != nullptr; }

  const Machine& machine() const { return machine_; }
  const MachineConfig& config() const { return config_; }
  msg::MachineStatus Status() const;
  // Publishes a changed status at once, not with the next changes. A service does so before it
  // answers: a client that has the answer never reads an older status.
  void PublishStatus();
  // The journal entries of this controller's last switches, oldest first.
  const std::vector<JournalEntry>& switches() const { return switches_; }
  msg::Capabilities Capabilities() const;

 private:
  // A process that has published as an actuator. Incarnations of different hosts, and of different
  // boots of one host, cannot be compared.
  struct Process {
    std::string host;
    Incarnation incarnation = 0;
    transport::ParticipantId participant = 0;  // 0: not known yet
    bool named = false;                        // its status has the participant's number
    std::int32_t pid = 0;                      // as in its status
    bool proven = false;                       // this pid is its own

    bool Is(const ActuatorReport& report) const {
      return host == report.host && incarnation == report.incarnation;
    }
  };
  // State of each actuator beside the machine's own record.
  struct Peer {
    std::unique_ptr<ActuatorLink> link;
    std::vector<Process> processes;          // in the order of their last status
    std::optional<Time> unproven_recorded;   // when an unproven pid was last recorded
    bool hash_recorded = false;              // a different config was recorded
    std::optional<Time> alive_since;         // heartbeats of its process, which counts as lost
    transport::ParticipantId looked_at = 0;  // of a program of another protocol; see WatchProgram()
  };

  ControllerShell(Dependencies dependencies, const MachineConfig& config, Hooks hooks);
  Result<> Open();
  Result<> OpenToClients();
  void CloseToClients(const Error& why);
  void CloseOnceAnswered(Time deadline);

  static bool Runs(const MachineConfig& config, const ActuatorReport& report);
  bool SharesItsProcess(const ActuatorReport& report) const;
  bool RanBeforeBegin(ActuatorIndex actuator) const;
  void OnStatus(const msg::ActuatorStatus& status, const transport::SampleInfo& info);
  ActuatorLink& LinkTo(ActuatorIndex actuator);
  void OnLinkEvent(const Event& event);
  bool TakeSender(ActuatorIndex actuator, const msg::ActuatorStatus& status,
                  transport::ParticipantId participant);
  transport::ParticipantId SenderOf(ActuatorIndex actuator, const ActuatorReport& report) const;
  void OnAlive(ActuatorIndex actuator, Incarnation incarnation);
  void CountAsHeartbeat(ActuatorIndex actuator, Incarnation incarnation);
  void OnWriterLost(transport::EndpointId writer);
  Process& ProcessOf(ActuatorIndex actuator, const ActuatorReport& report);
  ActuatorReport WithProvenPid(ActuatorIndex actuator, ActuatorReport report);
  void WatchProgram(ActuatorIndex actuator);
  Result<> ProveAndWatch(ActuatorIndex actuator, const ActuatorReport& report);
  void RecordUnproven(ActuatorIndex actuator, std::int32_t pid, const std::string& why);
  bool WatchFound(ActuatorIndex actuator, pid_t pid, const ChildProcess* child);
  void NoteChild(ActuatorIndex actuator, pid_t pid);
  void ForgetChild(ActuatorIndex actuator, pid_t pid);
  void SaveChildren();
  void CompareHash(ActuatorIndex actuator, const std::string& hash);
  void RecordUnlisted(const msg::ActuatorStatus& status);
  bool HoldsItsNameHere(const msg::ActuatorStatus& status) const;
  void RecordOtherMachines(const msg::ActuatorStatus& status, const MachineIdentity& theirs);
  void OnOtherMachine(const ControllerPresence::Rival* other);
  void RecordPeerFault(const transport::PeerFault& fault);

  bool KeepForBegin(const Event& event);
  void CheckThread() const;
  void Handle(const Event& event);
  void HandleQueued();
  void ArmTimer();
  void PublishSoon();
  void PublishWhileUnsaved();
  SwitchResult Refusal(const Error& why) const;
  void Do(const action::SendSwitch& a);
  void Do(const action::SendQuery& a);
  void Do(const action::StartProcess& a);
  void Do(const action::FindProcesses& a);
  void Do(const action::SignalProcess& a);
  void Do(const action::AnswerSetState& a);
  void Do(const action::AnswerCall& a);
  void Do(const action::TakeBacktrace& a);
  void Do(const action::PublishEmergencyStop& a);
  Dependencies::OnSaved OnSaved(Stored what, SaveNumber save);
  void Do(const action::SaveEmergencyStops& a);
  void Do(const action::Fenced& a);
  void Do(const action::SaveEpoch& a);
  void Do(const action::SavePolicy& a);
  void Do(const action::SaveStopIntent& a);
  void Do(const action::SaveRemoteActuators& a);
  void Do(const action::RunPowerCommand& a);
  void Do(const action::Record& a);
  // A record of the shell itself, not of a decision: without an id and a cause.
  void RecordHere(const std::string& kind, std::optional<ActuatorIndex> actuator, std::int32_t code,
                  const RecordText& text);
  void Do(const action::StartUpEnded& a);
  void Do(const action::Stopped& a);

  Dependencies dependencies_;
  const MachineConfig& config_;
  Hooks hooks_;
  Machine machine_;
  recording::Recorder recorder_;
  std::unordered_map<std::string, ActuatorIndex> index_;
  struct StatusWriter {
    ActuatorIndex actuator = 0;
    Incarnation incarnation = 0;
  };
  std::unordered_map<transport::EndpointId, StatusWriter> status_writers_;
  PerActuator<Peer> peers_;
  std::map<ActuatorIndex, ChildProcess> children_;  // by actuator; the running ones
  bool children_unsaved_ = false;                   // the last save failed, which was reported
  bool power_command_runs_ = false;                 // the command of power-off or reboot
  StoredStops stops_before_begin_;
  // The last one of each actuator and host, in the order of their receipt.
  std::map<ActuatorIndex, std::vector<event::StatusSeen>> before_begin_;
  std::map<ActuatorIndex, msg::ActuatorStatus> statuses_before_begin_;
  std::map<std::string, Incarnation> unlisted_;  // incarnations of actuators not in the config
  std::set<std::pair<ActuatorIndex, std::string>> of_others_;  // recorded, with their machine
  std::optional<Time> first_status_at_;                        // of before_begin_
  std::set<std::pair<transport::ParticipantId, std::string>> peer_faults_;  // recorded
  std::deque<Event> queue_;  // events that arrived while one was handled
  bool handling_ = false;
  RequestId next_request_ = 1;
  std::map<RequestId, OnResult> waiting_for_result_;
  std::map<RequestId, OnAnswer> waiting_for_answer_;
  std::optional<Error> refused_;
  std::vector<JournalEntry> switches_;
  std::optional<AfterTearDown> tear_down_at_begin_;  // requested before Begin()
  std::optional<Result<>> journal_at_begin_;         // the last OnJournalWritten() before Begin()
  msg::MachineStatus published_;
  Time published_at_{};
  std::vector<std::string> other_vendors_;  // participants of another DDS
  transport::LoopHandlePtr publish_later_;
  transport::LoopHandlePtr unsaved_timer_;  // while something is not on disk
  // Null unless this controller leads.
  std::unique_ptr<transport::Publisher<msg::MachineStatus>> status_;
  std::unique_ptr<transport::Publisher<msg::MachineInfo>> info_;
  std::unique_ptr<CapabilityBoard> capabilities_;
  transport::LoopHandlePtr close_later_;
  std::map<ActuatorIndex, transport::LoopHandlePtr> starts_later_;  // by actuator
  std::unique_ptr<ControllerPresence> presence_;
  std::unique_ptr<HealthWatch> health_;
  std::unique_ptr<PolicyInputs> policy_inputs_;  // null without [policy]
  std::optional<Time> armed_for_;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Subscription>
      actuator_status_;  // last: its callbacks use all of the above
};

}  // namespace musher
