#pragma once
// Passes all inputs of the decision code to the journal, and periodically a snapshot of the
// machine, from which a replay can start if the journal has lost its beginning.
//
// Threads: loop thread only. The loop copies; the journal encodes on its own thread.

#include <cstddef>
#include <cstdint>
#include <string>

#include "musher/controller/journal/journal.hpp"

namespace musher::recording {

class InputRecorder {
 public:
  // The sink must outlive it.
  InputRecorder(JournalSink& sink, const MachineConfig& config);

  // Call first, with the text of the machine's config.
  void Begin(std::int64_t wall_ns, std::string config_text);
  // Call for each event before its Step(); `before`: the machine before the step.
  void Note(std::int64_t wall_ns, const Machine& before, const Event& event, Time now);

 private:
  void TakeSnapshot(std::int64_t wall_ns, const Machine& machine);

  JournalSink& sink_;
  const MachineConfig& config_;
  std::string config_text_;
  std::size_t since_snapshot_ = 0;  // inputs
};

}  // namespace musher::recording
