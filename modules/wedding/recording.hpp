#pragma once
// The inputs of the show in a recording (behavior/fsm/recorder.hpp), a name and a text: numbers in
// a row, or one number and a word. The first number is always the time of reception, in
// nanoseconds since the machine was first started.

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"

namespace musher::wedding {

namespace input {
inline constexpr std::string_view kTarget = "target";       // x y distance_m stamp_ns
inline constexpr std::string_view kGesture = "gesture";     // its word
inline constexpr std::string_view kTooClose = "too_close";  // 0 or 1
inline constexpr std::string_view kFaces = "faces";         // count, face_id
inline constexpr std::string_view kFace = "face";           // count, face_id, x y stamp_ns
inline constexpr std::string_view kVoiceLevel = "voice_level";
inline constexpr std::string_view kHead = "head";      // stamp_ns yaw_rad
inline constexpr std::string_view kCamera = "camera";  // width height focal_length, in pixels
inline constexpr std::string_view kRest = "rest";
inline constexpr std::string_view kResume = "resume";
}  // namespace input

// Formats numbers so that the same numbers are read back.
std::string InputText(Duration at, std::initializer_list<double> numbers);
std::string InputText(Duration at, std::string_view word);

struct InputFields {
  Duration at{};
  std::vector<double> numbers;  // as many as requested
  std::string_view word;        // the text after the time
};
// Fails when the text has no time, or not `numbers` numbers after it.
Result<InputFields> ReadInput(std::string_view text, std::size_t numbers);

}  // namespace musher::wedding
