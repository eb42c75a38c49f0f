#pragma once
// The processes that publish as the actuators of the machine: their status, replies, heartbeats and
// loss become events. Any participant on the network can publish as an actuator, with any pid of
// this host: which participant and which process a status is from is proven here, and a pid that is
// not proven reaches nothing that watches, traces or signals it.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "musher/controller/link/actuator_link.hpp"
#include "musher/controller/shell/health_watch.hpp"
#include "musher/controller/shell/shell_context.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/transport/node.hpp"

namespace musher {

class ActuatorPeers {
 public:
  explicit ActuatorPeers(ShellContext context);
  ~ActuatorPeers();

  // Opens a link to each actuator.
  Result<> OpenLinks();
  // Receives the actuators' status, until Unsubscribe(). `health` must outlive that.
  Result<> Subscribe(HealthWatch& health);
  void Unsubscribe();
  // Sets the name and id of this controller's machine.
  void SetMachine(const MachineIdentity& machine);
  // The link to the process whose report is current; the previous process may still be matched.
  ActuatorLink& LinkTo(ActuatorIndex actuator);
  // A heartbeat was received. A process whose status writer was lost, but whose heartbeats are
  // received, is taken again.
  void OnAlive(ActuatorIndex actuator, Incarnation incarnation);

  // This controller has started a process, has found one that runs, or the process has exited.
  void OnProcess(ActuatorIndex actuator, pid_t pid) { peers_[actuator].link->OnProcess(pid); }
  void OnProcessFound(ActuatorIndex actuator, pid_t pid) {
    peers_[actuator].link->OnProcessFound(pid);
  }
  void OnProcessEnded(ActuatorIndex actuator, pid_t pid) {
    peers_[actuator].link->OnProcessEnded(pid);
  }

  // Calls `report`, of the exit of a process whose exit code is unknown. The exit may be seen
  // before the last sample of the process: during its TearDown that is waited for, since it says
  // whether the TearDown had ended; not once the processes get SIGKILL, since the budget ends soon.
  void ReportExit(ActuatorIndex actuator, std::function<void()> report);

  // Keeps an event from before the begin of the machine: an actuator latches its status once, so a
  // status received before would not be received again. Returns whether it is kept.
  bool KeepForBegin(const Event& event);
  // Forgets the events of actuators of this host that do not run any more. `runs_here`: whether an
  // actuator runs, by its name and the pid of its status.
  using RunsHere = std::function<bool(const std::string& actuator, std::int32_t pid)>;
  void ForgetEnded(const RunsHere& runs_here);
  // The last status of each actuator from before the begin of the machine.
  const std::map<ActuatorIndex, msg::ActuatorStatus>& statuses_before_begin() const {
    return statuses_before_begin_;
  }
  // When the first status was received before the begin.
  std::optional<Time> first_status_at() const { return first_status_at_; }
  // How many actuators have sent a status before the begin and are not lost since.
  std::size_t received_before_begin() const { return before_begin_.size(); }
  // "legs (pid 7), eyes (pid 8) run": the actuators on this host whose config is neither that of
  // this controller nor the one with the given hash; empty: none.
  std::string RunningWithAnotherConfig(const std::string& hash) const;
  // Whether the actuator's status from before the begin is of a process that runs and will not
  // exit.
  bool RanBeforeBegin(ActuatorIndex actuator) const;
  // What the actuator reports that it has not done at an emergency stop; empty: nothing.
  std::string StopTrouble(ActuatorIndex actuator) const;
  // The machine of this namespace and domain, not this controller's, of which that participant has
  // published an actuator's status; null: none is known.
  const MachineIdentity* OtherMachineOf(transport::ParticipantId participant) const;
  // Whether the process whose report the machine uses follows another machine since.
  bool FollowsOther(ActuatorIndex actuator) const;
  // Whether that process of another host is another machine's, by its last status.
  bool IsOfOther(ActuatorIndex actuator, const std::string& host, std::int32_t pid) const {
    return StatusOfOther(actuator, host, pid) != nullptr;
  }
  // Reports the process that this controller has started on another host, or found there, as taken
  // if it is another machine's.
  void ReportTaken(ActuatorIndex actuator);
  // The machine has begun: the kept events are handled.
  void Begin();

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
    std::string stop_trouble;                  // as in its status

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
    int looks_left = 0;                      // at that participant
    Time next_look;
  };

