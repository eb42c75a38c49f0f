#pragma once
// How far the clocks of the other hosts of a machine are from that of this computer, by one ssh to
// each of them, all at the same time.
//
// Threads: loop thread only.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

// Another host that runs actuators of a machine.
struct HostClock {
  std::string name;                    // as in the config
  std::string login;                   // "root@10.0.0.2"
  std::vector<std::string> actuators;  // whose `host` it is
  std::optional<Duration> ahead = {};  // of this computer's clock; nullopt: not known
  std::string trouble = {};            // why it has not answered, with what to do; empty: it has
};

// "12 ms behind", "3.5 s ahead"
std::string ClockText(Duration ahead);

class HostClocks {
 public:
  // Begins. The loop must outlive it.
  HostClocks(transport::EventLoop& loop, const MachineConfig& config);
  ~HostClocks();
  HostClocks(const HostClocks&) = delete;
  HostClocks& operator=(const HostClocks&) = delete;

  // Whether each host has answered, or has failed.
  bool Complete() const;
  // In the order of the config. `within`: for how long the loop has run since this has begun, for
  // the sentence about a host that has not answered.
  std::vector<HostClock> Now(Duration within) const;

 private:
  struct Host;

  static void OnLines(Host& host);

  std::vector<std::unique_ptr<Host>> hosts_;
};

}  // namespace musher::cli
