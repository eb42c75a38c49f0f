#include "musher/modules/audio/audio_code.hpp"

#include <array>

namespace musher::audio {
namespace {

struct Meaning {
  std::int32_t code;
  const char* text;
};

constexpr std::array kMeanings = {
    Meaning{AudioCode(KeyCode::kFailed), "the sound failed"},
    Meaning{AudioCode(KeyCode::kStateInvalid), "the state of the machine does not allow it"},
    Meaning{AudioCode(KeyCode::kTimeout), "timeout: the sound did not end in time"},
    Meaning{AudioCode(KeyCode::kSelfCheckFailed), "the self-check failed"},
    Meaning{AudioCode(KeyCode::kParametersInvalid), "the number is out of its range"},
    Meaning{AudioCode(KeyCode::kTargetBusy), "too many sounds are queued"},
    Meaning{AudioCode(KeyCode::kDeviceError), "the sound device takes no sound"},
    Meaning{AudioCode(AudioKey::kInterrupted), "interrupted by another sound"},
    Meaning{AudioCode(AudioKey::kStopped), "it was stopped"},
    Meaning{AudioCode(AudioKey::kNoPhrase), "unknown phrase number"},
    Meaning{AudioCode(AudioKey::kNothingToSay), "the text is empty"},
    Meaning{AudioCode(AudioKey::kTextTooLong), "the text is too long"},
    Meaning{AudioCode(AudioKey::kNotUtf8), "the text is not UTF-8"},
    Meaning{AudioCode(AudioKey::kVoice), "the voice could not speak it"},
    Meaning{AudioCode(AudioKey::kRecording), "the recording cannot be read"},
    Meaning{kBoardFailed, "the sound device failed the self-check"},
};

}  // namespace

std::string AudioCodeText(std::int32_t code) {
  for (const Meaning& meaning : kMeanings) {
    if (meaning.code == code) return meaning.text;
  }
  return {};
}

}  // namespace musher::audio
