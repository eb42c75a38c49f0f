#include "musher/modules/wedding/extension/extension_toml.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace musher::wedding {
namespace {

using config_toml::TableReader;

void Read(TableReader& table, const char* key, Duration& time) {
  time = table.Time(key).value_or(time);
}

// Reported at the key that the file has.
void Contradict(TableReader& table, const char* key, const char* other, const char* message) {
  const char* given = table.Has(key) ? key : other;
  table.Fault(table.At(given), given, message);
}

// Number of characters of a UTF-8 text.
int CharactersIn(const std::string& text) {
  constexpr unsigned char kKind = 0xc0;
  constexpr unsigned char kContinuation = 0x80;
  return static_cast<int>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & kKind) != kContinuation;
  }));
}

}  // namespace

std::optional<SearchRules> ReadSearch(TableReader& table) {
  const bool enabled = table.Bool("enabled").value_or(false);
  SearchRules rules;
  Read(table, "confirm_ms", rules.confirm);
  Read(table, "nobody_ms", rules.no_face);
  Read(table, "timeout_ms", rules.timeout);
  rules.scan = table.Number("scan", 0, 0.5).value_or(rules.scan);
  Read(table, "scan_period_ms", rules.scan_period);
  if (rules.confirm > rules.timeout) {
    Contradict(table, "confirm_ms", "timeout_ms",
               "expected confirm_ms to be at most timeout_ms: else no face can stay long enough");
  }
  if (!enabled) return std::nullopt;
  return rules;
}

std::optional<InterviewRules> ReadInterview(TableReader& table) {
  const bool enabled = table.Bool("enabled").value_or(false);
  InterviewRules rules;
  Read(table, "greeting_ms", rules.greeting);
  Read(table, "question_ms", rules.question);
  Read(table, "question_begin_ms", rules.question_begin);
  rules.question_character =
      table.Time("question_character_ms", 0).value_or(rules.question_character);
  if (const auto questions = table.Strings("questions", {.may_repeat = true})) {
    rules.question_characters.clear();
    for (const auto& question : *questions) {
      rules.question_characters.push_back(CharactersIn(question.text));
    }
  }
  Read(table, "listening_ms", rules.listening);
  Read(table, "silence_ms", rules.silence);
  rules.voice_threshold = table.Number("voice_threshold", 0, 1).value_or(rules.voice_threshold);
  Read(table, "ending_ms", rules.ending);
  Read(table, "done_ms", rules.done);
  Read(table, "lost_ms", rules.lost);
  rules.video = table.Bool("video").value_or(rules.video);
  rules.unasked = table.Bool("unasked").value_or(rules.unasked);
  Read(table, "stable_ms", rules.stable);
  Read(table, "stays_ms", rules.stays);
  Read(table, "lost_least_ms", rules.lost_least);
  Read(table, "lost_most_ms", rules.lost_most);
  if (rules.lost_least >= rules.lost_most) {
    Contradict(table, "lost_least_ms", "lost_most_ms",
               "expected lost_least_ms to be less than lost_most_ms: else the range is empty");
  }
  if (!enabled) return std::nullopt;
  return rules;
}

std::optional<ActionRules> ReadActions(TableReader& table) {
  const bool enabled = table.Bool("enabled").value_or(false);
  ActionRules rules;
  const auto seed = table.Integer("seed", 0, std::numeric_limits<std::int32_t>::max());
  if (seed) rules.seed = static_cast<std::uint64_t>(*seed);
  const auto span = [&table](const char* least_key, Duration& least, const char* most_key,
                             Duration& most) {
    Read(table, least_key, least);
    Read(table, most_key, most);
    if (least <= most) return;
    Contradict(table, least_key, most_key, "expected the least time to be at most the most time");
  };
  span("idle_least_ms", rules.idle_least, "idle_most_ms", rules.idle_most);
  rules.greeting_probability =
      table.Number("greeting_probability", 0, 1).value_or(rules.greeting_probability);
  Read(table, "greeting_ms", rules.greeting);
  span("observe_least_ms", rules.observe_least, "observe_most_ms", rules.observe_most);
  Read(table, "confirm_ms", rules.confirm);
  Read(table, "lost_ms", rules.lost);
  rules.same_within = table.Number("same_within", 0, 1).value_or(rules.same_within);
  if (rules.confirm > rules.observe_least) {
    Contradict(table, "confirm_ms", "observe_least_ms",
               "expected confirm_ms to be at most observe_least_ms: else no face can stay long "
               "enough");
  }
  if (!enabled) return std::nullopt;
  return rules;
}

}  // namespace musher::wedding
