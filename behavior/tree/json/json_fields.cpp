#include "musher/behavior/tree/json/json_fields.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "musher/behavior/tree/json/json_places.hpp"

namespace musher::tree::internal {
namespace {

constexpr double kExactWholeNumbers = 0x1p53;

}  // namespace

struct JsonReader::State {
  nlohmann::json json;
  struct Level {
    const nlohmann::json* value = nullptr;
    std::string name;              // ".x_m" or "[2]"
    std::set<std::string> read{};  // fields of an object
  };
  std::vector<Level> levels{};

  const nlohmann::json& value() const { return *levels.back().value; }
  std::string Path() const {
    std::string path;
    for (const Level& level : levels) path += level.name;
    return path.starts_with('.') ? path.substr(1) : path;
  }
};

JsonReader::JsonReader(std::string_view json) : state_(std::make_unique<State>()) {
  if (IsTooLargeJson(json)) {
    state_->json = nlohmann::json::value_t::discarded;
    error_ = "the JSON is larger than 1 MiB, or nested deeper than 100";
  } else {
    state_->json = nlohmann::json::parse(json, nullptr, false);
    if (state_->json.is_discarded()) error_ = "it is no JSON";
  }
  state_->levels.push_back({&state_->json, ""});
}

JsonReader::~JsonReader() = default;

void JsonReader::Fail(const std::string& why) {
  if (!error_.empty()) return;
  const std::string path = state_->Path();
  error_ = path.empty() ? "the JSON " + why : "the JSON field '" + path + "' " + why;
}

void JsonReader::Expect(std::string_view what) {
  Fail("is " + std::string(state_->value().type_name()) + "; expected " + std::string(what));
}

bool JsonReader::Enter(std::string_view field) {
  if (!error_.empty()) return false;
  const std::string name(field);
  State::Level& level = state_->levels.back();
  level.read.insert(name);
  const auto found = level.value->find(name);
  const bool is_there = found != level.value->end();
  state_->levels.push_back({is_there ? &*found : level.value, "." + name});
  if (is_there) return true;
  Fail("is missing");
  Leave();
  return false;
}

void JsonReader::EnterItem(std::size_t index) {
  const nlohmann::json& array = state_->value();
  state_->levels.push_back({&array[index], "[" + std::to_string(index) + "]"});
}

void JsonReader::Leave() {
  state_->levels.pop_back();
}

bool JsonReader::BeginObject() {
  if (!error_.empty()) return false;
  if (!state_->value().is_object()) Expect("an object with fields");
  return error_.empty();
}

void JsonReader::EndObject() {
  if (!error_.empty()) return;
  const State::Level& level = state_->levels.back();
  for (const auto& item : level.value->items()) {
    if (!level.read.contains(item.key())) return Fail("has an unknown field '" + item.key() + "'");
  }
}

std::size_t JsonReader::BeginArray() {
  if (!error_.empty()) return 0;
  if (!state_->value().is_array()) {
    Expect("an array");
    return 0;
  }
  return state_->value().size();
}

void JsonReader::ReadText(std::string& value) {
  if (!error_.empty()) return;
  if (!state_->value().is_string()) return Expect("a text");
  value = state_->value().get<std::string>();
}

void JsonReader::ReadBool(bool& value) {
  if (!error_.empty()) return;
  if (!state_->value().is_boolean()) return Expect("true or false");
  value = state_->value().get<bool>();
}

bool JsonReader::ReadNumber(double& value) {
  if (!error_.empty()) return false;
  if (!state_->value().is_number()) {
    Expect("a number");
    return false;
  }
  value = state_->value().get<double>();
  return true;
}

bool JsonReader::ReadUnsigned(std::uint64_t& value) {
  if (!error_.empty() || !state_->value().is_number_unsigned()) return false;
  value = state_->value().get<std::uint64_t>();
  return true;
}

// A number of JSON without a fraction is exact up to 2^63, one with a point up to 2^53.
bool JsonReader::ReadWhole(std::int64_t& value) {
  double number = 0;
  if (!ReadNumber(number)) return false;
  const nlohmann::json& json = state_->value();
  const bool too_large =
      json.is_number_unsigned() && !std::in_range<std::int64_t>(json.get<std::uint64_t>());
  const bool whole = json.is_number_integer()
                         ? !too_large
                         : std::trunc(number) == number && std::abs(number) < kExactWholeNumbers;
  if (!whole) {
    Expect("a whole number");
    return false;
  }
  value = json.is_number_integer() ? json.get<std::int64_t>() : static_cast<std::int64_t>(number);
  return true;
}

void JsonWriter::WriteText(std::string_view text) {
  text_ += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// JSON has no number that is not finite.
void JsonWriter::WriteNumber(double number) {
  text_ += std::isfinite(number) ? NumberText(number) : "null";
}

}  // namespace musher::tree::internal
