// The rows of the tables of a course that refer to few others: movements, results, speech, the
// robot.

#include <algorithm>
#include <filesystem>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/modules/race/course_parts.hpp"

namespace musher::race::parts {
namespace {

constexpr std::int64_t kMostMotion = 99'999;

Row NeedOf(std::string_view key, Need& taken) {
  return row::Choice(
      key, taken,
      {{"required", Need::kRequired}, {"optional", Need::kOptional}, {"none", Need::kNone}});
}

Phrase ReadPhrase(TableReader& table) {
  Phrase phrase;
  ReadRows(table, {row::Required("zh", "the text in Chinese", row::Text("zh", phrase.chinese)),
                   row::Required("en", "the text in English", row::Text("en", phrase.english))});
  return phrase;
}

}  // namespace

Rows RobotRows(const std::filesystem::path& folder, RobotRules& robot) {
  const auto read_record = [&](TableReader& table) {
    const auto file = table.String("record");
    if (file && !file->text.empty()) robot.record = config_toml::Absolute(folder, file->text);
  };
  return {
      row::Choice("resume", robot.from_start, {{"where_it_was", false}, {"start", true}}),
      row::Time("resume_within_ms", robot.resume_within, 0),
      read_record,
      row::Time("self_check_ms", robot.self_check),
      NeedOf("motion", robot.motion),
      NeedOf("cameras", robot.cameras),
      NeedOf("walker", robot.walker),
      NeedOf("audio", robot.audio),
  };
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): what a std::function keeps

Rows OdometryRows(OdometryRules& odometry) {
  return {
      row::Topic("topic", odometry.topic, "odom_out", {.may_be_empty = true}),
      row::Number("least_share", odometry.least_share, 0.2, 1),
      row::Number("most_share", odometry.most_share, 1, 5),
      row::Time("fresh_ms", odometry.fresh),
      row::Time("begin_ms", odometry.begin, 0),
      row::Number("most_turned_rad", odometry.most_turned_rad, 0, 3),
      row::Number("blocked_share", odometry.blocked_share, 0, 1),
      row::Number("most_moved_m", odometry.most_moved_m, 0, 10),
      row::Number("most_moved_rad", odometry.most_moved_rad, 0, 3),
  };
}

Rows MovementRows(TableReader& table, Movement& movement) {
  movement.walks = table.Has("twist");
  const Row motion = row::Required("motion", "the id of a motion",
                                   row::Integer("motion", movement.motion_id, 0, kMostMotion));
  if (!movement.walks) {
    return {motion, row::Time("before_ms", movement.before, 0),
            row::Time("after_ms", movement.after, 0), row::Time("limit_ms", movement.limit)};
  }
  Twist& twist = movement.twist;
  auto& [front_m, rear_m] = movement.step_height_m;
  return {
      motion,
      row::Numbers("twist", {&twist.forward_m_s, &twist.left_m_s, &twist.yaw_rad_s}, -2, 2,
                   "expected [ahead m/s, to the left m/s, yaw rad/s], each -2 to 2"),
      row::Numbers("step_height_m", {&front_m, &rear_m}, 0, 0.3,
                   "expected [front m, rear m], each 0 to 0.3"),
      row::Integer("count", movement.count, 1, kMostSteps, " steps"),
      row::Number("odometry_share", movement.odometry_share, 0.2, 2),
  };
}

Rows ResultRows(ResultRule& result) {
  const auto read_values = [&](TableReader& table) {
    const auto values = table.Strings("values");
    if (!values) return;
    for (const auto& value : *values) result.values.push_back(value.text);
  };
  const auto read_default = [&](TableReader& table) {
    const auto word = table.String("default");
    if (word) result.by_default = Refer(table, "default", "value", *word, result.values);
  };
  const auto check_shown = [&](TableReader& table) {
    if (!result.shown) return;
    for (const std::string& value : result.values) {
      const bool fits = std::ranges::none_of(value, [](char c) {
        return c == ',' || static_cast<unsigned char>(c) < ' ' || c == 0x7f;
      });
      if (fits) continue;
      table.Fault(table.At("values"), "values",
                  "expected no comma and no control character, which state_info would show, "
                  "found " +
                      config_toml::Quote(value));
    }
  };
  return {
      row::Required("values", "its values, as in [\"left\", \"right\"]", read_values),
      read_default,
      row::Text("command", result.command),
      row::Bool("once", result.once),
      row::Bool("shown", result.shown),
      check_shown,
  };
}

namespace {

void ReadTexts(TableReader& table, Speech& speech, Reading& reading) {
  if (!table.Has("result")) {
    for (TableReader& text : table.Subs("texts")) speech.phrases.push_back(ReadPhrase(text));
    return;
  }
  auto texts = table.Sub("texts");
  if (!texts || !speech.result) return;
  const std::vector<std::string>& values = reading.course.results[*speech.result].values;
  for (Index value = 0; value < values.size(); ++value) {
    auto text = texts->Sub(values[value]);
    if (text) speech.of_values.push_back({value, ReadPhrase(*text)});  // else nothing is said
  }
  texts->RefuseOthers();
}

}  // namespace

Rows SpeechRows(Speech& speech, Reading& reading) {
  return {
      row::Time("limit_ms", speech.limit),
      row::Time("every_ms", speech.every, 0),
      [](TableReader& table) {
        table.Require("texts", "what is said, as in [{ zh = \"五\", en = \"Five\" }]");
      },
      ReferenceRow("result", "result", reading.course.results, speech.result),
      [&](TableReader& table) { ReadTexts(table, speech, reading); },
  };
}

}  // namespace musher::race::parts
