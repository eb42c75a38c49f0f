#include "musher/modules/wedding/data/words.hpp"

#include <cctype>

namespace musher::wedding {
namespace {

constexpr std::array<std::pair<std::string_view, Gesture>, 4> kGestures = {
    {{"none", Gesture::kNone},
     {"heart", Gesture::kHeart},
     {"v", Gesture::kV},
     {"ok", Gesture::kOk}}};

}  // namespace

std::optional<Gesture> GestureOf(std::string_view word) {
  if (word.empty()) return Gesture::kNone;
  for (const auto& [name, gesture] : kGestures) {
    if (name == word) return gesture;
  }
  return std::nullopt;
}

std::string_view Name(Gesture gesture) {
  for (const auto& [name, each] : kGestures) {
    if (each == gesture) return name;
  }
  return "none";
}

std::string Tidy(std::string_view word) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = word.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return "";
  std::string tidy(word.substr(first, word.find_last_not_of(kBlanks) - first + 1));
  for (char& c : tidy) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return tidy;
}

}  // namespace musher::wedding