  void OnStatus(const msg::ActuatorStatus& status, const transport::SampleInfo& info);
  void OnLinkEvent(const Event& event);
  void OnWriterLost(transport::EndpointId writer);
  void LoseToOther(const msg::ActuatorStatus& status, transport::EndpointId writer);
  void CountAsHeartbeat(ActuatorIndex actuator, Incarnation incarnation);

  // The sender.
  bool TakeSender(ActuatorIndex actuator, const msg::ActuatorStatus& status,
                  transport::ParticipantId participant);
  transport::ParticipantId SenderOf(ActuatorIndex actuator, const ActuatorReport& report) const;
  Process& ProcessOf(ActuatorIndex actuator, const ActuatorReport& report);

  // Its process.
  std::int32_t ChildOf(ActuatorIndex actuator) const;
  ActuatorReport WithProvenPid(ActuatorIndex actuator, ActuatorReport report);
  Result<> ProveAndWatch(ActuatorIndex actuator, const ActuatorReport& report);
  void RecordUnproven(ActuatorIndex actuator, std::int32_t pid, const std::string& why);
  void WatchProgram(ActuatorIndex actuator);

  // What is not of this machine, or of another config.
  bool SharesItsProcess(const ActuatorReport& report) const;
  bool HoldsItsNameHere(const msg::ActuatorStatus& status) const;
  void CompareHash(ActuatorIndex actuator, const std::string& hash);
  void RecordUnlisted(const msg::ActuatorStatus& status);
  void NoteOtherMachine(const msg::ActuatorStatus& status, const transport::SampleInfo& info);
  void RecordOtherMachines(const msg::ActuatorStatus& status, const MachineIdentity& theirs);
  void RecordPeerFault(const transport::PeerFault& fault);

  const ShellContext context_;
  const ShellDependencies& dependencies_;
  const MachineConfig& config_;
  const Machine& machine_;
  MachineIdentity identity_;  // of this controller's machine
  std::unordered_map<std::string, ActuatorIndex> index_;
  struct StatusWriter {
    ActuatorIndex actuator = 0;
    Incarnation incarnation = 0;
  };
  std::unordered_map<transport::EndpointId, StatusWriter> status_writers_;
  // The last status of an actuator of another machine.
  struct OtherMachine {
    transport::ParticipantId participant = 0;
    MachineIdentity machine;
    std::string actuator;
    std::string host;
    std::int32_t pid = 0;
    Incarnation incarnation = 0;
  };
  const OtherMachine* StatusOfOther(ActuatorIndex actuator, const std::string& host,
                                    std::int32_t pid) const;
  std::unordered_map<transport::EndpointId, OtherMachine> other_machines_;  // by status writer
  PerActuator<Peer> peers_;
  // The last status of each actuator and host, in the order of receipt.
  std::map<std::uint64_t, transport::LoopHandlePtr> exits_later_;  // by a number of their own
  std::uint64_t last_exit_ = 0;
  std::map<ActuatorIndex, std::vector<event::StatusSeen>> before_begin_;
  std::map<ActuatorIndex, msg::ActuatorStatus> statuses_before_begin_;
  std::optional<Time> first_status_at_;          // of before_begin_
  std::map<std::string, Incarnation> unlisted_;  // incarnations of actuators not in the config
  std::set<std::pair<ActuatorIndex, std::string>> of_others_;  // recorded, with their machine
  std::set<std::pair<transport::ParticipantId, std::string>> peer_faults_;  // recorded
  Time peer_faults_full_at_{};
  HealthWatch* health_ = nullptr;
  std::unique_ptr<transport::Subscription> statuses_;  // last: its callbacks use all of the above
};

}  // namespace musher
