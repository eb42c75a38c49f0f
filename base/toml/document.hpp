#pragma once
// A TOML text as a tree of values with their positions. Only document.cpp uses toml++; everything
// else works on this tree.

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace musher::config_toml {

struct Position {
  int line = 0;    // from 1; 0: the file as a whole
  int column = 0;  // from 1, in characters (not bytes)

  friend bool operator<(const Position& a, const Position& b) {
    return std::pair(a.line, a.column) < std::pair(b.line, b.column);
  }
};

struct Value;
struct Member;
struct DateOrTime {};

using Array = std::vector<Value>;
using Table = std::vector<Member>;  // in the order of the file

struct Value {
  std::variant<DateOrTime, bool, std::int64_t, double, std::string, Array, Table> content;
  Position at;

  template <typename T>
  const T* As() const {
    return std::get_if<T>(&content);
  }
};

struct Member {
  std::string key;
  Position at;  // of the key
  Value value;
};

const Member* Find(const Table& table, std::string_view key);

// "a string", "an integer", ..., for messages.
std::string_view TypeName(const Value& value);

// Why a text is not valid TOML.
struct SyntaxFault {
  Position at;
  std::string message;
};

// Never throws. Only the first error is reported: the text after it cannot be parsed.
std::variant<Table, SyntaxFault> ParseDocument(std::string_view text);

}  // namespace musher::config_toml
