#pragma once
// Replays the inputs of a recording (recorder.hpp) to a machine, and compares its changes with the
// recorded ones.
//
//   Result<Recording> recording = ReadRecording(text, "show.record");
//   Result<Replayed> replayed = Replay(recording.value(), machine,
//       [&](std::string_view name, std::string_view text) { return robot.Apply(name, text); });
//
// A machine whose states depend only on their tick, their own data and the inputs recorded with
// Input() makes the same changes again, at any speed.
//
// Threads: ReadRecording() any; Replay() one at a time, like the machine and its `apply`.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/fsm/machine.hpp"

namespace musher::fsm {

struct Recording {
  struct Line {
    enum class Kind : std::uint8_t {
      kStart,
      kTick,
      kPause,
      kCommand,
      kForce,
      kReset,
      kStop,
      kInput,
      kChanged
    };

    Kind kind = Kind::kTick;
    int number = 0;    // in the file, from 1
    Duration time{};   // of kStart and kTick: since the first start
    std::string name;  // of the state, the command or the input
    std::string text;  // of kInput; of kChanged the words after it
    std::vector<std::pair<std::string, std::string>> data;  // of kCommand: its fields
  };

  std::string file;  // for messages
  std::string machine;
  bool has_inside = false;  // the changes of the machines inside are recorded too
  std::vector<Line> lines;
  // Its last line is incomplete and was left out: the recording process crashed.
  bool cut_short = false;
};

// Fails with the first invalid line, as "file:line:column: error: ...".
Result<Recording> ReadRecording(std::string_view text, const std::string& file);

struct Replayed {
  std::uint64_t ticks = 0;
  std::uint64_t changes = 0;
  // The first change that differs from the recorded one, with both: "file:line: ...".
  std::optional<std::string> difference;
};

// Replays an input to the application, before the next tick.
using ApplyInput = std::function<Result<>(std::string_view name, std::string_view text)>;

// `machine` has to be built like the recorded one, and must not run. Continues after a difference.
// Fails, with file and line, where the machine has another name or lacks a recorded state or
// command, and when `apply` fails. Leaves the machine as it is at the end of the recording.
Result<Replayed> Replay(const Recording& recording, Machine& machine, const ApplyInput& apply);

}  // namespace musher::fsm
