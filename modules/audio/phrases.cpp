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

Utterance Spoken::In(Language language) const {
  auto text = texts.find(language);
  if (text == texts.end()) text = texts.begin();
  if (text == texts.end()) return {{}, language, recording};
  return {text->second, text->first, recording};
}

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
  Utterance utterance = phrase->spoken.In(language);
  utterance.text = WithNumber(std::move(utterance.text), id - phrase->first);
  return utterance;
}

}  // namespace musher::audio
