#pragma once
// Checks and prepares a text before it is spoken. Plain functions, no IO.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace musher::audio {

enum class Language : std::uint8_t { kEnglish, kChinese };

// How many characters `text` has; nothing when it is not UTF-8.
std::optional<std::size_t> CharactersIn(std::string_view text);

// Whether it contains anything but blanks and control characters.
bool HasSomethingToSay(std::string_view text);

// `text` with a blank for each control character: a voice would end at the first zero byte.
std::string Speakable(std::string_view text);

// By its characters: Chinese if there is a Chinese one, else English if there are letters, else
// `otherwise` (numbers, signs).
Language LanguageOf(std::string_view text, Language otherwise);

}  // namespace musher::audio
