#pragma once
// Searches this host for its machines (storage/machines_here.hpp) on a thread of its own: the
// search reads the disk and other processes, and one that hangs may hold it up for as long as it
// hangs.
//
// Threads: loop thread only; `find` runs on the search's own.

#include <functional>
#include <memory>
#include <vector>

#include "musher/base/work_queue.hpp"
#include "musher/controller/client/machine_here.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::view {

class HostSearch {
 public:
  using Machines = std::vector<MachineHere>;

  // `find` must own what it uses: a search that hangs may outlive this.
  HostSearch(transport::EventLoop& loop, std::function<Machines()> find);
  ~HostSearch();
  HostSearch(const HostSearch&) = delete;
  HostSearch& operator=(const HostSearch&) = delete;

  // Searches after the earlier searches. `on_found` runs on the loop; never after this is dropped.
  void Begin(std::function<void(Machines)> on_found);

 private:
  struct Loop;  // empty once this is dropped

  const std::function<Machines()> find_;
  const std::shared_ptr<Loop> loop_;
  WorkQueue queue_;  // last: its thread ends first
};

}  // namespace musher::view
