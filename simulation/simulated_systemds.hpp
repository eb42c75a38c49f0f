#pragma once
// The systemds of a simulated robot's hosts, which run the actuators with a `host` as units, with
// `units = "always"` also the others, and the connections of controllers to them. Their client is
// the real one (controller/process host_units.hpp).
//
//   link cut    what is sent waits. After 6 s the controller's end gives the connection up; calls
//               that it had sent may still arrive, seconds after the link is back, unless a newer
//               connection of the same controller has ended this one there. What the host had sent
//               is lost with the connection.
//   power cut   all processes and units of the host are gone; its connections, within 6 s
//   silence     the D-Bus of the controller's own host answers nothing for some seconds, as where
//               systemd reloads; with `units = "always"`, in half of the hosts once
//   shutdown    systemd ends its units by SIGTERM, on which they exit with code 0, and starts none
//
// Threads: the one of the network.

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/controller/process/systemd.hpp"
#include "musher/simulation/hosts.hpp"
#include "musher/simulation/simulated_processes.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::simulation {

class SimulatedSystemds {
 public:
  // All must outlive it.
  SimulatedSystemds(transport::sim::Network& network, const MachineConfig& config, Hosts& hosts,
                    SimulatedProcesses& processes);
  ~SimulatedSystemds();
  SimulatedSystemds(const SimulatedSystemds&) = delete;
  SimulatedSystemds& operator=(const SimulatedSystemds&) = delete;

  // For a controller on that host, with the loop of its process. `on_start`: before it requests the
  // start of an actuator on its own host.
  ConnectSystemd From(std::size_t host, transport::EventLoop& loop,
                      std::function<void(const std::string& actuator)> on_start = nullptr);

  // A signal has reached another process than the one that it was sent to. May be empty.
  std::function<void(const std::string& actuator)> on_wrong_process;
  // Whether signals go by the name of the unit, to whatever runs as it when they arrive: a flaw.
  bool signals_by_name = false;

  // A process has ended.
  void OnEnd(std::size_t host, std::int32_t pid, const ProcessExit& exit);
  // Begins the orderly shutdown of the host, which PowerOff() ends.
  void ShutDown(std::size_t host);
  // Call before its processes end.
  void PowerOff(std::size_t host);
  void Boot(std::size_t host);
  bool IsOn(std::size_t host) const { return machines_[host].on; }
  std::size_t UnitsOn(std::size_t host) const { return machines_[host].units.size(); }
  // Whether the actuator runs there as a unit.
  bool RunsOn(std::size_t host, const std::string& actuator) const {
    return std::ranges::any_of(machines_[host].units, [&](const auto& unit) {
      return unit.second.actuator == actuator && unit.second.state.main_pid != 0;
    });
  }
  // Whether a controller on the host learns nothing from its systemd now, or within a second.
  bool IsSilent(std::size_t host) const;

 private:
  class Connection;
  struct Unit {
    std::string actuator;
    UnitState state;
    std::string job;  // that starts it; empty: it has ended
  };
  struct Machine {  // a host
    bool on = true;
    bool stopping = false;
    Time silent_from{};  // for a controller on it
    Time silent_until{};
    std::map<std::string, Unit> units;  // those that are loaded, by name
  };
  // The host's end of a connection, and what is on the way. It may outlive the controller's.
  struct Bridge {
    std::size_t from = 0;
    std::size_t to = 0;
    Connection* client = nullptr;  // null: the controller's end is gone
    bool alive = true;
    bool stalled = false;                       // by a cut link
    bool sent_again = false;                    // what was stalled, after its last client
    Duration silent_for{};                      // for the controller's end
    std::deque<std::function<void()>> calls;    // to the host, in order
    std::deque<std::function<void()>> replies;  // to the controller, with the signals
  };
  using BridgePtr = std::shared_ptr<Bridge>;

  void After(Duration delay, std::function<void()> what);
  Duration Delay();
  bool Reaches(std::size_t from, std::size_t to) const;
  bool IsReached(std::size_t from, std::size_t to) const;
  BridgePtr MakeBridge(Connection& client, std::size_t from, std::size_t to);
  void Watch(const BridgePtr& bridge);
  void Call(const BridgePtr& bridge, std::function<void()> what);
  void CarryCalls(const BridgePtr& bridge);
  void Reply(const BridgePtr& bridge, std::function<void()> what);
  void CarryReplies(const BridgePtr& bridge);
  // To all connections of the host.
  void SendChange(std::size_t host, const std::string& name, const UnitState& state);
  void SendJobRemoved(std::size_t host, const std::string& name, const std::string& job,
                      const std::string& result);

  // What the host does when a call has arrived.
  UnitState StateOf(std::size_t host, const std::string& name) const;
  void StartUnit(std::size_t host, const UnitStart& start, const std::string& job);
  void Execute(std::size_t host, const std::string& name, const std::string& invocation,
               const ProcessSpec& spec);
  // The unit that this start was of, if it still runs; with `signals_by_name` in any case.
  std::pair<const std::string, Unit>* UnitOf(std::size_t host, const std::string& invocation);
  bool Kill(std::size_t host, const std::string& invocation, int signal);
  void Stop(std::size_t host, const std::string& invocation);
  void Reset(std::size_t host, const std::string& name);
  void Unload(std::size_t host, const std::string& name);

  transport::sim::Network& network_;
  const MachineConfig& config_;
  Hosts& hosts_;
  SimulatedProcesses& processes_;
  transport::sim::Random random_;
  std::unique_ptr<transport::Node> node_;  // its loop runs what belongs to no controller
  std::vector<Machine> machines_;          // by host
  std::vector<std::weak_ptr<Bridge>> bridges_;
  std::map<std::string, std::string> names_;  // of units, by invocation
  std::uint64_t next_invocation_ = 1;
  std::uint64_t next_job_ = 1;
  std::uint64_t next_event_ = 1;
  std::map<std::uint64_t, transport::LoopHandlePtr> events_;  // last: they call the others
};

}  // namespace musher::simulation
