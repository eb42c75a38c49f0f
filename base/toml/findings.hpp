#pragma once
// Collects the errors and warnings of one config.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/toml/document.hpp"

namespace musher::config_toml {

// At most this many diagnostics are given; further ones are only counted.
inline constexpr std::size_t kMostDiagnostics = 200;

class Findings {
 public:
  void Error(Position at, std::string message);
  void Warning(Position at, std::string message);
  bool HasErrors() const { return errors_ > 0; }

  // "; did you mean ...?" or nothing. Gives nothing once a file has had too many guesses, since
  // each costs a comparison with every candidate.
  std::string Guess(std::string_view word, const std::vector<std::string_view>& candidates);

  // All diagnostics, by line and with columns in bytes of `text`. Where there are too many,
  // warnings are dropped first, and a last line reports how many are not shown.
  std::vector<Diagnostic> Take(const std::string& file, std::string_view text) &&;

 private:
  struct Finding {
    Position at;
    Severity severity;
    std::string message;
  };

  void Add(Position at, Severity severity, std::string message);

  std::vector<Finding> found_;
  std::size_t errors_ = 0;
  std::size_t total_ = 0;
  std::size_t guesses_ = 0;  // candidates compared
};

// `word` in quotation marks, escaped as in TOML and shortened.
std::string Quote(std::string_view word);

// "a, b and c".
std::string Listing(const std::vector<std::string_view>& words);

}  // namespace musher::config_toml
