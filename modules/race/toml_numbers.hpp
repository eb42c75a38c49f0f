#pragma once
// The numbers of a TOML text, read and changed in their places: comments and the layout stay as
// they are. For the files of this repository, where a step has a line of its own; base/toml reads
// any.
//
// Threads: a plain value. Errors: nothing where a place is not found.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace musher::race {

class TomlNumbers {
 public:
  // In the table of the header [table], or in those of the [[entry]] with name = "table", the value
  // of `key` in the `nth` line, from 0, that has it and contains `beside`.
  struct Place {
    std::string_view table;
    std::string_view beside;
    std::string_view key;
    int nth = 0;
  };

  explicit TomlNumbers(std::string_view text);

  std::optional<double> Get(const Place& place) const;
  // False where there is no such place.
  bool Set(const Place& place, const std::string& number);
  std::string text() const;

 private:
  struct Span {
    std::size_t line = 0;
    std::size_t begin = 0;
    std::size_t length = 0;
  };

  std::optional<Span> Find(const Place& place) const;

  std::vector<std::string> lines_;
};

}  // namespace musher::race
