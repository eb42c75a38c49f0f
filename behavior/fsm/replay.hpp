#pragma once
// Gives a machine again what a Recorder wrote down (recorder.hpp), and says whether the same came
// of it.
//
//   Result<Recording> recording = ReadRecording(text, "show.record");
//   Result<Replayed> replayed = Replay(recording.value(), machine,
//       [&](std::string_view name, std::string_view text) { return robot.Apply(name, text); });
//
// A machine whose states look at nothing but their tick, their own data and what Input() recorded
// does the same again, at any speed.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/behavior/fsm/machine.hpp"
#include "musher/lifecycle/result.hpp"

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
  };

  std::string file;  // for messages
  std::string machine;
  std::vector<Line> lines;
  bool cut_short = false;  // its last line has no end and was left out: whoever wrote it died
};

// Fails with the first line that is none, as "file:line:column: error: ...".
Result<Recording> ReadRecording(std::string_view text, const std::string& file);

struct Replayed {
  std::uint64_t ticks = 0;
  std::uint64_t changes = 0;
  // The first change that came otherwise than recorded, with both: "file:line: ...".
  std::optional<std::string> difference;
};

// Gives the application an input again, before the next tick.
using ApplyInput = std::function<Result<>(std::string_view name, std::string_view text)>;

// `machine` is built as the recorded one was, and does not run. Goes on after a difference; fails,
// with file and line, where the machine has another name or not the state or the command that is
// asked for, and when `apply` fails. Leaves the machine as it is at the recording's end.
Result<Replayed> Replay(const Recording& recording, Machine& machine, const ApplyInput& apply);

}  // namespace musher::fsm
