#include "musher/base/toml/findings.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/base/toml/text.hpp"

namespace musher::config_toml {
namespace {

constexpr std::size_t kMostKept = 20'000;      // reached only by the output of a broken generator
constexpr std::size_t kMostGuesses = 500'000;  // candidates compared
constexpr std::size_t kLongestQuote = 80;      // bytes

// Walks over a text once, from position to position.
class ByteColumns {
 public:
  explicit ByteColumns(std::string_view text) : text_(text) {}

  // The column of `at` in bytes; positions must come in order.
  int Of(Position at) {
    while (walked_.line < at.line) {
      const std::size_t end = text_.find('\n', offset_);
      if (end == std::string_view::npos) return at.column;
      offset_ = line_start_ = end + 1;
      walked_ = {walked_.line + 1, 1};
    }
    while (walked_.column < at.column && offset_ < text_.size() && text_[offset_] != '\n') {
      offset_ += std::max<std::size_t>(CharacterSize(text_.substr(offset_)), 1);
      ++walked_.column;
    }
    return static_cast<int>(offset_ - line_start_) + 1 + (at.column - walked_.column);
  }

 private:
  std::string_view text_;
  std::size_t offset_ = 0;
  std::size_t line_start_ = 0;
  Position walked_{1, 1};
};

std::string CountText(std::size_t errors, std::size_t warnings) {
  const auto count = [](std::size_t n, const std::string& noun) {
    return std::to_string(n) + " more " + noun + (n == 1 ? "" : "s");
  };
  if (warnings == 0) return count(errors, "error");
  if (errors == 0) return count(warnings, "warning");
  return count(errors, "error") + " and " + count(warnings, "warning");
}

}  // namespace

void Findings::Error(Position at, std::string message) {
  Add(at, Severity::kError, std::move(message));
}

void Findings::Warning(Position at, std::string message) {
  Add(at, Severity::kWarning, std::move(message));
}

void Findings::Add(Position at, Severity severity, std::string message) {
  ++total_;
  if (severity == Severity::kError) ++errors_;
  if (found_.size() >= kMostKept && (severity != Severity::kError || errors_ > kMostDiagnostics)) {
    return;
  }
  found_.push_back({at, severity, std::move(message)});
}

std::string Findings::Guess(std::string_view word,
                            const std::vector<std::string_view>& candidates) {
  guesses_ += candidates.size();
  if (guesses_ > kMostGuesses) return {};
  const std::string nearest = Nearest(word, candidates);
  return nearest.empty() ? std::string() : DidYouMean(Quote(nearest));
}

std::vector<Diagnostic> Findings::Take(const std::string& file, std::string_view text) && {
  const auto by_place = [](const Finding& a, const Finding& b) { return a.at < b.at; };
  std::stable_sort(found_.begin(), found_.end(), by_place);
  std::size_t shown_errors = errors_;
  if (total_ > kMostDiagnostics) {
    std::stable_partition(found_.begin(), found_.end(),
                          [](const Finding& f) { return f.severity == Severity::kError; });
    found_.resize(std::min(found_.size(), kMostDiagnostics));
    std::stable_sort(found_.begin(), found_.end(), by_place);
    shown_errors = std::min(errors_, kMostDiagnostics);
  }
  ByteColumns columns(text);
  std::vector<Diagnostic> diagnostics;
  diagnostics.reserve(found_.size() + 1);
  for (Finding& f : found_) {
    const int column = f.at.line > 0 ? columns.Of(f.at) : 0;
    diagnostics.push_back({file, f.at.line, column, f.severity, std::move(f.message)});
  }
  if (total_ > found_.size()) {
    const std::size_t hidden_errors = errors_ - shown_errors;
    const std::size_t hidden_warnings = total_ - found_.size() - hidden_errors;
    const Severity severity = hidden_errors > 0 ? Severity::kError : Severity::kWarning;
    diagnostics.push_back({file, 0, 0, severity, CountText(hidden_errors, hidden_warnings)});
  }
  return diagnostics;
}

std::string Quote(std::string_view word) {
  std::string quoted = "\"";
  for (std::size_t i = 0; i < word.size();) {
    const std::size_t size = std::max<std::size_t>(CharacterSize(word.substr(i)), 1);
    const auto byte = static_cast<unsigned char>(word[i]);
    if (i + size > kLongestQuote) {
      quoted += "...";
      break;
    }
    if (byte < 0x20 || byte == 0x7F) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04X", byte);
      quoted += escape;
    } else {
      if (word[i] == '"' || word[i] == '\\') quoted += '\\';
      quoted += word.substr(i, size);
    }
    i += size;
  }
  return quoted + "\"";
}

std::string Listing(const std::vector<std::string_view>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " and " : ", ";
    text += words[i];
  }
  return text;
}

}  // namespace musher::config_toml
