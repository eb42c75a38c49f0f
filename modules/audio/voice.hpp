#pragma once
// Text to sound, by espeak-ng.
//
// Threads: one voice at a time (the library has one state for all), its calls one after the other.

#include <functional>
#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/modules/audio/audio_config.hpp"
#include "musher/modules/audio/sound.hpp"
#include "musher/modules/audio/speech_text.hpp"

namespace musher::audio {

class Voice {
 public:
  explicit Voice(VoiceConfig config);

  // `text`: UTF-8 without control characters. Gives up between two words when `given_up` says so;
  // the sound is then what was made by then. Fails with kVoice's code.
  Result<Sound> Speak(const std::string& text, Language language,
                      const std::function<bool()>& given_up);

  // Whether it speaks both languages.
  Result<> Check();

 private:
  Result<> Choose(Language language);

  const VoiceConfig config_;
  Result<int> rate_hz_;  // or why there is no voice
};

}  // namespace musher::audio
