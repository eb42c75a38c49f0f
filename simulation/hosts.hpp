#pragma once
// The hosts of a simulated robot. Processes of one host share its id, its pids and its clock, which
// counts from its last boot. On the network each process has an endpoint of its own
// (transport::sim calls it a host), so that a single process can be cut off, or a whole host.
//
// Threads: the one of the network.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/per_actuator.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

// The name of a host in a sampled layout.
std::string_view HostName(std::size_t host);

// Which host each process of a robot runs on, and which actuators share a process.
struct Layout {
  std::vector<std::string> hosts = {"sim"};
  // For each actuator of the config, an index into `hosts`; empty: all on the first.
  PerActuator<std::size_t> host_of;
  // For each actuator, the one in whose process it runs: itself or an earlier one; empty: each has
  // a process of its own.
  PerActuator<ActuatorIndex> process_of;
  // The hosts of the first controller and of the one that takes over.
  std::array<std::size_t, 2> controllers{};
  // The machine's id, which its state folders keep; empty: none.
  std::string machine_id{};
  // Begins the names of its endpoints: those of two machines in one network differ.
  std::string prefix{};

  std::size_t HostOf(ActuatorIndex actuator) const {
    return host_of.empty() ? 0 : host_of[actuator];
  }
  ActuatorIndex ProcessOf(ActuatorIndex actuator) const {
    return process_of.empty() ? actuator : process_of[actuator];
  }
};

// Samples a layout. A config of profile "lan" gets two or three hosts: actuators without a command
// run on any of them, the others where the controller starts them. `shared_processes`: some
// actuators without a command run in the process of another.
Layout SampleLayout(const MachineConfig& config, std::uint64_t seed, bool shared_processes);

class Hosts {
 public:
  Hosts(transport::sim::Network& network, const std::vector<std::string>& names);

  std::size_t size() const { return hosts_.size(); }
  const std::string& name(std::size_t host) const { return hosts_[host].name; }
  // What HostId() returns on that host: its boot, here with its name, and a pid namespace.
  std::string Id(std::size_t host) const;
  // What NewIncarnation() returns there: the time since its boot, in ns; never the same
  // value twice.
  Incarnation NewIncarnation(std::size_t host);
  std::int32_t NewPid(std::size_t host) { return hosts_[host].next_pid++; }

  // For a process that starts; unique among all hosts.
  std::uint64_t NewSerial() { return next_serial_++; }

  // How long ago it was booted.
  Duration Uptime(std::size_t host) const { return network_.now() - hosts_[host].booted; }
  void SetUptime(std::size_t host, Duration uptime);
  // Resets its clock and its pids. Its processes must have ended.
  void Reboot(std::size_t host);
  // It was without power until now.
  void SetBooted(std::size_t host) { hosts_[host].booted = network_.now(); }

  // Assigns an endpoint of the network to the host: it gets the host's clock and links.
  void Attach(const std::string& endpoint, std::size_t host);
  // Blocks the link from one endpoint to the other. Calls are counted: each call that blocks needs
  // one that unblocks.
  void SetBlocked(const std::string& from, const std::string& to, bool blocked);
  void SetHostBlocked(std::size_t from, std::size_t to, bool blocked);
  // Whether the link from one host to the other is not blocked as a whole.
  bool Reaches(std::size_t from, std::size_t to) const {
    const auto blocks = host_blocks_.find({from, to});
    return blocks == host_blocks_.end() || blocks->second == 0;
  }
  // The outer interface of a host is gone, or back: it reaches no other host, while its own
  // processes reach each other by the loopback.
  void SetCutOff(std::size_t host, bool cut_off);
  // When the link was unblocked; Time::max(): it is blocked; nullopt: it never was.
  std::optional<Time> BlockedUntil(const std::string& from, const std::string& to) const;

 private:
  struct Host {
    std::string name;
    int boot = 1;
    Time booted{};
    std::int32_t next_pid = 1000;
    Incarnation last_incarnation = 0;
    Duration clock_offset{};  // against the network's time
    std::vector<std::string> endpoints;
  };
  struct Link {
    int blocks = 0;
    Time until{};  // blocked until then
  };

  transport::sim::Network& network_;
  std::uint64_t next_serial_ = 1;
  std::vector<Host> hosts_;
  std::map<std::pair<std::string, std::string>, Link> links_;       // from, to
  std::map<std::pair<std::size_t, std::size_t>, int> host_blocks_;  // from, to
};

}  // namespace musher::simulation
