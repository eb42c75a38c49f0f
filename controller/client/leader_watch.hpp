#pragma once
// A client's view of the leading controller: its latest status, and when it is lost.
//
//   none ──its status──▶ leads ──its process exits (noticed at once on the same host), its status
//    ▲                     │     writer is lost, or its heartbeat is lost──▶ on_end
//    └─────────────────────┘
//
// A controller whose heartbeat was lost leads again once its heartbeat is received again. A
// controller of the same machine with a higher epoch replaces the leader, which is then over, too.
// Without a leader any controller of the machine is taken, whatever its epoch: a machine whose
// state folder was lost begins with a low one. Epochs of different machines are never compared.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// Calls `on_end` on the loop once the process of this host has exited; null if there is none.
// Dropping the handle ends the watch.
using WatchProcess =
    std::function<transport::LoopHandlePtr(std::int32_t pid, std::function<void()> on_end)>;
// Watches by a pidfd. The loop must outlive the returned function and handles.
WatchProcess WatchByPidfd(transport::EventLoop& loop);

class LeaderWatch {
 public:
  struct Options {
    std::string name_space;
    std::string host;              // this host, whose processes can be watched
    WatchProcess watch_process;    // empty: watches no process
    MachineIdentity machine = {};  // empty: the first machine whose controller is found …
    bool one_machine = false;      // … and no other one after that
    // Prefers the machine of this host, even after a machine of another host was found. Once it is
    // found, no machine of another host is followed.
    bool prefer_here = false;
    // After the loss of a leader, only a machine of the same name is taken. A machine that was
    // started again with another state folder has another id.
    bool one_name = false;
    // The word by which a person chooses the machine: its name, or the beginning of its id; empty:
    // any machine.
    std::string word = {};
  };
  // The leader with this status has ended. `how` follows its name: "has exited", "sends no
  // heartbeat".
  using OnEnd = std::function<void(const msg::MachineStatus& leader, const std::string& how)>;
  using OnStatus = std::function<void(const msg::MachineStatus&)>;

  // The node must outlive it.
  static Result<std::unique_ptr<LeaderWatch>> Make(transport::Node& node, Options options,
                                                   OnStatus on_status, OnEnd on_end);

  // The last status of the leading controller; none while no controller leads.
  const std::optional<msg::MachineStatus>& leader() const { return leader_; }
  // The leader's participant. Services of a crashed controller stay matched until its lease
  // expires.
  transport::ParticipantId participant() const { return from_.participant; }
  // The machine of the leader, else of the last leader. Before the first leader: the machine of the
  // options, else their word as a name; empty: they have neither.
  const MachineIdentity& machine() const { return machine_; }
  // Whether machine() is the preferred machine, which runs on this host; also after its controller
  // has stopped leading.
  bool found_here() const { return found_here_; }
  // The machines that the options permit and that have published a status, at most
  // kMostCandidates; no two are the same.
  const std::vector<MachineIdentity>& candidates() const { return candidates_; }
  static constexpr std::size_t kMostCandidates = 64;

 private:
  LeaderWatch(transport::Node& node, Options options, OnStatus on_status, OnEnd on_end);
  Result<> Open();
  bool Follows(const msg::MachineStatus& status, const transport::SampleInfo& from) const;
  void OnStatusOf(const msg::MachineStatus& status, const transport::SampleInfo& from);
  void OnHeartbeat(const msg::ControllerHeartbeat& heartbeat);
  void ExpectHeartbeat();
  void OnHeartbeatLost();
  void End(const std::string& how);
  bool IsOurs(const msg::MachineStatus& leader) const;
  bool IsHere(const msg::MachineStatus& status) const;
  bool IsPermitted(const MachineIdentity& machine) const;
  void NoteCandidate(const MachineIdentity& machine);
  bool ReplacesElsewhere(const msg::MachineStatus& status) const;

  transport::Node& node_;
  const Options options_;
  const OnStatus on_status_;
  const OnEnd on_end_;
  std::optional<msg::MachineStatus> leader_;
  transport::SampleInfo from_;   // of its status
  Duration heartbeat_period_{};  // as in its heartbeat
  MachineIdentity machine_;
  bool found_ = false;       // … is that of a leader
  bool found_here_ = false;  // … on this host, which is preferred
  std::vector<MachineIdentity> candidates_;
  transport::EndpointId ended_ = 0;           // writer of the last leader whose process has exited
  std::optional<msg::MachineStatus> silent_;  // of the last leader whose heartbeat was lost
  transport::SampleInfo silent_from_;
  transport::LoopHandlePtr process_;
  transport::LoopHandlePtr silence_;
  std::unique_ptr<transport::Subscription> heartbeats_;
  std::unique_ptr<transport::Subscription> statuses_;
};

}  // namespace musher
