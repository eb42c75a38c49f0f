#include "musher/transport/sim/scheduler.hpp"

#include <algorithm>
#include <utility>

namespace musher::transport::sim {

namespace {

// Leaves room for times before the start of a simulation.
constexpr Time kStart = Time(std::chrono::hours(1));

}  // namespace

Scheduler::Scheduler() : now_(kStart), processes_(1) {}

ProcessId Scheduler::AddProcess() {
  processes_.emplace_back();
  return static_cast<ProcessId>(processes_.size() - 1);
}

void Scheduler::Kill(ProcessId process) {
  processes_[process].alive = false;
  processes_[process].waiting.clear();
  for (std::uint32_t slot = 0; slot < slots_.size(); ++slot) {
    if (slots_[slot].process == process && slots_[slot].work) Free(slot);
  }
}

void Scheduler::Resume(ProcessId process) {
  processes_[process].paused = false;
  for (const EventId event : std::exchange(processes_[process].waiting, {})) Push(now_, event);
}

EventId Scheduler::Add(ProcessId process, Time when, Work work) {
  EventId event;
  if (!Alive(process)) return event;
  if (free_slots_.empty()) {
    event.slot = static_cast<std::uint32_t>(slots_.size());
    slots_.emplace_back();
  } else {
    event.slot = free_slots_.back();
    free_slots_.pop_back();
  }
  Slot& slot = slots_[event.slot];
  event.generation = slot.generation;
  slot.work = std::move(work);
  slot.process = process;
  Push(std::max(when, now_), event);
  return event;
}

void Scheduler::Cancel(EventId event) {
  if (event.generation == 0) return;
  if (slots_[event.slot].generation == event.generation) Free(event.slot);
}

bool Scheduler::Step(Time limit) {
  while (!heap_.empty() && heap_.front().when <= limit) {
    const Entry next = heap_.front();
    std::pop_heap(heap_.begin(), heap_.end(), Later);
    heap_.pop_back();
    Slot& slot = slots_[next.event.slot];
    if (slot.generation != next.event.generation) continue;  // cancelled
    Process& process = processes_[slot.process];
    if (process.paused) {
      process.waiting.push_back(next.event);
    } else {
      now_ = next.when;
      const Work work = std::move(slot.work);
      Free(next.event.slot);
      ++steps_;
      ++running_;
      work();
      --running_;
      return true;
    }
  }
  return false;
}

void Scheduler::AdvanceTo(Time when) {
  now_ = std::max(now_, when);
}

bool Scheduler::Later(const Entry& a, const Entry& b) {
  return a.when != b.when ? a.when > b.when : a.number > b.number;
}

void Scheduler::Push(Time when, EventId event) {
  heap_.push_back({when, next_number_++, event});
  std::push_heap(heap_.begin(), heap_.end(), Later);
}

void Scheduler::Free(std::uint32_t slot) {
  ++slots_[slot].generation;
  const Work work = std::exchange(slots_[slot].work, nullptr);  // goes last: it may own handles
  free_slots_.push_back(slot);
}

}  // namespace musher::transport::sim
