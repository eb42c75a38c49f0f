#pragma once
// The codes of the audio module: module AudioNX (5000) and a key. CyberDog's own module builds
// them from module Robot, which hides where they come from.

#include <cstdint>
#include <string>

#include "musher/base/code.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::audio {

enum class AudioKey : std::int32_t {
  kInterrupted = 21,
  kStopped = 22,
  kNoPhrase = 23,
  kNothingToSay = 24,
  kTextTooLong = 25,
  kNotUtf8 = 26,
  kVoice = 27,
  kRecording = 28,
};

constexpr std::int32_t AudioCode(KeyCode key) {
  return MakeCode(cyberdog::module_code::kAudioNx, key);
}
constexpr std::int32_t AudioCode(AudioKey key) {
  return static_cast<std::int32_t>(cyberdog::module_code::kAudioNx) +
         static_cast<std::int32_t>(key);
}

// The output's self-check reports as the sound board, which CyberDog has a phrase for.
inline constexpr std::int32_t kBoardFailed =
    MakeCode(cyberdog::module_code::kAudioBoard, KeyCode::kSelfCheckFailed);

// The meaning of a code; empty for a code that is not this module's.
std::string AudioCodeText(std::int32_t code);

}  // namespace musher::audio
