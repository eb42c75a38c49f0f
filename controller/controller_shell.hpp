#pragma once
// The IO around the controller's decision code (lifecycle/coordinator.hpp): samples, process exits
// and requests become events; actions become commands, processes, answers and journal entries.
//
// Threads: loop thread only. Runs on any transport; the simulation runs this very class.

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "musher/controller/capability_board.hpp"
#include "musher/controller/child_processes.hpp"
#include "musher/controller/controller_presence.hpp"
#include "musher/controller/health_watch.hpp"
#include "musher/controller/journal.hpp"
#include "musher/controller/link/actuator_link.hpp"
#include "musher/controller/policy_inputs.hpp"
#include "musher/controller/process_probe.hpp"
#include "musher/controller/process_runner.hpp"
#include "musher/controller/recording/recorder.hpp"
#include "musher/lifecycle/coordinator.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/unique_fd.hpp"

namespace musher {

class ControllerShell {
 public:
  // What the shell works with; all must outlive it.
  struct World {
    transport::Node* node = nullptr;
    ProcessRunner* processes = nullptr;
    ProcessProbe* process_probe = nullptr;
    JournalSink* journal = nullptr;
    // What has to survive this controller. Each hands its value to the disk and does not wait for
    // it: `done` runs on the loop, at once or later, when it is there or has failed, and once more
    // when what failed has worked later. All may be called again before that; then the last value
    // counts.
    using OnSaved = std::function<void(const Result<>&)>;
    std::function<void(std::uint64_t, OnSaved done)> save_epoch;
    std::function<void(const StoredStops&, OnSaved done)> save_emergency_stops;
    std::function<void(const StoredPolicy&, OnSaved done)> save_policy;
    std::function<void(bool, OnSaved done)> save_stop_intent;
    // The processes that the next controller has to know; may be empty.
    std::function<void(const std::vector<ChildProcess>&, OnSaved done)> save_children;
    // By which the process of an actuator is known again (child_processes.hpp); may be empty.
    std::function<std::string(const std::string& actuator)> child_mark;
    // Where a process of this name writes its stdout and stderr; may be null.
    std::function<std::shared_ptr<const transport::UniqueFd>(const std::string&)> output;
    std::function<std::int64_t()> wall_ns;  // since 1970
    std::string config_text;  // what the config was read from, for the journal; may be empty
    std::string host;         // transport::HostId()
    std::int32_t pid = 0;
    std::uint64_t incarnation = 0;  // of this controller
  };
  // What it tells; each may be empty.
  struct Hooks {
    // Opens what answers clients. Called by Begin() before anything is decided: only the controller
    // that leads answers. When it fails, this controller does not begin.
    std::function<Result<>()> open_services;
    // Closes it: at once when another controller has taken over, after the last answer when the
    // machine is stopped.
    std::function<void()> close_services;
    // Whether an answer of these has not been sent yet; may be empty.
    std::function<bool()> holds_answers;
    std::function<void(const action::Record&)> on_record;
    std::function<void(const action::SendSwitch&)> on_send;  // before it is sent
    std::function<void(const action::StartUpEnded&)> on_start_up_ended;
    std::function<void(bool reboot)> on_power;  // the power command is due
    std::function<void()> on_stopped;
    std::function<void(const std::string&)> on_fenced;  // another controller has taken over
  };

  static Result<std::unique_ptr<ControllerShell>> Make(World world, const MachineConfig& config,
                                                       Hooks hooks);
  ~ControllerShell();

  // Starts the machine; what this shell knows itself (the host) need not be in `begin`. From now on
  // clients are answered and the machine's status is latched, until another controller takes over
  // or the machine is stopped. `children`: those of the processes that a controller before has
  // started.
  void Begin(event::Begin begin, const std::vector<ChildProcess>& children = {});
  // Another controller of this machine that was heard, if any.
  const std::optional<ControllerPresence::Rival>& rival() const { return presence_->rival(); }
  // When the first actuator was heard, before Begin().
  std::optional<Time> first_heard() const { return first_heard_; }
  // How many actuators were heard before Begin().
  std::size_t HeardBeforeBegin() const { return before_begin_.size(); }
  // "legs (process 7), eyes (process 8) run" of those heard by then that run on this host and have
  // read another config than ours, and than the one whose hash is given; empty where there are
  // none.
  std::string RunningWithAnotherConfig(const std::string& hash) const;
  // Instead of beginning: every caller in this process is told why, and on_fenced is called.
  void Refuse(const Error& why);
  // As if `who` ("process 4711 of this host") had been heard to lead: this controller is over, and
  // on_fenced is called.
  void LetGo(const std::string& who);

  using OnResult = std::function<void(const SwitchResult&)>;
  using OnAnswer = std::function<void(const Result<>&)>;
  // Switches the machine, or one actuator. `done` runs exactly once, also for a refusal, maybe at
  // once.
  void SetState(const State& target, const std::optional<std::string>& actuator, OnResult done);
  // TearDown of the machine; hooks.on_stopped tells its end.
  void TearDown(AfterTearDown after);
  void AwaitSetUp(OnAnswer done);
  // Starts an actuator's process again; `done` when it is back, or why it is not.
  void Restart(const std::string& actuator, OnAnswer done);
  void ReleaseEmergencyStop(const std::string& by, OnAnswer done);
  // Asks the policy for something; `asked.request` is chosen here. `done` runs exactly once, maybe
  // at once: what leads to a switch is answered at its end, with its code and reason unless all is
  // done.
  void AskPolicy(event::PolicyRequested asked, OnAnswer done);

  // Leaves a record of something that reached the controller and no further: it was no use asking.
  void Remark(std::int32_t code, const std::string& message);

  // Whether clients are answered; once the machine is stopped, until the last answer is sent.
  bool OpenForClients() const { return status_ != nullptr; }

