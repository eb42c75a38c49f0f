#pragma once
// Gathers the faults and warnings of one config.

#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/diagnostic.hpp"
#include "musher/lifecycle/toml/document.hpp"

namespace musher::config_toml {

// So many diagnostics are given; further ones are only counted.
inline constexpr std::size_t kMostDiagnostics = 200;

class Findings {
 public:
  void Error(Position at, std::string message);
  void Warning(Position at, std::string message);
  bool HasErrors() const { return errors_ > 0; }

  // "; did you mean ...?" or nothing. Falls silent once a file has had more guesses than anyone
  // would read, since each costs a look at every candidate.
  std::string Guess(std::string_view word, const std::vector<std::string_view>& candidates);

  // Everything found, by line and with columns in bytes of `text`. Where there is too much the
  // warnings go first, and a last line says how many are not shown.
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
  std::size_t guesses_ = 0;  // candidates looked at
};

// `word` in quotation marks, escaped as TOML does it and shortened.
std::string Quote(std::string_view word);

// "a, b and c".
std::string Listing(const std::vector<std::string_view>& words);

}  // namespace musher::config_toml
