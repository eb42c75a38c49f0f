#pragma once
// What the readers of a course's tables share: names, references and their positions. Internal to
// course_reader.cpp, table_rows.cpp, state_reader.cpp and course_check.cpp.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/rows.hpp"
#include "musher/modules/race/course.hpp"

namespace musher::race::parts {

namespace row = config_toml::row;

using config_toml::Findings;
using config_toml::Position;
using config_toml::Row;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

// Where a state stands in the file, and which of its parts have no errors.
struct StatePlace {
  Position at;
  Position next;                      // the value of `next`
  std::vector<Position> transitions;  // as StateRule::transitions
  Position on_fault;
  bool has_number = false;
  bool has_all_steps = false;
  bool has_all_transitions = false;
};

struct Reading {
  Course course;
  Findings& findings;
  std::vector<StatePlace> places = {};  // as Course::states
  bool has_ends = true;                 // start, end and error are states, each of its own
  bool has_leads = true;  // every other reference to a state, and all steps that may have one
};

inline std::vector<std::string> NamesOf(const std::vector<std::string>& names) {
  return names;
}
template <class Thing>
std::vector<std::string> NamesOf(const std::vector<Thing>& things) {
  std::vector<std::string> names;
  names.reserve(things.size());
  for (const Thing& thing : things) names.push_back(thing.name);
  return names;
}

// Nothing, and an error with a suggestion, where `names` lacks `word`.
std::optional<Index> Refer(TableReader& table, std::string_view key, std::string_view kind,
                           const config_toml::Word& word, const std::vector<std::string>& names);

// The thing that the key names; nothing where the key is missing or wrong.
template <class Thing>
std::optional<Index> Reference(TableReader& table, std::string_view key, std::string_view kind,
                               const std::vector<Thing>& things) {
  const auto word = table.String(key);
  return word ? Refer(table, key, kind, *word, NamesOf(things)) : std::nullopt;
}

// The same for a list of names.
std::vector<Index> States(TableReader& table, std::string_view key, Reading& reading);

// Steps of a walk, from 1 to kMostSteps; nothing where the key is missing or wrong.
std::optional<int> Count(TableReader& table, std::string_view key);

// A walk; `table` has `move` and `count`.
std::optional<Stretch> ReadStretch(TableReader& table, const Reading& reading,
                                   std::string_view count = "count");
// The key's table { move = …, count = … }.
std::optional<Stretch> StretchAt(TableReader& table, std::string_view key, Reading& reading);

// The same as rows; the variable keeps its value where the reading function gives nothing.
template <class Thing>
Row ReferenceRow(std::string_view key, std::string_view kind, const std::vector<Thing>& things,
                 std::optional<Index>& index) {
  return [=, &things, &index](TableReader& table) {
    if (const auto found = Reference(table, key, kind, things)) index = found;
  };
}
// A key that has to be there.
template <class Thing>
Row ReferenceRow(std::string_view key, std::string_view kind, const std::vector<Thing>& things,
                 Index& index) {
  return [=, &things, &index](TableReader& table) {
    table.Require(key, "the name of a " + std::string(kind));
    index = Reference(table, key, kind, things).value_or(index);
  };
}
Row CounterRow(std::string_view key, const Reading& reading, std::optional<Index>& counter);
Row StatesRow(std::string_view key, Reading& reading, std::vector<Index>& states);
// The key `otherwise`.
Row OtherwiseRow(Otherwise& otherwise, Reading& reading);

// The rows of [robot], [odometry], [movement.NAME], [result.NAME] and [speech.NAME].
// table_rows.cpp. `table` is the one that they are for.
Rows RobotRows(const std::filesystem::path& folder, RobotRules& robot);
Rows OdometryRows(OdometryRules& odometry);
Rows MovementRows(TableReader& table, Movement& movement);
Rows ResultRows(ResultRule& result);
Rows SpeechRows(Speech& speech, Reading& reading);

// The body of [state.NAME].
void ReadState(TableReader& table, StateRule& state, StatePlace& place, Reading& reading);

// States that get stuck. Also of a course with errors: what these may hide is left out, so that no
// error is only the consequence of another one. course_check.cpp.
void CheckStates(Reading& reading);

// Commands that no text reaches. course_commands.cpp.
void CheckCommands(TableReader& root, Reading& reading);

}  // namespace musher::race::parts
