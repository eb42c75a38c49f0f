#pragma once
// The config of the audio module, a TOML file; README.md and config/audio/audio.toml explain its
// keys.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/audio/cues.hpp"
#include "musher/modules/audio/phrases.hpp"

namespace musher::audio {

enum class OutputKind : std::uint8_t { kAuto, kAlsa, kWav, kSilent };

struct OutputConfig {
  OutputKind kind = OutputKind::kAuto;
  std::string device = "default";  // of ALSA
  std::string folder;              // of WAV files: absolute

  friend bool operator==(const OutputConfig&, const OutputConfig&) = default;
};

struct VoiceConfig {
  int words_per_minute = 175;
  std::string english = "en-us";  // voices of espeak-ng
  std::string chinese = "cmn";

  friend bool operator==(const VoiceConfig&, const VoiceConfig&) = default;
};

struct AudioConfig {
  OutputConfig output;
  int volume = 60;  // %
  Language language = Language::kEnglish;
  std::size_t longest_text = 1000;  // characters
  VoiceConfig voice;
  std::string phrases_file;  // absolute
  Phrases phrases;
  std::vector<std::string> cue_files;  // of each of the topics; absolute
  std::vector<CueTopic> cue_topics;

  friend bool operator==(const AudioConfig&, const AudioConfig&) = default;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<AudioConfig> ReadAudioFile(const std::string& path);

// The same for a text; `path` is what diagnostics and relative paths refer to. Reads the phrases
// and cues.
Parsed<AudioConfig> ReadAudioText(std::string_view text, const std::string& path);

}  // namespace musher::audio
