#pragma once
// Reads the keys of one table and reports errors in their values. The keys that are read are the
// known keys; RefuseOthers() reports all other keys of the table.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/toml/document.hpp"
#include "musher/base/toml/findings.hpp"

namespace musher::config_toml {

// A string of the file and its position.
struct Word {
  std::string text;
  Position at;
};

inline constexpr std::int64_t kLongestMs = 3'600'000;  // an hour; more is a typing error

struct ListRule {
  bool may_be_empty = false;
  bool may_repeat = false;
};

// Which names TableReader::Topic() permits. Services and actions have names of the same form.
struct TopicRule {
  std::string_view of = "a topic";  // what has the name, in messages
  bool relative = false;            // to the namespace: not "/scan"
  bool may_be_empty = false;        // for none
};

// Each reading function gives nothing where the key is missing, which is an error only after
// Require(), or where its value is invalid, which it reports.
class TableReader {
 public:
  // `path` names the table in messages: "controller", "actuator.audio", "" for the file itself.
  // `at` is the position of the table. The table and the findings must outlive the reader.
  TableReader(const Table& table, Position at, std::string path, Findings& findings);

  // Reports `key` as missing unless the table has it.
  void Require(std::string_view key, std::string_view expected);

  std::optional<Word> String(std::string_view key);
  std::optional<std::int64_t> Integer(std::string_view key, std::int64_t least, std::int64_t most,
                                      std::string_view unit = "");
  std::optional<Duration> Time(std::string_view key, std::int64_t least_ms = 1);
  std::optional<double> Number(std::string_view key, double least, double most);
  std::optional<bool> Bool(std::string_view key);
  // `example` is a name that a topic of this key has, in messages.
  std::optional<Word> Topic(std::string_view key, std::string_view example,
                            const TopicRule& rule = {});
  // The valid elements; invalid and repeated ones are reported and left out.
  std::optional<std::vector<Word>> Strings(std::string_view key, ListRule rule = {});
  std::optional<std::vector<Duration>> Times(std::string_view key);
  std::optional<std::vector<std::int64_t>> Integers(std::string_view key, std::int64_t least,
                                                    std::int64_t most,
                                                    ListRule rule = {.may_repeat = true});
  const Table* SubTable(std::string_view key);
  // The same with a reader, whose path is this table's path and the key.
  std::optional<TableReader> Sub(std::string_view key);
  // The tables of an array of tables.
  std::vector<const Value*> Tables(std::string_view key);
  // The same with readers, whose path is this table's path and the key.
  std::vector<TableReader> Subs(std::string_view key);
  // A string or an array of strings.
  std::optional<std::vector<Word>> StringOrStrings(std::string_view key);
  // One of a few words, each with its meaning.
  template <typename T>
  std::optional<T> Choice(std::string_view key,
                          const std::vector<std::pair<std::string_view, T>>& choices);
  // A list of such words.
  template <typename T>
  std::optional<std::vector<T>> Choices(std::string_view key,
                                        const std::vector<std::pair<std::string_view, T>>& choices,
                                        ListRule rule = {});

  // Reports every key that was not read.
  void RefuseOthers();

  const Value* Get(std::string_view key);
  bool Has(std::string_view key) { return Get(key) != nullptr; }
  // Whether the key has been read.
  bool Knows(std::string_view key) const;
  // Whether Fault() has reported the key.
  bool IsFaulty(std::string_view key) const;
  // The position of the value of `key`, or of the table where the key is missing.
  Position At(std::string_view key);
  // Puts the table's path and the key before `message`.
  void Fault(Position at, std::string_view key, std::string_view message);
  void Warn(Position at, std::string_view key, std::string_view message);

  const std::string& path() const { return path_; }
  Position at() const { return at_; }

 private:
  const Member* Lookup(std::string_view key);
  void Mismatch(std::string_view key, std::string_view expected, const Value& found);
  std::optional<std::string> Text(std::string_view key, const Value& value);
  std::optional<std::int64_t> InRange(std::string_view key, const Value& value, std::int64_t least,
                                      std::int64_t most, std::string_view unit);
  std::optional<std::size_t> OneOf(std::string_view key, const Word& word,
                                   const std::vector<std::string_view>& words);
  std::string Path(std::string_view key) const;

  const Table& table_;
  Position at_;
  std::string path_;
  Findings& findings_;
  std::vector<std::string> read_keys_;
  std::vector<std::string> faulty_keys_;
};

template <typename T>
std::optional<T> TableReader::Choice(std::string_view key,
                                     const std::vector<std::pair<std::string_view, T>>& choices) {
  std::vector<std::string_view> words;
  words.reserve(choices.size());
  for (const auto& [word, meaning] : choices) words.push_back(word);
  const std::optional<Word> found = String(key);
  const auto index = found ? OneOf(key, *found, words) : std::nullopt;
  if (!index) return std::nullopt;
  return choices[*index].second;
}

template <typename T>
std::optional<std::vector<T>> TableReader::Choices(
    std::string_view key, const std::vector<std::pair<std::string_view, T>>& choices,
    ListRule rule) {
  std::vector<std::string_view> words;
  words.reserve(choices.size());
  for (const auto& [word, meaning] : choices) words.push_back(word);
  const auto found = Strings(key, rule);
  if (!found) return std::nullopt;
  std::vector<T> chosen;
  for (const Word& word : *found) {
    if (const auto index = OneOf(key, word, words)) chosen.push_back(choices[*index].second);
  }
  return chosen;
}

}  // namespace musher::config_toml
