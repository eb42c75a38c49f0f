#pragma once
// The I/O around the controller's decision code (lifecycle/coordinator/coordinator.hpp): samples,
// process exits and requests become events; actions become commands, processes, replies and journal
// entries. The shell queues the events, decides on one after the other, and gives each action to
// the part that executes it:
//
//   ActuatorPeers       status, replies and loss of the actuators; which process a status is from
//   HealthWatch         their heartbeats
//   ActuatorProcesses   start, search, signals and exits of their processes
//   ControllerPresence  this controller and others; emergency stops
//   PolicyInputs        battery, motion and time
//   MachineBoard        what clients see
//   RecordWriter        the journal
//
// Beside the decision, RuleMonitor checks the user's rules after each event. What it finds is
// recorded, and the decision does not know of it.
//
// Threads: loop thread only. Runs on any transport; the simulation runs this class, too.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/controller/journal/input_recorder.hpp"
#include "musher/controller/shell/actuator_peers.hpp"
#include "musher/controller/shell/actuator_processes.hpp"
#include "musher/controller/shell/controller_presence.hpp"
#include "musher/controller/shell/health_watch.hpp"
#include "musher/controller/shell/machine_board.hpp"
#include "musher/controller/shell/policy_inputs.hpp"
#include "musher/controller/shell/record_writer.hpp"
#include "musher/controller/shell/shell_context.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/lifecycle/machine/rule_monitor.hpp"

namespace musher {

class ControllerShell {
 public:
  using Dependencies = ShellDependencies;
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
  // Sets the id of this machine; call it before Begin().
  void SetMachineId(const std::string& id);
  // An emergency stop of a process of this host, which has not sent it by the transport.
  void OnStop(const msg::EmergencyStop& stop) { presence_->OnStop(stop); }
  // What this machine is known by on the network.
  MachineIdentity machine_identity() const { return presence_->machine(); }
  // Whether that is another machine, whose controller is present in this namespace and domain.
  bool IsOtherMachine(const MachineIdentity& machine) const;
  // Another controller of this machine whose heartbeat was received, if any.
  const std::optional<ControllerPresence::Rival>& rival() const { return presence_->rival(); }
  // Why this controller was refused before it began, if it was.
  const std::optional<Error>& refused() const { return refused_; }
  // Call before Begin(): forgets what was received from actuators of this host that do not run.
  void ForgetEnded(const ActuatorPeers::RunsHere& runs_here) { peers_->ForgetEnded(runs_here); }
  // The actuators' processes, with what was received of them before Begin().
  const ActuatorPeers& peers() const { return *peers_; }
  // Call instead of Begin(): refuses every caller in this process with `why` and calls
  // on_fenced.
  void Refuse(const Error& why);
  // Releases control, as if a heartbeat of the leader `rival` ("process 4711 of this host") had
  // been received: this controller is fenced, and on_fenced is called.
  // `elsewhere`: that leader is on another host.
  void ReleaseControl(const std::string& rival, bool elsewhere = false);

  // Why a request that cannot name its machine, such as ROS 2's Trigger, is refused: its caller is
  // an actuator of another machine with this namespace and domain, whose requests arrive here, too.
  std::optional<Error> MeantForAnother(transport::ParticipantId caller) const;
  // Why a service refuses a request that has just arrived and may raise or move something: it may
  // have been sent long ago, while this controller could not run.
  std::optional<Error> MayBeLate() const;
  // The same of a switch; a switch that raises no actuator is obeyed however late.
  std::optional<Error> MayBeLate(const State& target, std::optional<ActuatorIndex> only) const;
  // A service has refused a request by MayBeLate(): recorded as other refusals are. Of a request
  // that is repeated the first one is recorded, and after one stop of this process kMostLate.
  void RecordLate(const State& target, std::optional<ActuatorIndex> only, const Error& late);
  void RecordLate(const event::PolicyRequested& requested, const Error& late);
  void RecordLateRestart(const std::string& actuator, const Error& late);
  void RecordLateRelease(const Error& late);
  static constexpr std::size_t kMostLate = 16;

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
  void Restart(const std::string& actuator, const std::string& by, OnAnswer done);
  void ReleaseEmergencyStop(const std::string& by, OnAnswer done, std::vector<StopId> seen = {});
  // Sends a request to the policy; this function chooses `requested.request`. `done` runs exactly
  // once, maybe at once. A request that leads to a switch is answered at the switch's end, with its
  // code and reason unless the outcome is done.
  void SendPolicyRequest(event::PolicyRequested requested, OnAnswer done);

