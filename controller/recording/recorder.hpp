#pragma once
// Hands all that goes into the decision code to the journal, and a snapshot of the machine now and
// then, from which what follows can be replayed when the journal has lost its beginning.
//
// Threads: loop thread only. The loop copies; the journal encodes on its own thread.

#include <cstddef>
#include <cstdint>
#include <string>

#include "musher/controller/journal.hpp"

namespace musher::recording {

class Recorder {
 public:
  // The sink must outlive it.
  Recorder(JournalSink& sink, const MachineConfig& config);

  // To be told first: what the machine's config says, as it was written.
  void Begin(std::int64_t wall_ns, std::string config_text);
  // To be told of each event before its Step(): `before` is the machine that it is for.
  void Note(std::int64_t wall_ns, const Machine& before, const Event& event, Time now);

 private:
  void TakeSnapshot(std::int64_t wall_ns, const Machine& machine);

  JournalSink& sink_;
  const MachineConfig& config_;
  std::string config_text_;
  std::size_t since_snapshot_ = 0;  // inputs
};

}  // namespace musher::recording
