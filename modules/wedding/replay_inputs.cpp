// Applies the recorded inputs of a show.

#include <algorithm>
#include <array>

#include "musher/modules/wedding/recording.hpp"
#include "musher/modules/wedding/show.hpp"

namespace musher::wedding {
namespace {

struct Kind {
  std::string_view name;
  std::size_t numbers;
};
constexpr std::array<Kind, 10> kKinds = {{{input::kTarget, 4},
                                          {input::kGesture, 0},
                                          {input::kTooClose, 1},
                                          {input::kFaces, 2},
                                          {input::kFace, 5},
                                          {input::kVoiceLevel, 1},
                                          {input::kHead, 2},
                                          {input::kCamera, 3},
                                          {input::kRest, 0},
                                          {input::kResume, 0}}};

Duration Nanoseconds(double count) {
  return Duration(static_cast<std::int64_t>(count));
}

}  // namespace

Result<> Show::Apply(std::string_view input, std::string_view text) {
  const auto* const kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& k) { return k.name == input; });
  if (kind == kKinds.end()) {
    return Error{kCodeFailed, "the show has no input '" + std::string(input) + "'"};
  }
  const Result<InputFields> read = ReadInput(text, kind->numbers);
  if (!read) return read.error();
  if (!first_start_) return Error{kCodeFailed, "an input before the first start"};
  const Time now = *first_start_ + read.value().at;
  const std::vector<double>& numbers = read.value().numbers;
  Note(now);
  if (input == input::kTarget) {
    OnTarget({{numbers[0], numbers[1]}, numbers[2], Nanoseconds(numbers[3])}, now);
  } else if (input == input::kGesture) {
    OnGesture(read.value().word, now);
  } else if (input == input::kTooClose) {
    OnTooClose(numbers[0] != 0, now);
  } else if (input == input::kFaces) {
    perception_.OnFaces({static_cast<int>(numbers[0]), static_cast<int>(numbers[1]), {}, {}}, now);
  } else if (input == input::kFace) {
    perception_.OnFaces({static_cast<int>(numbers[0]), static_cast<int>(numbers[1]),
                         Gaze{numbers[2], numbers[3]}, Nanoseconds(numbers[4])},
                        now);
  } else if (input == input::kVoiceLevel) {
    OnVoiceLevel(numbers[0], now);
  } else if (input == input::kCamera) {
    OnCamera(numbers[0], numbers[1], numbers[2], now);
  } else if (input == input::kHead) {
    perception_.OnHead(Nanoseconds(numbers[0]), numbers[1], now);
  } else {
    Clear();  // the machine's part is recorded as a line of its own
    resting_ = input == input::kRest;
  }
  return Ok();
}

}  // namespace musher::wedding
