#pragma once
// What the processes of other hosts use, from the kernels there: each host sends a sample in each
// interval, over one ssh.
//
// Threads: loop thread only.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/process_usage.hpp"
#include "musher/cli/machine/host_query.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

class HostUsage {
 public:
  struct Sample {
    ProcessUsage usage;
    std::optional<double> cpu_percent;  // of one CPU, since the sample before
  };

  // The loop must outlive it.
  HostUsage(transport::EventLoop& loop, const MachineConfig& config, Duration interval);
  HostUsage(const HostUsage&) = delete;
  HostUsage& operator=(const HostUsage&) = delete;

  // The last sample of the process of an actuator; null: none.
  const Sample* Of(const std::string& actuator) const;
  // Whether each host has sent two samples, or has failed.
  bool Complete() const;
  // Why hosts send none; each is given once.
  std::vector<std::string> TakeTroubles();

 private:
  struct Host {
    const std::string name;
    std::vector<std::string> actuators;
    std::optional<HostScript> script;
    int samples = 0;
    double ticks_per_second = 100;
    std::uint64_t page_bytes = 4096;
    Time sampled{};                          // the sample before
    std::map<std::string, Sample> now = {};  // of the sample that is being read
    std::map<std::string, Sample> last = {};
    transport::LoopHandlePtr watch = nullptr;  // last: its callback ends before what it uses
  };

  void OnLines(Host& host);
  void Take(Host& host, const std::string& line) const;

  transport::EventLoop& loop_;
  std::vector<std::string> troubles_;
  std::vector<std::unique_ptr<Host>> hosts_;
};

}  // namespace musher::cli
