// A changed recording of a Recorder. If it can be read and played, it is recorded again, and that
// recording plays without a difference.

#include "musher/behavior/fsm/recorder.hpp"
#include "musher/behavior/fsm/replay.hpp"
#include "musher/test/fuzz/greeting.hpp"

namespace musher::fsm {
namespace {

using fuzz::Greeter;
using fuzz::Require;

// Plays a recording, and returns the recording of that; nothing when it cannot be played.
std::optional<std::string> Play(std::string_view text, Replayed& replayed) {
  const auto recording = ReadRecording(text, "a.record");
  if (!recording) {
    Require(recording.error().message.starts_with("a.record:"), "an error has a position");
    return std::nullopt;
  }
  Greeter greeter;
  std::string record;
  Recorder recorder(*greeter.machine, [&](std::string_view line) { record += line; });
  const auto played = Replay(recording.value(), *greeter.machine, [&](auto name, auto input) {
    recorder.Input(name, input);
    return greeter.Apply(name, input);
  });
  if (!played) return std::nullopt;
  replayed = played.value();
  Require(replayed.ticks <= recording.value().lines.size(), "a tick is a line");
  return record;
}

}  // namespace
}  // namespace musher::fsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using musher::fuzz::Require;
  musher::fsm::Replayed first;
  musher::fuzz::Input input(data, size);
  const auto again = musher::fsm::Play(input.Rest(), first);
  if (!again) return 0;
  musher::fsm::Replayed second;
  Require(musher::fsm::Play(*again, second).has_value(), "a new recording can be played");
  Require(!second.difference, second.difference.value_or("") + " in\n" + *again);
  Require(first.ticks == second.ticks, "both have the same length");
  return 0;
}
