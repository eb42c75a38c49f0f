// Reads the tables of a course that refer to few others: movements, results, speech, the robot.

#include <algorithm>
#include <filesystem>

#include "musher/base/toml/names.hpp"
#include "musher/modules/race/course_parts.hpp"

namespace musher::race::parts {
namespace {

constexpr std::int64_t kMostMotion = 99'999;

std::vector<double> Numbers(TableReader& table, const char* key, std::size_t size, double least,
                            double most, const char* expected) {
  const config_toml::Value* value = table.Get(key);
  if (value == nullptr) return {};
  std::vector<double> numbers;
  if (const auto* array = value->As<config_toml::Array>()) {
    for (const config_toml::Value& item : *array) {
      const auto* real = item.As<double>();
      const auto* integer = item.As<std::int64_t>();
      if (real == nullptr && integer == nullptr) break;
      const double number = real != nullptr ? *real : static_cast<double>(*integer);
      if (number >= least && number <= most) numbers.push_back(number);
    }
    if (numbers.size() == size && array->size() == size) return numbers;
  }
  table.Fault(value->at, key, expected);
  return {};
}

Phrase ReadPhrase(TableReader& table) {
  Phrase phrase;
  table.Require("zh", "the text in Chinese");
  table.Require("en", "the text in English");
  if (const auto word = table.String("zh")) phrase.chinese = word->text;
  if (const auto word = table.String("en")) phrase.english = word->text;
  table.RefuseOthers();
  return phrase;
}

}  // namespace

void Take(TableReader& table, const char* key, Duration& time, std::int64_t least_ms) {
  time = table.Time(key, least_ms).value_or(time);
}

void ReadRobot(TableReader& table, const std::filesystem::path& folder, RobotRules& robot) {
  robot.from_start = table.Choice<bool>("resume", {{"where_it_was", false}, {"start", true}})
                         .value_or(robot.from_start);
  if (const auto file = table.String("record"); file && !file->text.empty()) {
    robot.record = config_toml::Absolute(folder, file->text);
  }
  Take(table, "self_check_ms", robot.self_check);
  const auto need = [&table](const char* key, Need& taken) {
    taken = table
                .Choice<Need>(key, {{"required", Need::kRequired},
                                    {"optional", Need::kOptional},
                                    {"none", Need::kNone}})
                .value_or(taken);
  };
  need("motion", robot.motion);
  need("cameras", robot.cameras);
  need("walker", robot.walker);
  need("audio", robot.audio);
}

void ReadMovement(TableReader& table, Movement& movement) {
  movement.walks = table.Has("twist");
  table.Require("motion", "the id of a motion");
  movement.motion_id = static_cast<std::int32_t>(
      table.Integer("motion", 0, kMostMotion).value_or(movement.motion_id));
  if (!movement.walks) {
    Take(table, "before_ms", movement.before, 0);
    Take(table, "after_ms", movement.after, 0);
    return Take(table, "limit_ms", movement.limit);
  }
  const auto twist = Numbers(table, "twist", 3, -2, 2,
                             "expected [ahead m/s, to the left m/s, yaw rad/s], each -2 to 2");
  if (twist.size() == 3) movement.twist = {twist[0], twist[1], twist[2]};
  const auto height =
      Numbers(table, "step_height_m", 2, 0, 0.3, "expected [front m, rear m], each 0 to 0.3");
  if (height.size() == 2) movement.step_height_m = {height[0], height[1]};
  movement.count = Count(table, "count").value_or(movement.count);
}

void ReadResult(TableReader& table, ResultRule& result) {
  table.Require("values", "its values, as in [\"left\", \"right\"]");
  if (const auto values = table.Strings("values")) {
    for (const auto& value : *values) result.values.push_back(value.text);
  }
  if (const auto word = table.String("default")) {
    result.by_default = Refer(table, "default", "value", *word, result.values);
  }
  if (const auto command = table.String("command")) result.command = command->text;
  result.once = table.Bool("once").value_or(false);
  result.shown = table.Bool("shown").value_or(false);
  if (!result.shown) return;
  for (const std::string& value : result.values) {
    const bool fits = std::ranges::none_of(
        value, [](char c) { return c == ',' || (c >= 0 && c < ' ') || c == 0x7f; });
    if (fits) continue;
    table.Fault(table.At("values"), "values",
                "expected no comma and no control character, which state_info would show, found " +
                    config_toml::Quote(value));
  }
}

void ReadSpeech(TableReader& table, Speech& speech, Reading& reading) {
  Take(table, "limit_ms", speech.limit);
  Take(table, "every_ms", speech.every, 0);
  table.Require("texts", "what is said, as in [{ zh = \"五\", en = \"Five\" }]");
  speech.result = Reference(table, "result", "result", reading.course.results);
  if (!table.Has("result")) {
    for (const config_toml::Value* text : table.Tables("texts")) {
      TableReader reader(*text->As<Table>(), text->at, table.path() + ".texts", reading.findings);
      speech.phrases.push_back(ReadPhrase(reader));
    }
    return;
  }
  const Table* texts = table.SubTable("texts");
  if (texts == nullptr || !speech.result) return;
  TableReader reader(*texts, table.At("texts"), table.path() + ".texts", reading.findings);
  const std::vector<std::string>& values = reading.course.results[*speech.result].values;
  for (Index value = 0; value < values.size(); ++value) {
    const Table* text = reader.SubTable(values[value]);
    if (text == nullptr) continue;  // of this value nothing is said
    TableReader phrase(*text, reader.At(values[value]), reader.path() + "." + values[value],
                       reading.findings);
    speech.of_values.push_back({value, ReadPhrase(phrase)});
  }
  reader.RefuseOthers();
}

}  // namespace musher::race::parts
