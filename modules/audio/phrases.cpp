#include "musher/modules/audio/phrases.hpp"

#include <algorithm>
#include <utility>

namespace musher::audio {
namespace {

std::string WithNumber(std::string text, int number) {
  const std::string digits = std::to_string(number);
  std::size_t at = 0;
  while ((at = text.find(kNumberMark, at)) != std::string::npos) {
    text.replace(at, kNumberMark.size(), digits);
    at += digits.size();
  }
  return text;
}

}  // namespace

Phrases::Phrases(std::vector<Phrase> phrases) : phrases_(std::move(phrases)) {
  std::sort(phrases_.begin(), phrases_.end(),
            [](const Phrase& a, const Phrase& b) { return a.first < b.first; });
}

const Phrase* Phrases::PhraseOf(std::uint16_t id) const {
  const auto after =
      std::upper_bound(phrases_.begin(), phrases_.end(), id,
                       [](std::uint16_t wanted, const Phrase& p) { return wanted < p.first; });
  if (after == phrases_.begin()) return nullptr;
  const Phrase& phrase = *std::prev(after);
  return id <= phrase.last ? &phrase : nullptr;
}

std::optional<Utterance> Phrases::Find(std::uint16_t id, Language language) const {
  const Phrase* phrase = PhraseOf(id);
  if (phrase == nullptr) return std::nullopt;
  Utterance utterance{{}, language, phrase->recording};
  auto text = phrase->texts.find(language);
  if (text == phrase->texts.end()) text = phrase->texts.begin();
  if (text != phrase->texts.end()) {
    utterance.language = text->first;
    utterance.text = WithNumber(text->second, id - phrase->first);
  }
  return utterance;
}

}  // namespace musher::audio
