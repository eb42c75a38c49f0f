#include "musher/base/toml/text.hpp"

#include <cstdint>
#include <cstdio>
#include <string>

namespace musher::config_toml {
namespace {

unsigned ByteAt(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

Position PositionAt(std::string_view text, std::size_t offset) {
  Position at{1, 1};
  for (std::size_t i = 0; i < offset; ++i) {
    if (text[i] == '\n') {
      at = {at.line + 1, 1};
    } else if ((ByteAt(text, i) & 0xC0U) != 0x80U) {
      ++at.column;
    }
  }
  return at;
}

std::optional<SyntaxFault> FindForeignByte(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const std::size_t size = ByteAt(text, i) < 0x80U ? 1 : CharacterSize(text.substr(i));
    if (size == 0) {
      char message[64];
      std::snprintf(message, sizeof message, "expected UTF-8, found the byte 0x%02X",
                    ByteAt(text, i));
      return SyntaxFault{PositionAt(text, i), message};
    }
    i += size;
  }
  return std::nullopt;
}

// Scans TOML without parsing it: recognises strings and comments, counts the rest. Its result for a
// text that is not TOML does not matter: the parser stops at the first syntax error.
class LimitScanner {
 public:
  explicit LimitScanner(std::string_view text) : text_(text) {}

  std::optional<SyntaxFault> Scan() {
    while (at_ < text_.size()) {
      const std::size_t start = at_;
      Step();
      if (const char* fault = Exceeded()) return SyntaxFault{PositionAt(text_, start), fault};
    }
    return std::nullopt;
  }

 private:
  void Step() {
    const char c = text_[at_];
    if (c == '"' || c == '\'') return SkipString(c);
    if (c == '#') return SkipTo('\n');
    ++at_;
    if (c == '.') {
      ++dots_;
      ++key_parts_;
    } else if (c == '=' || c == ',' || c == '[' || c == '{') {
      ++entries_;
      key_parts_ = 1;
      if (c == '[' || c == '{') ++nesting_;
    } else if (c == ']' || c == '}') {
      key_parts_ = 1;
      if (nesting_ > 0) --nesting_;
    } else if (c == '\n') {
      key_parts_ = 1;
    }
  }

  void SkipString(char quote) {
    const std::string fence(3, quote);
    const bool many_lines = text_.substr(at_).starts_with(fence);
    at_ += many_lines ? 3 : 1;
    while (at_ < text_.size()) {
      if (quote == '"' && text_[at_] == '\\') {
        at_ += 2;
      } else if (many_lines && text_.substr(at_).starts_with(fence)) {
        at_ += 3;
        while (at_ < text_.size() && text_[at_] == quote) ++at_;  // """ may follow up to two quotes
        return;
      } else if (!many_lines && (text_[at_] == quote || text_[at_] == '\n')) {
        ++at_;
        return;
      } else {
        ++at_;
      }
    }
  }

  void SkipTo(char end) {
    while (at_ < text_.size() && text_[at_] != end) ++at_;
  }

  const char* Exceeded() const {
    if (nesting_ > kDeepestNesting) return "arrays and tables are nested too deeply (at most 32)";
    if (key_parts_ > kMostKeyParts) return "the key has too many parts (at most 32)";
    if (dots_ > kMostDots) return "the file has too many dotted keys (at most 50000)";
    if (entries_ > kMostEntries) return "the file has too many entries (at most 500000)";
    return nullptr;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int nesting_ = 0;
  int key_parts_ = 1;
  int dots_ = 0;
  int entries_ = 0;
};

}  // namespace

std::size_t CharacterSize(std::string_view text) {
  if (text.empty()) return 0;
  const unsigned first = ByteAt(text, 0);
  if (first < 0x80U) return 1;
  const std::size_t size = first >= 0xF0U ? 4 : first >= 0xE0U ? 3 : 2;
  if (first < 0xC2U || first > 0xF4U || text.size() < size) return 0;
  std::uint32_t code = first & (0xFFU >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if ((ByteAt(text, i) & 0xC0U) != 0x80U) return 0;
    code = code << 6U | (ByteAt(text, i) & 0x3FU);
  }
  const bool too_long = (size == 3 && code < 0x800U) || (size == 4 && code < 0x10000U);
  const bool surrogate = code >= 0xD800U && code <= 0xDFFFU;
  return too_long || surrogate || code > 0x10FFFFU ? 0 : size;
}

std::optional<SyntaxFault> FindTextFault(std::string_view text) {
  if (std::optional<SyntaxFault> fault = FindForeignByte(text)) return fault;
  return LimitScanner(text).Scan();
}

}  // namespace musher::config_toml
