#include "musher/modules/audio/speech_text.hpp"

#include <algorithm>

#include "musher/base/toml/text.hpp"

namespace musher::audio {
namespace {

constexpr unsigned char kLastControl = 0x20;  // a blank counts as one here
constexpr unsigned char kDelete = 0x7F;

bool IsControl(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte < kLastControl || byte == kDelete;
}

// Length of a character of valid UTF-8.
char32_t CodePoint(std::string_view character) {
  const auto lead = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return lead;
  char32_t point = lead & (0xFFU >> (character.size() + 1));
  for (const char c : character.substr(1)) {
    point = (point << 6U) | (static_cast<unsigned char>(c) & 0x3FU);
  }
  return point;
}

bool IsChinese(char32_t point) {
  return (point >= 0x3400 && point <= 0x4DBF) || (point >= 0x4E00 && point <= 0x9FFF) ||
         (point >= 0xF900 && point <= 0xFAFF) || (point >= 0x20000 && point <= 0x3FFFF);
}

bool IsLetter(char32_t point) {
  return (point >= 'a' && point <= 'z') || (point >= 'A' && point <= 'Z') ||
         (point >= 0xC0 && point <= 0x24F);
}

// Includes the ideographic blank.
bool IsBlank(char32_t point) {
  return point <= kLastControl || point == kDelete || point == 0xA0 || point == 0x3000;
}

// Calls `use` with each character of valid UTF-8, until it returns true.
template <class Use>
bool AnyCharacter(std::string_view text, Use use) {
  while (const std::size_t size = config_toml::CharacterSize(text)) {
    if (use(CodePoint(text.substr(0, size)))) return true;
    text.remove_prefix(size);
  }
  return false;
}

}  // namespace

std::optional<std::size_t> CharactersIn(std::string_view text) {
  std::size_t count = 0;
  while (!text.empty()) {
    const std::size_t size = config_toml::CharacterSize(text);
    if (size == 0) return std::nullopt;
    text.remove_prefix(size);
    ++count;
  }
  return count;
}

bool HasSomethingToSay(std::string_view text) {
  return AnyCharacter(text, [](char32_t point) { return !IsBlank(point); });
}

std::string Speakable(std::string_view text) {
  std::string speakable(text);
  std::replace_if(speakable.begin(), speakable.end(), IsControl, ' ');
  return speakable;
}

Language LanguageOf(std::string_view text, Language otherwise) {
  if (AnyCharacter(text, IsChinese)) return Language::kChinese;
  if (AnyCharacter(text, IsLetter)) return Language::kEnglish;
  return otherwise;
}

}  // namespace musher::audio