  const Machine& machine() const { return machine_; }
  const MachineConfig& config() const { return config_; }
  msg::MachineStatus Status() const;
  // What the journal got about this controller's last switches, oldest first.
  const std::vector<JournalEntry>& switches() const { return switches_; }
  msg::Capabilities Capabilities() const;

 private:
  // A process that has spoken as an actuator. Incarnations of different hosts, and of different
  // boots of one, say nothing about each other.
  struct Process {
    std::string host;
    std::uint64_t incarnation = 0;
    transport::PeerId participant = 0;  // 0: not known yet
    std::int32_t pid = 0;               // as it says itself
    bool proven = false;                // that this pid is its own

    bool Is(const ActuatorReport& report) const {
      return host == report.host && incarnation == report.incarnation;
    }
  };
  // What is kept for each actuator beside the machine's own record.
  struct Peer {
    std::unique_ptr<ActuatorLink> link;
    std::vector<Process> processes;     // the last one was heard last
    std::optional<Time> unproven_told;  // when it was last said that a pid is not its own
    bool hash_told = false;             // that its config differs
  };

  ControllerShell(World world, const MachineConfig& config, Hooks hooks);
  Result<> Open();
  Result<> OpenToClients();
  void CloseToClients(const Error& why);
  void CloseOnceAnswered(Time deadline);

  static bool Runs(const MachineConfig& config, const ActuatorReport& report);
  void OnStatus(const msg::ActuatorStatus& status, const transport::SampleInfo& info);
  ActuatorLink& LinkTo(std::size_t actuator);
  void OnLinkEvent(const Event& event);
  void OnSignOfLife(std::size_t actuator, std::uint64_t incarnation);
  void OnWriterLost(transport::PeerId writer);
  Process& Heard(std::size_t actuator, const ActuatorReport& report);
  ActuatorReport Believed(std::size_t actuator, ActuatorReport report);
  Result<> ProveAndWatch(std::size_t actuator, const ActuatorReport& report);
  void TellUnproven(std::size_t actuator, std::int32_t pid, const std::string& why);
  bool WatchFound(std::size_t actuator, pid_t pid, bool child);
  void NoteChild(std::size_t actuator, pid_t pid);
  void ForgetChild(std::size_t actuator, pid_t pid);
  void SaveChildren();
  void CompareHash(std::size_t actuator, const std::string& hash);
  void TellUnlisted(const msg::ActuatorStatus& status);

  bool KeepForBegin(const Event& event);
  void Handle(const Event& event);
  void HandleQueued();
  void ArmTimer();
  void PublishSoon();
  void PublishWhileUnsaved();
  void Publish();
  SwitchResult Refusal(const Error& why) const;
  void Do(const action::SendSwitch& a);
  void Do(const action::SendAsk& a);
  void Do(const action::StartProcess& a);
  void Do(const action::FindProcesses& a);
  void Do(const action::SignalProcess& a);
  void Do(const action::AnswerSetState& a);
  void Do(const action::AnswerCall& a);
  void Do(const action::TakeBacktrace& a);
  void Do(const action::TellEmergencyStop& a);
  World::OnSaved OnSaved(Stored what, std::uint64_t save);
  void Do(const action::SaveEmergencyStops& a);
  void Do(const action::Fenced& a);
  void Do(const action::SaveEpoch& a);
  void Do(const action::SavePolicy& a);
  void Do(const action::SaveStopIntent& a);
  void Do(const action::RunPowerCommand& a);
  void Do(const action::Record& a);
  void Do(const action::StartUpEnded& a);
  void Do(const action::Stopped& a);

  World world_;
  const MachineConfig& config_;
  Hooks hooks_;
  Machine machine_;
  recording::Recorder recorder_;
  std::unordered_map<std::string, std::size_t> index_;
  struct Speaker {
    std::size_t actuator = 0;
    std::uint64_t incarnation = 0;
  };
  std::unordered_map<transport::PeerId, Speaker> speakers_;  // who is behind a status writer
  std::vector<Peer> peers_;
  std::map<std::size_t, ChildProcess> children_;  // by actuator; those that run
  bool children_unsaved_ = false;                 // the disk has refused them, which was told
  StoredStops stops_before_begin_;
  std::map<std::size_t, event::StatusSeen> before_begin_;   // the last one of each actuator
  std::map<std::size_t, std::string> hashes_before_begin_;  // of their configs
  std::map<std::string, std::uint64_t> unlisted_;  // actuators of no config of ours: incarnation
  std::optional<Time> first_heard_;                // of those
  std::deque<Event> queue_;                        // events that came while one was handled
  bool handling_ = false;
  RequestId next_request_ = 1;
  std::map<RequestId, OnResult> waiting_for_result_;
  std::map<RequestId, OnAnswer> waiting_for_answer_;
  std::optional<Error> refused_;
  std::vector<JournalEntry> switches_;
  msg::MachineStatus published_;
  Time published_at_{};
  transport::LoopHandlePtr publish_later_;
  transport::LoopHandlePtr unsaved_timer_;  // while something is not on disk
  // There only while this controller leads.
  std::unique_ptr<transport::Publisher<msg::MachineStatus>> status_;
  std::unique_ptr<transport::Publisher<msg::MachineInfo>> info_;
  std::unique_ptr<CapabilityBoard> capabilities_;
  transport::LoopHandlePtr close_later_;
  std::unique_ptr<ControllerPresence> presence_;
  std::unique_ptr<HealthWatch> health_;
  std::unique_ptr<PolicyInputs> policy_inputs_;  // null without [policy]
  std::optional<Time> armed_for_;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Subscription>
      actuator_status_;  // last: its callbacks use all of the above
};

}  // namespace musher
