#include "musher/modules/meilin/plan/json_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "musher/base/suggest.hpp"

namespace musher::meilin {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostJsonBytes = std::size_t{1} << 20;
constexpr int kMostJsonLevels = 32;

// Whether objects and arrays are nested so deeply that code which visits them by recursion would
// use up its stack. Of a text that is no JSON it may say anything.
bool IsTooDeep(std::string_view text) {
  int level = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\') ++i;
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '{' || c == '[') ++level;
    if (c == '}' || c == ']') --level;
    if (level > kMostJsonLevels) return true;
  }
  return false;
}

std::string LinePlace(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte == 0 ? 0 : byte - 1);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t newline = before.rfind('\n');
  const std::size_t column = before.size() - (newline == before.npos ? 0 : newline + 1) + 1;
  return fmt::format("line {}, column {}", line, column);
}

// Without the prefix that nlohmann puts before it.
std::string ReasonOf(const Json::exception& error) {
  std::string reason = error.what();
  for (const std::string_view before : {"] ", "syntax error "}) {
    const std::size_t at = reason.find(before);
    if (at != std::string::npos) reason.erase(0, at + before.size());
  }
  constexpr std::size_t kLongest = 200;
  if (reason.size() > kLongest) reason.resize(kLongest);
  return reason;
}

std::string Short(const std::string& word) {
  constexpr std::size_t kLongest = 60;
  return word.size() <= kLongest ? word : word.substr(0, kLongest) + "...";
}

}  // namespace

void JsonFaults::Add(const std::string& path, const std::string& message) {
  if (list_.size() < kMostJsonFaults)
    list_.push_back(path.empty() ? message : path + ": " + message);
}

std::optional<Json> ParseJson(std::string_view text, JsonFaults& faults) {
  if (text.size() > kMostJsonBytes) {
    faults.Add(
        "", fmt::format("the text has {} bytes, expected at most {}", text.size(), kMostJsonBytes));
    return std::nullopt;
  }
  if (IsTooDeep(text)) {
    faults.Add("",
               fmt::format("objects and arrays are nested deeper than {} levels", kMostJsonLevels));
    return std::nullopt;
  }
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    faults.Add(LinePlace(text, error.byte), "invalid JSON: " + ReasonOf(error));
  } catch (const Json::exception& error) {
    faults.Add("", "invalid JSON: " + ReasonOf(error));
  }
  return std::nullopt;
}

std::string_view JsonTypeName(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array";
  if (value.is_string()) return "a string";
  if (value.is_boolean()) return "a boolean";
  if (value.is_null()) return "null";
  return "a number";
}

JsonObject::JsonObject(const Json& value, std::string path, JsonFaults& faults)
    : path_(std::move(path)), faults_(faults) {
  if (value.is_object()) {
    object_ = &value;
  } else {
    faults_.Add(path_, fmt::format("expected an object, found {}", JsonTypeName(value)));
  }
}

std::string JsonObject::PathOf(std::string_view key) const {
  return (path_.empty() ? "" : path_ + ".") + std::string(key);
}

void JsonObject::Fault(std::string_view key, const std::string& message) {
  faults_.Add(PathOf(key), message);
}

void JsonObject::Mismatch(std::string_view key, const std::string& expected, const Json& found) {
  const bool plain = found.is_number() || found.is_boolean();
  Fault(key, fmt::format("expected {}, found {}", expected,
                         plain ? found.dump() : std::string(JsonTypeName(found))));
}

const Json* JsonObject::Get(std::string_view key) {
  read_.push_back(key);
  if (object_ == nullptr) return nullptr;
  const auto found = object_->find(std::string(key));
  return found == object_->end() ? nullptr : &*found;
}

void JsonObject::Require(std::string_view key, std::string_view expected) {
  if (object_ != nullptr && Get(key) == nullptr) {
    Fault(key, fmt::format("missing, expected {}", expected));
  }
}

std::optional<double> JsonObject::Number(std::string_view key, double least, double most) {
  const Json* value = Get(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_number()) {
    const auto number = value->get<double>();
    if (number >= least && number <= most) return number;
  }
  Mismatch(key, fmt::format("a number from {:g} to {:g}", least, most), *value);
  return std::nullopt;
}

std::optional<int> JsonObject::Integer(std::string_view key, int least, int most) {
  const Json* value = Get(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_number_integer()) {
    const auto number = value->get<double>();  // a double also where it is too large for an int
    if (number >= least && number <= most) return static_cast<int>(number);
  }
  Mismatch(key, fmt::format("a whole number from {} to {}", least, most), *value);
  return std::nullopt;
}

std::optional<bool> JsonObject::Bool(std::string_view key) {
  const Json* value = Get(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_boolean()) return value->get<bool>();
  Mismatch(key, "true or false", *value);
  return std::nullopt;
}

std::optional<std::string> JsonObject::String(std::string_view key) {
  const Json* value = Get(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_string()) return value->get<std::string>();
  Mismatch(key, "a string", *value);
  return std::nullopt;
}

std::optional<std::size_t> JsonObject::Choice(std::string_view key,
                                              const std::vector<std::string_view>& words) {
  const std::optional<std::string> text = String(key);
  if (!text) return std::nullopt;
  const auto found = std::find(words.begin(), words.end(), *text);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  Fault(key, fmt::format("unknown value '{}'{}, expected {}", Short(*text),
                         DidYouMean(*text, words), fmt::join(words, ", ")));
  return std::nullopt;
}

void JsonObject::RefuseOthers() {
  if (object_ == nullptr) return;
  for (const auto& item : object_->items()) {
    if (std::find(read_.begin(), read_.end(), item.key()) != read_.end()) continue;
    faults_.Add(PathOf(Short(item.key())), "unknown key" + DidYouMean(item.key(), read_));
  }
}

}  // namespace musher::meilin
