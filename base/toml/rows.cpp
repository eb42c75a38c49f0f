#include "musher/base/toml/rows.hpp"

#include <numbers>
#include <optional>

#include "musher/base/toml/names.hpp"

namespace musher::config_toml {

namespace {

std::optional<double> NumberIn(const Value& value) {
  if (const auto* integer = value.As<std::int64_t>()) return static_cast<double>(*integer);
  if (const auto* number = value.As<double>()) return *number;
  return std::nullopt;
}

}  // namespace

void ReadRows(TableReader& reader, const Rows& rows) {
  for (const Row& row : rows) row(reader);
  reader.RefuseOthers();
}

namespace row {

Row Number(std::string_view key, double& value, double least, double most) {
  return
      [=, &value](TableReader& reader) { value = reader.Number(key, least, most).value_or(value); };
}

Row Numbers(std::string_view key, std::vector<double*> values, double least, double most,
            std::string_view expected) {
  return [=, values = std::move(values)](TableReader& reader) {
    const Value* list = reader.Get(key);
    if (list == nullptr) return;
    const auto* items = list->As<Array>();
    if (items == nullptr || items->size() != values.size()) {
      return reader.Fault(list->at, key, expected);
    }
    std::vector<double> numbers;
    for (const Value& item : *items) {
      const auto number = NumberIn(item);
      if (!number || !(*number >= least && *number <= most)) {  // nan, too
        return reader.Fault(item.at, key, expected);
      }
      numbers.push_back(*number);
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) *values[i] = numbers[i];
  };
}

Row Degrees(std::string_view key, double& value_rad, double least_deg, double most_deg) {
  return [=, &value_rad](TableReader& reader) {
    const auto degrees = reader.Number(key, least_deg, most_deg);
    if (degrees) value_rad = *degrees * (std::numbers::pi / 180);
  };
}

Row Time(std::string_view key, Duration& value, std::int64_t least_ms) {
  return [=, &value](TableReader& reader) { value = reader.Time(key, least_ms).value_or(value); };
}

Row Bool(std::string_view key, bool& value) {
  return [=, &value](TableReader& reader) { value = reader.Bool(key).value_or(value); };
}

Row Text(std::string_view key, std::string& value) {
  return [=, &value](TableReader& reader) {
    if (auto word = reader.String(key)) value = std::move(word->text);
  };
}

Row File(std::string_view key, std::string& value, std::filesystem::path folder) {
  return [=, &value, folder = std::move(folder)](TableReader& reader) {
    if (const auto word = reader.String(key)) value = Absolute(folder, word->text);
  };
}

Row Program(std::string_view key, std::vector<std::string>& argv, std::filesystem::path folder,
            ListRule rule) {
  return [=, &argv, folder = std::move(folder)](TableReader& reader) {
    auto words = reader.Strings(key, rule);
    if (!words || words->empty()) return;
    std::string& program = words->front().text;
    if (program.empty()) {
      reader.Fault(words->front().at, key, "expected a program, found an empty string");
    } else if (program.find('/') != std::string::npos) {
      program = Absolute(folder, program);
    }
    argv.clear();
    for (Word& word : *words) argv.push_back(std::move(word.text));
  };
}

Row Topic(std::string_view key, std::string& value, std::string_view example, TopicRule rule) {
  return [=, &value](TableReader& reader) {
    if (auto topic = reader.Topic(key, example, rule)) value = std::move(topic->text);
  };
}

Row Sub(std::string_view key, Rows rows) {
  return [key, rows = std::move(rows)](TableReader& reader) {
    if (auto sub = reader.Sub(key)) ReadRows(*sub, rows);
  };
}

Row Required(std::string_view key, std::string_view expected, Row row) {
  return [=, row = std::move(row)](TableReader& reader) {
    reader.Require(key, expected);
    row(reader);
  };
}

Row Check(std::string_view key, std::function<bool()> holds, std::string_view message) {
  return [=, holds = std::move(holds)](TableReader& reader) {
    if (!holds()) reader.Fault(reader.At(key), key, message);
  };
}

}  // namespace row
}  // namespace musher::config_toml
