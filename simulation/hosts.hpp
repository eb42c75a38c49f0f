#pragma once
// The hosts of a simulated robot. Processes of one host share its id, its pids and its clock, which
// counts from its last boot. On the network each process has an endpoint of its own
// (transport::sim calls it a host), so that one process can be cut off as well as a whole host.
//
// Threads: one, that of the network.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

// Of the hosts that are drawn.
std::string_view HostName(std::size_t host);

// Which host each part of a robot is on, and which actuators share a process.
struct Layout {
  std::vector<std::string> hosts = {"sim"};
  // Of each actuator of the config, an index into `hosts`; empty: all on the first.
  std::vector<std::size_t> host_of;
  // The actuator in whose process it runs, itself or an earlier one; empty: each has its own.
  std::vector<std::size_t> process_of;
  // Of the first controller and of the one that takes over.
  std::array<std::size_t, 2> controllers{};

  std::size_t HostOf(std::size_t actuator) const { return host_of.empty() ? 0 : host_of[actuator]; }
  std::size_t ProcessOf(std::size_t actuator) const {
    return process_of.empty() ? actuator : process_of[actuator];
  }
};

// A config of profile "lan" has two or three hosts: actuators without a command are on any of them,
// the others where the controller starts them. `shared_processes`: some actuators without a command
// run in the process of another.
Layout DrawLayout(const MachineConfig& config, std::uint64_t seed, bool shared_processes);

class Hosts {
 public:
  Hosts(transport::sim::Network& network, const std::vector<std::string>& names);

  std::size_t size() const { return hosts_.size(); }
  const std::string& name(std::size_t host) const { return hosts_[host].name; }
  // What transport::HostId() gives there: the name and the boot.
  std::string Id(std::size_t host) const;
  // What transport::NewIncarnation() gives there: the time since its boot, in ns; never twice.
  std::uint64_t NewIncarnation(std::size_t host);
  std::int32_t NewPid(std::size_t host) { return hosts_[host].next_pid++; }

  // Of a process that starts; of all hosts, ever.
  std::uint64_t NewSerial() { return next_serial_++; }

  // How long ago it was booted.
  void SetUptime(std::size_t host, Duration uptime);
  // Its clock and its pids begin again. Its processes must have ended.
  void Reboot(std::size_t host);

  // An endpoint of the network belongs to the host: it has its clock and its links.
  void Attach(const std::string& endpoint, std::size_t host);
  // Nothing gets from one to the other. Calls are counted: as often as it was blocked it has to be
  // freed.
  void SetBlocked(const std::string& from, const std::string& to, bool blocked);
  void SetHostBlocked(std::size_t from, std::size_t to, bool blocked);
  // When the link was free again; the end of time: it is blocked. nullopt: it never was.
  std::optional<Time> BlockedUntil(const std::string& from, const std::string& to) const;

 private:
  struct Host {
    std::string name;
    int boot = 1;
    std::int32_t next_pid = 1000;
    std::uint64_t last_incarnation = 0;
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
