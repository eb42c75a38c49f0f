#pragma once
// Text to sound, by espeak-ng.
//
// Threads: one voice at a time (the library has one global state), one call after the other.

#include <functional>
#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/audio/audio_config.hpp"
#include "musher/modules/audio/sound.hpp"
#include "musher/modules/audio/speech_text.hpp"

namespace musher::audio {

class Voice {
 public:
  explicit Voice(VoiceConfig config);

  // `text`: UTF-8 without control characters. Stops between two words when `given_up` returns
  // true; the sound is then what was made so far. Fails with kVoice's code.
  Result<Sound> Speak(const std::string& text, Language language,
                      const std::function<bool()>& given_up);

  // Whether it can speak both languages.
  Result<> Check();

 private:
  Result<> Choose(Language language);

  const VoiceConfig config_;
  Result<int> rate_hz_;  // or why the voice does not work
};

}  // namespace musher::audio
