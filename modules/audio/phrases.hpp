#pragma once
// The robot's phrases by number. Plain values; phrases_toml.cpp reads them.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/modules/audio/speech_text.hpp"

namespace musher::audio {

// What is to be played: a recording, or a spoken text without one.
struct Utterance {
  std::string text;
  Language language = Language::kEnglish;
  std::string recording;  // absolute path; empty: none

  friend bool operator==(const Utterance&, const Utterance&) = default;
};

// How a phrase or a cue is played: as a recording, or as text in a language.
struct Spoken {
  std::map<Language, std::string> texts;
  std::string recording;  // absolute path; empty: none

  // In `language`, or in the other one when there is no text in it.
  Utterance In(Language language) const;

  friend bool operator==(const Spoken&, const Spoken&) = default;
};

inline constexpr std::string_view kNumberMark = "{number}";

// One phrase, or a range of them that differ by a number: id `first` + n says n.
struct Phrase {
  std::uint16_t first = 0;
  std::uint16_t last = 0;
  Spoken spoken;

  friend bool operator==(const Phrase&, const Phrase&) = default;
};

class Phrases {
 public:
  Phrases() = default;
  // The ranges do not overlap.
  explicit Phrases(std::vector<Phrase> phrases);

  // In `language`, or in the other one when the phrase has no text in it.
  std::optional<Utterance> Find(std::uint16_t id, Language language) const;
  bool Has(std::uint16_t id) const { return PhraseOf(id) != nullptr; }
  const std::vector<Phrase>& all() const { return phrases_; }

  friend bool operator==(const Phrases&, const Phrases&) = default;

 private:
  const Phrase* PhraseOf(std::uint16_t id) const;

  std::vector<Phrase> phrases_;  // by id
};

struct PhrasesReading {
  std::optional<Phrases> phrases;       // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
};

// Never throws; an unreadable file is a diagnostic, and so is a recording that cannot be read.
PhrasesReading ReadPhrasesFile(const std::string& path);
// The same for a text; `path` is what diagnostics and relative paths refer to.
PhrasesReading ReadPhrasesText(std::string_view text, const std::string& path);

}  // namespace musher::audio
