#include "musher/modules/vision/course/words.hpp"

#include <algorithm>
#include <cctype>

namespace musher::vision {
namespace {

bool IsAscii(char c) {
  return static_cast<unsigned char>(c) < 0x80;
}

constexpr std::string_view kDashesAndQuotes = "\xe2\x80";  // the first bytes of U+2000 to 203F

bool HasDash(std::string_view text) {
  return text.find('-') != text.npos || text.find(kDashesAndQuotes) != text.npos;
}

// Letters and digits as they are compared; bytes of other scripts stay as they are.
std::string Essence(std::string_view text, bool loosely) {
  std::string essence;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (text.substr(i).starts_with(kDashesAndQuotes)) {
      i += 2;
      continue;
    }
    if (!IsAscii(c)) {
      essence += c;
      continue;
    }
    const auto upper = static_cast<char>(std::toupper(c));
    if (loosely && (upper == 'I' || upper == 'L')) {
      essence += '1';
    } else if (loosely && upper == 'Z') {
      essence += '2';
    } else if (std::isalnum(static_cast<unsigned char>(upper))) {
      essence += upper;
    }
  }
  return essence;
}

bool ContainsInOrder(std::string_view text, std::string_view word) {
  std::size_t next = 0;
  for (const char c : text) {
    if (next < word.size() && c == word[next]) ++next;
  }
  return next == word.size();
}

}  // namespace

std::optional<std::string> WordOfCode(std::string_view content,
                                      const std::vector<std::string>& words) {
  constexpr std::string_view kSpace = " \t\r\n";
  const std::size_t from = content.find_first_not_of(kSpace);
  if (from == std::string_view::npos) return std::nullopt;
  content = content.substr(from, content.find_last_not_of(kSpace) - from + 1);
  const auto word = std::find(words.begin(), words.end(), content);
  return word == words.end() ? std::nullopt : std::optional(*word);
}

std::vector<std::string> WordsOfLetters(std::string_view text,
                                        const std::vector<std::string>& words) {
  constexpr std::size_t kMostExtra = 2;
  const bool loosely = HasDash(text);
  const std::string essence = Essence(text, loosely);
  std::vector<std::string> matches;
  for (const std::string& word : words) {
    const std::string sought = Essence(word, loosely);
    if (sought.empty() || essence.size() > sought.size() + kMostExtra) continue;
    const bool is_known = std::find(matches.begin(), matches.end(), word) != matches.end();
    if (!is_known && ContainsInOrder(essence, sought)) matches.push_back(word);
  }
  return matches;
}

std::optional<std::string> WordOfLetters(std::string_view text,
                                         const std::vector<std::string>& words) {
  const std::vector<std::string> matches = WordsOfLetters(text, words);
  return matches.size() == 1 ? std::optional(matches.front()) : std::nullopt;
}

std::set<std::string> WordsOfReadings(const std::vector<std::string>& texts,
                                      const std::vector<std::string>& words) {
  std::set<std::string> all;
  for (const std::string& text : texts) {
    const std::vector<std::string> matches = WordsOfLetters(text, words);
    all.insert(matches.begin(), matches.end());
    const bool has_signs = !Essence(text, false).empty();
    if (matches.empty() && has_signs) all.insert("?");
  }
  return all;
}

std::string Excerpt(std::string_view text) {
  constexpr std::size_t kMost = 64;
  std::string excerpt(text.substr(0, kMost));
  for (char& c : excerpt) {
    if (!IsAscii(c) || std::isprint(static_cast<unsigned char>(c)) == 0) c = '?';
  }
  return excerpt;
}

std::optional<std::string> WordRepeats::OnPicture(const std::optional<std::string>& word) {
  in_row_ = word && word == word_ ? std::min(in_row_ + 1, least_) : 1;
  word_ = word;
  return word_ && in_row_ >= least_ ? word_ : std::nullopt;
}

}  // namespace musher::vision
