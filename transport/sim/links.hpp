#pragma once
// The hosts of a simulation and the link faults between them.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::transport::sim {

using HostId = std::uint32_t;

// The faults of one direction between two hosts, also from a host to itself. Inside a process no
// sample is delayed or lost.
struct LinkFaults {
  Duration delay_min = std::chrono::microseconds(20);
  Duration delay_max = std::chrono::microseconds(100);
  double loss = 0;  // a best-effort sample is lost, a reliable one delayed
  Duration retransmission = Milliseconds(10);   // the delay for each loss
  double duplication = 0;                       // a sample arrives twice
  double reordering = 0;                        // a sample may be overtaken by later ones …
  Duration reordering_delay = Milliseconds(5);  // … and arrive up to this much later
  double reliable_loss = 0;                     // a reliable sample is lost without retransmission
};

class Links {
 public:
  // The host of that name; creates it if necessary.
  HostId Host(const std::string& name);
  std::size_t hosts() const { return names_.size(); }

  void SetFaults(const LinkFaults& faults);  // on all links, also of later hosts
  void SetFaults(HostId from, HostId to, const LinkFaults& faults) { At(from, to).faults = faults; }
  // All links from and to that host, also with later hosts, have these faults instead of their own.
  void SetFaultsOf(HostId host, const LinkFaults& faults) { of_hosts_[host] = faults; }
  const LinkFaults& Faults(HostId from, HostId to) const {
    if (!of_hosts_.empty()) {
      for (const HostId host : {from, to}) {
        if (const auto of_host = of_hosts_.find(host); of_host != of_hosts_.end()) {
          return of_host->second;
        }
      }
    }
    return At(from, to).faults;
  }

  void SetBlocked(HostId from, HostId to, bool blocked);
  bool Blocked(HostId from, HostId to) const { return At(from, to).blocked; }
  // Grows with every change of SetBlocked().
  std::uint64_t Changes(HostId from, HostId to) const { return At(from, to).changes; }

  void SetClockOffset(HostId host, Duration offset) { offsets_[host] = offset; }
  Duration ClockOffset(HostId host) const { return offsets_[host]; }

 private:
  struct Link {
    LinkFaults faults;
    bool blocked = false;
    std::uint64_t changes = 0;
  };

  Link& At(HostId from, HostId to) { return links_[from][to]; }
  const Link& At(HostId from, HostId to) const { return links_[from][to]; }

  std::vector<std::string> names_;
  std::vector<Duration> offsets_;
  std::vector<std::vector<Link>> links_;  // from, to
  LinkFaults default_faults_;
  std::map<HostId, LinkFaults> of_hosts_;
};

}  // namespace musher::transport::sim
