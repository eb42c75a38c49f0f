#pragma once
// The event loop of a simulated process: a view of the network's event queue. It has no file
// descriptors, and running it runs the whole network.

#include <functional>

#include "musher/transport/event_loop.hpp"
#include "musher/transport/sim/links.hpp"
#include "musher/transport/sim/scheduler.hpp"

namespace musher::transport::sim {

class SimLoop : public EventLoop {
 public:
  SimLoop(Scheduler& scheduler, ProcessId process, const Links& links, HostId host)
      : scheduler_(scheduler), process_(process), links_(links), host_(host) {}

  Time Now() const override { return scheduler_.now() + links_.ClockOffset(host_); }
  void Post(std::function<void()> work) override;
  LoopHandlePtr At(Time when, std::function<void()> callback) override;
  LoopHandlePtr Every(Duration period, std::function<void()> callback) override;
  // Not supported: aborts.
  LoopHandlePtr WhenReadable(int fd, std::function<void()> callback) override;
  // Also returns if the network has no more events.
  void Run() override;
  bool RunUntil(const std::function<bool()>& done, Time deadline) override;
  void Stop() override { stop_ = true; }

 private:
  class Timer;
  class Handle;

  Scheduler& scheduler_;
  ProcessId process_;
  const Links& links_;
  HostId host_;
  bool stop_ = false;
};

// Runs events until `done` holds (checked after every event) or `limit` is reached; returns whether
// it held. If not, virtual time is at `limit`.
bool RunEventsUntil(Scheduler& scheduler, const std::function<bool()>& done, Time limit);

}  // namespace musher::transport::sim
