#pragma once
// Ends actuators that no controller leads: each gets TearDown, as a controller would send it, and a
// process of this host that does not end by itself gets SIGTERM and SIGKILL.
//
//   asked ──torn down, 1 s──▶ SIGTERM ──2 s──▶ SIGKILL
//     └──not torn down within its time──▲
//
// All at the same time: their order is in the config, which is not read.
//
// Threads: loop thread only.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/cli/running.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/transport/service.hpp"
#include "musher/transport/unique_fd.hpp"

namespace musher::cli {

class Ending {
 public:
  // What became of one.
  struct Outcome {
    std::string name;
    std::int32_t pid = 0;
    bool torn_down = false;
    bool ended = false;
    std::string signal;   // the last one that its process got: "SIGTERM", "SIGKILL"
    std::string trouble;  // why it was not torn down, as far as it says
  };

  // `patience`: for the TearDowns. The node and `running` must outlive it.
  static Result<std::unique_ptr<Ending>> Begin(transport::Node& node, const std::string& name_space,
                                               const Running& running, Duration patience);

  bool Ended() const;
  // Nothing more is tried.
  bool OutOfTime() const;
  std::vector<Outcome> Outcomes() const;

 private:
  struct Target {
    Outcome outcome;
    bool here = false;  // a process of this host that is ours to signal
    bool asked = false;
    std::unique_ptr<transport::Client<msg::ActuatorCommand>> commands;
    transport::UniqueFd process;
    std::optional<Time> torn_down_at;
    std::optional<Time> terminated_at;
    bool killed = false;
  };

  using Actuators = std::map<std::string, Running::Actuator>;

  Ending(transport::Node& node, std::string name_space, const Running& running, Duration patience);
  Result<> Open();
  void Advance();
  void Look(Target& target, const Actuators& running);
  void Ask(Target& target, const Actuators& running);
  void Signal(Target& target);

  transport::Node& node_;
  const std::string name_space_;
  const Running& running_;
  const Time deadline_;
  std::uint64_t epoch_ = 1;
  msg::ControllerBeat heartbeat_;
  std::unique_ptr<transport::Publisher<msg::ControllerBeat>> heartbeats_;
  std::map<std::string, Target> targets_;
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::cli