  // Writing the journal has begun to fail, or works again.
  void OnJournalWritten(const Result<>& written);

  // The participants of another DDS, for the status.
  void SetOtherVendors(std::vector<std::string> others) {
    board_->SetOtherVendors(std::move(others));
  }

  // Records an event that needs no decision.
  void Remark(std::int32_t code, const std::string& message);

  // Whether clients are answered; after the machine is stopped, until the last reply is sent.
  bool OpenForClients() const { return board_->is_open(); }

  const Machine& machine() const { return machine_; }
  const MachineConfig& config() const { return config_; }
  msg::MachineStatus Status() const { return board_->Status(); }
  // Publishes a changed status at once, not with the next changes. A service does so before it
  // answers: a client that has the answer never reads an older status.
  void PublishStatus() { board_->PublishStatus(); }
  // The journal entries of this controller's last switches, oldest first.
  const std::vector<JournalEntry>& switches() const { return records_.switches(); }
  msg::Capabilities Capabilities() const { return board_->Capabilities(); }

 private:
  ControllerShell(Dependencies dependencies, const MachineConfig& config, Hooks hooks);
  Result<> Open();
  Result<> OpenToClients();
  void CloseToClients(const Error& why);
  void CloseOnceAnswered(Time deadline);
  void OnOtherMachine(const ControllerPresence::Rival* other);

  void CheckThread() const;
  bool KeepForBegin(const Event& event);
  void Handle(const Event& event);
  void HandleQueued();
  void HandleOne(const Event& event);
  void ArmTimer();
  void CheckRules();
  void ShowNotStopped();
  RequestId NewAnswer(OnAnswer done);
  void RecordLate(const std::string& kind, std::optional<ActuatorIndex> actuator, const Error& late,
                  const RecordText& text);
  Dependencies::OnSaved OnSaved(Stored what, SaveNumber save);

  void Do(const action::SendSwitch& a);
  void Do(const action::SendQuery& a);
  void Do(const action::StartProcess& a) { processes_->Do(a); }
  void Do(const action::FindProcesses& a) { processes_->Do(a); }
  void Do(const action::SignalProcess& a) { processes_->Do(a); }
  void Do(const action::TakeBacktrace& a) { processes_->Do(a); }
  void Do(const action::RunPowerCommand& a);
  void Do(const action::AnswerSetState& a);
  void Do(const action::AnswerCall& a);
  void Do(const action::PublishEmergencyStop& a);
  void Do(const action::SaveEmergencyStops& a);
  void Do(const action::SaveEpoch& a);
  void Do(const action::SavePolicy& a);
  void Do(const action::SaveStopIntent& a);
  void Do(const action::SaveRemoteActuators& a);
  void Do(const action::SaveActuators& a);
  void Do(const action::Fenced& a);
  void Do(const action::Record& a) { records_.Write(a); }
  void Do(const action::StartUpEnded& a);
  void Do(const action::Stopped& a);

  Dependencies dependencies_;
  const MachineConfig& config_;
  Hooks hooks_;
  Machine machine_;
  RecordWriter records_;
  const ShellContext context_;
  recording::InputRecorder recorder_;
  std::deque<Event> queue_;  // events that arrived while one was handled
  bool handling_ = false;
  RequestId next_request_ = 1;
  std::map<RequestId, OnResult> waiting_for_result_;
  std::map<RequestId, OnAnswer> waiting_for_answer_;
  std::optional<Error> refused_;
  std::vector<std::string> recorded_late_;  // what RecordLate() has written since …
  Time recorded_late_at_{};                 // … that time
  StoredStops stops_before_begin_;
  std::optional<AfterTearDown> tear_down_at_begin_;  // requested before Begin()
  std::optional<Result<>> journal_at_begin_;         // the last OnJournalWritten() before Begin()
  std::unique_ptr<ActuatorPeers> peers_;
  std::unique_ptr<MachineBoard> board_;
  transport::LoopHandlePtr close_later_;
  std::unique_ptr<ActuatorProcesses> processes_;
  std::unique_ptr<ControllerPresence> presence_;
  std::unique_ptr<HealthWatch> health_;
  std::unique_ptr<PolicyInputs> policy_inputs_;  // null without [policy]
  std::optional<Time> armed_for_;
  transport::LoopHandlePtr timer_;
  std::optional<RuleMonitor> rules_;  // none without rules of the user
  std::optional<Time> rules_armed_for_;
  transport::LoopHandlePtr rules_timer_;
  PerActuator<std::optional<Time>> moves_on_since_;  // although it has latched the stop
  transport::LoopHandlePtr not_stopped_timer_;
};

}  // namespace musher
