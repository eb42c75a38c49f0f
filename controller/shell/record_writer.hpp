#pragma once
// Writes the records of a controller to its journal, and keeps the records of its last switches.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/journal/journal.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

class RecordWriter {
 public:
  using OnRecord = std::function<void(const action::Record&)>;

  // All must outlive it. `on_record` may be empty.
  RecordWriter(transport::EventLoop& loop, JournalSink& journal,
               std::function<std::int64_t()> wall_ns, const MachineConfig& config,
               const Machine& machine, OnRecord on_record);

  void Write(const action::Record& record);
  // A record of the shell itself, not of a decision: without an id and a cause.
  void WriteOwn(const std::string& kind, std::optional<ActuatorIndex> actuator, std::int32_t code,
                const RecordText& text);
  // An event of the machine that needs no decision.
  void Remark(std::int32_t code, const std::string& message);

  // The journal entries of this controller's last switches, oldest first.
  const std::vector<JournalEntry>& switches() const { return switches_; }

 private:
  transport::EventLoop& loop_;
  JournalSink& journal_;
  const std::function<std::int64_t()> wall_ns_;
  const MachineConfig& config_;
  const Machine& machine_;
  const OnRecord on_record_;
  std::vector<JournalEntry> switches_;
};

}  // namespace musher
