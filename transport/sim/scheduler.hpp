#pragma once
// Virtual time: all events of a simulation in order of time, events of the same time in the order
// in which they were added. Each belongs to a process; events of a crashed process are dropped,
// those of a paused process wait.

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::transport::sim {

using Work = std::function<void()>;
using ProcessId = std::uint32_t;  // an index; 0 is the network itself

struct EventId {
  std::uint32_t slot = 0;
  std::uint32_t generation = 0;  // 0: no event
};

class Scheduler {
 public:
  Scheduler();

  Time now() const { return now_; }
  std::uint64_t steps() const { return steps_; }

  ProcessId AddProcess();
  void Kill(ProcessId process);  // for good
  void Pause(ProcessId process) { processes_[process].paused = true; }
  void Resume(ProcessId process);
  bool Alive(ProcessId process) const { return processes_[process].alive; }

  // Adds `work` at `when`, or now if that is past; no effect for a process that is not alive.
  EventId Add(ProcessId process, Time when, Work work);
  // No effect if the event has run.
  void Cancel(EventId event);

  // Whether an event runs now.
  bool running() const { return running_ > 0; }
  // Runs the next event if it is due by `limit`; returns whether one ran. An event may do so.
  bool Step(Time limit);
  // Advances time to `when`; there must be no earlier event.
  void AdvanceTo(Time when);

 private:
  struct Entry {
    Time when;
    std::uint64_t number;
    EventId event;
  };
  struct Slot {
    Work work;
    ProcessId process = 0;
    std::uint32_t generation = 1;  // of the event in it; grows when that has run or been cancelled
  };
  struct Process {
    bool alive = true;
    bool paused = false;
    std::vector<EventId> waiting;  // became due while it was paused
  };

  static bool Later(const Entry& a, const Entry& b);
  void Push(Time when, EventId event);
  void Free(std::uint32_t slot);

  Time now_;
  std::uint64_t steps_ = 0;
  int running_ = 0;  // events, one in another
  std::uint64_t next_number_ = 0;
  std::vector<Entry> heap_;  // the earliest in front
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> free_slots_;
  std::vector<Process> processes_;
};

}  // namespace musher::transport::sim
