#pragma once
// Reads objects of a JSON text and names the place of each error, as in "segments[2].max_speed".
// Only sources include it, because nlohmann's header is large.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace musher::meilin {

inline constexpr std::size_t kMostJsonFaults = 50;  // reported of one text

// Sentences with their places.
class JsonFaults {
 public:
  // `path`: "segments[2].max_speed"; empty: the text as a whole.
  void Add(const std::string& path, const std::string& message);
  const std::vector<std::string>& list() const { return list_; }
  bool empty() const { return list_.empty(); }

 private:
  std::vector<std::string> list_;
};

// Nothing, with a fault that has line and column, if the text is not JSON.
std::optional<nlohmann::json> ParseJson(std::string_view text, JsonFaults& faults);

// "a number", "an object", …
std::string_view JsonTypeName(const nlohmann::json& value);

// Each reading function gives nothing where the key is missing, or where its value is invalid,
// which it reports. RefuseOthers() reports all keys that were not read.
class JsonObject {
 public:
  // `value` and `faults` must outlive it. Anything but an object is reported.
  JsonObject(const nlohmann::json& value, std::string path, JsonFaults& faults);

  void Require(std::string_view key, std::string_view expected);
  const nlohmann::json* Get(std::string_view key);
  std::optional<double> Number(std::string_view key, double least, double most);
  std::optional<int> Integer(std::string_view key, int least, int most);
  std::optional<bool> Bool(std::string_view key);
  std::optional<std::string> String(std::string_view key);
  // The index of the text in `words`.
  std::optional<std::size_t> Choice(std::string_view key,
                                    const std::vector<std::string_view>& words);
  void RefuseOthers();

  std::string PathOf(std::string_view key) const;
  void Fault(std::string_view key, const std::string& message);

 private:
  void Mismatch(std::string_view key, const std::string& expected, const nlohmann::json& found);

  const nlohmann::json* object_ = nullptr;  // null: it is none
  std::string path_;
  JsonFaults& faults_;
  std::vector<std::string_view> read_;
};

}  // namespace musher::meilin
