#include "musher/base/toml/table_reader.hpp"

#include <algorithm>
#include <unordered_map>

#include "musher/base/toml/names.hpp"

namespace musher::config_toml {
namespace {

std::string Expected(std::string_view expected, const Value& found) {
  return "expected " + std::string(expected) + ", found " + std::string(TypeName(found));
}

std::string NumberText(double number) {
  std::string text = std::to_string(number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

}  // namespace

TableReader::TableReader(const Table& table, Position at, std::string path, Findings& findings)
    : table_(table), at_(at), path_(std::move(path)), findings_(findings) {}

void TableReader::Require(std::string_view key, std::string_view expected) {
  if (Has(key)) return;
  findings_.Error(at_, (path_.empty() ? "" : path_ + ": ") + "the key \"" + std::string(key) +
                           "\" is missing; expected " + std::string(expected));
}

std::optional<Word> TableReader::String(std::string_view key) {
  const Value* value = Get(key);
  if (value == nullptr) return std::nullopt;
  std::optional<std::string> text = Text(key, *value);
  if (!text) return std::nullopt;
  return Word{*std::move(text), value->at};
}

std::optional<std::int64_t> TableReader::Integer(std::string_view key, std::int64_t least,
                                                 std::int64_t most, std::string_view unit) {
  const Value* value = Get(key);
  return value == nullptr ? std::nullopt : InRange(key, *value, least, most, unit);
}

std::optional<Duration> TableReader::Time(std::string_view key, std::int64_t least_ms) {
  const std::optional<std::int64_t> ms = Integer(key, least_ms, kLongestMs, " (milliseconds)");
  if (!ms) return std::nullopt;
  return Milliseconds(*ms);
}

std::optional<double> TableReader::Number(std::string_view key, double least, double most) {
  const Value* value = Get(key);
  if (value == nullptr) return std::nullopt;
  const auto* integer = value->As<std::int64_t>();
  const auto* number = value->As<double>();
  const std::string expected = "a number from " + NumberText(least) + " to " + NumberText(most);
  if (integer == nullptr && number == nullptr) {
    Mismatch(key, expected, *value);
    return std::nullopt;
  }
  const double found = number != nullptr ? *number : static_cast<double>(*integer);
  if (found >= least && found <= most) return found;  // never true for nan
  Fault(value->at, key, "expected " + expected + ", found " + NumberText(found));
  return std::nullopt;
}

std::optional<bool> TableReader::Bool(std::string_view key) {
  const Value* value = Get(key);
  if (value == nullptr) return std::nullopt;
  if (const auto* boolean = value->As<bool>()) return *boolean;
  Mismatch(key, "true or false", *value);
  return std::nullopt;
}

std::optional<Word> TableReader::Topic(std::string_view key, std::string_view example,
                                       const TopicRule& rule) {
  std::optional<Word> name = String(key);
  if (!name || (rule.may_be_empty && name->text.empty())) return name;
  if (rule.relative ? IsRelativeTopic(name->text) : IsTopic(name->text)) return name;
  Fault(name->at, key,
        "expected the name of " + std::string(rule.of) +
            (rule.relative ? " relative to the namespace" : "") + ", as in " + Quote(example) +
            (rule.may_be_empty ? ", or \"\" for none" : "") + ", found " + Quote(name->text));
  return std::nullopt;
}

std::optional<std::vector<Word>> TableReader::Strings(std::string_view key, ListRule rule) {
  const Value* value = Get(key);
  if (value == nullptr) return std::nullopt;
  const auto* array = value->As<Array>();
  if (array == nullptr) {
    Mismatch(key, "an array of strings", *value);
    return std::nullopt;
  }
  if (array->empty() && !rule.may_be_empty) {
    Fault(value->at, key, "expected at least one string, found an empty array");
    return std::nullopt;
  }
  std::vector<Word> words;
  words.reserve(array->size());
  std::unordered_map<std::string_view, int> first_lines;
  for (const Value& item : *array) {
    std::optional<std::string> text = Text(key, item);
    if (!text) continue;
    const std::string_view view = *item.As<std::string>();
    const auto [first, is_new] = first_lines.emplace(view, item.at.line);
    if (!is_new && !rule.may_repeat) {
      Fault(item.at, key,
            Quote(view) + " is listed twice, first in line " + std::to_string(first->second));
      continue;
    }
    words.push_back({*std::move(text), item.at});
  }
  return words;
}

std::vector<const Value*> TableReader::Tables(std::string_view key) {
  const Value* value = Get(key);
  if (value == nullptr) return {};
  const std::string expected = "tables that begin with [[" + std::string(key) + "]]";
  const auto* array = value->As<Array>();
  if (array == nullptr) {
    Mismatch(key, expected, *value);
    return {};
  }
  if (array->empty()) Fault(value->at, key, "expected " + expected + ", found an empty array");
  std::vector<const Value*> tables;
  for (const Value& item : *array) {
    if (item.As<Table>() != nullptr) {
      tables.push_back(&item);
    } else {
      Mismatch(key, expected, item);
    }
  }
  return tables;
}

std::optional<std::vector<Word>> TableReader::StringOrStrings(std::string_view key) {
  const Value* value = Get(key);
  if (value == nullptr) return std::nullopt;
  if (value->As<Array>() != nullptr) return Strings(key);
  if (value->As<std::string>() == nullptr) {
    Mismatch(key, "a string or an array of strings", *value);
    return std::nullopt;
  }
  std::optional<Word> word = String(key);
  if (!word) return std::nullopt;
  return std::vector<Word>{*std::move(word)};
}

std::optional<std::vector<Duration>> TableReader::Times(std::string_view key) {
  const Value* value = Get(key);
  if (value == nullptr) return std::nullopt;
  const auto* array = value->As<Array>();
  if (array == nullptr) {
    Mismatch(key, "an array of integers (milliseconds)", *value);
    return std::nullopt;
  }
  if (array->empty()) {
    Fault(value->at, key, "expected one time for each state, found an empty array");
    return std::nullopt;
  }
  std::vector<Duration> times;
  times.reserve(array->size());
  for (const Value& item : *array) {
    const auto ms = InRange(key, item, 1, kLongestMs, " (milliseconds)");
    if (ms) times.push_back(Milliseconds(*ms));
  }
  return times;
}

std::optional<std::vector<std::int64_t>> TableReader::Integers(std::string_view key,
                                                               std::int64_t least,
                                                               std::int64_t most, ListRule rule) {
  const Value* value = Get(key);
  if (value == nullptr) return std::nullopt;
  const auto* array = value->As<Array>();
  if (array == nullptr) {
    Mismatch(key, "an array of integers", *value);
    return std::nullopt;
  }
  if (array->empty() && !rule.may_be_empty) {
    Fault(value->at, key, "expected one integer or more, found an empty array");
    return std::nullopt;
  }
  std::vector<std::int64_t> integers;
  for (const Value& item : *array) {
    const auto integer = InRange(key, item, least, most, "");
    if (!integer) continue;
    const bool is_new = std::find(integers.begin(), integers.end(), *integer) == integers.end();
    if (is_new || rule.may_repeat) {
      integers.push_back(*integer);
    } else {
      Fault(item.at, key, std::to_string(*integer) + " is listed twice");
    }
  }
  return integers;
}

const Table* TableReader::SubTable(std::string_view key) {
  const Value* value = Get(key);
  if (value == nullptr) return nullptr;
  const auto* table = value->As<Table>();
  if (table == nullptr) Mismatch(key, "a table", *value);
  return table;
}

std::optional<TableReader> TableReader::Sub(std::string_view key) {
  const Table* table = SubTable(key);
  if (table == nullptr) return std::nullopt;
  return TableReader(*table, At(key), Path(key), findings_);
}

std::vector<TableReader> TableReader::Subs(std::string_view key) {
  std::vector<TableReader> readers;
  for (const Value* table : Tables(key)) {
    readers.emplace_back(*table->As<Table>(), table->at, Path(key), findings_);
  }
  return readers;
}

void TableReader::RefuseOthers() {
  const std::vector<std::string_view> known(read_keys_.begin(), read_keys_.end());
  for (const Member& member : table_) {
    if (Knows(member.key)) continue;
    std::string message = "unknown key " + Quote(member.key);
    const std::string guess = findings_.Guess(member.key, known);
    message += guess.empty() ? "; expected one of " + Listing(known) : guess;
    findings_.Error(member.at, (path_.empty() ? "" : path_ + ": ") + message);
  }
}

bool TableReader::Knows(std::string_view key) const {
  return std::find(read_keys_.begin(), read_keys_.end(), key) != read_keys_.end();
}

const Value* TableReader::Get(std::string_view key) {
  const Member* member = Lookup(key);
  return member == nullptr ? nullptr : &member->value;
}

bool TableReader::IsFaulty(std::string_view key) const {
  return std::find(faulty_keys_.begin(), faulty_keys_.end(), key) != faulty_keys_.end();
}

Position TableReader::At(std::string_view key) {
  const Value* value = Get(key);
  return value == nullptr ? at_ : value->at;
}

void TableReader::Fault(Position at, std::string_view key, std::string_view message) {
  findings_.Error(at, Path(key) + ": " + std::string(message));
  faulty_keys_.emplace_back(key);
}

void TableReader::Warn(Position at, std::string_view key, std::string_view message) {
  findings_.Warning(at, Path(key) + ": " + std::string(message));
}

const Member* TableReader::Lookup(std::string_view key) {
  if (std::find(read_keys_.begin(), read_keys_.end(), key) == read_keys_.end())
    read_keys_.emplace_back(key);
  return Find(table_, key);
}

void TableReader::Mismatch(std::string_view key, std::string_view expected, const Value& found) {
  Fault(found.at, key, Expected(expected, found));
}

std::optional<std::string> TableReader::Text(std::string_view key, const Value& value) {
  const auto* text = value.As<std::string>();
  if (text == nullptr) {
    Mismatch(key, "a string", value);
    return std::nullopt;
  }
  if (text->find('\0') != std::string::npos) {
    Fault(value.at, key, "expected a string without NUL characters, found " + Quote(*text));
    return std::nullopt;
  }
  return *text;
}

std::optional<std::int64_t> TableReader::InRange(std::string_view key, const Value& value,
                                                 std::int64_t least, std::int64_t most,
                                                 std::string_view unit) {
  const auto* integer = value.As<std::int64_t>();
  if (integer != nullptr && *integer >= least && *integer <= most) return *integer;
  const std::string expected = "an integer from " + std::to_string(least) + " to " +
                               std::to_string(most) + std::string(unit);
  if (integer == nullptr) {
    Mismatch(key, expected, value);
  } else {
    Fault(value.at, key, "expected " + expected + ", found " + std::to_string(*integer));
  }
  return std::nullopt;
}

std::optional<std::size_t> TableReader::OneOf(std::string_view key, const Word& word,
                                              const std::vector<std::string_view>& words) {
  const auto found = std::find(words.begin(), words.end(), word.text);
  if (found != words.end()) return found - words.begin();
  const std::string guess = findings_.Guess(word.text, words);
  Fault(word.at, key, "expected one of " + Listing(words) + ", found " + Quote(word.text) + guess);
  return std::nullopt;
}

// A key that needs quotes in TOML is shown in quotes: it may contain any character, also line ends.
std::string TableReader::Path(std::string_view key) const {
  constexpr std::string_view kBare =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  const bool bare = !key.empty() && key.find_first_not_of(kBare) == std::string_view::npos;
  const std::string shown = bare ? std::string(key) : Quote(key);
  return path_.empty() ? shown : path_ + "." + shown;
}

}  // namespace musher::config_toml
