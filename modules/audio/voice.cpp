#include "musher/modules/audio/voice.hpp"

#include <espeak-ng/speak_lib.h>

#include <utility>

#include "musher/base/toml/findings.hpp"
#include "musher/modules/audio/audio_code.hpp"

namespace musher::audio {
namespace {

Error Failed(const std::string& why) {
  return {AudioCode(AudioKey::kVoice), "espeak-ng: " + why};
}

struct Synthesis {
  Sound sound;
  const std::function<bool()>& given_up;
};

// The library's callback: 0 to continue, 1 to stop.
int Take(short* samples, int count, espeak_EVENT* events) {
  auto& synthesis = *static_cast<Synthesis*>(events->user_data);
  if (samples != nullptr) {
    synthesis.sound.samples.insert(synthesis.sound.samples.end(), samples, samples + count);
  }
  return synthesis.given_up() ? 1 : 0;
}

// The library is initialised once a process and never terminated: after a second initialisation
// its termination blocks for ever (1.51).
Result<int> Start(const VoiceConfig& config) {
  static const int rate_hz =
      espeak_Initialize(AUDIO_OUTPUT_SYNCHRONOUS, 0, nullptr, espeakINITIALIZE_DONT_EXIT);
  if (rate_hz <= 0) return Failed("its data is missing (Debian package espeak-ng-data)");
  espeak_SetSynthCallback(Take);
  espeak_SetParameter(espeakRATE, config.words_per_minute, 0);
  return rate_hz;
}

}  // namespace

Voice::Voice(VoiceConfig config) : config_(std::move(config)), rate_hz_(Start(config_)) {}

Result<> Voice::Choose(Language language) {
  if (!rate_hz_) return rate_hz_.error();
  const std::string& name = language == Language::kChinese ? config_.chinese : config_.english;
  if (espeak_SetVoiceByName(name.c_str()) == EE_OK) return Ok();
  return Failed("there is no voice " + config_toml::Quote(name));
}

Result<Sound> Voice::Speak(const std::string& text, Language language,
                           const std::function<bool()>& given_up) {
  if (Result<> chosen = Choose(language); !chosen) return chosen.error();
  Synthesis synthesis{{rate_hz_.value(), {}}, given_up};
  const espeak_ERROR error = espeak_Synth(text.c_str(), text.size() + 1, 0, POS_CHARACTER, 0,
                                          espeakCHARS_UTF8, nullptr, &synthesis);
  if (error != EE_OK) return Failed("error " + std::to_string(error));
  return std::move(synthesis.sound);
}

Result<> Voice::Check() {
  for (const auto& [language, text] :
       {std::pair{Language::kEnglish, "one"}, std::pair{Language::kChinese, "一"}}) {
    const Result<Sound> sound = Speak(text, language, [] { return false; });
    if (!sound) return sound.error();
    if (sound.value().samples.empty()) return Failed("it makes no sound");
  }
  return Ok();
}

}  // namespace musher::audio
