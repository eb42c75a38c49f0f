#pragma once
// A client's view of the controller that leads: who it is, what it says of its machine, and that it
// has ended.
//
//   none ──its status──▶ leads ──its process ended (seen at once on the same host), its status
//    ▲                     │     is taken back, or its heartbeat stays away──▶ on_end
//    └─────────────────────┘
//
// One that was silent leads again once it is heard again.
// Another one with a higher epoch takes the place of the first: that one is over, too.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// Calls `on_end` on the loop once the process of this host has ended; null when there is none.
// Dropping the handle ends the watch.
using WatchProcess =
    std::function<transport::LoopHandlePtr(std::int32_t pid, std::function<void()> on_end)>;
// By a pidfd. The loop must outlive what it returns.
WatchProcess WatchByPidfd(transport::EventLoop& loop);

class LeaderWatch {
 public:
  struct Options {
    std::string name_space;
    std::string host;            // ours: a process of it can be watched
    WatchProcess watch_process;  // empty: no process is watched
  };
  // The leader of that status is over. `how` goes on from its name: "has ended", "is silent".
  using OnEnd = std::function<void(const msg::MachineStatus& leader, const std::string& how)>;
  using OnStatus = std::function<void(const msg::MachineStatus&)>;

  // The node must outlive it.
  static Result<std::unique_ptr<LeaderWatch>> Make(transport::Node& node, Options options,
                                                   OnStatus on_status, OnEnd on_end);

  // The last status of the controller that leads; none while none does.
  const std::optional<msg::MachineStatus>& leader() const { return leader_; }
  // The participant of that one. Services of one that died are matched until its lease is over.
  transport::PeerId participant() const { return from_.participant; }

 private:
  LeaderWatch(transport::Node& node, Options options, OnStatus on_status, OnEnd on_end);
  Result<> Open();
  void OnStatusOf(const msg::MachineStatus& status, const transport::SampleInfo& from);
  void OnHeartbeat(const msg::ControllerBeat& heartbeat);
  void ExpectBeat();
  void OnSilence();
  void End(const std::string& how);
  bool IsOurs(const msg::MachineStatus& leader) const;

  transport::Node& node_;
  const Options options_;
  const OnStatus on_status_;
  const OnEnd on_end_;
  std::optional<msg::MachineStatus> leader_;
  transport::SampleInfo from_;                // its status
  Duration heartbeat_period_{};               // as its heartbeat says
  std::uint64_t ended_ = 0;                   // epoch of the last one whose process has ended
  std::optional<msg::MachineStatus> silent_;  // of the last one that was silent
  transport::SampleInfo silent_from_;
  transport::LoopHandlePtr process_;
  transport::LoopHandlePtr silence_;
  std::unique_ptr<transport::Subscription> heartbeats_;
  std::unique_ptr<transport::Subscription> statuses_;
};

}  // namespace musher
