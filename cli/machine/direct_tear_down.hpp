#pragma once
// Stops actuators that run without a controller: each gets TearDown, as a controller would command
// it; a process of this host that does not exit by itself gets SIGTERM, then SIGKILL.
//
//   commanded ──torn down, 1 s──▶ SIGTERM ──2 s──▶ SIGKILL
//       └──not torn down in time────▲
//
// One whose process is found here and whose status has not arrived yet is awaited: it is commanded
// once its status arrives.
//
// Where several hosts run one actuator, one of its processes is stopped, that of this host if there
// is one; the others are named at the end.
//
// All stop at the same time: their order is in the config, which this class does not read.
//
// Threads: loop thread only.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/transport/service.hpp"

namespace musher::cli {

class DirectTearDown {
 public:
  // The result for one actuator.
  struct Outcome {
    std::string name;
    std::int32_t pid = 0;
    bool has_tear_down = false;  // not so a program that is no actuator of Musher
    bool torn_down = false;
    bool ended = false;
    std::string signal;   // the last signal sent to its process: "SIGTERM", "SIGKILL"
    std::string trouble;  // why it was not torn down, if it says so
  };

  // A process that runs and is not stopped: a second one of an actuator, on another host, or one
  // whose first status has arrived since the begin.
  struct Other {
    std::string name;
    std::int32_t pid = 0;
    std::string host;  // its name, if that is known, else its HostId()
  };

  // `timeout`: for the TearDowns. The node and `running` must outlive it.
  static Result<std::unique_ptr<DirectTearDown>> Begin(transport::Node& node,
                                                       const std::string& name_space,
                                                       const RunningActuators& running,
                                                       Duration timeout);

  bool Ended() const;
  // The time for all attempts is over.
  bool OutOfTime() const;
  std::vector<Outcome> Outcomes() const;
  // By what is known now.
  std::vector<Other> Others() const;

 private:
  struct Target {
    Outcome outcome;
    bool here = false;       // a process of this host, proven to hold the actuator's name
    bool elsewhere = false;  // of another host
    bool known = false;      // its status was received
    std::string host;        // by that status, as the incarnation
    std::uint64_t incarnation = 0;
    bool commanded = false;
    // Of the last status in a reply: that of the topic may be as old as its last change, and a
    // command counts as that old.
    std::int64_t stamp_ns = 0;
    Time stamped_at{};
    CommandNumber last_number = 0;
    std::unique_ptr<transport::Client<msg::ActuatorCommand>> commands;
    UniqueFd process;
    std::optional<Time> torn_down_at;
    std::optional<Time> terminated_at;
    bool killed = false;
  };

  using Actuators = std::map<std::string, RunningActuators::Actuator>;

  DirectTearDown(transport::Node& node, std::string name_space, const RunningActuators& running,
                 Duration timeout);
  Result<> Open();
  // Its status has arrived.
  void Know(Target& target, const msg::ActuatorStatus& status);
  void Advance();
  bool MayBeSignalled(const Target& target, Time now) const;
  void Check(Target& target, const Actuators& running);
  void CommandTearDown(Target& target, const Actuators& running);
  void Learn(Target& target, const msg::ActuatorStatus& status);
  void Signal(Target& target);
  static bool IsOf(const msg::ActuatorStatus& status, const Target& target);

  transport::Node& node_;
  const std::string name_space_;
  const RunningActuators& running_;
  const Time deadline_;
  Epoch epoch_ = 1;
  MachineIdentity machine_;  // of the actuators
  msg::ControllerHeartbeat heartbeat_;
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> heartbeats_;
  std::map<std::string, Target> targets_;
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::cli
